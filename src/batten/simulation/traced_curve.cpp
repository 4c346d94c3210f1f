#include "batten/simulation/traced_curve.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/curves/gauss.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The common zeros of two functions, as a polyline of exact points; between two of them a point is found by
/// Newton's method in the plane across their chord.
class IntersectionCurve : public ArcLengthCurve {
 public:
  explicit IntersectionCurve(const TraceRequest& request) : surface_(request.surface), cut_(request.cut) {
    if (!(request.step > 0)) throw InvalidInput(concat("step must be above 0, got ", request.step));
    const double step = request.step;
    Vector3d start = request.start;
    Vector3d tangent = request.towards.normalized();
    if (request.closed) start = project(start, start, tangent);
    const Vector3d end = request.closed ? start : request.end;
    knots_.push_back(start);
    // A curve of a sensible scan has some thousand steps; one that leaves for infinity has more.
    constexpr int kMostSteps = 200000;
    while (true) {
      const Vector3d& last = knots_.back();
      tangent = direction(last, tangent);
      const Vector3d rest = end - last;
      const bool left_the_start = knots_.size() > 3 || !request.closed;
      if (left_the_start && rest.norm() <= 1.5 * step && rest.dot(tangent) > 0) break;
      if (knots_.size() > kMostSteps)
        throw InvalidInput("a curve of the surface does not come to its end; check its start and end");
      const Vector3d ahead = last + step * tangent;
      knots_.push_back(project(ahead, ahead, tangent));
    }
    knots_.push_back(end);
    distances_.resize(knots_.size(), 0);
    for (size_t i = 0; i + 1 < knots_.size(); ++i) distances_[i + 1] = distances_[i] + partial_length(i, 1);
  }

  double length() const override { return distances_.back(); }

  CurvePoint at(double distance) const override {
    const double s = std::clamp(distance, 0.0, length());
    const auto after = std::upper_bound(distances_.begin() + 1, distances_.end() - 1, s);
    const auto i = static_cast<size_t>(after - distances_.begin()) - 1;
    const double target = s - distances_[i];
    const double segment = distances_[i + 1] - distances_[i];
    double u = target / segment;
    // Newton's method for the length up to u; the speed is nearly constant in a segment.
    for (int iteration = 0; iteration < 10; ++iteration) {
      const double error = partial_length(i, u) - target;
      if (std::abs(error) <= 1e-15 * length()) break;
      u = std::clamp(u - error / speed(i, point(i, u)), 0.0, 1.0);
    }
    CurvePoint result;
    result.position = point(i, u);
    Vector3d normal;
    Vector3d across;
    surface_(result.position, normal);
    cut_(result.position, across);
    result.normal = normal.normalized();
    result.tangent = normal.cross(across).normalized();
    if (result.tangent.dot(chord(i)) < 0) result.tangent = -result.tangent;
    return result;
  }

 private:
  Vector3d chord(size_t i) const { return knots_[i + 1] - knots_[i]; }

  /// The unit tangent at x that makes an acute angle with `before`.
  Vector3d direction(const Vector3d& x, const Vector3d& before) const {
    Vector3d normal;
    Vector3d across;
    surface_(x, normal);
    cut_(x, across);
    const Vector3d t = normal.cross(across);
    if (!(t.norm() > 1e-9 * normal.norm() * across.norm()))
      throw InvalidInput("a cutting plane touches the surface; move it");
    return t.dot(before) < 0 ? Vector3d(-t.normalized()) : Vector3d(t.normalized());
  }

  /// The point of the curve in the plane through `origin` across `axis`, by Newton's method from `guess`.
  Vector3d project(const Vector3d& guess, const Vector3d& origin, const Vector3d& axis) const {
    Vector3d x = guess;
    double change = 0;
    const double size = 1e-14 * (1e-3 + guess.norm());
    for (int iteration = 0; iteration < 30; ++iteration) {
      Vector3d normal;
      Vector3d across;
      const Vector3d values(surface_(x, normal), cut_(x, across), axis.dot(x - origin));
      Matrix3d jacobian;
      jacobian << normal.transpose(), across.transpose(), axis.transpose();
      const Vector3d step = -jacobian.inverse() * values;
      if (!step.allFinite()) break;
      x += step;
      change = step.norm();
      if (change <= size) return x;
    }
    // Rounding may keep the last steps a little above the goal.
    if (change <= 1e3 * size && x.allFinite()) return x;
    throw InvalidInput("tracing a curve of the surface does not converge; take a smaller step");
  }

