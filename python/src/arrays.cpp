#include "arrays.hpp"

#include <cmath>
#include <cstdint>
#include <limits>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten::python {

namespace {

/// Whatever numpy makes of it. @throws InvalidInput where that are no numbers.
py::array array_of(py::handle object, const std::string& name, const char* kinds, const char* wanted) {
  py::array array;
  try {
    array = py::module_::import("numpy").attr("asarray")(object).cast<py::array>();
  } catch (py::error_already_set& error) {
    if (!error.matches(PyExc_ValueError) && !error.matches(PyExc_TypeError)) throw;
    throw InvalidInput(concat(name, " must be an array of ", wanted,
                              "; numpy says: ", py::str(error.value()).cast<std::string>()));
  }
  const char kind = array.dtype().kind();
  // An empty list is an array of floating-point numbers to numpy, and of anything to us.
  if (array.size() > 0 && std::string(kinds).find(kind) == std::string::npos)
    throw InvalidInput(concat(name, " must hold ", wanted, ", got an array of ",
                              py::str(array.dtype()).cast<std::string>()));
  return array;
}

std::string shape_of(const py::array& array) {
  if (array.ndim() == 0) return "a single number";
  std::string text = "the shape";
  for (py::ssize_t i = 0; i < array.ndim(); ++i) text += concat(i == 0 ? " " : " × ", array.shape(i));
  return text;
}

void require_columns(const py::array& array, const std::string& name) {
  if (array.ndim() != 2 || array.shape(1) != 3)
    if (array.ndim() != 1 || array.shape(0) != 0)  // an empty list has no columns
      throw InvalidInput(concat(name, " must have three columns, got ", shape_of(array)));
}

void require_line(const py::array& array, const std::string& name) {
  if (array.ndim() != 1) throw InvalidInput(concat(name, " must have one dimension, got ", shape_of(array)));
}

/// A number as Python writes it.
std::string shown(double value) {
  return py::repr(py::float_(value)).cast<std::string>();
}

template <typename Matrix>
void require_finite(const Matrix& values, const std::string& name, Missing missing) {
  for (Eigen::Index row = 0; row < values.rows(); ++row)
    for (Eigen::Index column = 0; column < values.cols(); ++column) {
      const double value = values(row, column);
      if (std::isfinite(value) || (missing == Missing::Allowed && std::isnan(value))) continue;
      throw InvalidInput(concat(name, ": row ", row, " holds ", shown(value), "; numbers must be finite"));
    }
}

/// Calls use(row, column, value) for all whole numbers, which are in range. Floating-point numbers are taken
/// where they are whole.
template <typename Use>
void each_integer(const py::array& array, long long least, long long most, const std::string& name,
                  int per_row, const Use& use) {
  const py::ssize_t rows = array.shape(0), columns = array.ndim() == 2 ? array.shape(1) : 1;
  const auto refuse = [&](py::ssize_t row, const std::string& value) {
    throw InvalidInput(concat(name, ": row ", row / per_row, " holds ", value,
                              ", which is out of range; whole numbers from ", least, " to ", most,
                              " are allowed"));
  };
  const auto visit = [&](const auto& values, const auto& problem) {
    for (py::ssize_t row = 0; row < rows; ++row)
      for (py::ssize_t column = 0; column < columns; ++column) {
        const auto value = values.data()[row * columns + column];
        problem(row, value);
        use(row, column, static_cast<int>(value));
      }
  };
  constexpr int kStyle = py::array::c_style | py::array::forcecast;
  if (array.dtype().kind() == 'u') {
    visit(py::array_t<std::uint64_t, kStyle>(array), [&](py::ssize_t row, std::uint64_t value) {
      if (most < 0 || value > static_cast<std::uint64_t>(most) ||
          (least > 0 && value < static_cast<std::uint64_t>(least)))
        refuse(row, std::to_string(value));
    });
  } else if (array.dtype().kind() == 'f') {
    visit(py::array_t<double, kStyle>(array), [&](py::ssize_t row, double value) {
      if (!(std::floor(value) == value))  // NaN too
        throw InvalidInput(
            concat(name, ": row ", row / per_row, " holds ", shown(value), ", which is no whole number"));
      if (value < static_cast<double>(least) || value > static_cast<double>(most)) refuse(row, shown(value));
    });
  } else {
    visit(py::array_t<std::int64_t, kStyle>(array), [&](py::ssize_t row, std::int64_t value) {
      if (value < least || value > most) refuse(row, std::to_string(value));
    });
  }
}

template <typename Kept, typename Scalar>
py::array line(Kept* kept, const Scalar* data, py::ssize_t n) {
  const py::capsule owner(kept, [](void* memory) { delete static_cast<Kept*>(memory); });
  return py::array_t<Scalar>({n}, data, owner);
}

}  // namespace

