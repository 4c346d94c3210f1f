#include "batten/remeshing/feature_chains.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

constexpr int kNoEdge = HalfedgeMesh::kNone;
using Eigen::Vector3d;

/// Marked edges at v, as half-edges from v or, on a border's far side, to v.
std::vector<int> marked_edges(const HalfedgeMesh& mesh, int v) {
  std::vector<int> edges;
  mesh.for_each_outgoing(v, [&](int h) {
    if (mesh.is_marked(h)) edges.push_back(h);
    const int before = HalfedgeMesh::prev(h);
    if (mesh.is_border_edge(before) && mesh.is_marked(before)) edges.push_back(before);
  });
  return edges;
}

int other_end(const HalfedgeMesh& mesh, int h, int v) {
  return mesh.from(h) == v ? mesh.to(h) : mesh.from(h);
}

/// Between the normals of the two faces at h; 0 where one has no area and so no normal. @pre not on a border
double dihedral_angle(const HalfedgeMesh& mesh, int h) {
  const Vector3d a = mesh.area_normal(HalfedgeMesh::face(h));
  const Vector3d b = mesh.area_normal(HalfedgeMesh::face(mesh.opposite(h)));
  if (!(a.norm() > 0) || !(b.norm() > 0)) return 0;
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Walks along marked edges from v over h until `stop` says so or the curve closes; vertices in order.
template <typename Stop>
std::vector<int> walk(const HalfedgeMesh& mesh, int v, int h, const Stop& stop) {
  std::vector<int> vertices{v};
  int at = other_end(mesh, h, v), edge = h;
  while (at != v && !stop(at)) {
    vertices.push_back(at);
    int following = kNoEdge;
    for (const int e : marked_edges(mesh, at))
      if (e != edge && e != mesh.opposite(edge)) following = e;
    if (following == kNoEdge) return vertices;
    edge = following;
    at = other_end(mesh, edge, at);
  }
  vertices.push_back(at);
  return vertices;
}

double polyline_length(const HalfedgeMesh& mesh, const std::vector<int>& vertices) {
  double length = 0;
  for (std::size_t i = 1; i < vertices.size(); ++i)
    length += (mesh.position(vertices[i]) - mesh.position(vertices[i - 1])).norm();
  return length;
}

void unmark(HalfedgeMesh& mesh, const std::vector<int>& vertices) {
  for (std::size_t i = 1; i < vertices.size(); ++i) {
    int h = mesh.find(vertices[i - 1], vertices[i]);
    if (h == kNoEdge) h = mesh.find(vertices[i], vertices[i - 1]);
    if (!mesh.is_border_edge(h)) mesh.set_marked(h, false);
  }
}

/// Marks edges on from the free end v of a curve while the crease goes on below the angle at which it is
/// kept: along the sharpest edge that goes straight on, above `least` and twice as sharp as any other
/// unmarked edge at the end but the one behind it.
void extend_crease(HalfedgeMesh& mesh, int v, double least, double corner_angle) {
  for (;;) {
    const std::vector<int> marked = marked_edges(mesh, v);
    if (marked.size() != 1) return;
    const Vector3d back = mesh.position(v) - mesh.position(other_end(mesh, marked[0], v));
    int best = kNoEdge;
    double best_angle = least, second = 0;
    mesh.for_each_outgoing(v, [&](int h) {
      if (mesh.is_border_edge(h) || mesh.is_marked(h)) return;
      const Vector3d on = mesh.position(mesh.to(h)) - mesh.position(v);
      const double angle = dihedral_angle(mesh, h);
      if (angle > best_angle && std::atan2(back.cross(on).norm(), back.dot(on)) < corner_angle) {
        second = std::max(second, best == kNoEdge ? 0 : best_angle);
        best_angle = angle;
        best = h;
      } else {
        second = std::max(second, angle);
      }
    });
    if (best == kNoEdge || second > 0.5 * best_angle) return;
    mesh.set_marked(best, true);
    v = mesh.to(best);
  }
}

/// Short curves with a free end are unmarked, again and again: dropping one may free the end of another.
void drop_short_curves(HalfedgeMesh& mesh, double least_length) {
  for (bool dropped = least_length > 0; dropped;) {
    dropped = false;
    for (int v = 0; v < mesh.vertex_capacity(); ++v) {
      if (!mesh.has_vertex(v)) continue;
      const std::vector<int> edges = marked_edges(mesh, v);
      if (edges.size() != 1) continue;
      const std::vector<int> curve =
          walk(mesh, v, edges[0], [&](int u) { return marked_edges(mesh, u).size() != 2; });
      if (polyline_length(mesh, curve) >= least_length) continue;
      unmark(mesh, curve);
      dropped = true;
    }
  }
}

/// Marks corners: ends of curves, where they meet, and where one turns. @return per vertex whether it is on a
/// curve.
std::vector<char> find_corners(const HalfedgeMesh& mesh, double corner_angle, FeatureChains& result) {
  const int n = mesh.vertex_capacity();
  std::vector<char> on_curve(n, 0);
  for (int v = 0; v < n; ++v) {
    if (!mesh.has_vertex(v)) continue;
    const std::vector<int> edges = marked_edges(mesh, v);
    if (edges.empty()) continue;
    on_curve[v] = 1;
    if (edges.size() == 2) {
      const Vector3d a = mesh.position(v) - mesh.position(other_end(mesh, edges[0], v));
      const Vector3d b = mesh.position(other_end(mesh, edges[1], v)) - mesh.position(v);
      result.is_corner[v] = std::atan2(a.cross(b).norm(), a.dot(b)) > corner_angle ? 1 : 0;
    } else {
      result.is_corner[v] = 1;
    }
  }
  return on_curve;
}

/// The inner vertex of a curve that is nearest to its middle, from behind.
int vertex_halfway(const HalfedgeMesh& mesh, const std::vector<int>& loop) {
  const double half = polyline_length(mesh, loop) / 2;
  double length = 0;
  for (std::size_t i = 1; i + 1 < loop.size(); ++i) {
    length += (mesh.position(loop[i]) - mesh.position(loop[i - 1])).norm();
    if (length >= half || i + 2 == loop.size()) return loop[i];
  }
  return kNoEdge;
}

/// Curves without a corner get one at their lowest vertex; then those that return to their only corner get
/// another, halfway.
void add_missing_corners(const HalfedgeMesh& mesh, const std::vector<char>& on_curve, FeatureChains& result) {
  const int n = mesh.vertex_capacity();
  const auto is_corner = [&](int v) { return result.is_corner[v] != 0; };
  std::vector<char> reached(n, 0);
  for (int v = 0; v < n; ++v)
    if (on_curve[v] != 0 && is_corner(v))
      for (const int e : marked_edges(mesh, v))
        for (const int u : walk(mesh, v, e, is_corner)) reached[u] = 1;
  for (int v = 0; v < n; ++v) {
    if (on_curve[v] == 0 || reached[v] != 0) continue;
    result.is_corner[v] = 1;
    for (const int u : walk(mesh, v, marked_edges(mesh, v)[0], is_corner)) reached[u] = 1;
  }
  for (int v = 0; v < n; ++v) {
    if (on_curve[v] == 0 || !is_corner(v)) continue;
    for (const int e : marked_edges(mesh, v)) {
      const std::vector<int> curve = walk(mesh, v, e, is_corner);
      if (curve.back() != v) continue;
      if (const int middle = vertex_halfway(mesh, curve); middle != kNoEdge) result.is_corner[middle] = 1;
    }
  }
}

/// The chains from corner to corner.
void collect_chains(const HalfedgeMesh& mesh, const std::vector<char>& on_curve, FeatureChains& result) {
  const int n = mesh.vertex_capacity();
  const auto is_corner = [&](int v) { return result.is_corner[v] != 0; };
  for (int v = 0; v < n; ++v) {
    if (on_curve[v] == 0 || !is_corner(v)) continue;
    for (const int e : marked_edges(mesh, v)) {
      std::vector<int> curve = walk(mesh, v, e, is_corner);
      // Every chain is met from both of its ends: keep one sense. Between the same two corners, the sense of
      // the lower corner.
      if (curve.front() > curve.back()) continue;
      FeatureChain chain;
      chain.vertices = std::move(curve);
      double length = 0;
      for (std::size_t i = 0; i < chain.vertices.size(); ++i) {
        const int u = chain.vertices[i];
        if (i > 0) length += (mesh.position(u) - chain.points.back()).norm();
        chain.lengths.push_back(length);
        chain.points.push_back(mesh.position(u));
        if (i > 0 && i + 1 < chain.vertices.size()) {
          result.chain_of_vertex[u] = static_cast<int>(result.chains.size());
          result.place_of_vertex[u] = length;
        }
      }
      result.chains.push_back(std::move(chain));
    }
  }
}

}  // namespace