  Vector3d point(size_t i, double u) const {
    const Vector3d along = chord(i);
    const Vector3d on_chord = knots_[i] + u * along;
    return project(on_chord, on_chord, along.normalized());
  }

  /// d(arc length)/du at a point of segment i: the chord advances by |c| du, the curve by |c| / cos of the
  /// angle between them.
  double speed(size_t i, const Vector3d& x) const {
    const Vector3d along = chord(i);
    return along.squaredNorm() / direction(x, along).dot(along);
  }

  double partial_length(size_t i, double u) const {
    // With steps of 1 % of the radius of curvature the error of a segment is below rounding.
    return u * gauss_integral([&](double t) { return speed(i, point(i, u * t)); });
  }

  ImplicitFunction surface_;
  ImplicitFunction cut_;
  std::vector<Vector3d> knots_;
  std::vector<double> distances_;
};

}  // namespace

std::shared_ptr<const ArcLengthCurve> trace_intersection(const TraceRequest& request) {
  return std::make_shared<IntersectionCurve>(request);
}

CurveNetwork truth_network(const TracedNetwork& traced, double step) {
  if (!(step > 0)) throw InvalidInput(concat("the step of the truth must be above 0, got ", step));
  std::vector<Vector3d> positions;
  std::vector<Vector3d> normals;
  const auto add = [&](const Vector3d& position, const Vector3d& normal) {
    positions.push_back(position);
    normals.push_back(normal);
    return static_cast<int>(positions.size()) - 1;
  };
  for (Eigen::Index v = 0; v < traced.node_positions.rows(); ++v)
    add(traced.node_positions.row(v), traced.node_normals.row(v));

  CurveNetwork network;
  for (const TracedCurve& curve : traced.curves) {
    const double length = curve.path->length();
    const auto add_at = [&](double s) {
      const CurvePoint point = curve.path->at(s);
      return add(point.position, point.normal);
    };
    // Stations that become vertices: the nodes, and the ends of the curve where they are none.
    std::vector<double> stations = curve.node_distances;
    std::vector<int> vertices = curve.node_ids;
    const double same = 1e-9 * length;
    if (stations.empty() || stations.front() > same) {
      stations.insert(stations.begin(), 0.0);
      vertices.insert(vertices.begin(), add_at(0));
    }
    if (stations.back() < length - same) {
      stations.push_back(length);
      vertices.push_back(curve.closed ? vertices.front() : add_at(length));
    }
    NetworkCurve walk;
    walk.name = curve.name;
    walk.boundary = curve.boundary;
    walk.vertices.push_back(vertices.front());
    for (size_t j = 0; j + 1 < stations.size(); ++j) {
      const double gap = stations[j + 1] - stations[j];
      // A closed polyline needs three vertices to be one.
      const int fewest = curve.closed && stations.size() == 2 ? 3 : 1;
      const int pieces = std::max(fewest, static_cast<int>(std::ceil(gap / step)));
      for (int k = 1; k < pieces; ++k) walk.vertices.push_back(add_at(stations[j] + gap * k / pieces));
      walk.vertices.push_back(vertices[j + 1]);
    }
    network.curves.push_back(std::move(walk));
  }
  network.positions.resize(static_cast<Eigen::Index>(positions.size()), 3);
  network.normals.resize(static_cast<Eigen::Index>(normals.size()), 3);
  for (size_t v = 0; v < positions.size(); ++v) {
    network.positions.row(static_cast<Eigen::Index>(v)) = positions[v];
    network.normals.row(static_cast<Eigen::Index>(v)) = normals[v];
  }
  return network;
}

}  // namespace batten
