// Catmull–Clark limit surfaces as bicubic B-splines. A control point of a B-spline with simple inner knots a
// ≤ b ≤ c is the polar form (blossom) of the polynomial of a nearby cell at (a, b, c) [ramshaw1989]; the
// cells are the uniform B-splines that adaptive refinement leaves, so nothing is fitted where the surface is
// regular.
#include "batten/subdivision/bspline_surface.hpp"

#include <algorithm>
#include <cmath>

#include "batten/core/disjoint_sets.hpp"
#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/subdivision/bspline_basis_detail.hpp"
#include "batten/subdivision/bspline_pieces_detail.hpp"
#include "batten/subdivision/cage_topology_detail.hpp"
#include "batten/subdivision/catmull_clark_detail.hpp"
#include "batten/subdivision/isolated_limit_detail.hpp"
#include "batten/subdivision/subdivide.hpp"

namespace batten {

namespace {

using detail::CageTopology;

constexpr int kMostPatches = 200000;

BsplineSurface build(const detail::IsolatedLimit& limit, const Progress& progress) {
  BsplineSurface surface;
  surface.isolation = limit.isolation();
  surface.vertices = limit.surface().vertex_positions;
  detail::build_edges(limit, surface);
  const int n_faces = static_cast<int>(limit.cage().mesh.n_faces());
  surface.patches.resize(at(n_faces));
  for (int f = 0; f < n_faces; ++f) {
    if (f % 256 == 0) progress.report("patches", static_cast<double>(f) / n_faces);
    detail::build_patch(limit, surface, f);
  }
  for (int f = 0; f < n_faces; ++f) detail::measure_deviation(limit, surface, f);
  detail::measure_normals(limit, surface);
  return surface;
}

int count_components(const CageTopology& topology, Eigen::Index n_faces) {
  DisjointSets parts(static_cast<int>(n_faces));
  for (const std::array<int, 2>& sides : topology.sides)
    if (sides[1] >= 0)
      parts.unite(topology.face_of_corner[at(sides[0])], topology.face_of_corner[at(sides[1])]);
  return parts.n_sets();
}

/// How often a cage must be refined until it is all quads and nothing is semi-sharp.
int levels_to_resolve(const ControlCage& cage) {
  int levels = 0;
  for (size_t f = 0; f + 1 < cage.mesh.offsets.size(); ++f)
    if (cage.mesh.offsets[f + 1] - cage.mesh.offsets[f] != 4) levels = 1;
  const auto outlast = [&levels](double sharpness) {
    if (std::isfinite(detail::sharpness_after(sharpness, 0)))
      levels = std::max(levels, static_cast<int>(std::ceil(sharpness)));
  };
  for (const SharpEdge& edge : cage.sharp_edges) outlast(edge.sharpness);
  for (const SharpVertex& vertex : cage.sharp_vertices) outlast(vertex.sharpness);
  return levels;
}

/// @throws InvalidInput where the patches would be too many.
void check_size(const ControlCage& cage, int levels) {
  const double n_patches = levels == 0
                               ? static_cast<double>(cage.mesh.n_faces())
                               : static_cast<double>(cage.mesh.corners.size()) * std::pow(4, levels - 1);
  if (n_patches > kMostPatches)
    throw InvalidInput(
        levels > 1 ? concat("the semi-sharp features last ", levels, " levels; resolving them would make ",
                            n_patches, " patches, and at most ", kMostPatches,
                            " are made: lower the sharpness, or set it to 10, which is sharp for ever")
                   : concat("the cage would make ", n_patches, " patches, and at most ", kMostPatches,
                            " are made: simplify it first"));
}

}  // namespace

std::optional<std::string> BsplineOptions::problem() const {
  if (!(tolerance > 0)) return concat("tolerance must be > 0, got ", tolerance);
  if (most_isolation < detail::kLeastIsolation || most_isolation > 6)
    return concat("most_isolation must be 2 to 6, got ", most_isolation);
  return std::nullopt;
}

BsplineSurface limit_bsplines(const ControlCage& cage, const BsplineOptions& options,
                              const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  ControlCage quads = cage;
  detail::CageTopology topology = detail::cage_topology(cage.mesh);
  detail::edge_sharpness(cage, topology);  // checks what the cage says of sharpness before it is believed
  detail::vertex_sharpness(cage);
  const int levels = levels_to_resolve(cage);
  std::vector<int> parents(static_cast<size_t>(cage.mesh.n_faces()));
  for (size_t f = 0; f < parents.size(); ++f) parents[f] = static_cast<int>(f);
  check_size(cage, levels);
  if (levels > 0) {
    SubdividedSurface refined =
        subdivide(cage, {.levels = levels, .smooth_corners = options.smooth_corners}, progress);
    quads = std::move(refined.cage);
    parents = std::move(refined.face_parent);
    topology = detail::cage_topology(quads.mesh);
  }
  const std::vector<double> sharpness = detail::edge_sharpness(quads, topology);
  const detail::LimitCells limit = detail::limit_cells(
      quads, topology, options.most_isolation + detail::kSampledHalvings, options.smooth_corners);
  const double tolerance = options.tolerance * bounding_box_diagonal(cage.mesh.positions);
  BsplineSurface surface;
  for (int isolation = detail::kLeastIsolation; isolation <= options.most_isolation; ++isolation) {
    surface = build(detail::IsolatedLimit(quads, topology, limit, sharpness, isolation), progress);
    if (surface.deviation <= tolerance) break;
  }
  surface.levels = levels;
  surface.n_components = count_components(topology, quads.mesh.n_faces());
  surface.is_closed = std::all_of(topology.sides.begin(), topology.sides.end(),
                                  [](const std::array<int, 2>& sides) { return sides[1] >= 0; });
  for (BsplinePatch& patch : surface.patches) patch.face = parents[at(patch.face)];
  return surface;
}

PatchPoint evaluate(const BsplinePatch& patch, double u, double v) {
  const detail::BsplineBasis of_u = detail::bspline_basis(patch.knots_u, u),
                             of_v = detail::bspline_basis(patch.knots_v, v);
  PatchPoint point{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector3d p =
          patch.control_points.row((of_v.first + j) * patch.n_u() + of_u.first + i).transpose();
      point.position += of_u.value[i] * of_v.value[j] * p;
      point.along_u += of_u.derivative[i] * of_v.value[j] * p;
      point.along_v += of_u.value[i] * of_v.derivative[j] * p;
    }
  return point;
}

std::array<double, 2> on_patch_side(int k, double t) {
  switch (k) {
    case 0:
      return {t, 0};
    case 1:
      return {1, t};
    case 2:
      return {1 - t, 1};
    default:
      return {0, 1 - t};
  }
}

Eigen::Vector3d evaluate(const BsplineCurve& curve, double t) {
  const detail::BsplineBasis of_t = detail::bspline_basis(curve.knots, t);
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  for (int i = 0; i < 4; ++i) point += of_t.value[i] * curve.control_points.row(of_t.first + i).transpose();
  return point;
}

}  // namespace batten
