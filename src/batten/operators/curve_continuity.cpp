#include "batten/operators/curve_continuity.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/QR>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/parallel.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/mesh/normals.hpp"

namespace batten {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Lengths below are in edges around the sample. A vertex or an edge this near to a curve lies on it.
constexpr double kOnCurve = 0.05;
/// Step to either side of the curve at which the triangles of both sides are looked for.
constexpr double kStep = 0.15;
/// Vertices that a quadric wants: half as many again as its six coefficients.
constexpr int kFewestVertices = 9;
/// Pivots of the fit, in units of the radius, whose ratio is below this say that the vertices lie along a
/// curve.
constexpr double kLeastPivot = 3e-3;

struct Quadric {
  Vector3d point, normal;
  double curvature = 0;  ///< normal curvature across the curve
};

/// A polyline by its arc length.
struct Curve {
  explicit Curve(const Points& given) : points(given), arcs(at(given.rows()), 0) {
    for (Index i = 1; i < points.rows(); ++i)
      arcs[at(i)] = arcs[at(i - 1)] + (points.row(i) - points.row(i - 1)).norm();
    closed = points.row(0) == points.row(points.rows() - 1);
  }
  double length() const { return arcs.back(); }
  Index segment(double arc) const {
    const auto above = std::upper_bound(arcs.begin(), arcs.end(), arc) - arcs.begin();
    return std::clamp<Index>(above - 1, 0, points.rows() - 2);
  }
  Vector3d position(double arc) const {
    if (closed && length() > 0) arc -= length() * std::floor(arc / length());
    arc = std::clamp(arc, 0.0, length());
    const Index i = segment(arc);
    const double step = arcs[at(i + 1)] - arcs[at(i)];
    const double t = step > 0 ? (arc - arcs[at(i)]) / step : 0;
    return (1 - t) * points.row(i) + t * points.row(i + 1);
  }

  const Points& points;
  std::vector<double> arcs;
  bool closed = false;
};

class Measurement {
 public:
  Measurement(const Points& positions, const Triangles& triangles, const std::vector<Points>& curves,
              const ContinuityOptions& options)
      : positions_(positions),
        triangles_(triangles),
        options_(options),
        edges_(mesh_edges(triangles, positions.rows())),
        vertex_normals_(vertex_normals(positions, triangles)),
        tree_(positions, triangles) {
    edge_lengths_ = Eigen::VectorXd::Zero(positions.rows());
    Eigen::VectorXd count = Eigen::VectorXd::Zero(positions.rows());
    double total = 0;
    for (Index e = 0; e < edges_.n_edges(); ++e) {
      const int a = edges_.vertices(e, 0), b = edges_.vertices(e, 1);
      const double length = (positions.row(a) - positions.row(b)).norm();
      total += length;
      for (const int v : {a, b}) {
        edge_lengths_[v] += length;
        count[v] += 1;
      }
    }
    edge_lengths_.array() /= count.array().max(1);
    mean_edge_ = total / static_cast<double>(edges_.n_edges());
    find_barriers(curves);
  }

  double mean_edge() const { return mean_edge_; }

  void measure(const Curve& curve, ContinuitySample& sample) const {
    const Vector3d drawn = curve.position(sample.arc);
    const ClosestPoint place = tree_.closest(drawn);
    sample.point = place.point;
    sample.distance = std::sqrt(place.squared_distance);
    double edge = 0;
    Vector3d normal = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      const int v = triangles_(place.element, k);
      edge += place.weights[k] * edge_lengths_[v];
      normal += place.weights[k] * vertex_normals_.row(v).transpose();
    }
    const Vector3d along = curve.position(sample.arc + edge / 2) - curve.position(sample.arc - edge / 2);
    const Vector3d tangent = along.stableNormalized();
    normal = (normal - normal.dot(tangent) * tangent).stableNormalized();
    const Vector3d across = normal.cross(tangent);
    if (!(edge > 0 && across.squaredNorm() > 0.5)) return;

