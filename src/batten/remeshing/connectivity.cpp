#include "batten/remeshing/connectivity.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/units.hpp"

namespace batten {

namespace {

constexpr int kNone = HalfedgeMesh::kNone;
/// Sine of a fair smallest angle, 15°: a collapse may lower angles, but not below it.
constexpr double kFairSine = 0.2588;
using Eigen::Vector3d;

/// The sine of the smallest angle, which lies between the two longest sides; 0 without area. It grows with
/// the angle, which is at most 60°.
double smallest_sine(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d u = b - a, v = c - b, w = a - c;
  const double squared = u.cross(v).squaredNorm();
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), ww = w.squaredNorm();
  const double longest_two = uu <= vv && uu <= ww ? vv * ww : (vv <= ww ? uu * ww : uu * vv);
  return squared > 0 ? std::sqrt(squared / longest_two) : 0;
}

/// Edges changed between two reports: some 10 ms.
constexpr std::size_t kEdgesPerReport = 8192;

/// Edges by a key, in an order that does not depend on how they are stored in memory.
struct Candidate {
  double key;
  int halfedge;
  bool operator<(const Candidate& other) const {
    return key != other.key ? key < other.key : halfedge < other.halfedge;
  }
  bool operator>(const Candidate& other) const { return other < *this; }
};

}  // namespace

