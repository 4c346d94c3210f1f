#include "batten/modelling/continuity.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Eigenvalues>

#include "batten/core/index.hpp"

namespace batten {

namespace {

/// Directions of curves within this of a plane, rms, radians: a surface can be smooth there. They are taken
/// over a twentieth of the edges, in which curves bend.
constexpr double kFlat = 0.25;

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

}  // namespace batten
