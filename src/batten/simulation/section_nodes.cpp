#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "batten/simulation/section_nodes_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Vector3d;

// Crossings are searched at this spacing, in diameters; no two of a curve with one plane are nearer.
constexpr double kSearchStep = 0.02;

/// A closed curve that begins elsewhere.
class ShiftedCurve : public ArcLengthCurve {
 public:
  ShiftedCurve(std::shared_ptr<const ArcLengthCurve> base, double shift)
      : base_(std::move(base)), shift_(shift) {}
  double length() const override { return base_->length(); }
  CurvePoint at(double distance) const override {
    const double s = std::clamp(distance, 0.0, length()) + shift_;
    return base_->at(s > length() ? s - length() : s);
  }

 private:
  std::shared_ptr<const ArcLengthCurve> base_;
  double shift_;
};

/// The zero of `cut` between the distances a and b, by Newton's method kept inside by bisection.
/// @param negative_at_a the sign of `cut` there. @param s the first guess.
double refined_passage(const ArcLengthCurve& path, const ImplicitFunction& cut, double a, double b,
                       bool negative_at_a, double s) {
  const double length = path.length();
  for (int iteration = 0; iteration < 60; ++iteration) {
    const CurvePoint point = path.at(s);
    Vector3d gradient;
    const double value = cut(point.position, gradient);
    ((value < 0) == negative_at_a ? a : b) = s;
    double next = s - value / gradient.dot(point.tangent);
    if (!(next >= a && next <= b)) next = (a + b) / 2;
    const double change = std::abs(next - s);
    s = next;
    if (change <= 1e-15 * length) break;
  }
  return s;
}

/// A place where one curve passes through the cut of another.
struct Passage {
  size_t curve, other;
  double distance;
  Vector3d position;
};

std::vector<Passage> all_passages(const TracedNetwork& traced, const std::vector<ImplicitFunction>& cuts,
                                  double tolerance) {
  std::vector<Passage> found;
  const size_t n = traced.curves.size();
  for (size_t a = 0; a < n; ++a)
    for (size_t b = 0; b < n; ++b) {
      if (a == b) continue;
      const TracedCurve& curve = traced.curves[a];
      const std::vector<double> distances =
          passages(*curve.path, curve.closed, cuts[b], kSearchStep * traced.diameter, tolerance);
      for (const double s : distances) found.push_back({a, b, s, curve.path->at(s).position});
    }
  return found;
}

void set_nodes_on(TracedNetwork& traced, const std::vector<Vector3d>& nodes,
                  const ImplicitFunction& surface) {
  traced.node_positions.resize(static_cast<Eigen::Index>(nodes.size()), 3);
  traced.node_normals.resize(static_cast<Eigen::Index>(nodes.size()), 3);
  for (size_t v = 0; v < nodes.size(); ++v) {
    Vector3d gradient;
    surface(nodes[v], gradient);
    traced.node_positions.row(static_cast<Eigen::Index>(v)) = nodes[v];
    traced.node_normals.row(static_cast<Eigen::Index>(v)) = gradient.normalized();
  }
}

/// @param nodes_here distances along the curve and the nodes there.
void set_nodes_of(TracedCurve& curve, std::vector<std::pair<double, int>> nodes_here) {
  std::sort(nodes_here.begin(), nodes_here.end());
  if (nodes_here.empty()) return;
  const double shift = curve.closed ? nodes_here.front().first : 0;
  if (shift > 0) curve.path = std::make_shared<ShiftedCurve>(curve.path, shift);
  for (const auto& [distance, id] : nodes_here) {
    curve.node_distances.push_back(distance - shift);
    curve.node_ids.push_back(id);
  }
  if (curve.closed) {
    curve.node_distances.push_back(curve.path->length());
    curve.node_ids.push_back(nodes_here.front().second);
  }
}

}  // namespace

std::vector<double> passages(const ArcLengthCurve& path, bool closed, const ImplicitFunction& cut,
                             double step, double tolerance) {
  const double length = path.length();
  const int pieces = std::max(8, static_cast<int>(std::ceil(length / step)));
  const auto value_at = [&](double s) {
    Vector3d gradient;
    const double value = cut(path.at(s).position, gradient);
    return value / gradient.norm();
  };
  std::vector<double> found;
  const auto add = [&](double s) {
    for (const double other : found) {
      const double gap = std::abs(s - other);
      if (gap < tolerance || (closed && length - gap < tolerance)) return;
    }
    found.push_back(s);
  };
  double low = 0;
  const double value_at_start = value_at(0);
  double value_low = value_at_start;
  // Ends of open curves lie on the curve that they end at; rounding decides on the sign there.
  if (!closed && std::abs(value_low) < tolerance) add(0);
  if (!closed && std::abs(value_at(length)) < tolerance) add(length);
  for (int i = 1; i <= pieces; ++i) {
    const double high = length * i / pieces;
    // Back at the start of a closed curve the value must be that of the start, or rounding could hide a
    // passage just there.
    const double value_high = closed && i == pieces ? value_at_start : value_at(high);
    if ((value_low < 0) != (value_high < 0)) {
      const double start = low + (high - low) * value_low / (value_low - value_high);
      add(refined_passage(path, cut, low, high, value_low < 0, start));
    }
    low = high;
    value_low = value_high;
  }
  std::sort(found.begin(), found.end());
  return found;
}

void find_nodes(TracedNetwork& traced, const std::vector<ImplicitFunction>& cuts,
                const ImplicitFunction& surface) {
  const double tolerance = 1e-9 * traced.diameter;
  const std::vector<Passage> found = all_passages(traced, cuts, tolerance);
  std::vector<Vector3d> nodes;
  std::vector<std::vector<std::pair<double, int>>> on_curve(traced.curves.size());
  for (const Passage& one : found) {
    const bool meets = std::any_of(found.begin(), found.end(), [&](const Passage& two) {
      return two.curve == one.other && two.other == one.curve &&
             (two.position - one.position).norm() < tolerance;
    });
    if (!meets) continue;  // the plane cuts the other curve elsewhere
    const auto same = std::find_if(nodes.begin(), nodes.end(), [&](const Vector3d& node) {
      return (node - one.position).norm() < tolerance;
    });
    const int id = static_cast<int>(same - nodes.begin());
    if (same == nodes.end()) nodes.push_back(one.position);
    auto& list = on_curve[one.curve];
    const bool listed =
        std::any_of(list.begin(), list.end(), [id](const auto& entry) { return entry.second == id; });
    if (!listed) list.emplace_back(one.distance, id);
  }
  set_nodes_on(traced, nodes, surface);
  for (size_t c = 0; c < traced.curves.size(); ++c) set_nodes_of(traced.curves[c], std::move(on_curve[c]));
}

}  // namespace batten::detail
