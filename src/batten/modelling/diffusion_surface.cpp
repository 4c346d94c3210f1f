// Based on H 6.4; the split is in face_split.cpp, the flow in curvature_flow.cpp.
#include "batten/modelling/diffusion_surface.hpp"

#include <cmath>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/modelling/cage_fit_detail.hpp"
#include "batten/modelling/refined_mesh_detail.hpp"
#include "batten/modelling/region_flow_detail.hpp"
#include "batten/modelling/surface_records_detail.hpp"

namespace batten {

namespace {

using Eigen::Index;

/// Rings of faces around the touched ones that the flow moves at once; more follow where the change goes on.
constexpr int kFirstRings = 1;
/// The weights by which a cage follows its limit points fall to 1e-5 over so many quads.
constexpr int kReachOfCage = 8;

}  // namespace

struct EditedSurface::Implementation {
  detail::SurfaceRecords records;
  SurfaceUpdate last;

  /// Moves the region, and as many rings of faces around it as the change reaches.
  void flow(detail::FaceSet& region, const PolylineMesh& mesh, const Progress& progress) {
    const double diameter = mesh.diameter();
    for (int ring = 0; ring < kFirstRings; ++ring) records.grow(region, mesh);
    for (bool start = true;; start = false) {
      detail::FaceSet surroundings = region;
      const bool whole = !records.grow(surroundings, mesh);
      records.close_fans(surroundings, mesh);
      const double rim =
          detail::move_region(records, region, surroundings, start, mesh, diameter, last, progress);
      for (const int f : region.list) records.faces[at(f)].stale = true;
      if (!whole && rim > records.options.tolerance)
        records.grow(region, mesh);
      else if (!detail::freeze_folded(records, region, mesh))
        break;
    }
  }

  /// Refuses what is unsound in the region.
  void require_sound(const detail::FaceSet& region, const PolylineMesh& mesh) {
    const detail::SurfacePart parts = records.part(records.near_to(region), mesh);
    Points start(static_cast<Index>(parts.vertices.size()), 3);
    for (size_t v = 0; v < parts.vertices.size(); ++v)
      start.row(static_cast<Index>(v)) = records.targets[at(parts.vertices[v])].transpose();
    detail::require_sound(parts.mesh, parts.face_of_quad,
                          records.options.fidelity > 0 ? parts.soft : parts.held, start);
  }

  /// Lets the cage follow the region.
  void fit_cage(const detail::FaceSet& region, const PolylineMesh& mesh) {
    detail::FaceSet around = region;
    for (int reach = 0; reach < kReachOfCage + 1; reach += 1 << records.options.splits)
      if (!records.grow(around, mesh)) break;
    records.close_fans(around, mesh);
    const detail::SurfacePart part_of = records.part(around, mesh);
    ControlCage fitted;
    fitted.mesh = part_of.mesh;
    fitted.sharp_edges = part_of.sharp_edges;
    for (size_t v = 0; v < part_of.vertices.size(); ++v)
      fitted.mesh.positions.row(static_cast<Index>(v)) = records.cage[at(part_of.vertices[v])].transpose();
    last.cage_fit = detail::fit_limit(fitted, part_of.mesh.positions, part_of.complete,
                                      records.options.fidelity > 0 ? part_of.soft : part_of.held);
    for (size_t v = 0; v < part_of.vertices.size(); ++v)
      records.cage[at(part_of.vertices[v])] = fitted.mesh.positions.row(static_cast<Index>(v));
  }
};

EditedSurface::EditedSurface(const DiffusionOptions& options)
    : implementation_(std::make_unique<Implementation>()) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  implementation_->records.options = options;
}
EditedSurface::~EditedSurface() = default;
EditedSurface::EditedSurface(EditedSurface&&) noexcept = default;
EditedSurface& EditedSurface::operator=(EditedSurface&&) noexcept = default;

SurfaceUpdate EditedSurface::update(const PolylineMesh& mesh, const Progress& progress) {
  Implementation& own = *implementation_;
  detail::SurfaceRecords& records = own.records;
  double quads = 0;
  for (const SketchFace& face : mesh.faces()) quads += static_cast<double>(face.sides.size());
  quads *= std::pow(4.0, records.options.splits - 1);
  if (quads == 0) throw InvalidInput("the model has no faces; insert a closed curve first");
  if (quads > 2e6)
    throw InvalidInput(concat("the refined mesh would have ", quads, " quads; use fewer splits"));
  own.last = SurfaceUpdate();
  std::vector<int> stale;
  {
    const ScopedStage stage(own.last.times, "refine");
    records.adopt(mesh);
    for (size_t f = 0; f < records.faces.size(); ++f)
      if (records.faces[f].stale) stale.push_back(static_cast<int>(f));
  }
  if (stale.empty()) return own.last;
  detail::FaceSet region = records.set_of(stale, mesh);
  {
    const ScopedStage stage(own.last.times, "flow");
    own.flow(region, mesh, progress);
  }
  {
    const ScopedStage stage(own.last.times, "check");
    if (!records.options.keep_folded || !records.is_finite(region)) own.require_sound(region, mesh);
  }
  for (const int f : stale)
    for (const int v : records.faces[at(f)].inner) records.cage[at(v)] = records.positions[at(v)];
  {
    const ScopedStage stage(own.last.times, "cage");
    own.fit_cage(region, mesh);
  }
  for (const int f : region.list) {
    records.faces[at(f)].stale = false;
    own.last.quads += static_cast<Index>(records.faces[at(f)].quads.size());
  }
  own.last.faces = region.list;
  for (size_t f = 0; f < records.faces.size(); ++f)
    if (records.faces[f].frozen) own.last.not_smoothed.push_back(static_cast<int>(f));
  return own.last;
}

