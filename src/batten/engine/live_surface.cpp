#include <utility>

#include "batten/engine/live_surface_detail.hpp"

namespace batten::detail {

namespace {

/// Whether a surface through one network can be moved to another one: the same curves over the same vertices.
bool same_curves(const CurveNetwork& a, const CurveNetwork& b) {
  if (a.positions.rows() != b.positions.rows() || a.curves.size() != b.curves.size()) return false;
  for (std::size_t c = 0; c < a.curves.size(); ++c)
    if (a.curves[c].vertices != b.curves[c].vertices || a.curves[c].boundary != b.curves[c].boundary)
      return false;
  return true;
}

bool same_options(const SurfaceOptions& a, const SurfaceOptions& b) {
  const auto& [method, map, order, rebuilds, soft, weight, length, most] = a;
  // The length follows the diameter, which moves a little with every position of a slider: a surface that is
  // only a preview keeps its triangles until it differs by a tenth.
  return method == b.method && map == b.map && order == b.base_order && rebuilds == b.rebuilds &&
         soft == b.soft_constraints && weight == b.soft_weight && most == b.max_triangles &&
         length <= 1.1 * b.edge_length && b.edge_length <= 1.1 * length;
}

double diameter_of(const CurveNetwork& network) {
  if (network.positions.rows() == 0) return 0;
  return (network.positions.colwise().maxCoeff() - network.positions.colwise().minCoeff()).norm();
}

}  // namespace

LiveSurface::Shown LiveSurface::show(const SharedScan& scan, const ScanOptions& options,
                                     const NetworkSurfaceOptions& surface, LiveDetail detail,
                                     double edge_length, bool moving, const Progress& progress) {
  if (scan != scan_) {
    for (Kept& kept : surfaces_) kept.solver.reset();
    solver_ = std::make_unique<ReconstructionSolver>(*scan);
    scan_ = scan;
  }
  ScanNetwork made = moving ? solver_->follow(options, progress) : solver_->solve(options, progress);
  const double size = diameter_of(made.network);
  SurfaceOptions wanted = surface.surface;
  if (detail == LiveDetail::Coarse)
    wanted.edge_length = edge_length * size;
  else if (surface.edge_length)
    wanted.edge_length = surface.edge_length->in_file_units(size);
  Kept& kept = surfaces_[detail == LiveDetail::Coarse ? 0 : 1];
  const bool can_move =
      kept.solver && same_options(wanted, kept.options) && same_curves(made.network, kept.network);
  if (can_move) {
    kept.solver->move(made.network.positions, made.network.normals, {.reach = SurfaceReach::All});
  } else {
    kept.solver = std::make_unique<SurfaceSolver>(made.network, wanted, progress);
    kept.options = wanted;
  }
  kept.network = std::move(made.network);
  report_ = std::move(made.report);
  return {&kept.network, &report_, &kept.solver->result(), !can_move};
}

}  // namespace batten::detail
