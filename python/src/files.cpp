#include "arrays.hpp"
#include "commands/words.hpp"
#include "errors.hpp"
#include "functions.hpp"
#include "objects.hpp"
#include "running.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/stl.h>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/cage_io.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/io/network_io.hpp"
#include "batten/io/scan_io.hpp"
#include "batten/io/sensor_log_io.hpp"
#include "batten/network/curve_network.hpp"

namespace batten::python {

namespace {

/// What a reader found and told.
template <typename Content>
struct Read {
  Content content;
  std::vector<std::string> warnings;
};

/// Runs a reader of (path, warnings) without the lock of the interpreter; Ctrl-C ends the waiting for it.
template <typename Reader>
auto reading(const std::string& path, Reader reader) {
  return running(py::none(), [path, reader](const Progress&) {
    Read<decltype(reader(path, nullptr))> read;
    read.content = reader(path, &read.warnings);
    return read;
  });
}

py::dict read_a_mesh(const std::string& path) {
  auto read =
      reading(path, [](const std::string& p, std::vector<std::string>* w) { return read_mesh_file(p, w); });
  py::dict fields = fields_of(std::move(read.content));
  fields["warnings"] = spoken(read.warnings);
  return fields;
}

/// A length of one unit. @throws InvalidInput.
double metres_per_unit(const std::string& unit) {
  try {
    const Length one = parse_length("1" + unit);
    if (one.kind == Length::Kind::Metres) return one.value;
  } catch (const InvalidInput&) {
    // no length at all
  }
  throw InvalidInput(concat("'", unit, "' is no unit of length; use m, cm, mm, um, km, in or ft"));
}

/// @return what the format could not hold.
std::vector<std::string> write_a_mesh(const std::string& path, const py::object& mesh, bool ascii,
                                      const std::string& unit) {
  MeshWriteOptions options;
  options.ascii = ascii;
  const MeshFormat format = mesh_format(path);
  if (has_unit(format)) options.metres_per_unit = metres_per_unit(unit);
  return spoken(running(py::none(), [path, options, format, made = mesh_from(mesh)](const Progress&) {
    std::vector<std::string> losses = losses_in_format(made.file.mesh, format, options);
    for (const std::string& loss : losses_in_format(made.file.attributes, format)) losses.push_back(loss);
    write_mesh_file(path, made.file, options);
    return losses;
  }));
}

py::dict read_a_network(const std::string& path) {
  auto read = reading(path, [](const std::string& p, std::vector<std::string>* w) {
    CurveNetwork network = read_network(p, w);
    Eigen::VectorXd uncertainty = read_network_uncertainty(p);
    return std::pair(std::move(network), std::move(uncertainty));
  });
  py::dict fields = fields_of(std::move(read.content.first));
  fields["uncertainty"] =
      read.content.second.size() == 0 ? py::object(py::none()) : owned(std::move(read.content.second));
  fields["warnings"] = spoken(read.warnings);
  return fields;
}

std::vector<std::string> write_a_network(const std::string& path, const py::object& network) {
  const NetworkFormat format = network_format(path);
  return spoken(running(py::none(), [path, format, made = network_from(network)](const Progress&) {
    std::vector<std::string> losses = losses_in_format(made.network, format);
    if (made.uncertainty.size() == 0) {
      write_network(path, made.network);
    } else if (format == NetworkFormat::Json) {
      write_uncertain_network(path, made.network, made.uncertainty);
    } else {
      write_network(path, made.network);
      losses.emplace_back("cannot hold the uncertainty; write .json to keep it");
    }
    return losses;
  }));
}

py::dict read_a_scan(const std::string& path, const std::optional<std::string>& calibration,
                     const std::string& columns, const std::string& nodes) {
  const NodeNumbers numbers =
      commands::is_first_word(nodes, "--nodes", "auto", "given") ? NodeNumbers::MayMiss : NodeNumbers::Needed;
  LogScan read = running(py::none(), [=](const Progress&) {
    LogScanOptions options;
    if (calibration) options.calibration = read_calibration(*calibration);
    return read_scan(path, options, columns, numbers);
  });
  py::dict fields = fields_of(std::move(read.scan));
  fields["warnings"] = spoken(read.warnings);
  return fields;
}

void write_a_scan(const std::string& path, const py::object& scan) {
  running(py::none(), [path, made = scan_from(scan)](const Progress&) {
    write_rawnet(made, path);
    return true;
  });
}

py::dict read_a_log(const std::string& path, const std::string& columns) {
  auto read = reading(path, [columns](const std::string& p, std::vector<std::string>* w) {
    return read_sensor_log(p, columns, columns.empty() ? nullptr : w);
  });
  py::dict fields = fields_of(std::move(read.content));
  fields["warnings"] = spoken(read.warnings);
  return fields;
}

void write_a_log(const std::string& path, const py::object& log) {
  running(py::none(), [path, made = log_from(log)](const Progress&) {
    write_sensor_log(made, path);
    return true;
  });
}

py::dict read_a_cage(const std::string& path) {
  auto read =
      reading(path, [](const std::string& p, std::vector<std::string>* w) { return read_cage(p, w); });
  py::dict fields = fields_of(std::move(read.content));
  fields["warnings"] = spoken(read.warnings);
  return fields;
}

void write_a_cage(const std::string& path, const py::object& cage) {
  const py::object normals = py::getattr(cage, "normals");
  ControlCage made = cage_from(cage);
  Points given = points_or_none(normals, made.mesh.positions.rows(), "normals");
  running(py::none(), [path, made = std::move(made), given = std::move(given)](const Progress&) {
    write_cage(path, made, given);
    return true;
  });
}

}  // namespace

void add_files(py::module_& module) {
  module.def("read_mesh", read_a_mesh);
  module.def("write_mesh", write_a_mesh);
  module.def("read_network", read_a_network);
  module.def("write_network", write_a_network);
  module.def("read_scan", read_a_scan);
  module.def("write_rawnet", write_a_scan);
  module.def("read_sensor_log", read_a_log);
  module.def("write_sensor_log", write_a_log);
  module.def("read_cage", read_a_cage);
  module.def("write_cage", write_a_cage);
}

}  // namespace batten::python
