#include "batten/network/contacts.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "batten/core/disjoint_sets.hpp"
#include "batten/core/index.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten::detail {

namespace {

using Vector = Eigen::Vector3d;

/// The closest points of two segments ([ericson2005], 5.1.9): fractions s, t.
double segment_distance(const Vector& p, const Vector& p_end, const Vector& q, const Vector& q_end, double& s,
                        double& t) {
  const Vector u = p_end - p, v = q_end - q, w = p - q;
  const double a = u.squaredNorm(), e = v.squaredNorm(), f = v.dot(w), c = u.dot(w), b = u.dot(v);
  const double denominator = a * e - b * b;
  s = denominator > 0 ? std::clamp((b * f - c * e) / denominator, 0.0, 1.0) : 0.0;
  t = e > 0 ? (b * s + f) / e : 0.0;
  if (t < 0) {
    t = 0;
    s = a > 0 ? std::clamp(-c / a, 0.0, 1.0) : 0.0;
  } else if (t > 1) {
    t = 1;
    s = a > 0 ? std::clamp((b - c) / a, 0.0, 1.0) : 0.0;
  }
  return (p + s * u - q - t * v).norm();
}

/// The fraction of the segment p–p_end, from `inside` towards `end`, up to which it is within `reach` of
/// another one. There is one such place: the distance to a segment is a convex function along a line.
double near_until(const Vector& p, const Vector& p_end, double inside, double end, const Vector& q,
                  const Vector& q_end, double reach) {
  const auto is_near = [&](double s) {
    return closest_point_on_segment(p + s * (p_end - p), q, q_end).squared_distance <= reach * reach;
  };
  if (is_near(end)) return end;
  for (int halving = 0; halving < 24; ++halving) {
    const double middle = 0.5 * (inside + end);
    (is_near(middle) ? inside : end) = middle;
  }
  return inside;
}

}  // namespace

CurveIndex::CurveIndex(const CurveNetwork& network, double tolerance)
    : network_(network), tolerance_(tolerance) {
  std::vector<int> uses(at(static_cast<int>(network.positions.rows())), 0);
  for (const NetworkCurve& curve : network.curves)
    for (const int v : curve.vertices) ++uses[at(v)];
  for (size_t c = 0; c < network.curves.size(); ++c) {
    const std::vector<int>& vertices = network.curves[c].vertices;
    const auto n = static_cast<int>(vertices.size());
    std::vector<double> arc{0};
    for (int k = 1; k < n; ++k)
      arc.push_back(arc.back() + (point(static_cast<int>(c), k) - point(static_cast<int>(c), k - 1)).norm());
    arcs_.push_back(std::move(arc));
    first_edge_.push_back(static_cast<int>(edges_.size()));
    int begin = 0;
    for (int k = 1; k < n; ++k)
      if (k == n - 1 || uses[at(vertices[at(k)])] > 1 || arcs_[c][at(k)] - arcs_[c][at(begin)] >= tolerance) {
        edges_.push_back({static_cast<int>(c), begin, k});
        begin = k;
      }
  }
  first_edge_.push_back(static_cast<int>(edges_.size()));
  for (const Edge& edge : edges_) {
    Box box{point(edge.curve, edge.begin), point(edge.curve, edge.begin)};
    for (int k = edge.begin + 1; k <= edge.end; ++k)
      box.include({point(edge.curve, k), point(edge.curve, k)});
    boxes_.push_back(box);
  }
  tree_ = std::make_unique<BoxTree>(boxes_);
  size_ = bounding_box_diagonal(network.positions);
}

Vector CurveIndex::point(int curve, int k) const {
  return network_.positions.row(network_.curves[at(curve)].vertices[at(k)]);
}

CurvePlace CurveIndex::nearest_on(const Edge& edge, const Vector& q) const {
  CurvePlace best;
  double least = 0;
  for (int k = edge.begin; k < edge.end; ++k) {
    const ClosestPoint closest = closest_point_on_segment(q, point(edge.curve, k), point(edge.curve, k + 1));
    if (best.curve < 0 || closest.squared_distance < least) {
      least = closest.squared_distance;
      best = {edge.curve, k, closest.weights(1), closest.point};
    }
  }
  return best;
}