Vector3d FeatureChain::at(double s) const {
  const auto above = std::upper_bound(lengths.begin(), lengths.end(), s);
  if (above == lengths.begin()) return points.front();
  if (above == lengths.end()) return points.back();
  const auto i = static_cast<std::size_t>(above - lengths.begin());
  const double t = (s - lengths[i - 1]) / (lengths[i] - lengths[i - 1]);
  return (1 - t) * points[i - 1] + t * points[i];
}

std::optional<std::string> FeatureOptions::problem() const {
  if (!(crease_angle >= 0)) return concat("crease_angle must be >= 0, got ", crease_angle);
  if (!(corner_angle >= 0)) return concat("corner_angle must be >= 0, got ", corner_angle);
  if (!(least_length >= 0)) return concat("least_length must be >= 0, got ", least_length);
  if (!(fade > 0 && fade <= 1)) return concat("fade must be above 0 and at most 1, got ", fade);
  return std::nullopt;
}

FeatureChains mark_features(HalfedgeMesh& mesh, const FeatureOptions& options) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  const int n = mesh.vertex_capacity();
  for (int h = 0; h < mesh.halfedge_capacity(); ++h)
    if (mesh.is_representative(h) &&
        (mesh.is_border_edge(h) || dihedral_angle(mesh, h) > options.crease_angle))
      mesh.set_marked(h, true);
  drop_short_curves(mesh, options.least_length);
  if (options.fade < 1)
    for (int v = 0; v < n; ++v)
      if (mesh.has_vertex(v) && !mesh.is_border_vertex(v))
        extend_crease(mesh, v, options.fade * options.crease_angle, options.corner_angle);

  FeatureChains result;
  result.chain_of_vertex.assign(n, kNoEdge);
  result.place_of_vertex.assign(n, 0.0);
  result.is_corner.assign(n, 0);
  const std::vector<char> on_curve = find_corners(mesh, options.corner_angle, result);
  if (options.hold_border)
    for (int v = 0; v < n; ++v)
      if (mesh.has_vertex(v) && mesh.is_border_vertex(v)) result.is_corner[v] = 1;
  add_missing_corners(mesh, on_curve, result);
  collect_chains(mesh, on_curve, result);
  return result;
}

}  // namespace batten