double angle_between(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

RemeshState::RemeshState(HalfedgeMesh initial, const FeatureChains& features, const Eigen::VectorXd& sizes)
    : mesh(std::move(initial)),
      size(sizes.data(), sizes.data() + sizes.size()),
      chain(features.chain_of_vertex),
      place(features.place_of_vertex),
      corner(features.is_corner.size(), kNone),
      features_(&features) {
  for (std::size_t v = 0; v < corner.size(); ++v)
    if (features.is_corner[v] != 0) corner[v] = static_cast<int>(v);
  for (std::size_t c = 0; c < features.chains.size(); ++c) {
    const std::vector<int>& vertices = features.chains[c].vertices;
    inner_vertices_.push_back(static_cast<int>(vertices.size()) - 2);
    chains_between_[std::minmax(vertices.front(), vertices.back())].push_back(static_cast<int>(c));
  }
}

int RemeshState::chain_of_edge(int h) const {
  const int u = mesh.from(h), v = mesh.to(h);
  if (chain[u] != kNone) return chain[u];
  if (chain[v] != kNone) return chain[v];
  // An edge from corner to corner: of the chains between the two, the one that has no vertex inside. There
  // cannot be two, since they would be the same edge.
  const auto found = chains_between_.find(std::minmax(corner[u], corner[v]));
  if (found != chains_between_.end())
    for (const int c : found->second)
      if (inner_vertices_[c] == 0) return c;
  return kNone;
}

double RemeshState::place_on(int chain_number, int v) const {
  if (chain[v] == chain_number) return place[v];
  const FeatureChain& curve = features_->chains[chain_number];
  return corner[v] == curve.vertices.front() ? 0.0 : curve.length();
}

void RemeshState::add_vertex(int v, double size_there, int chain_there, double place_there) {
  size.resize(v + 1, size_there);
  chain.resize(v + 1, chain_there);
  place.resize(v + 1, place_there);
  corner.resize(v + 1, kNone);
  size[v] = size_there;
  chain[v] = chain_there;
  place[v] = place_there;
}

bool RemeshState::can_split(int h) const {
  if (!hold_border) return true;
  if (mesh.is_border_edge(h)) return false;
  for (const int side : {h, mesh.opposite(h)})
    for (const int beside : {HalfedgeMesh::next(side), HalfedgeMesh::prev(side)})
      if (mesh.is_border_edge(beside) && !(edge_length(h) > edge_length(beside))) return false;
  return true;
}

bool RemeshState::is_longest_of_its_faces(int h) const {
  for (const int side : {h, mesh.opposite(h)})
    if (side != kNone)
      for (const int beside : {HalfedgeMesh::next(side), HalfedgeMesh::prev(side)})
        if (edge_length(h) < edge_length(beside)) return false;
  return true;
}

int RemeshState::split_in_the_middle(int h) {
  const int u = mesh.from(h), v = mesh.to(h);
  const double size_there = 0.5 * (size[u] + size[v]);
  int chain_there = kNone;
  double place_there = 0;
  Vector3d p = 0.5 * (mesh.position(u) + mesh.position(v));
  if (mesh.is_marked(h)) {
    chain_there = chain_of_edge(h);
    place_there = 0.5 * (place_on(chain_there, u) + place_on(chain_there, v));
    p = features_->chains[chain_there].at(place_there);
    ++inner_vertices_[chain_there];
  }
  const int m = mesh.split_edge(h, p);
  add_vertex(m, size_there, chain_there, place_there);
  return m;
}

int RemeshState::refine(double ratio, bool lines_only, double turn, const Progress& progress) {
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> edges;
  const double cosine = std::cos(turn);
  const auto is_line = [&](int h) {
    if (mesh.is_border_edge(h) || mesh.is_marked(h)) return true;
    const Vector3d m = mesh.area_normal(HalfedgeMesh::face(h)),
                   n = mesh.area_normal(HalfedgeMesh::face(mesh.opposite(h)));
    return m.dot(n) < cosine * m.norm() * n.norm();
  };
  const auto offer = [&](int h) {
    const double key = edge_length(h) / wanted_length(h);
    if (key > ratio && (!lines_only || is_line(h))) edges.push({-key, h});
  };
  for (int h = 0; h < mesh.halfedge_capacity(); ++h)
    if (mesh.is_representative(h)) offer(h);
  int splits = 0;
  while (!edges.empty()) {
    const auto [key, h] = edges.top();
    edges.pop();
    if (-key != edge_length(h) / wanted_length(h)) continue;  // was split since
    // Where some edges must not be split, those beside them would be for ever.
    if (hold_border && !(can_split(h) && is_longest_of_its_faces(h))) continue;
    const int m = split_in_the_middle(h);
    if (++splits % kEdgesPerReport == 0) progress.report("refine", 0);
    // The edges across from it were renumbered.
    mesh.for_each_outgoing(m, [&](int out) {
      offer(out);
      offer(HalfedgeMesh::next(out));
      if (const int before = HalfedgeMesh::prev(out); mesh.is_border_edge(before)) offer(before);
    });
  }
  return splits;
}

int RemeshState::split_long_edges(double ratio, const Progress& progress) {
  std::vector<Candidate> edges;
  for (int h = 0; h < mesh.halfedge_capacity(); ++h)
    if (mesh.is_representative(h)) {
      const double key = edge_length(h) / wanted_length(h);
      if (key > ratio) edges.push_back({-key, h});
    }
  std::sort(edges.begin(), edges.end());
  int splits = 0;
  // Halves that are still too long join the end of the list. The edges across do not: cutting them in any
  // order need not end (between two far vertices the cuts can alternate for ever); they wait for the next
  // round.
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (i % kEdgesPerReport == 0)
      progress.report("split", static_cast<double>(i) / static_cast<double>(edges.size()));
    const int h = edges[i].halfedge;
    if (!(edge_length(h) > ratio * wanted_length(h)) || !can_split(h)) continue;
    const int v = mesh.to(h);
    const int m = split_in_the_middle(h);
    ++splits;
    // h kept the half at u.
    for (const int half : {h, mesh.find(m, v), mesh.find(v, m)})
      if (half != kNone && edge_length(half) > ratio * wanted_length(half)) edges.push_back({0, half});
  }
  return splits;
}

