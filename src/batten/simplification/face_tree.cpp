#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "batten/simplification/face_tree_detail.hpp"

namespace batten::simplification {

using Eigen::Vector3d;

namespace {

constexpr int kLeafSize = 4;
/// Least cosine to the mean normal for triangles that count as looking to the same side.
constexpr float kSameSide = 0.3F;
/// Sines and relative volumes below this are rounding, and count as zero.
constexpr double kRounding = 1e-12;
/// Adjacent triangles are folded onto each other when the angle between their normals exceeds this cosine.
constexpr double kFolded = -0.9999;

/// The nearest floats surely below and above x.
float float_below(double x) {
  const auto f = static_cast<float>(x);
  return f - std::abs(f) * 1.2e-7F - std::numeric_limits<float>::min();
}
float float_above(double x) {
  const auto f = static_cast<float>(x);
  return f + std::abs(f) * 1.2e-7F + std::numeric_limits<float>::min();
}

double det(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  return a.cross(b).dot(c);
}

/// Two triangles with one common corner meet elsewhere exactly when the arcs that they cut out of a sphere
/// around it meet. Arcs a b and c d of unit vectors.
bool arcs_meet(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  const Vector3d ab = a.cross(b), cd = c.cross(d);
  const double s1 = -ab.dot(c), s2 = ab.dot(d), s3 = cd.dot(a), s4 = -cd.dot(b);
  const double least = std::min({s1, s2, s3, s4}), largest = std::max({s1, s2, s3, s4});
  if (largest <= kRounding && least >= -kRounding) {  // one plane: do the arcs overlap?
    const auto inside = [](const Vector3d& p, const Vector3d& from, const Vector3d& to, const Vector3d& n) {
      return from.cross(p).dot(n) > -kRounding && p.cross(to).dot(n) > -kRounding && p.dot(from + to) > 0;
    };
    return inside(a, c, d, cd) || inside(b, c, d, cd) || inside(c, a, b, ab) || inside(d, a, b, ab);
  }
  return least >= -kRounding || largest <= kRounding;
}

/// Whether the segment p q passes through the triangle a b c; touching counts.
bool segment_meets(const Vector3d& p, const Vector3d& q, const Vector3d& a, const Vector3d& b,
                   const Vector3d& c, double slack) {
  const Vector3d pq = q - p, pa = a - p, pb = b - p, pc = c - p;
  const double u = det(pq, pc, pb), v = det(pq, pa, pc), w = det(pq, pb, pa);
  return (u >= -slack && v >= -slack && w >= -slack) || (u <= slack && v <= slack && w <= slack);
}

/// Overlap of two triangles in one plane with unit-free normal n, by separating lines along the edges.
bool coplanar_overlap(const std::array<Vector3d, 3>& s, const std::array<Vector3d, 3>& t, const Vector3d& n) {
  const auto separated_by = [&](const std::array<Vector3d, 3>& p, const std::array<Vector3d, 3>& q) {
    for (int k = 0; k < 3; ++k) {
      const Vector3d side = n.cross(p[(k + 1) % 3] - p[k]);
      const double inner = side.dot(p[(k + 2) % 3] - p[k]);
      const double sign = inner < 0 ? -1 : 1;
      double nearest = -std::numeric_limits<double>::infinity();
      for (const Vector3d& x : q) nearest = std::max(nearest, sign * side.dot(x - p[k]));
      if (nearest < -kRounding * std::abs(inner)) return true;
    }
    return false;
  };
  return !separated_by(s, t) && !separated_by(t, s);
}

/// Triangles without a common corner.
bool apart_triangles_meet(const Vector3d* s, const Vector3d* t) {
  const Vector3d ns = (s[1] - s[0]).cross(s[2] - s[0]), nt = (t[1] - t[0]).cross(t[2] - t[0]);
  const double size = std::max({(s[1] - s[0]).norm(), (s[2] - s[0]).norm(), (t[1] - t[0]).norm(),
                                (t[2] - t[0]).norm(), (t[0] - s[0]).norm()});
  double ds[3], dt[3];
  const double slack_t = kRounding * ns.norm() * size, slack_s = kRounding * nt.norm() * size;
  int above = 0, below = 0;
  for (int k = 0; k < 3; ++k) {
    dt[k] = ns.dot(t[k] - s[0]);
    above += dt[k] > slack_t ? 1 : 0;
    below += dt[k] < -slack_t ? 1 : 0;
  }
  if (above == 3 || below == 3) return false;
  if (above == 0 && below == 0)
    return coplanar_overlap({s[0], s[1], s[2]}, {t[0], t[1], t[2]}, ns.normalized());
  above = below = 0;
  for (int k = 0; k < 3; ++k) {
    ds[k] = nt.dot(s[k] - t[0]);
    above += ds[k] > slack_s ? 1 : 0;
    below += ds[k] < -slack_s ? 1 : 0;
  }
  if (above == 3 || below == 3) return false;
  const double slack = kRounding * size * size * size;
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3;
    const bool t_crosses = !((dt[k] > slack_t && dt[l] > slack_t) || (dt[k] < -slack_t && dt[l] < -slack_t));
    if (t_crosses && segment_meets(t[k], t[l], s[0], s[1], s[2], slack)) return true;
    const bool s_crosses = !((ds[k] > slack_s && ds[l] > slack_s) || (ds[k] < -slack_s && ds[l] < -slack_s));
    if (s_crosses && segment_meets(s[k], s[l], t[0], t[1], t[2], slack)) return true;
  }
  return false;
}

/// Whether triangles pass through each other: those that only meet in a corner or along an edge do not, be it
/// shared or, between pieces that were never joined, at the same place.
bool triangles_cross(const FaceTree::Triangle& s, FaceTree::Triangle t) {
  int shared = 0;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      if (s.corner[i] != t.corner[k] && s.point[i] != t.point[k]) continue;
      t.corner[k] = s.corner[i];
      ++shared;
      break;
    }
  return shared < 2 && triangles_touch(s, t);
}