/// The next or the same piece of one curve; the first follows on the last of a closed one.
bool CurveIndex::neighbours(int e, int f) const {
  const int curve = edges_[at(e)].curve;
  if (edges_[at(f)].curve != curve) return false;
  if (std::abs(e - f) <= 1) return true;
  return network_.curves[at(curve)].closed() && std::min(e, f) == first_edge_[at(curve)] &&
         std::max(e, f) == first_edge_[at(curve) + 1] - 1;
}

std::vector<CurveIndex::NearPair> CurveIndex::near_pairs() const {
  std::vector<NearPair> pairs;
  for (int e = 0; e < static_cast<int>(edges_.size()); ++e) {
    const Edge& edge = edges_[at(e)];
    Box grown = boxes_[at(e)];
    grown.low.array() -= tolerance_;
    grown.high.array() += tolerance_;
    const auto& own = network_.curves[at(edge.curve)].vertices;
    const size_t before = pairs.size();
    tree_->query(grown, [&](int f) {
      if (f <= e) return true;
      const Edge& other = edges_[at(f)];
      const auto& theirs = network_.curves[at(other.curve)].vertices;
      const int a[2] = {own[at(edge.begin)], own[at(edge.end)]},
                b[2] = {theirs[at(other.begin)], theirs[at(other.end)]};
      NearPair pair{e, f, 0, 0, 0, a[0] == b[0] || a[0] == b[1] || a[1] == b[0] || a[1] == b[1]};
      pair.distance =
          segment_distance(point(edge.curve, edge.begin), point(edge.curve, edge.end),
                           point(other.curve, other.begin), point(other.curve, other.end), pair.s, pair.t);
      if (pair.share || pair.distance <= tolerance_) pairs.push_back(pair);
      return true;
    });
    std::sort(pairs.begin() + static_cast<std::ptrdiff_t>(before), pairs.end(),
              [](const NearPair& x, const NearPair& y) { return x.f < y.f; });
  }
  return pairs;
}

std::array<int, 3> CurveIndex::around(int e) const {
  std::array<int, 3> near{e, e - 1, e + 1};
  const int curve = edges_[at(e)].curve, first = first_edge_[at(curve)],
            last = first_edge_[at(curve) + 1] - 1;
  const bool closed = network_.curves[at(curve)].closed();
  if (near[1] < first) near[1] = closed ? last : e;
  if (near[2] > last) near[2] = closed ? first : e;
  return near;
}

std::vector<CurveIndex::PairGroup> CurveIndex::grouped(const std::vector<NearPair>& pairs) const {
  DisjointSets sets(static_cast<int>(pairs.size()));
  std::unordered_map<long long, int> number;
  const auto key = [&](int e, int f) {
    return static_cast<long long>(std::min(e, f)) * static_cast<long long>(edges_.size()) + std::max(e, f);
  };
  for (size_t p = 0; p < pairs.size(); ++p) number[key(pairs[p].e, pairs[p].f)] = static_cast<int>(p);
  for (size_t p = 0; p < pairs.size(); ++p)
    for (const int e : around(pairs[p].e))
      for (const int f : around(pairs[p].f)) {
        const auto found = number.find(key(e, f));
        if (e == f || found == number.end()) continue;
        sets.unite(static_cast<int>(p), found->second);
      }
  std::map<int, PairGroup> groups;
  for (size_t p = 0; p < pairs.size(); ++p) {
    PairGroup& group = groups[sets.root(static_cast<int>(p))];
    group.share = group.share || pairs[p].share;
    if (pairs[p].distance <= tolerance_) group.spans.push_back(near_part(pairs[p]));
    if (!pairs[p].share && (group.best < 0 || pairs[p].distance < pairs[at(group.best)].distance))
      group.best = static_cast<int>(p);
  }
  std::vector<PairGroup> list;
  for (auto& [root, group] : groups) list.push_back(std::move(group));
  return list;
}