std::vector<int> RemeshState::split_longest_edges(const std::vector<int>& faces) {
  std::vector<char> is_cut(mesh.face_capacity(), 0);
  std::vector<int> added;
  for (const int f : faces) {
    if (is_cut[f] != 0) continue;
    int longest = kNone;
    for (int h = 3 * f; h < 3 * f + 3; ++h)
      if (can_split(h) && (longest == kNone || edge_length(h) > edge_length(longest))) longest = h;
    is_cut[f] = 1;
    if (longest == kNone) continue;
    if (!mesh.is_border_edge(longest)) {
      const int beside = HalfedgeMesh::face(mesh.opposite(longest));
      if (beside < static_cast<int>(is_cut.size())) is_cut[beside] = 1;
    }
    added.push_back(split_in_the_middle(longest));
  }
  return added;
}

bool RemeshState::collapse_is_sound(int h, const Vector3d& p, double longest) const {
  const int u = mesh.from(h), v = mesh.to(h);
  const int o = mesh.opposite(h);
  const int f = HalfedgeMesh::face(h), g = o == kNone ? kNone : HalfedgeMesh::face(o);
  bool sound = true;
  // The worst angle may fall, but not below what was there or a fair bound.
  double before = 1, after = 1;
  for (const int end : {u, v}) {
    const bool moves = end == u || p != mesh.position(v);
    if (!moves) continue;
    mesh.for_each_outgoing(end, [&](int out) {
      const int face = HalfedgeMesh::face(out);
      if (!sound) return;
      const Vector3d &b = mesh.position(mesh.to(out)), &c = mesh.position(mesh.tip(out));
      before = std::min(before, smallest_sine(mesh.position(end), b, c));
      if (face == f || face == g) return;
      const Vector3d old_normal = mesh.area_normal(face), new_normal = (b - p).cross(c - p);
      // 0.5: no face turns by more than 60°. Faces without area have nothing to turn.
      if (old_normal.norm() > 0 &&
          !(old_normal.dot(new_normal) > 0.5 * old_normal.norm() * new_normal.norm()))
        sound = false;
      after = std::min(after, smallest_sine(p, b, c));
      const double wanted = 0.5 * (size[mesh.to(out)] + size[v]);
      if (mesh.to(out) != u && mesh.to(out) != v && (b - p).norm() > longest * wanted) sound = false;
    });
  }
  return sound && after > std::min(before, kFairSine);
}

bool RemeshState::collapse_towards(int h, bool reversed, double longest) {
  // On a border there is one half-edge only: its start goes in any case, but may hand its place to the other.
  const int u = mesh.from(h), v = mesh.to(h);
  const int goes = reversed ? v : u, stays = reversed ? u : v;
  if (corner[goes] != kNone) return false;
  const bool along = mesh.is_marked(h);
  if (!is_free(goes) && !along) return false;  // a feature vertex stays on its curve
  Vector3d p = mesh.position(stays);
  double new_place = place[stays];
  if (along && corner[stays] == kNone) {
    new_place = 0.5 * (place[u] + place[v]);
    p = features_->chains[chain[goes]].at(new_place);
  } else if (is_free(u) && is_free(v)) {
    p = 0.5 * (mesh.position(u) + mesh.position(v));
  }
  if (!mesh.can_collapse(h) || !collapse_is_sound(h, p, longest)) return false;
  if (chain[goes] != kNone) --inner_vertices_[chain[goes]];
  const double new_size = size[stays];
  const int new_chain = chain[stays], new_corner = corner[stays];
  mesh.collapse(h);
  mesh.set_position(v, p);
  size[v] = new_size;
  chain[v] = new_chain;
  corner[v] = new_corner;
  place[v] = new_place;
  return true;
}

int RemeshState::collapse_short_edges(double ratio, double longest, const Progress& progress) {
  std::vector<Candidate> edges;
  for (int h = 0; h < mesh.halfedge_capacity(); ++h)
    if (mesh.is_representative(h)) {
      const double key = edge_length(h) / wanted_length(h);
      if (key < ratio) edges.push_back({key, h});
    }
  std::sort(edges.begin(), edges.end());
  int collapses = 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (i % kEdgesPerReport == 0)
      progress.report("collapse", static_cast<double>(i) / static_cast<double>(edges.size()));
    int h = edges[i].halfedge;
    if (!mesh.has_halfedge(h) || !(edge_length(h) < ratio * wanted_length(h))) continue;
    for (int side = 0; side < 2; ++side) {
      if (side == 1 && mesh.opposite(h) != kNone) h = mesh.opposite(h);
      if (collapse_towards(h, side == 1 && mesh.is_border_edge(h), longest)) {
        ++collapses;
        break;
      }
    }
  }
  return collapses;
}