DiffusionSurface EditedSurface::surface(const PolylineMesh& mesh) const {
  const detail::SurfaceRecords& own = implementation_->records;
  const SurfaceUpdate& last = implementation_->last;
  DiffusionSurface surface;
  std::vector<int> number(own.positions.size(), -1), order;
  const auto take = [&](int v) {
    number[at(v)] = static_cast<int>(order.size());
    order.push_back(v);
  };
  for (const int v : own.of_vertex)
    if (v >= 0) take(v);
  for (const detail::EdgeRecord& edge : own.edges)
    for (size_t k = 1; k + 1 < edge.chain.size(); ++k) take(edge.chain[k]);
  for (const detail::FaceRecord& face : own.faces)
    for (const int v : face.inner) take(v);
  surface.on_curve.assign(order.size(), 0);
  surface.vertices_of_edge.resize(mesh.edges().size());
  for (size_t e = 0; e < mesh.edges().size(); ++e) {
    const detail::EdgeRecord& edge = own.edges[e];
    std::vector<int>& chain = surface.vertices_of_edge[e];
    for (size_t k = 0; k < edge.chain.size(); ++k) {
      chain.push_back(number[at(edge.chain[k])]);
      if (edge.drawn || k == 0 || k + 1 == edge.chain.size()) surface.on_curve[at(chain.back())] = 1;
      if (k > 0 && edge.sharpness > 0)
        surface.refined.sharp_edges.push_back(
            {chain[k - 1], chain[k], detail::crease_sharpness(edge.sharpness)});
    }
  }
  PolygonMesh& refined = surface.refined.mesh;
  refined.positions.resize(static_cast<Index>(order.size()), 3);
  for (size_t v = 0; v < order.size(); ++v)
    refined.positions.row(static_cast<Index>(v)) = own.positions[at(order[v])].transpose();
  for (size_t f = 0; f < own.faces.size(); ++f)
    for (const std::array<int, 4>& quad : own.faces[f].quads) {
      for (const int v : quad) refined.corners.push_back(number[at(v)]);
      refined.offsets.push_back(static_cast<int>(refined.corners.size()));
      surface.face_of_quad.push_back(static_cast<int>(f));
    }
  for (const detail::FaceRecord& face : own.faces)
    for (const auto& [corner, next] : face.relief)
      surface.refined.sharp_edges.push_back({number[at(corner)], number[at(next)], kInfinitelySharp});
  detail::turn_outwards(mesh, refined, surface.face_of_quad);
  surface.cage = surface.refined;
  for (size_t v = 0; v < order.size(); ++v)
    surface.cage.mesh.positions.row(static_cast<Index>(v)) = own.cage[at(order[v])].transpose();
  surface.last_move = last.last_move;
  surface.not_smoothed = last.not_smoothed;
  surface.cage_fit = last.cage_fit;
  surface.times = last.times;
  return surface;
}

std::optional<std::string> DiffusionOptions::problem() const {
  if (splits < 1 || splits > 6) return concat("splits must be 1 to 6, got ", splits);
  if (rounds < 0 || rounds > 200) return concat("rounds must be 0 to 200, got ", rounds);
  if (!(tolerance > 0) || !std::isfinite(tolerance))
    return concat("tolerance must be above 0, got ", tolerance);
  if (!(time_step > 0) || !std::isfinite(time_step))
    return concat("time_step must be above 0, got ", time_step);
  if (diffusion_steps < 1 || diffusion_steps > 1000)
    return concat("diffusion_steps must be 1 to 1000, got ", diffusion_steps);
  if (!(similarity > 0) || !std::isfinite(similarity))
    return concat("similarity must be above 0, got ", similarity);
  if (!(fidelity >= 0) || !std::isfinite(fidelity))
    return concat("fidelity must be at least 0, got ", fidelity);
  return std::nullopt;
}

DiffusionSurface diffusion_surface(const PolylineMesh& mesh, const DiffusionOptions& options,
                                   const Progress& progress) {
  EditedSurface edited(options);
  edited.update(mesh, progress);
  return edited.surface(mesh);
}

}  // namespace batten