/// Of its first piece, what is within the tolerance of its second.
CurveIndex::Span CurveIndex::near_part(const NearPair& pair) const {
  const Edge &e = edges_[at(pair.e)], &f = edges_[at(pair.f)];
  const Vector p = point(e.curve, e.begin), p_end = point(e.curve, e.end), q = point(f.curve, f.begin),
               q_end = point(f.curve, f.end);
  return {pair.e, near_until(p, p_end, pair.s, 0, q, q_end, tolerance_),
          near_until(p, p_end, pair.s, 1, q, q_end, tolerance_)};
}

Contact CurveIndex::contact_of(PairGroup group, const NearPair& best) const {
  const Edge &e = edges_[at(best.e)], &f = edges_[at(best.f)];
  Contact contact;
  contact.joined = group.share;
  // The thinned pieces gave the place; the exact one is found among the edges that they stand for.
  Vector q = point(e.curve, e.begin) + best.s * (point(e.curve, e.end) - point(e.curve, e.begin));
  for (int round = 0; round < 4; ++round) {
    contact.second = nearest_on(f, q);
    contact.first = nearest_on(e, contact.second.point);
    q = contact.first.point;
  }
  contact.distance = (contact.first.point - contact.second.point).norm();
  std::sort(group.spans.begin(), group.spans.end(),
            [](const Span& x, const Span& y) { return std::tie(x.edge, x.from) < std::tie(y.edge, y.from); });
  int edge = -1;
  double counted = 0;  // of this edge: what is near several others counts once
  for (const Span& span : group.spans) {
    const Edge& piece = edges_[at(span.edge)];
    if (piece.curve != e.curve) continue;
    if (std::exchange(edge, span.edge) != span.edge) counted = 0;
    const double from = std::max(span.from, counted);
    counted = std::max(counted, span.to);
    contact.length += (counted - from) * (arc(e.curve, piece.end) - arc(e.curve, piece.begin));
  }
  return contact;
}

std::vector<Contact> CurveIndex::contacts() const {
  const std::vector<NearPair> pairs = near_pairs();
  std::vector<Contact> contacts;
  for (PairGroup& group : grouped(pairs)) {
    if (group.best < 0) continue;
    const NearPair& best = pairs[at(group.best)];
    // A curve is always near itself.
    if (group.share && edges_[at(best.e)].curve == edges_[at(best.f)].curve) continue;
    contacts.push_back(contact_of(std::move(group), best));
  }
  return contacts;
}

std::optional<CurvePlace> CurveIndex::nearest_other(int curve, bool at_last, double reach) const {
  const std::vector<int>& own = network_.curves[at(curve)].vertices;
  const int end = at_last ? static_cast<int>(own.size()) - 1 : 0;
  const Vector q = point(curve, end);
  // A part of the same curve counts when the way along the curve is much longer than the way across.
  constexpr double kDetour = 4;
  CurvePlace best;
  double radius = tolerance_;
  while (true) {
    radius = std::min(radius, reach);
    double least = radius * radius;
    const Box around{q.array() - radius, q.array() + radius};
    tree_->query(around, [&](int e) {
      const Edge& edge = edges_[at(e)];
      const CurvePlace place = nearest_on(edge, q);
      const double squared = (place.point - q).squaredNorm();
      if (squared > least) return true;
      // Of equally near ones the first: the order of the visits must not matter.
      if (best.curve >= 0 && squared == least &&
          std::tie(best.curve, best.edge) < std::tie(place.curve, place.edge))
        return true;
      if (edge.curve == curve) {
        const double along = std::abs(arc(curve, place.edge) +
                                      place.fraction * (arc(curve, place.edge + 1) - arc(curve, place.edge)) -
                                      arc(curve, end));
        if (along < kDetour * std::sqrt(squared) || along == 0) return true;
      } else {
        const std::vector<int>& theirs = network_.curves[at(edge.curve)].vertices;
        if (theirs[at(edge.begin)] == own[at(end)] || theirs[at(edge.end)] == own[at(end)]) return true;
      }
      least = squared;
      best = place;
      return true;
    });
    if (best.curve >= 0 || radius >= reach || radius > size_) break;
    radius *= 4;
  }
  if (best.curve < 0) return std::nullopt;
  return best;
}

}  // namespace batten::detail