RemeshState::FlipSines RemeshState::flip_sines(int h) const {
  const Vector3d &u = mesh.position(mesh.from(h)), &v = mesh.position(mesh.to(h)),
                 &w = mesh.position(mesh.tip(h)), &x = mesh.position(mesh.tip(mesh.opposite(h)));
  return {std::min(smallest_sine(u, v, w), smallest_sine(u, x, v)),
          std::min(smallest_sine(x, w, u), smallest_sine(w, x, v))};
}

bool RemeshState::flip_is_sound(int h, double turn) const {
  const Vector3d &u = mesh.position(mesh.from(h)), &v = mesh.position(mesh.to(h)),
                 &w = mesh.position(mesh.tip(h)), &x = mesh.position(mesh.tip(mesh.opposite(h)));
  const Vector3d n1 = (v - u).cross(w - u), n2 = (x - u).cross(v - u);
  const Vector3d f1 = (w - x).cross(u - x), f2 = (x - w).cross(v - w);  // of the new faces x w u and w x v
  const double a1 = n1.norm(), a2 = n2.norm(), b1 = f1.norm(), b2 = f2.norm();
  if (!(b1 > 0 && b2 > 0)) return false;
  if (a1 > 0 && a2 > 0) {
    const Vector3d normal = (n1 / a1 + n2 / a2).normalized();
    const double least_cosine = std::min(f1.dot(normal) / b1, f2.dot(normal) / b2);
    if (!(least_cosine >= std::cos(turn))) {
      const double limit = std::max(turn, 0.75 * angle_between(n1, n2));
      if (!(least_cosine >= std::cos(limit))) return false;
    }
  }
  return mesh.can_flip(h);  // last, since it walks around vertices
}

void RemeshState::relax_chains(double share) {
  std::vector<double> moved = place;
  std::vector<int> ends;
  for (int v = 0; v < mesh.vertex_capacity(); ++v) {
    if (!mesh.has_vertex(v) || chain[v] == kNone) continue;
    ends.clear();
    mesh.for_each_outgoing(v, [&](int h) {
      if (mesh.is_marked(h)) ends.push_back(mesh.to(h));
      const int before = HalfedgeMesh::prev(h);
      if (mesh.is_border_edge(before) && mesh.is_marked(before)) ends.push_back(mesh.from(before));
    });
    if (ends.size() != 2) continue;
    const double a = place_on(chain[v], ends[0]), b = place_on(chain[v], ends[1]);
    const double to_a = size[v] + size[ends[0]], to_b = size[v] + size[ends[1]];
    moved[v] += share * (a + (b - a) * to_a / (to_a + to_b) - place[v]);
  }
  place = std::move(moved);
  for (int v = 0; v < mesh.vertex_capacity(); ++v)
    if (mesh.has_vertex(v) && chain[v] != kNone)
      mesh.set_position(v, features_->chains[chain[v]].at(place[v]));
}

