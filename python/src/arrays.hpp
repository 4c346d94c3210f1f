#pragma once
#include <string>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "batten/core/arrays.hpp"

namespace batten::python {

namespace py = pybind11;

// From Python: anything that numpy makes an array of. Numbers are never wrapped or cut; what does not fit is
// refused with the row and the value. `name` is what sentences call the array. All throw InvalidInput.

enum class Missing { Refused, Allowed };  ///< whether numbers may be NaN

/// n × 3, float64; float32, integers, other strides and byte orders are copied.
Points points_from(py::handle object, const std::string& name, Missing missing = Missing::Refused);
/// None, or anything without rows: 0 × 3. @throws InvalidInput where there are other than n rows.
Points points_or_none(py::handle object, Eigen::Index n, const std::string& name,
                      Missing missing = Missing::Refused);
/// One number per row. @param n wanted; −1: any.
Eigen::VectorXd numbers_from(py::handle object, Eigen::Index n, const std::string& name,
                             Missing missing = Missing::Refused);
/// m × 3 indices of `n_vertices` vertices. Whole numbers of any integer type; of floating point only where
/// they are whole.
Triangles triangles_from(py::handle object, Eigen::Index n_vertices, const std::string& name);
/// One-dimensional, each from `least` to `most`. @param per_row how many of them sentences count as a row.
std::vector<int> integers_from(py::handle object, long long least, long long most, const std::string& name,
                               int per_row = 1);

// To Python: the array owns what it shows, and nothing is copied.

template <typename Scalar, int Columns>
py::array owned(Eigen::Matrix<Scalar, Eigen::Dynamic, Columns, Eigen::RowMajor>&& matrix) {
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Columns, Eigen::RowMajor>;
  auto* kept = new Matrix(std::move(matrix));
  const py::capsule owner(kept, [](void* memory) { delete static_cast<Matrix*>(memory); });
  return py::array_t<Scalar>({kept->rows(), kept->cols()}, kept->data(), owner);
}
py::array owned(Eigen::VectorXd&& vector);
py::array owned(std::vector<int>&& numbers);
/// None without rows.
py::object owned_or_none(Points&& points);

}  // namespace batten::python
