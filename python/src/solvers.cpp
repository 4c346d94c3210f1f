#include "arrays.hpp"
#include "commands/uncertainty.hpp"
#include "commands/words.hpp"
#include "errors.hpp"
#include "functions.hpp"
#include "objects.hpp"
#include "options.hpp"
#include "reports.hpp"
#include "running.hpp"

#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include <pybind11/stl.h>

#include "batten/core/error.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/scan/reconstruct.hpp"
#include "batten/surfacing/surface.hpp"

namespace batten::python {

namespace {

/// A solver that one thread uses at a time. Work that was interrupted may hold it a while longer; whoever
/// comes next waits for it, and can be interrupted in turn.
template <typename Solver>
struct Kept {
  explicit Kept(Solver made) : solver(std::move(made)) {}
  std::mutex mutex;
  Solver solver;
};

class SurfaceSolverHolder {
 public:
  SurfaceSolverHolder(const py::object& network, const py::dict& given, const py::object& progress) {
    const auto arguments = options_from<KeptArguments>(given);
    const NetworkSurfaceOptions options = options_of(arguments.surface);
    kept_ = running(progress, [read = network_from(network).network, options](const Progress& p) {
      if (const auto problem = options.problem()) throw InvalidInput(*problem);
      SurfaceOptions surface = options.surface;
      if (options.edge_length)
        surface.edge_length = options.edge_length->in_file_units(bounding_box_diagonal(read.positions));
      return std::make_shared<Kept<SurfaceSolver>>(SurfaceSolver(read, surface, p));
    });
    n_ = network_from(network).network.positions.rows();
  }

  py::dict move(const py::object& positions, const py::object& normals, const std::string& reach,
                bool positions_only, const py::object& progress) {
    Points X = points_from(positions, "positions"), N = points_from(normals, "normals");
    for (const auto& [points, name] : {std::pair(&X, "positions"), std::pair(&N, "normals")})
      if (points->rows() != n_)
        throw InvalidInput(std::string(name) + " must have " + std::to_string(n_) +
                           " rows, one for each vertex of the network, got " +
                           std::to_string(points->rows()));
    SurfaceMoveOptions options;
    options.positions_only = positions_only;
    options.reach = commands::is_first_word(reach, "--reach", "touched", "all") ? SurfaceReach::Touched
                                                                                : SurfaceReach::All;
    const SurfaceMove moved =
        running(progress, [kept = kept_, X = std::move(X), N = std::move(N), options](const Progress&) {
          const std::lock_guard<std::mutex> lock(kept->mutex);
          return kept->solver.move(X, N, options);
        });
    const auto ranges = [](const std::vector<VertexRange>& all) {
      py::list list;
      for (const VertexRange& range : all) list.append(py::make_tuple(range.first, range.end));
      return list;
    };
    py::dict fields;
    fields["positions"] = ranges(moved.positions);
    fields["normals"] = ranges(moved.normals);
    fields["patches_solved"] = moved.patches_solved;
    return fields;
  }

  /// A copy of a part of the result: the next move changes it in place.
  template <typename Get>
  auto copy(const Get& get) const {
    const py::gil_scoped_release released;
    const std::lock_guard<std::mutex> lock(kept_->mutex);
    return get(kept_->solver.result());
  }

 private:
  std::shared_ptr<Kept<SurfaceSolver>> kept_;
  Eigen::Index n_ = 0;
};

class ReconstructionSolverHolder {
 public:
  explicit ReconstructionSolverHolder(const py::object& scan)
      : kept_(std::make_shared<Kept<ReconstructionSolver>>(ReconstructionSolver(scan_from(scan)))) {}

  py::dict solve(bool moving, const py::dict& given, const py::object& progress) {
    const auto arguments = options_from<commands::NetworkArguments>(given);
    const ScanOptions options = options_of(arguments);
    ScanNetwork made = running(progress, [kept = kept_, options, moving](const Progress& p) {
      const std::lock_guard<std::mutex> lock(kept->mutex);
      return moving ? kept->solver.follow(options, p) : kept->solver.solve(options, p);
    });
    commands::Json figures = commands::figures_of(made);
    if (made.uncertainty)
      figures["uncertainty"] =
          commands::uncertainty_json(made.network.positions, made.uncertainty->deviations);
    const py::dict report = report_of("network", figures, given, made.report.times, made.report.warnings);
    py::dict fields = fields_of(std::move(made.network));
    if (made.uncertainty) fields["uncertainty"] = owned(std::move(made.uncertainty->deviations));
    fields["report"] = report;
    return fields;
  }

 private:
  std::shared_ptr<Kept<ReconstructionSolver>> kept_;
};

}  // namespace

void add_solvers(py::module_& module) {
  py::class_<SurfaceSolverHolder>(module, "SurfaceSolver")
      .def(py::init<const py::object&, const py::dict&, const py::object&>())
      .def("move", &SurfaceSolverHolder::move)
      .def_property_readonly(
          "positions",
          [](const SurfaceSolverHolder& self) {
            return owned(self.copy([](const SurfaceResult& result) { return result.mesh.positions; }));
          })
      .def_property_readonly(
          "normals",
          [](const SurfaceSolverHolder& self) {
            return owned(self.copy([](const SurfaceResult& result) { return result.mesh.normals; }));
          })
      .def_property_readonly(
          "triangles",
          [](const SurfaceSolverHolder& self) {
            return owned(self.copy([](const SurfaceResult& result) { return result.mesh.triangles; }));
          })
      .def_property_readonly(
          "patch_of_triangle",
          [](const SurfaceSolverHolder& self) {
            return owned(self.copy([](const SurfaceResult& result) { return result.patch_of_triangle; }));
          })
      .def_property_readonly("on_network",
                             [](const SurfaceSolverHolder& self) {
                               const auto on =
                                   self.copy([](const SurfaceResult& result) { return result.on_network; });
                               py::array_t<bool> array(static_cast<py::ssize_t>(on.size()));
                               for (std::size_t v = 0; v < on.size(); ++v)
                                 array.mutable_data()[v] = on[v] != 0;
                               return array;
                             })
      .def_property_readonly("warnings", [](const SurfaceSolverHolder& self) {
        return spoken(self.copy([](const SurfaceResult& result) { return result.warnings; }));
      });
  py::class_<ReconstructionSolverHolder>(module, "ReconstructionSolver")
      .def(py::init<const py::object&>())
      .def("solve", &ReconstructionSolverHolder::solve);
}

}  // namespace batten::python