int RemeshState::flip_for_valence(double turn, double least_angle) {
  const int n = mesh.vertex_capacity();
  std::vector<int> valence(n, 0), best(n, 6);
  for (int v = 0; v < n; ++v) {
    if (!mesh.has_vertex(v)) continue;
    valence[v] = mesh.valence(v);
    if (is_free(v)) continue;
    double angles = 0;
    mesh.for_each_outgoing(v, [&](int h) {
      angles += angle_between(mesh.position(mesh.to(h)) - mesh.position(v),
                              mesh.position(mesh.tip(h)) - mesh.position(v));
    });
    best[v] = std::max(1, static_cast<int>(std::lround(angles / radians(60.0)))) +
              (mesh.is_border_vertex(v) ? 1 : 0);
  }
  const auto excess = [&](int v, int change) {
    const int e = valence[v] + change - best[v];
    return e * e;
  };
  const double least_sine = std::sin(least_angle);
  int flips = 0;
  for (int h = 0; h < mesh.halfedge_capacity(); ++h) {
    if (!mesh.is_representative(h) || mesh.is_marked(h) || mesh.is_border_edge(h)) continue;
    const int u = mesh.from(h), v = mesh.to(h), w = mesh.tip(h), x = mesh.tip(mesh.opposite(h));
    const int gain = excess(u, 0) + excess(v, 0) + excess(w, 0) + excess(x, 0) - excess(u, -1) -
                     excess(v, -1) - excess(w, 1) - excess(x, 1);
    if (gain <= 0 || valence[u] <= 3 || valence[v] <= 3) continue;
    const FlipSines sines = flip_sines(h);
    if (sines.after < std::min(sines.before, least_sine) || !flip_is_sound(h, turn)) continue;
    mesh.flip(h);
    --valence[u];
    --valence[v];
    ++valence[w];
    ++valence[x];
    ++flips;
  }
  return flips;
}

int RemeshState::flip_for_angles(double turn) {
  int flips = 0;
  for (int h = 0; h < mesh.halfedge_capacity(); ++h) {
    if (!mesh.is_representative(h) || mesh.is_marked(h) || mesh.is_border_edge(h)) continue;
    const FlipSines sines = flip_sines(h);
    if (!(sines.after > sines.before + 1e-9) || !flip_is_sound(h, turn)) continue;
    if (!mesh.is_border_vertex(mesh.from(h)) && mesh.valence(mesh.from(h)) <= 3) continue;
    if (!mesh.is_border_vertex(mesh.to(h)) && mesh.valence(mesh.to(h)) <= 3) continue;
    mesh.flip(h);
    ++flips;
  }
  return flips;
}

int RemeshState::flip_flat_pieces(double turn) {
  const double cosine = std::cos(turn);
  std::vector<int> due;
  std::vector<char> is_due(mesh.halfedge_capacity(), 0);
  const auto offer = [&](int h) {
    if (std::exchange(is_due[h], 1) == 0) due.push_back(h);
  };
  for (int h = mesh.halfedge_capacity() - 1; h >= 0; --h)
    if (mesh.is_representative(h)) offer(h);
  int flips = 0;
  // In a plane it ends by itself; the limit is for pieces that are not quite flat.
  for (const int most = 20 * mesh.halfedge_capacity(); !due.empty() && flips < most;) {
    const int h = due.back();
    due.pop_back();
    is_due[h] = 0;
    if (mesh.is_border_edge(h) || mesh.is_marked(h)) continue;
    const int o = mesh.opposite(h);
    const Vector3d &u = mesh.position(mesh.from(h)), &v = mesh.position(mesh.to(h)),
                   &w = mesh.position(mesh.tip(h)), &x = mesh.position(mesh.tip(o));
    const Vector3d n1 = (v - u).cross(w - u), n2 = (x - u).cross(v - u);
    if (!(n1.dot(n2) >= cosine * n1.norm() * n2.norm())) continue;
    if (!(angle_between(u - w, v - w) + angle_between(u - x, v - x) > kPi + 1e-6)) continue;
    const Vector3d normal = n1 + n2, f1 = (w - x).cross(u - x), f2 = (x - w).cross(v - w);
    if (!(f1.dot(normal) > 0 && f2.dot(normal) > 0) || !mesh.can_flip(h)) continue;
    mesh.flip(h);
    ++flips;
    for (const int side : {h, mesh.opposite(h)}) {
      offer(HalfedgeMesh::next(side));
      offer(HalfedgeMesh::prev(side));
    }
  }
  return flips;
}

}  // namespace batten
