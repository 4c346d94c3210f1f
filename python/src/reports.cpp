#include "reports.hpp"

#include "errors.hpp"

#include "batten/core/error.hpp"

namespace batten::python {

namespace py = pybind11;

py::object as_python(const commands::Json& json) {
  switch (json.type()) {
    case commands::Json::value_t::object: {
      py::dict dict;
      for (const auto& [key, value] : json.items()) dict[py::str(key)] = as_python(value);
      return dict;
    }
    case commands::Json::value_t::array: {
      py::list list;
      for (const commands::Json& value : json) list.append(as_python(value));
      return list;
    }
    case commands::Json::value_t::string:
      return py::str(spoken(json.get<std::string>()));
    case commands::Json::value_t::boolean:
      return py::bool_(json.get<bool>());
    case commands::Json::value_t::number_integer:
      return py::int_(json.get<long long>());
    case commands::Json::value_t::number_unsigned:
      return py::int_(json.get<unsigned long long>());
    case commands::Json::value_t::number_float:
      return py::float_(json.get<double>());
    default:
      return py::none();
  }
}

py::dict report_of(const char* command, const commands::Json& figures, const py::dict& options,
                   const StageTimes& times, const std::vector<std::string>& warnings) {
  py::dict report;
  report["command"] = command;
  for (const auto& [key, value] : figures.items()) report[py::str(key)] = as_python(value);
  report["options"] = options;
  py::dict seconds;
  for (const auto& [stage, time] : times.stages()) seconds[py::str(stage)] = time;
  seconds["total"] = times.total();
  report["seconds"] = seconds;
  py::list told;
  for (const std::string& warning : warnings) told.append(spoken(warning));
  report["warnings"] = told;
  return report;
}

void tell_flaws(const std::vector<std::string>& flaws, const std::string& what, bool accepted,
                std::vector<std::string>& warnings) {
  if (flaws.empty()) return;
  std::string all;
  for (const std::string& flaw : flaws) all += (all.empty() ? "" : "; ") + flaw;
  if (!accepted) throw Error(what + ": " + all + "; --accept-flaws=True returns it all the same");
  warnings.push_back("accepted: " + all);
}

}  // namespace batten::python
