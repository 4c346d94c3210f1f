#include "model_surface.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <Eigen/Eigenvalues>

#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/modelling/diffusion_surface.hpp"
#include "batten/modelling/model_network.hpp"
#include "batten/subdivision/subdivide.hpp"

namespace batten::cli {

namespace {

/// Directions of curves within this of a plane, rms, radians: a surface can be smooth there. They are taken
/// over a twentieth of the edges, in which curves bend.
constexpr double kFlat = 0.25;

/// Quads as triangles, cut along the shorter diagonal, but through a vertex that has only two quads: both cut
/// past it would share the diagonal as well, and the mesh would be no surface there.
Triangles cut_quads(const PolygonMesh& mesh) {
  Triangles triangles(2 * mesh.n_faces(), 3);
  std::vector<int> n_quads(static_cast<size_t>(mesh.positions.rows()), 0);
  for (const int v : mesh.corners) ++n_quads[static_cast<size_t>(v)];
  for (Eigen::Index f = 0; f < mesh.n_faces(); ++f) {
    const int* c = &mesh.corners[static_cast<size_t>(mesh.offsets[static_cast<size_t>(f)])];
    const auto p = [&](int k) { return mesh.positions.row(c[k]); };
    const auto has_two = [&](int k) { return n_quads[static_cast<size_t>(c[k])] == 2; };
    const bool through_even = has_two(0) || has_two(2), through_odd = has_two(1) || has_two(3);
    const bool shorter_even = (p(0) - p(2)).squaredNorm() <= (p(1) - p(3)).squaredNorm();
    const int first = (through_even != through_odd ? through_even : shorter_even) ? 0 : 1;
    triangles.row(2 * f) << c[first], c[first + 1], c[first + 2];
    triangles.row(2 * f + 1) << c[first], c[first + 2], c[(first + 3) % 4];
  }
  return triangles;
}

/// Lists faces in `json` and returns their names for a sentence: "f3, f7".
template <typename Faces>
std::string name_faces(const Faces& faces, Json& json) {
  json = Json::array();
  std::string names;
  for (const int face : faces) {
    json.push_back(concat("f", face));
    names += concat(names.empty() ? "f" : ", f", face);
  }
  return names;
}

/// Pairs of crossing triangles that are counted; more are told as "at least".
constexpr size_t kMostCrossings = 100000;

/// Counts what is broken in a finished surface and names the faces in which it is.
/// @param turned triangles against their normals. @param face_of_triangle of the model.
void tell_soundness(const std::vector<int>& turned, const std::vector<int>& face_of_triangle,
                    ModelSurface& result) {
  const ScopedStage stage(result.times, "check");
  const auto crossing = self_intersections(result.mesh.positions, result.mesh.triangles, kMostCrossings);
  result.figures["crossing_pairs"] = crossing.size();
  result.figures["turned_triangles"] = turned.size();
  std::set<int> faces;
  const auto note = [&](int triangle) { faces.insert(face_of_triangle[static_cast<size_t>(triangle)]); };
  for (const auto& [one, other] : crossing) note(one), note(other);
  for (const int triangle : turned) note(triangle);
  const std::string names = name_faces(faces, result.figures["broken_faces"]);
  if (faces.empty()) return;
  result.warnings.push_back(concat("the finished surface is not sound in ", names, ": ",
                                   crossing.size() == kMostCrossings ? "at least " : "", crossing.size(),
                                   " pairs of triangles cross and ", turned.size(),
                                   " are turned over; divide these faces by another curve, or make curves "
                                   "sharp along which the surface is to turn"));
}

/// Triangles against the normals of the surface. Those of vertices on creases, means of both sides, do not
/// count: where the sides meet at a sharp angle, sound triangles lie against them.
std::vector<int> turned_triangles(const TriangleMesh& mesh, const std::vector<char>& on_crease) {
  Points normals = mesh.normals;
  for (size_t v = 0; v < on_crease.size(); ++v)
    if (on_crease[v]) normals.row(static_cast<Eigen::Index>(v)).setZero();
  std::vector<int> turned = folded_triangles(mesh.positions, mesh.triangles, normals);
  const auto all_on_crease = [&](int t) {
    const auto on = [&](int k) { return on_crease[static_cast<size_t>(mesh.triangles(t, k))] != 0; };
    return on(0) && on(1) && on(2);
  };
  turned.erase(std::remove_if(turned.begin(), turned.end(), all_on_crease), turned.end());
  return turned;
}

struct LimitMesh {
  TriangleMesh mesh;
  std::vector<int> face_of_triangle;  ///< of the model
  std::vector<char> on_crease;        ///< per vertex
};

/// The limit surface of a cage at a level. @param face_of_quad face of the model per quad of the cage.
LimitMesh limit_mesh(const ControlCage& cage, int levels, const std::vector<int>& face_of_quad,
                     ModelSurface& result, const Progress& progress) {
  const ScopedStage stage(result.times, "subdivision");
  SubdivisionOptions subdivision;
  subdivision.levels = levels;
  subdivision.limit = true;
  const SubdividedSurface fine = subdivide(cage, subdivision, progress);
  LimitMesh limit;
  limit.mesh.positions = fine.limit_positions;
  limit.mesh.normals = fine.limit_normals;
  limit.mesh.triangles = cut_quads(fine.cage.mesh);
  for (const int parent : fine.face_parent)
    limit.face_of_triangle.insert(limit.face_of_triangle.end(), 2, face_of_quad[static_cast<size_t>(parent)]);
  limit.on_crease.assign(static_cast<size_t>(fine.limit_positions.rows()), 0);
  for (const SharpEdge& edge : fine.cage.sharp_edges)
    for (const int v : {edge.from, edge.to}) limit.on_crease[static_cast<size_t>(v)] = 1;
  return limit;
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

using Samples = std::vector<ContinuitySample>;

/// Per vertex of the model: no surface through the curves is smooth there.
std::vector<char> corner_vertices(const PolylineMesh& model) {
  std::vector<char> corner(model.vertices().size(), 0);
  for (size_t v = 0; v < corner.size(); ++v) {
    const SketchVertex& vertex = model.vertices()[v];
    if (!vertex.alive) continue;
    Eigen::Matrix3d directions = Eigen::Matrix3d::Zero();
    for (const int e : vertex.edges) {
      const SketchEdge& edge = model.edge(e);
      if (edge.sharpness > 0) corner[v] = 1;
      if (!edge.drawn) continue;
      const Eigen::Vector3d d = model.direction_of(side_of(e, edge.vertices[0] != static_cast<int>(v)));
      directions += d * d.transpose();
    }
    // The rms angle of the directions with the plane that fits them best.
    const double least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(directions).eigenvalues()[0];
    if (least > std::pow(kFlat, 2) * directions.trace()) corner[v] = 1;
  }
  return corner;
}

}  // namespace

const std::vector<std::string>& model_surface_methods() {
  static const std::vector<std::string> methods = {"v1", "v2", "curvature"};
  return methods;
}

ModelSurface make_model_surface(const PolylineMesh& model, const ModelSurfaceOptions& options, bool with_mesh,
                                const Progress& progress) {
  ModelSurface result;
  if (options.method == "v1") {
    Outcome outcome;
    CoonsSurface surface =
        run_coons_stage(options.coons, model, options.levels, Context{progress}, outcome, result.figures);
    result.times = outcome.times;
    result.lines = std::move(outcome.lines);
    result.mesh.triangles = triangles_of(surface.fine);
    result.mesh.positions = std::move(surface.fine.positions);
    result.mesh.normals = std::move(surface.normals);
    result.cage = std::move(surface.cage);
    std::vector<int> face_of_triangle;
    for (const int face : surface.face_of_fine) face_of_triangle.insert(face_of_triangle.end(), 2, face);
    tell_soundness(folded_triangles(result.mesh.positions, result.mesh.triangles, result.mesh.normals),
                   face_of_triangle, result);
    return result;
  }
  DiffusionOptions diffusion;
  diffusion.splits = options.splits;
  // Filling the network does not refine it any further, so it wants more samples along its curves.
  if (options.method == "curvature") diffusion.splits = std::min(options.splits + 1, 6);
  DiffusionSurface surface = diffusion_surface(model, diffusion, progress);
  result.times.add(surface.times);
  result.figures["quads"] = surface.refined.mesh.n_faces();
  result.figures["last_move"] = surface.last_move;
  const std::string names = name_faces(surface.not_smoothed, result.figures["not_smoothed"]);
  if (!names.empty())
    result.warnings.push_back(concat("smoothing would fold ", names,
                                     "; they keep their first shape and meet their neighbours in a crease; ",
                                     "divide them by another curve for a smooth surface"));
  if (with_mesh && options.method == "curvature") {
    FilledModel filled = fill_model(model, surface, {}, progress);
    result.times.add(filled.times);
    result.warnings.insert(result.warnings.end(), filled.warnings.begin(), filled.warnings.end());
    result.mesh = std::move(filled.mesh);
    tell_soundness(filled.turned, filled.face_of_triangle, result);
  } else if (with_mesh) {
    LimitMesh limit = limit_mesh(surface.cage, options.levels, surface.face_of_quad, result, progress);
    result.mesh = std::move(limit.mesh);
    tell_soundness(turned_triangles(result.mesh, limit.on_crease), limit.face_of_triangle, result);
  }
  result.cage = std::move(surface.cage);
  return result;
}

ModelContinuity model_continuity(const PolylineMesh& model, const TriangleMesh& mesh, int splits,
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
  const std::vector<Samples> measured =
      curve_continuity(mesh.positions, mesh.triangles, polylines, {}, progress);
  const std::vector<char> corner = corner_vertices(model);
  ModelContinuity result;
  std::map<int, Samples> of_curve;
  std::map<int, double> sharpness;
  Samples smooth, corners, sharp;
  double worst = -1;
  for (size_t k = 0; k < edges.size(); ++k) {
    const SketchEdge& edge = model.edge(edges[k]);
    if (!edge.drawn || edge.faces[0] < 0 || edge.faces[1] < 0) continue;
    sharpness[edge.curve] = std::max(sharpness[edge.curve], edge.sharpness);
    const double piece = edge.polyline->length() / (1 << splits);
    for (const ContinuitySample& sample : measured[k]) {
      of_curve[edge.curve].push_back(sample);
      const auto near = [&](int end, double distance) {
        return corner[static_cast<size_t>(edge.vertices[static_cast<size_t>(end)])] && distance < piece;
      };
      if (edge.sharpness > 0) {
        sharp.push_back(sample);
      } else if (near(0, sample.arc) || near(1, edge.polyline->length() - sample.arc)) {
        corners.push_back(sample);
      } else {
        smooth.push_back(sample);
        if (sample.state != ContinuitySample::State::Measured || sample.normal_jump <= worst) continue;
        worst = sample.normal_jump;
        result.worst_curve = edge.curve;
      }
    }
  }
  for (const auto& [curve, samples] : of_curve)
    result.curves.push_back({curve, sharpness[curve], continuity_figures(samples)});
  result.smooth = continuity_figures(smooth);
  result.corners = continuity_figures(corners);
  result.sharp = continuity_figures(sharp);
  return result;
}

Json continuity_json(const ModelContinuity& continuity, double diameter) {
  Json json = {{"smooth", nullptr}, {"corners", nullptr}, {"sharp", nullptr}, {"curves", Json::array()}};
  if (continuity.smooth.n_samples > 0) {
    json["smooth"] = figures_of(continuity.smooth, diameter);
    json["smooth"]["worst_curve"] = concat("c", continuity.worst_curve);
  }
  if (continuity.corners.n_samples > 0) json["corners"] = figures_of(continuity.corners, diameter);
  if (continuity.sharp.n_samples > 0) json["sharp"] = figures_of(continuity.sharp, diameter);
  for (const ModelContinuity::CurveEntry& entry : continuity.curves) {
    Json figures = {{"id", concat("c", entry.curve)}, {"sharpness", entry.sharpness}};
    figures.update(figures_of(entry.figures, diameter));
    json["curves"].push_back(std::move(figures));
  }
  return json;
}

}  // namespace batten::cli
