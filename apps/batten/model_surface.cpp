#include "model_surface.hpp"

#include <algorithm>
#include <map>

#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/sketch/diffusion_surface.hpp"
#include "batten/sketch/model_network.hpp"
#include "batten/subdivision/subdivide.hpp"
#include "batten/surfacing/surface.hpp"

namespace batten::cli {

namespace {

/// Quads as triangles, cut along the shorter diagonal.
Triangles cut_quads(const PolygonMesh& mesh) {
  Triangles triangles(2 * mesh.n_faces(), 3);
  for (Eigen::Index f = 0; f < mesh.n_faces(); ++f) {
    const int* c = &mesh.corners[static_cast<size_t>(mesh.offsets[static_cast<size_t>(f)])];
    const auto p = [&](int k) { return mesh.positions.row(c[k]); };
    const int first = (p(0) - p(2)).squaredNorm() <= (p(1) - p(3)).squaredNorm() ? 0 : 1;
    triangles.row(2 * f) << c[first], c[first + 1], c[first + 2];
    triangles.row(2 * f + 1) << c[first], c[first + 2], c[(first + 3) % 4];
  }
  return triangles;
}

/// The limit surface of a cage at a level.
TriangleMesh limit_mesh(const ControlCage& cage, int levels, ModelSurface& result, const Progress& progress) {
  const ScopedStage stage(result.times, "subdivision");
  SubdivisionOptions subdivision;
  subdivision.levels = levels;
  subdivision.limit = true;
  const SubdividedSurface fine = subdivide(cage, subdivision, progress);
  TriangleMesh mesh;
  mesh.positions = fine.limit_positions;
  mesh.normals = fine.limit_normals;
  mesh.triangles = cut_quads(fine.cage.mesh);
  return mesh;
}

Json figures_of(const CurveContinuity& c, double diameter) {
  return {{"samples", c.n_samples},
          {"max_normal_jump_deg", degrees(c.max_normal_jump)},
          {"mean_normal_jump_deg", degrees(c.mean_normal_jump)},
          {"max_curvature_jump", c.max_curvature_jump * diameter},
          {"mean_curvature_jump", c.mean_curvature_jump * diameter},
          {"max_gap", c.max_gap / diameter},
          {"max_distance", c.max_distance / diameter},
          {"worst", {c.worst.x(), c.worst.y(), c.worst.z()}}};
}

}  // namespace

const std::vector<std::string>& model_surface_methods() {
  static const std::vector<std::string> methods = {"v2", "curvature"};
  return methods;
}

ModelSurface make_model_surface(const PolylineMesh& model, const ModelSurfaceOptions& options, bool with_mesh,
                                const Progress& progress) {
  ModelSurface result;
  DiffusionOptions diffusion;
  diffusion.splits = options.splits;
  // Filling the network does not refine it any further, so it wants more samples along its curves.
  if (options.method == "curvature") diffusion.splits = std::min(options.splits + 1, 6);
  DiffusionSurface surface = diffusion_surface(model, diffusion, progress);
  result.times.add(surface.times);
  result.figures["quads"] = surface.refined.mesh.n_faces();
  result.figures["last_move"] = surface.last_move;
  if (with_mesh && options.method == "curvature") {
    SurfaceResult filled = surface_network(network_of_model(model, surface), {}, progress);
    result.times.add(filled.times);
    result.warnings = std::move(filled.warnings);
    result.figures["cycles"] = filled.n_cycles;
    result.figures["folded_triangles"] = filled.folded_triangles;
    result.mesh = std::move(filled.mesh);
  } else if (with_mesh) {
    result.mesh = limit_mesh(surface.cage, options.levels, result, progress);
  }
  result.cage = std::move(surface.cage);
  return result;
}

ModelContinuity model_continuity(const PolylineMesh& model, const TriangleMesh& mesh,
                                 const Progress& progress) {
  std::vector<int> edges;
  std::vector<Points> polylines;
  for (size_t e = 0; e < model.edges().size(); ++e) {
    const SketchEdge& edge = model.edges()[e];
    if (!edge.alive) continue;
    edges.push_back(static_cast<int>(e));
    polylines.push_back(edge.polyline->points());
  }
  // Ties take part all the same: they may be sharp, and then no neighbourhood should go over them.
  const std::vector<CurveContinuity> measured =
      curve_continuity(mesh.positions, mesh.triangles, polylines, {}, progress);
  ModelContinuity result;
  std::map<int, std::vector<CurveContinuity>> of_curve;
  std::map<int, double> sharpness;
  std::vector<CurveContinuity> smooth, sharp;
  double worst = -1;
  for (size_t k = 0; k < edges.size(); ++k) {
    const SketchEdge& edge = model.edge(edges[k]);
    if (!edge.drawn || edge.faces[0] < 0 || edge.faces[1] < 0) continue;
    of_curve[edge.curve].push_back(measured[k]);
    sharpness[edge.curve] = std::max(sharpness[edge.curve], edge.sharpness);
    (edge.sharpness > 0 ? sharp : smooth).push_back(measured[k]);
    if (edge.sharpness == 0 && measured[k].n_samples > 0 && measured[k].max_normal_jump > worst) {
      worst = measured[k].max_normal_jump;
      result.worst_curve = edge.curve;
    }
  }
  for (const auto& [curve, pieces] : of_curve)
    result.curves.push_back({curve, sharpness[curve], joint_continuity(pieces)});
  result.smooth = joint_continuity(smooth);
  result.sharp = joint_continuity(sharp);
  return result;
}

Json continuity_json(const ModelContinuity& continuity, double diameter) {
  Json json = {{"smooth", nullptr}, {"sharp", nullptr}, {"curves", Json::array()}};
  if (continuity.smooth.n_samples > 0) {
    json["smooth"] = figures_of(continuity.smooth, diameter);
    json["smooth"]["worst_curve"] = concat("c", continuity.worst_curve);
  }
  if (continuity.sharp.n_samples > 0) json["sharp"] = figures_of(continuity.sharp, diameter);
  for (const ModelContinuity::CurveEntry& entry : continuity.curves) {
    Json figures = {{"id", concat("c", entry.curve)}, {"sharpness", entry.sharpness}};
    figures.update(figures_of(entry.figures, diameter));
    json["curves"].push_back(std::move(figures));
  }
  return json;
}

}  // namespace batten::cli
