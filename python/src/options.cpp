#include "options.hpp"

#include <limits>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten::python {

namespace py = pybind11;

namespace {

bool is_switch(py::handle given) {
  return PyBool_Check(given.ptr()) ||
         py::str(py::type::handle_of(given).attr("__name__")).cast<std::string>() == "bool_";
}

/// A float or what can be made one, but no text and no switch.
bool is_number(py::handle given) {
  return !is_switch(given) && !py::isinstance<py::str>(given) &&
         (PyFloat_Check(given.ptr()) || PyIndex_Check(given.ptr()) || py::hasattr(given, "__float__"));
}

[[noreturn]] void refuse(const std::string& name, const char* wanted, py::handle given) {
  throw InvalidInput(concat(name, " must be ", wanted, ", got ", py::repr(given).cast<std::string>()));
}

/// One word or number of a list.
std::string text_of(const std::string& name, py::handle given) {
  if (py::isinstance<py::str>(given)) return given.cast<std::string>();
  if (!is_number(given)) refuse(name, "text or a number", given);
  if (PyIndex_Check(given.ptr()))
    return py::str(py::reinterpret_steal<py::object>(PyNumber_Index(given.ptr()))).cast<std::string>();
  double value = 0;
  read_option(name, given, value);
  return exact_decimal(value);
}

}  // namespace

void read_option(const std::string& name, py::handle given, std::string& field) {
  field.clear();
  if (given.is_none()) return;
  if (!py::isinstance<py::list>(given) && !py::isinstance<py::tuple>(given)) {
    field = text_of(name, given);
    return;
  }
  for (const py::handle part : given) field += (field.empty() ? "" : ",") + text_of(name, part);
}

void read_option(const std::string& name, py::handle given, double& field) {
  if (!is_number(given)) refuse(name, "a number", given);
  field = PyFloat_AsDouble(given.ptr());
  if (PyErr_Occurred() != nullptr) {
    PyErr_Clear();
    refuse(name, "a number", given);
  }
  if (!std::isfinite(field)) refuse(name, "a finite number", given);
}

void read_option(const std::string& name, py::handle given, bool& field) {
  if (!is_switch(given)) refuse(name, "True or False", given);
  field = py::bool_(py::reinterpret_borrow<py::object>(given));
}

long long whole_number(const std::string& name, py::handle given, long long least, unsigned long long most) {
  if (is_switch(given) || PyIndex_Check(given.ptr()) == 0) refuse(name, "a whole number", given);
  const auto number = py::reinterpret_steal<py::object>(PyNumber_Index(given.ptr()));
  if (!number) throw py::error_already_set();
  if (number < py::int_(least) || number > py::int_(most))
    throw InvalidInput(concat(name, " must be a whole number from ", least, " to ", most, ", got ",
                              py::str(number).cast<std::string>()));
  if (most > static_cast<unsigned long long>(std::numeric_limits<long long>::max()))
    return static_cast<long long>(PyLong_AsUnsignedLongLong(number.ptr()));
  return PyLong_AsLongLong(number.ptr());
}

void add_options(py::module_& module) {
  module.def("default_options", [](const std::string& command) {
    if (command == "fair") return default_options<commands::FairArguments>();
    if (command == "remesh") return default_options<commands::RemeshArguments>();
    if (command == "repair") return default_options<commands::RepairArguments>();
    if (command == "simplify") return default_options<commands::SimplifyArguments>();
    if (command == "deform") return default_options<commands::DeformArguments>();
    if (command == "subdivide") return default_options<commands::SubdivideArguments>();
    if (command == "compare") return default_options<commands::CompareArguments>();
    if (command == "check") return default_options<commands::CheckArguments>();
    if (command == "surface") return default_options<FillArguments>();
    if (command == "network") return default_options<commands::NetworkArguments>();
    if (command == "reconstruct") return default_options<ReconstructArguments>();
    if (command == "simulate") return default_options<commands::SimulateArguments>();
    throw InvalidInput("no options are known of " + command);
  });
}

}  // namespace batten::python
