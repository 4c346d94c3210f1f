#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/simulation/section_knots_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Vector3d;

// Two curves that cross at less than this make a poor node (radians).
const double kFlatCrossing = radians(15);

/// A polyline by its length.
class MeasuredLine {
 public:
  explicit MeasuredLine(const MeshPolyline& line) : line_(line) {
    for (size_t k = 0; k < line.n_pieces(); ++k)
      starts_.push_back(starts_.back() + (line.next(k) - line.points[k]).norm());
  }

  double length() const { return starts_.back(); }
  double distance_of(const CrossingPlace& place) const {
    return starts_[place.piece] + place.fraction * (starts_[place.piece + 1] - starts_[place.piece]);
  }

  /// Appends the point at a distance from the start; on closed lines it may be up to two rounds.
  void append_knot(double s, SectionKnots& knots) const {
    if (line_.closed && s >= length()) s -= length();
    const auto after = std::upper_bound(starts_.begin() + 1, starts_.end() - 1, s);
    const auto k = static_cast<size_t>(after - starts_.begin()) - 1;
    const double piece = starts_[k + 1] - starts_[k];
    const double u = piece > 0 ? std::clamp((s - starts_[k]) / piece, 0.0, 1.0) : 0.0;
    knots.points.emplace_back((1 - u) * line_.points[k] + u * line_.next(k));
    knots.normals.emplace_back(
        ((1 - u) * line_.normals[k] + u * line_.normals[(k + 1) % line_.normals.size()]).normalized());
    knots.nodes.push_back(-1);
  }

 private:
  const MeshPolyline& line_;
  std::vector<double> starts_ = {0};  // of the pieces
};

/// Distances at which a knot has to be, with the crossing there or −1: crossings, and the ends of open lines.
/// Of a closed line the first comes again, one round further.
std::vector<std::pair<double, int>> fixed_knots(const MeasuredLine& measured, bool closed,
                                                const std::vector<CrossingPlace>& places) {
  const double length = measured.length();
  std::vector<std::pair<double, int>> fixed;
  fixed.reserve(places.size() + 2);
  for (const CrossingPlace& place : places) fixed.emplace_back(measured.distance_of(place), place.node);
  if (fixed.empty()) fixed.emplace_back(0, -1);
  if (closed) {
    fixed.emplace_back(fixed.front().first + length, fixed.front().second);
  } else {
    if (fixed.front().first > 1e-9 * length) fixed.insert(fixed.begin(), {0, -1});
    if (fixed.back().first < length * (1 - 1e-9)) fixed.emplace_back(length, -1);
  }
  return fixed;
}

/// Turns the normals of crossings to right angles with both curves. @return how many crossings are flat.
int turn_to_both_curves(const std::vector<std::shared_ptr<SplineCurve>>& curves,
                        const std::vector<SectionKnots>& knots, std::vector<MeshCrossing>& crossings) {
  std::vector<std::vector<Vector3d>> tangents(crossings.size());
  for (size_t c = 0; c < curves.size(); ++c)
    for (size_t i = 0; i < knots[c].nodes.size(); ++i)
      if (knots[c].nodes[i] >= 0)
        tangents[static_cast<size_t>(knots[c].nodes[i])].push_back(curves[c]->tangent_at_knot(i));
  int flat = 0;
  for (size_t v = 0; v < crossings.size(); ++v) {
    if (tangents[v].size() != 2) continue;
    const Vector3d across = tangents[v][0].cross(tangents[v][1]);
    if (across.norm() < std::sin(kFlatCrossing)) ++flat;
    if (across.norm() < 1e-3) continue;
    crossings[v].normal = across.normalized() * (across.dot(crossings[v].normal) < 0 ? -1 : 1);
  }
  return flat;
}