bool cross_each_other(const std::vector<FaceTree::Triangle>& triangles) {
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (std::size_t k = i + 1; k < triangles.size(); ++k)
      if (triangles_cross(triangles[i], triangles[k])) return true;
  return false;
}

bool touch_each_other(const std::vector<FaceTree::Triangle>& triangles) {
  for (std::size_t i = 0; i < triangles.size(); ++i)
    for (std::size_t k = i + 1; k < triangles.size(); ++k)
      if (triangles_touch(triangles[i], triangles[k])) return true;
  return false;
}

bool is_one_closed_surface(const HalfedgeMesh& mesh) {
  std::vector<char> reached(mesh.face_capacity(), 0);
  std::vector<int> stack;
  int n_reached = 0;
  for (int f = 0; f < mesh.face_capacity(); ++f) {
    if (!mesh.has_face(f) || reached[f] != 0) continue;
    if (n_reached > 0) return false;  // a second component
    stack.assign(1, f);
    reached[f] = 1;
    while (!stack.empty()) {
      const int g = stack.back();
      stack.pop_back();
      ++n_reached;
      for (int k = 0; k < 3; ++k) {
        if (mesh.is_border_edge(3 * g + k)) return false;
        const int neighbour = HalfedgeMesh::face(mesh.opposite(3 * g + k));
        if (reached[neighbour] != 0) continue;
        reached[neighbour] = 1;
        stack.push_back(neighbour);
      }
    }
  }
  return n_reached > 0;
}

}  // namespace

