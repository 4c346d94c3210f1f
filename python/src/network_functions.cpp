#include "arrays.hpp"
#include "commands/uncertainty.hpp"
#include "commands/words.hpp"
#include "errors.hpp"
#include "functions.hpp"
#include "objects.hpp"
#include "options.hpp"
#include "reports.hpp"
#include "running.hpp"

#include <optional>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/pipeline/reconstruction.hpp"

namespace batten::python {

namespace {

/// A surface with the network that it fills.
struct Filled {
  CurveNetwork network;
  NetworkSurface surface;
  commands::Json figures = commands::Json::object();
  StageTimes times;
  std::vector<std::string> warnings;
};

void finish(const commands::SurfaceArguments& arguments, Filled& filled) {
  commands::Json& figures = filled.figures;
  NetworkSurface& surface = filled.surface;
  filled.times.add(surface.times);
  filled.warnings.insert(filled.warnings.end(), surface.warnings.begin(), surface.warnings.end());
  commands::append(commands::figures_of(arguments, surface), figures);
  if (const auto found = surface.mesh.vertex_values.find("uncertainty");
      found != surface.mesh.vertex_values.end())
    figures["uncertainty"] = commands::uncertainty_json(surface.mesh.positions, found->second);
  tell_flaws(surface.flaws, "the surface is not sound", arguments.accept_flaws, filled.warnings);
}

py::dict surface_fields(Filled&& filled, const Eigen::VectorXd* network_uncertainty) {
  py::dict fields = fields_of(MeshFile{std::move(filled.surface.mesh), {}});
  fields["unit"] = filled.network.unit;
  fields["patch_of_triangle"] = owned(std::move(filled.surface.patch_of_triangle));
  py::dict network = fields_of(std::move(filled.network));
  if (network_uncertainty != nullptr) network["uncertainty"] = owned(Eigen::VectorXd(*network_uncertainty));
  fields["network"] = network;
  return fields;
}

py::dict surface(const py::object& network, const py::dict& given, const py::object& progress) {
  const auto arguments = options_from<FillArguments>(given);
  const NetworkSurfaceOptions options = options_of(arguments.surface);
  options_of(arguments.strokes, 1);  // words are refused before the work
  Filled made = running(progress, [read = network_from(network), arguments, options](const Progress& p) {
    Filled out;
    const CurveNetwork& curves = read.network;
    if (curves.has_normals()) {
      out.network = commands::mended(arguments.strokes, curves, out.figures, out.warnings);
      if (arguments.uncertainty && read.uncertainty.size() == 0)
        out.warnings.emplace_back(
            "the network does not say how sure its curves are; they are taken as exact, and only what lies "
            "between "
            "them as unsure");
      out.surface =
          arguments.uncertainty
              ? uncertain_surface(out.network,
                                  commands::carried_uncertainty(read.uncertainty, curves, out.network),
                                  options, p)
              : network_surface(out.network, options, p);
    } else {
      if (arguments.uncertainty) throw InvalidInput("--uncertainty needs a network with normals");
      StrokeSurface filled = stroke_surface(
          curves, commands::options_of(arguments.strokes, options, bounding_box_diagonal(curves.positions)),
          p);
      if (filled.strokes) {
        commands::append(commands::figures_of(*filled.strokes), out.figures);
        out.figures["diagnosis"] = commands::diagnosis_json(*filled.strokes);
        out.times.add(filled.strokes->times);
        out.warnings.insert(out.warnings.end(), filled.strokes->warnings.begin(),
                            filled.strokes->warnings.end());
      }
      commands::append(commands::figures_of(filled), out.figures);
      if (const std::string warning = commands::warning_of(filled); !warning.empty())
        out.warnings.push_back(warning);
      out.surface = std::move(filled.surface);
      out.network = filled.implicit ? curves : std::move(filled.strokes->network);
    }
    finish(arguments.surface, out);
    return out;
  });
  const py::dict report = report_of("surface", made.figures, given, made.times, made.warnings);
  py::dict fields = surface_fields(std::move(made), nullptr);
  fields["report"] = report;
  return fields;
}

/// The scan with numbers for all nodes. @throws Error where they are not sure.
Scan numbered(const commands::NetworkArguments& arguments, Scan scan, commands::Json& figures,
              StageTimes& times, const Progress& progress) {
  if (!commands::is_first_word(arguments.nodes, "--nodes", "auto", "given")) return scan;
  const ScopedStage stage(times, "nodes");
  NodeInference found = infer_nodes(scan, progress);
  figures["inferred_nodes"] = commands::figures_of(found);
  if (found.is_sure()) return std::move(found.scan);
  std::string doubts;
  for (const std::string& doubt : found.doubts) doubts += "; " + doubt;
  throw Error(concat("the numbers of the nodes are not sure, ", found.doubts.size(), " doubts", doubts,
                     "; infer_nodes() gives the proposal to be corrected"));
}

/// A network of a scan, with its figures.
struct Scanned {
  ScanNetwork result;
  commands::Json figures = commands::Json::object();
  StageTimes times;
  std::vector<std::string> warnings;
};

void finish(Scanned& scanned) {
  const ScanReport& report = scanned.result.report;
  scanned.times.add(report.times);
  scanned.warnings.insert(scanned.warnings.end(), report.warnings.begin(), report.warnings.end());
  commands::append(commands::figures_of(scanned.result), scanned.figures);
  if (scanned.result.uncertainty)
    scanned.figures["uncertainty"] =
        commands::uncertainty_json(scanned.result.network.positions, scanned.result.uncertainty->deviations);
}

py::dict network_fields(ScanNetwork&& made) {
  py::dict fields = fields_of(std::move(made.network));
  if (made.uncertainty) fields["uncertainty"] = owned(std::move(made.uncertainty->deviations));
  return fields;
}

py::dict network_from_readings(const py::object& scan, const py::dict& given, const py::object& progress) {
  const auto arguments = options_from<commands::NetworkArguments>(given);
  const ScanOptions options = options_of(arguments);
  Scanned made = running(progress, [read = scan_from(scan), arguments, options](const Progress& p) {
    Scanned out;
    const Scan all = numbered(arguments, read, out.figures, out.times, p);
    out.result = network_from_scan(all, options, p);
    finish(out);
    return out;
  });
  const py::dict report = report_of("network", made.figures, given, made.times, made.warnings);
  py::dict fields = network_fields(std::move(made.result));
  fields["report"] = report;
  return fields;
}

py::dict reconstruct_scan(const py::object& scan, const py::object& against, const py::dict& given,
                          const py::object& progress) {
  const auto arguments = options_from<ReconstructArguments>(given);
  const ScanOptions options = options_of(arguments.network);
  const NetworkSurfaceOptions filling = options_of(arguments.surface);
  std::optional<Shape> truth;
  if (!against.is_none())
    truth =
        is_mesh(against) ? shape_of(mesh_from(against).file.mesh) : shape_of(network_from(against).network);
  struct Reconstructed {
    Scanned network;
    Filled filled;
    std::optional<TruthErrors> errors;
  };
  Reconstructed made =
      running(progress, [read = scan_from(scan), truth, arguments, options, filling](const Progress& p) {
        Reconstructed out;
        const Scan all = numbered(arguments.network, read, out.network.figures, out.network.times, p);
        ScanNetwork& scanned = out.network.result = network_from_scan(all, options, p);
        finish(out.network);
        out.filled.network = scanned.network;
        out.filled.surface = scanned.uncertainty
                                 ? uncertain_surface(scanned.network, *scanned.uncertainty, filling, p)
                                 : network_surface(scanned.network, filling, p);
        finish(arguments.surface, out.filled);
        if (truth) {
          const ScopedStage stage(out.filled.times, "compare");
          out.errors = truth_errors(shape_of(out.filled.surface.mesh), *truth, RegistrationKind::Rigid, p);
        }
        return out;
      });
  commands::Json figures = commands::Json::object();
  // The counts of what was made at the top, as every command has them; the figures of each stage by its name.
  for (const char* count : {"curves", "nodes", "segments", "cycles", "components", "boundary_loops",
                            "vertices", "faces", "genus", "watertight"})
    figures[count] = made.filled.figures[count];
  figures["network"] = made.network.figures;
  figures["surface"] = made.filled.figures;
  if (made.errors) figures["error_percent"] = commands::figures_of(*made.errors);
  StageTimes times = made.network.times;
  times.add(made.filled.times);
  std::vector<std::string> warnings = made.network.warnings;
  warnings.insert(warnings.end(), made.filled.warnings.begin(), made.filled.warnings.end());
  const py::dict report = report_of("reconstruct", figures, given, times, warnings);
  if (made.errors) made.filled.surface.mesh.vertex_values["error_percent"] = made.errors->vertices;
  const auto& uncertainty = made.network.result.uncertainty;
  py::dict fields = surface_fields(std::move(made.filled), uncertainty ? &uncertainty->deviations : nullptr);
  fields["report"] = report;
  return fields;
}

py::dict inferred(const py::object& scan, const py::object& progress) {
  NodeInference found =
      running(progress, [read = scan_from(scan)](const Progress& p) { return infer_nodes(read, p); });
  const commands::Json evidence = commands::figures_of(found);
  py::dict fields = fields_of(std::move(found.scan));
  fields["report"] = as_python(evidence);
  return fields;
}

/// @param object the name of a shape, or a Mesh.
py::dict simulate_object(const py::object& object, bool truth, bool truth_network, bool tumble,
                         const py::dict& given, const py::object& progress) {
  const auto arguments = options_from<commands::SimulateArguments>(given);
  check_arguments(arguments, tumble);
  std::optional<NamedMesh> mesh;
  std::string shape;
  if (py::isinstance<py::str>(object))
    shape = object.cast<std::string>();
  else
    mesh = mesh_from(object);
  struct Simulated {
    commands::SimulatedObject object;
    commands::Simulation made;
    commands::Json figures;
    std::optional<TriangleMesh> truth;
    std::optional<CurveNetwork> network;
    StageTimes times;
  };
  Simulated made = running(progress, [=](const Progress& p) {
    Simulated out;
    {
      const ScopedStage stage(out.times, "trace");
      out.object = mesh ? commands::traced_mesh(mesh->file.mesh, arguments) : commands::traced_shape(shape);
    }
    p.report("simulate", 0);
    {
      const ScopedStage stage(out.times, "simulate");
      out.made = commands::simulate(arguments, out.object, tumble);
    }
    out.figures = commands::figures_of(out.object, out.made.simulated);
    if (!arguments.raw) commands::leave_out_numbers(arguments.nodes, out.made.simulated.scan);
    p.report("truth", 0);
    if (truth_network) {
      out.network = true_network(arguments, out.object);
      out.figures["truth_network_vertices"] = out.network->positions.rows();
    }
    if (truth) {
      out.truth = true_mesh(arguments, out.object);
      out.figures["truth_faces"] = out.truth->n_triangles();
    }
    return out;
  });
  py::dict fields;
  fields["report"] = report_of("simulate", made.figures, given, made.times, made.object.traced.warnings);
  fields["scan"] = fields_of(std::move(made.made.simulated.scan));
  fields["log"] = made.made.log ? py::object(fields_of(std::move(*made.made.log))) : py::none();
  fields["tumble"] = made.made.tumble ? py::object(fields_of(std::move(*made.made.tumble))) : py::none();
  fields["truth"] = made.truth ? py::object(fields_of(MeshFile{std::move(*made.truth), {}})) : py::none();
  fields["truth_network"] = made.network ? py::object(fields_of(std::move(*made.network))) : py::none();
  return fields;
}

}  // namespace

void add_network_functions(py::module_& module) {
  module.def("surface", surface);
  module.def("network_from_scan", network_from_readings);
  module.def("reconstruct", reconstruct_scan);
  module.def("infer_nodes", inferred);
  module.def("simulate", simulate_object);
}

}  // namespace batten::python