    Quadric sides[2];
    bool fitted = true;
    for (int side = 0; side < 2; ++side) {
      const double sign = side == 0 ? 1 : -1;
      const Vector3d aside = place.point + sign * kStep * edge * across;
      const ClosestPoint seed = tree_.closest(aside);
      // On a border the nearest point is that of the curve again.
      if (sign * (seed.point - place.point).dot(across) < 0.1 * kStep * edge) {
        sample.state = ContinuitySample::State::OneSided;
        return;
      }
      fitted = fitted && fit_side(curve, sample.arc, place.point, tangent, sign * across,
                                  static_cast<int>(seed.element), edge, sides[side]);
    }
    if (!fitted) return;
    sample.state = ContinuitySample::State::Measured;
    sample.gap = (sides[0].point - sides[1].point).norm();
    sample.normal_jump =
        std::atan2(sides[0].normal.cross(sides[1].normal).norm(), sides[0].normal.dot(sides[1].normal));
    sample.curvature_jump = std::abs(sides[0].curvature - sides[1].curvature);
    sample.curvature = std::max(std::abs(sides[0].curvature), std::abs(sides[1].curvature));
  }

 private:
  /// Marks the edges that lie on a curve: no neighbourhood goes over them.
  void find_barriers(const std::vector<Points>& curves) {
    Index n_points = 0, n_segments = 0;
    for (const Points& curve : curves) {
      n_points += curve.rows();
      n_segments += curve.rows() - 1;
    }
    Points points(n_points, 3);
    Segments segments(n_segments, 2);
    n_points = n_segments = 0;
    for (const Points& curve : curves) {
      for (Index i = 0; i + 1 < curve.rows(); ++i)
        segments.row(n_segments++) << static_cast<int>(n_points + i), static_cast<int>(n_points + i + 1);
      points.middleRows(n_points, curve.rows()) = curve;
      n_points += curve.rows();
    }
    const SegmentTree tree(points, segments);
    const Eigen::VectorXd distance = distances(tree.closest(positions_));
    is_barrier_.assign(at(edges_.n_edges()), 0);
    for (Index e = 0; e < edges_.n_edges(); ++e) {
      const int a = edges_.vertices(e, 0), b = edges_.vertices(e, 1);
      const double length = (positions_.row(a) - positions_.row(b)).norm();
      if (std::max(distance[a], distance[b]) > kOnCurve * length) continue;
      const Vector3d middle = (positions_.row(a) + positions_.row(b)).transpose() / 2;
      // The middle of a chord lies off a curve that bends.
      is_barrier_[at(e)] = tree.closest(middle).squared_distance < std::pow(3 * kOnCurve * length, 2);
    }
  }

  /// Signed distance from the curve along `across`, near an arc length.
  static double lateral(const Curve& curve, double arc, double reach, const Vector3d& x,
                        const Vector3d& tangent, const Vector3d& across) {
    double nearest = std::numeric_limits<double>::infinity(), result = 0;
    const auto visit = [&](double from, double to) {
      for (Index i = curve.segment(from); i <= curve.segment(to); ++i) {
        const Vector3d a = curve.points.row(i), b = curve.points.row(i + 1);
        const ClosestPoint c = closest_point_on_segment(x, a, b);
        if (!(c.squared_distance < nearest)) continue;
        nearest = c.squared_distance;
        // The curve has turned on the way from the sample to here: so has what is beside it.
        const Vector3d here = (b - a).stableNormalized();
        const Vector3d beside = across - across.dot(here) * here;
        result = (x - c.point).dot(tangent.dot(here) >= 0 ? beside.stableNormalized() : across);
      }
    };
    visit(std::max(0.0, arc - reach), std::min(curve.length(), arc + reach));
    if (curve.closed && arc - reach < 0) visit(curve.length() + arc - reach, curve.length());
    if (curve.closed && arc + reach > curve.length()) visit(0, arc + reach - curve.length());
    return result;
  }