bool triangles_touch(const FaceTree::Triangle& s, const FaceTree::Triangle& t) {
  int shared = 0, si[3], ti[3];
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      if (s.corner[i] == t.corner[k]) {
        si[shared] = i;
        ti[shared] = k;
        ++shared;
        break;
      }
  if (shared == 0) return apart_triangles_meet(s.point, t.point);
  if (shared == 1) {
    const Vector3d& a = s.point[si[0]];
    const auto direction = [&](const Vector3d& p) { return Vector3d((p - a).normalized()); };
    return arcs_meet(direction(s.point[(si[0] + 1) % 3]), direction(s.point[(si[0] + 2) % 3]),
                     direction(t.point[(ti[0] + 1) % 3]), direction(t.point[(ti[0] + 2) % 3]));
  }
  if (shared == 3) return true;
  // A common edge: the triangles meet elsewhere only where one lies on the other.
  const Vector3d& a = s.point[si[0]];
  const Vector3d edge = s.point[si[1]] - a;
  const Vector3d ns = edge.cross(s.point[3 - si[0] - si[1]] - a),
                 nt = edge.cross(t.point[3 - ti[0] - ti[1]] - a);
  return ns.dot(nt) > -kFolded * ns.norm() * nt.norm();
}

FaceTree::FaceTree(const HalfedgeMesh& mesh) : mesh_(mesh), alternates_(is_one_closed_surface(mesh)) {
  rebuild();
}

void FaceTree::set_normal(int f) {
  const Vector3d n = mesh_.area_normal(f);
  const double length = n.norm();
  normal_[f] = length > 0 ? Eigen::Vector3f((n / length).cast<float>()) : Eigen::Vector3f::Zero();
}

void FaceTree::rebuild() {
  faces_.clear();
  for (int f = 0; f < mesh_.face_capacity(); ++f)
    if (mesh_.has_face(f)) faces_.push_back(f);
  built_faces_ = static_cast<int>(faces_.size());
  leaf_.assign(mesh_.face_capacity(), -1);
  excluded_.resize(mesh_.face_capacity(), 0);
  ring_.resize(mesh_.vertex_capacity(), 0);
  if (normal_.empty()) {
    normal_.resize(mesh_.face_capacity());
    for (const int f : faces_) set_normal(f);
  }
  normal_.resize(mesh_.face_capacity(), Eigen::Vector3f::Zero());
  nodes_.clear();
  nodes_.reserve(faces_.size());
  if (!faces_.empty()) build_node(0, built_faces_, -1);
}

