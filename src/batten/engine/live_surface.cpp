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
         length < 1.1 * b.edge_length && b.edge_length < 1.1 * length;
}

double diameter_of(const CurveNetwork& network) {
  if (network.positions.rows() == 0) return 0;
  return (network.positions.colwise().maxCoeff() - network.positions.colwise().minCoeff()).norm();
}

}  // namespace

LiveSurface::Shown LiveSurface::show(const SharedScan& scan, const ScanOptions& options,
                                     const NetworkSurfaceOptions& surface, double edge_length, bool moving,
                                     const Progress& progress) {
  if (scan != scan_) {
    surface_.reset();
    solver_ = std::make_unique<ReconstructionSolver>(*scan);
    scan_ = scan;
  }
  ScanNetwork network = moving ? solver_->follow(options, progress) : solver_->solve(options, progress);
  SurfaceOptions wanted = surface.surface;
  wanted.edge_length = edge_length * diameter_of(network.network);
  const bool can_move =
      surface_ && same_options(wanted, options_) && same_curves(network.network, network_.network);
  if (can_move) {
    surface_->move(network.network.positions, network.network.normals, {.reach = SurfaceReach::All});
  } else {
    surface_ = std::make_unique<SurfaceSolver>(network.network, wanted, progress);
    options_ = wanted;
  }
  network_ = std::move(network);
  return {&network_.network, &network_.report, &surface_->result(), !can_move};
}

}  // namespace batten::detail