  bool fit_side(const Curve& curve, double arc, const Vector3d& point, const Vector3d& tangent,
                const Vector3d& across, int seed, double edge, Quadric& result) const {
    double radius = options_.radius * edge;
    for (int attempt = 0; attempt < 3; ++attempt, radius *= std::sqrt(2.0)) {
      // The vertices of this side, by walking over triangles.
      std::vector<int> walk{seed}, vertices;
      std::vector<int> seen{seed};
      Vector3d normal = Vector3d::Zero();
      for (size_t k = 0; k < walk.size(); ++k) {
        const int t = walk[k];
        bool within = false;
        for (int i = 0; i < 3; ++i)
          within = within || (positions_.row(triangles_(t, i)).transpose() - point).norm() < radius;
        if (!within && t != seed) continue;
        const Vector3d a = positions_.row(triangles_(t, 0)), b = positions_.row(triangles_(t, 1)),
                       c = positions_.row(triangles_(t, 2));
        const Vector3d middle = (a + b + c) / 3;
        const bool on_side = t == seed || lateral(curve, arc, 3 * radius, middle, tangent, across) > 0;
        if (!on_side) continue;
        if ((middle - point).norm() < radius) normal += (b - a).cross(c - a);
        for (int i = 0; i < 3; ++i) vertices.push_back(triangles_(t, i));
        for (int i = 0; i < 3; ++i) {
          const Index e = edges_.of_triangle(t, i);
          if (is_barrier_[at(e)]) continue;
          for (int s = edges_.offsets[at(e)]; s < edges_.offsets[at(e) + 1]; ++s) {
            const int next = edges_.sides[static_cast<size_t>(s)] / 3;
            if (std::find(seen.begin(), seen.end(), next) != seen.end()) continue;
            seen.push_back(next);
            walk.push_back(next);
          }
        }
      }
      std::sort(vertices.begin(), vertices.end());
      vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
      const auto out = [&](int v) {
        const Vector3d x = positions_.row(v);
        return (x - point).norm() >= radius ||
               lateral(curve, arc, 3 * radius, x, tangent, across) < -kOnCurve * edge;
      };
      vertices.erase(std::remove_if(vertices.begin(), vertices.end(), out), vertices.end());
      if (static_cast<int>(vertices.size()) < kFewestVertices) continue;
      if (fit(vertices, point, tangent, normal, radius, result)) return true;
    }
    return false;
  }

  bool fit(const std::vector<int>& vertices, const Vector3d& point, const Vector3d& tangent, Vector3d normal,
           double radius, Quadric& result) const {
    const auto n = static_cast<Index>(vertices.size());
    Eigen::Matrix<double, Eigen::Dynamic, 6> A(n, 6);
    Eigen::VectorXd b(n);
    Eigen::Matrix<double, 6, 1> z;
    Vector3d across;
    normal.stableNormalize();
    for (int turn = 0; turn < 4; ++turn) {
      const Vector3d u_axis = (tangent - tangent.dot(normal) * normal).stableNormalized();
      across = normal.cross(u_axis);
      for (Index k = 0; k < n; ++k) {
        const Vector3d d = (positions_.row(vertices[at(k)]).transpose() - point) / radius;
        const double u = d.dot(u_axis), v = d.dot(across), w = 1.02 - std::min(1.0, d.squaredNorm());
        A.row(k) << w, w * u, w * v, w * u * u / 2, w * u * v, w * v * v / 2;
        b[k] = w * d.dot(normal);
      }
      Eigen::ColPivHouseholderQR<Eigen::Matrix<double, Eigen::Dynamic, 6>> qr(A);
      const auto pivots = qr.matrixQR().diagonal().cwiseAbs();
      if (!(pivots.minCoeff() > kLeastPivot * pivots.maxCoeff())) return false;
      z = qr.solve(b);
      result.point = point + radius * z[0] * normal;
      // The last turn only confirms the plane; its slopes are of the order of rounding.
      if (turn < 3) normal = (normal - z[1] * u_axis - z[2] * across).normalized();
    }
    result.normal = normal;
    result.curvature = z[5] / radius;
    return result.normal.allFinite();
  }