std::int32_t FaceTree::build_node(std::int32_t begin, std::int32_t end, std::int32_t parent) {
  const auto index = static_cast<std::int32_t>(nodes_.size());
  nodes_.push_back({});
  // Centres by one corner: cheaper than the centroid and as good for halving.
  const auto centre = [&](int f) -> const Vector3d& { return mesh_.position(mesh_.from(3 * f)); };
  Node node;
  node.parent = parent;
  if (end - begin <= kLeafSize) {
    Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (std::int32_t i = begin; i < end; ++i) {
      leaf_[faces_[i]] = index;
      for (int k = 0; k < 3; ++k) {
        const Vector3d& p = mesh_.position(mesh_.from(3 * faces_[i] + k));
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
      }
    }
    for (int k = 0; k < 3; ++k) {
      node.low[k] = float_below(low[k]);
      node.high[k] = float_above(high[k]);
      node.normal_low[k] = 1;
      node.normal_high[k] = -1;
      for (std::int32_t i = begin; i < end; ++i) {
        node.normal_low[k] = std::min(node.normal_low[k], normal_[faces_[i]][k]);
        node.normal_high[k] = std::max(node.normal_high[k], normal_[faces_[i]][k]);
      }
    }
    node.left = begin;
    node.right = begin - end;
    nodes_[index] = node;
    return index;
  }
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (std::int32_t i = begin; i < end; ++i) {
    low = low.cwiseMin(centre(faces_[i]));
    high = high.cwiseMax(centre(faces_[i]));
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const std::int32_t middle = (begin + end) / 2;
  std::nth_element(faces_.begin() + begin, faces_.begin() + middle, faces_.begin() + end, [&](int f, int g) {
    const double cf = centre(f)[axis], cg = centre(g)[axis];
    return cf < cg || (cf == cg && f < g);
  });
  node.left = build_node(begin, middle, index);
  node.right = build_node(middle, end, index);
  const Node &l = nodes_[node.left], &r = nodes_[node.right];
  for (int k = 0; k < 3; ++k) {
    node.low[k] = std::min(l.low[k], r.low[k]);
    node.high[k] = std::max(l.high[k], r.high[k]);
    node.normal_low[k] = std::min(l.normal_low[k], r.normal_low[k]);
    node.normal_high[k] = std::max(l.normal_high[k], r.normal_high[k]);
  }
  nodes_[index] = node;
  return index;
}

void FaceTree::rebuild_if_thinned() {
  if (mesh_.n_faces() * 2 < built_faces_) rebuild();
}

void FaceTree::update(int f) {
  if (f >= static_cast<int>(leaf_.size()) || leaf_[f] < 0) {
    rebuild();
    set_normal(f);
    return;
  }
  set_normal(f);
  float low[3], high[3];
  for (int k = 0; k < 3; ++k) {
    const double a = mesh_.position(mesh_.from(3 * f))[k], b = mesh_.position(mesh_.from(3 * f + 1))[k],
                 c = mesh_.position(mesh_.from(3 * f + 2))[k];
    low[k] = float_below(std::min({a, b, c}));
    high[k] = float_above(std::max({a, b, c}));
  }
  const Eigen::Vector3f& n = normal_[f];
  for (std::int32_t i = leaf_[f]; i >= 0; i = nodes_[i].parent) {
    Node& node = nodes_[i];
    bool grew = false;
    for (int k = 0; k < 3; ++k) {
      if (n[k] < node.normal_low[k]) node.normal_low[k] = n[k], grew = true;
      if (n[k] > node.normal_high[k]) node.normal_high[k] = n[k], grew = true;
      if (low[k] < node.low[k]) node.low[k] = low[k], grew = true;
      if (high[k] > node.high[k]) node.high[k] = high[k], grew = true;
    }
    if (!grew) return;
  }
}

std::vector<FaceTree::Triangle> FaceTree::as_they_are(const std::vector<int>& faces) const {
  std::vector<Triangle> triangles(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      triangles[i].corner[k] = mesh_.from(3 * faces[i] + k);
      triangles[i].point[k] = mesh_.position(triangles[i].corner[k]);
    }
  return triangles;
}

FaceTree::Bounds FaceTree::bounds_of(const Vector3d (&corners)[3]) {
  Bounds b;
  for (int k = 0; k < 3; ++k) {
    const double low = std::min({corners[0][k], corners[1][k], corners[2][k]}),
                 high = std::max({corners[0][k], corners[1][k], corners[2][k]});
    b.low[k] = float_below(low);
    b.high[k] = float_above(high);
  }
  return b;
}

FaceTree::Query FaceTree::query_of(const std::vector<Triangle>& triangles, const std::vector<int>& replaced) {
  Query query{triangles, replaced};
  ++stamp_;
  // Where old and new triangles all look to the same side as their mean, they cover the same polygon in the
  // plane across it: then they do not meet each other, nor faces beside them that look to that side too.
  Vector3d mean = Vector3d::Zero();
  std::array<Vector3d, kMaxStar> normals;
  const std::size_t n_normals = std::min(triangles.size(), normals.size());
  for (std::size_t i = 0; i < n_normals; ++i) {
    const Vector3d* p = triangles[i].point;
    normals[i] = (p[1] - p[0]).cross(p[2] - p[0]);
    mean += normals[i];
  }
  mean.normalize();
  query.side = mean.cast<float>();
  query.graph = triangles.size() <= kMaxStar;
  for (std::size_t i = 0; i < n_normals && query.graph; ++i)
    query.graph = normals[i].dot(mean) > kSameSide * normals[i].norm();
  for (const int f : replaced) {
    excluded_[f] = stamp_;
    query.graph = query.graph && normal_[f].dot(query.side) > kSameSide;
  }
  if (query.graph)
    for (const Triangle& t : triangles)
      for (const int v : t.corner) ring_[v] = stamp_;
  return query;
}

void FaceTree::bound(Query& query) const {
  for (std::size_t i = 0; i < query.triangles.size(); ++i) {
    const Bounds b = bounds_of(query.triangles[i].point);
    if (i < kMaxStar) query.bounds[i] = b;
    for (int k = 0; k < 3; ++k) {
      query.all.low[k] = i == 0 ? b.low[k] : std::min(query.all.low[k], b.low[k]);
      query.all.high[k] = i == 0 ? b.high[k] : std::max(query.all.high[k], b.high[k]);
    }
  }
  // On one closed surface another sheet that looks to the same side is hidden behind one that does not, and
  // cannot be reached without meeting that first: same-sided boxes need no visit. The old triangles
  // belong to what is swept.
  query.skip = query.graph && alternates_;
  if (!query.skip) return;
  for (const int f : query.replaced)
    for (int k = 0; k < 3; ++k)
      for (int axis = 0; axis < 3; ++axis) {
        const double x = mesh_.position(mesh_.from(3 * f + k))[axis];
        query.all.low[axis] = std::min(query.all.low[axis], float_below(x));
        query.all.high[axis] = std::max(query.all.high[axis], float_above(x));
      }
}

bool FaceTree::may_meet(const Query& query, const Node& node) const {
  if (query.all.misses(node.low, node.high)) return false;
  if (!query.skip) return true;
  float least = 0;
  for (int k = 0; k < 3; ++k)
    least += query.side[k] * (query.side[k] > 0 ? node.normal_low[k] : node.normal_high[k]);
  return !(least > kSameSide);
}

bool FaceTree::meets(const Query& query, int f) {
  if (!mesh_.has_face(f) || excluded_[f] == stamp_) return false;
  Triangle other;
  for (int k = 0; k < 3; ++k) other.corner[k] = mesh_.from(3 * f + k);
  if (query.graph &&
      (ring_[other.corner[0]] == stamp_ || ring_[other.corner[1]] == stamp_ ||
       ring_[other.corner[2]] == stamp_) &&
      normal_[f].dot(query.side) > kSameSide)
    return false;
  for (int k = 0; k < 3; ++k) other.point[k] = mesh_.position(other.corner[k]);
  const Bounds b = bounds_of(other.point);
  if (query.all.misses(b.low, b.high)) return false;
  for (std::size_t t = 0; t < query.triangles.size(); ++t) {
    if (t < kMaxStar && query.bounds[t].misses(b.low, b.high)) continue;
    if (!triangles_touch(query.triangles[t], other)) continue;
    // What intersects already may go on doing so; else nothing could be done where the input does.
    const std::vector<Triangle> present = as_they_are(query.replaced);
    if (std::none_of(present.begin(), present.end(),
                     [&](const Triangle& p) { return triangles_cross(p, other); }))
      return true;
    alternates_ = false;  // sheets that pass through each other hide nothing
    break;
  }
  return false;
}

bool FaceTree::intersects(const std::vector<Triangle>& triangles, const std::vector<int>& replaced) {
  Query query = query_of(triangles, replaced);
  if (!query.graph && touch_each_other(triangles) && !cross_each_other(as_they_are(replaced))) return true;
  if (nodes_.empty()) return false;
  bound(query);
  stack_.assign(1, 0);
  while (!stack_.empty()) {
    const Node& node = nodes_[stack_.back()];
    stack_.pop_back();
    if (!may_meet(query, node)) continue;
    if (node.right > 0) {
      stack_.push_back(node.left);
      stack_.push_back(node.right);
      continue;
    }
    for (std::int32_t i = node.left; i < node.left - node.right; ++i)
      if (meets(query, faces_[i])) return true;
  }
  return false;
}

}  // namespace batten::simplification