Points points_from(py::handle object, const std::string& name, Missing missing) {
  const py::array array = array_of(object, name, "fiu", "numbers");
  require_columns(array, name);
  if (array.size() == 0) return Points(0, 3);
  const py::array_t<double, py::array::c_style | py::array::forcecast> numbers(array);
  Points points = Eigen::Map<const Points>(numbers.data(), numbers.shape(0), 3);
  require_finite(points, name, missing);
  return points;
}

Points points_or_none(py::handle object, Eigen::Index n, const std::string& name, Missing missing) {
  if (object.is_none()) return Points(0, 3);
  Points points = points_from(object, name, missing);
  if (points.rows() != 0 && points.rows() != n)
    throw InvalidInput(concat(name, " must have ", n, " rows, got ", points.rows()));
  return points;
}

Eigen::VectorXd numbers_from(py::handle object, Eigen::Index n, const std::string& name, Missing missing) {
  const py::array array = array_of(object, name, "fiu", "numbers");
  require_line(array, name);
  const py::array_t<double, py::array::c_style | py::array::forcecast> numbers(array);
  if (n >= 0 && numbers.shape(0) != n)
    throw InvalidInput(concat(name, " must hold ", n, " numbers, got ", numbers.shape(0)));
  Eigen::VectorXd values = Eigen::Map<const Eigen::VectorXd>(numbers.data(), numbers.shape(0));
  require_finite(values, name, missing);
  return values;
}

Triangles triangles_from(py::handle object, Eigen::Index n_vertices, const std::string& name) {
  const py::array array = array_of(object, name, "iuf", "whole numbers");
  require_columns(array, name);
  if (array.size() == 0) return Triangles(0, 3);
  Triangles triangles(array.shape(0), 3);
  each_integer(array, 0, n_vertices - 1, name, 1,
               [&](py::ssize_t row, py::ssize_t column, int value) { triangles(row, column) = value; });
  return triangles;
}

std::vector<int> integers_from(py::handle object, long long least, long long most, const std::string& name,
                               int per_row) {
  const py::array array = array_of(object, name, "iuf", "whole numbers");
  require_line(array, name);
  std::vector<int> numbers(static_cast<std::size_t>(array.shape(0)));
  if (!numbers.empty())
    each_integer(array, least, most, name, per_row, [&](py::ssize_t row, py::ssize_t, int value) {
      numbers[static_cast<std::size_t>(row)] = value;
    });
  return numbers;
}

py::array owned(Eigen::VectorXd&& vector) {
  auto* kept = new Eigen::VectorXd(std::move(vector));
  return line(kept, kept->data(), kept->size());
}

py::array owned(std::vector<int>&& numbers) {
  auto* kept = new std::vector<int>(std::move(numbers));
  return line(kept, kept->data(), static_cast<py::ssize_t>(kept->size()));
}

py::object owned_or_none(Points&& points) {
  if (points.rows() == 0) return py::none();
  return owned(std::move(points));
}

}  // namespace batten::python