  const Points& positions_;
  const Triangles& triangles_;
  const ContinuityOptions& options_;
  MeshEdges edges_;
  Points vertex_normals_;
  TriangleTree tree_;
  Eigen::VectorXd edge_lengths_;  ///< per vertex the mean of its edges
  double mean_edge_ = 0;
  std::vector<char> is_barrier_;  ///< per edge
};

}  // namespace

std::optional<std::string> ContinuityOptions::problem() const {
  if (!(radius >= 1.5 && radius <= 20)) return concat("radius must be 1.5 to 20, got ", radius);
  if (max_samples < 1) return concat("max_samples must be at least 1, got ", max_samples);
  return std::nullopt;
}

std::vector<std::vector<ContinuitySample>> curve_continuity(const Points& positions,
                                                            const Triangles& triangles,
                                                            const std::vector<Points>& curves,
                                                            const ContinuityOptions& options,
                                                            const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  for (size_t c = 0; c < curves.size(); ++c) {
    if (curves[c].rows() < 2)
      throw InvalidInput(concat("curve ", c, " has ", curves[c].rows(), " points; a curve needs two"));
    if (!curves[c].allFinite()) throw InvalidInput(concat("curve ", c, " has a point that is not finite"));
  }
  std::vector<std::vector<ContinuitySample>> result(curves.size());
  if (curves.empty()) return result;
  const Measurement measurement(positions, triangles, curves, options);
  for (size_t c = 0; c < curves.size(); ++c) {
    progress.report("continuity", static_cast<double>(c) / static_cast<double>(curves.size()));
    const Curve curve(curves[c]);
    const double wanted = curve.length() / measurement.mean_edge();
    const auto n = static_cast<int>(std::clamp(wanted, 1.0, static_cast<double>(options.max_samples)));
    result[c].resize(static_cast<size_t>(n));
    for (int k = 0; k < n; ++k) result[c][static_cast<size_t>(k)].arc = (k + 0.5) / n * curve.length();
    parallel_for(n, 8, [&](Index begin, Index end) {
      for (Index k = begin; k < end; ++k) measurement.measure(curve, result[c][at(k)]);
    });
  }
  return result;
}

CurveContinuity continuity_figures(const std::vector<ContinuitySample>& samples) {
  CurveContinuity figures;
  for (const ContinuitySample& sample : samples) {
    figures.max_distance = std::max(figures.max_distance, sample.distance);
    figures.mean_distance += sample.distance;
    figures.n_one_sided += sample.state == ContinuitySample::State::OneSided;
    figures.n_unfitted += sample.state == ContinuitySample::State::Unfitted;
    if (sample.state != ContinuitySample::State::Measured) continue;
    ++figures.n_samples;
    if (figures.n_samples == 1 || sample.normal_jump > figures.max_normal_jump) figures.worst = sample.point;
    figures.max_gap = std::max(figures.max_gap, sample.gap);
    figures.max_normal_jump = std::max(figures.max_normal_jump, sample.normal_jump);
    figures.max_curvature_jump = std::max(figures.max_curvature_jump, sample.curvature_jump);
    figures.mean_gap += sample.gap;
    figures.mean_normal_jump += sample.normal_jump;
    figures.mean_curvature_jump += sample.curvature_jump;
  }
  const double share = 1.0 / std::max(1, figures.n_samples);
  figures.mean_gap *= share;
  figures.mean_normal_jump *= share;
  figures.mean_curvature_jump *= share;
  figures.mean_distance /= std::max(1.0, static_cast<double>(samples.size()));
  return figures;
}

}  // namespace batten