/// Fills in turns between the knots where they are given: interpolated by their number between two of them
/// (round the end of a closed curve); beyond the last of an open curve it stays.
/// @param fixed ascending; none leaves the turns as they are.
void interpolate_turns(const std::vector<size_t>& fixed, bool closed, std::vector<double>& turns) {
  const size_t n = turns.size();
  for (size_t j = 0; j < fixed.size(); ++j) {
    const bool wraps = j + 1 == fixed.size();
    const size_t from = fixed[j];
    const size_t to = wraps ? fixed[0] + n : fixed[j + 1];
    const bool open = wraps && !closed;
    for (size_t i = from + 1; i < to; ++i) {
      if (open && i >= n) break;
      const double w = open ? 0 : static_cast<double>(i - from) / static_cast<double>(to - from);
      turns[i % n] = (1 - w) * turns[from] + w * turns[to % n];
    }
    if (j == 0 && !closed)
      for (size_t i = 0; i < from; ++i) turns[i] = turns[from];
  }
}

/// The normals of the mesh at right angles to a curve, turned about its tangents so that they are those of
/// the crossings there.
void set_normals(SplineCurve& curve, const SectionKnots& knots, const std::vector<MeshCrossing>& crossings) {
  const size_t n = curve.n_knots();
  std::vector<Vector3d> normals(n);
  std::vector<Vector3d> along(n);
  std::vector<size_t> fixed;
  std::vector<double> turns(n, 0);
  for (size_t i = 0; i < n; ++i) {
    along[i] = curve.tangent_at_knot(i);
    const Vector3d flat_normal = knots.normals[i] - knots.normals[i].dot(along[i]) * along[i];
    normals[i] = flat_normal.norm() > 1e-6 ? Vector3d(flat_normal.normalized()) : along[i].unitOrthogonal();
    if (knots.nodes[i] < 0) continue;
    const Vector3d wanted = crossings[static_cast<size_t>(knots.nodes[i])].normal;
    fixed.push_back(i);
    turns[i] = std::atan2(along[i].dot(normals[i].cross(wanted)), normals[i].dot(wanted));
  }
  interpolate_turns(fixed, curve.closed(), turns);
  for (size_t i = 0; i < n; ++i) normals[i] = so3_exp(turns[i] * along[i]) * normals[i];
  curve.set_normals(std::move(normals));
}

}  // namespace

SectionKnots place_knots(const MeshPolyline& line, const std::vector<CrossingPlace>& places,
                         const std::vector<MeshCrossing>& crossings, double spacing) {
  const MeasuredLine measured(line);
  const std::vector<std::pair<double, int>> fixed = fixed_knots(measured, line.closed, places);
  SectionKnots knots;
  for (size_t j = 0; j < fixed.size(); ++j) {
    const bool last = j + 1 == fixed.size();
    if (last && line.closed) break;
    const auto [s, node] = fixed[j];
    measured.append_knot(s, knots);
    if (node >= 0) {
      knots.points.back() = crossings[static_cast<size_t>(node)].position;
      knots.normals.back() = crossings[static_cast<size_t>(node)].normal;
      knots.nodes.back() = node;
    }
    if (last) break;
    const double gap = fixed[j + 1].first - s;
    // A closed spline needs three knots.
    const int fewest = line.closed && fixed.size() <= 3 ? 3 : 1;
    const int pieces = std::max(fewest, static_cast<int>(std::lround(gap / spacing)));
    for (int k = 1; k < pieces; ++k) measured.append_knot(s + gap * k / pieces, knots);
  }
  return knots;
}

void set_consistent_normals(const std::vector<std::shared_ptr<SplineCurve>>& curves,
                            const std::vector<SectionKnots>& knots, std::vector<MeshCrossing>& crossings,
                            std::vector<std::string>& warnings) {
  const int flat = turn_to_both_curves(curves, knots, crossings);
  if (flat > 0)
    warnings.push_back(
        concat(flat, " of ", crossings.size(),
               " crossings are flatter than 15 degrees; other planes (--planes, --axes) may suit "
               "the mesh better"));
  for (size_t c = 0; c < curves.size(); ++c) set_normals(*curves[c], knots[c], crossings);
}

}  // namespace batten::detail
