#include "batten/mesh/halfedge_mesh.hpp"

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

/// Half-edges by origin: those from v are order[start[v]] … order[start[v + 1] − 1], increasing.
struct OutgoingLists {
  std::vector<int> start, order;

  OutgoingLists(const std::vector<int>& origin, Eigen::Index n_vertices)
      : start(static_cast<std::size_t>(n_vertices) + 1, 0), order(origin.size()) {
    for (const int v : origin) ++start[v + 1];
    for (std::size_t v = 1; v < start.size(); ++v) start[v] += start[v - 1];
    std::vector<int> fill(start.begin(), start.end() - 1);
    for (std::size_t h = 0; h < origin.size(); ++h) order[fill[origin[h]]++] = static_cast<int>(h);
  }
};

void check_input(const Points& positions, const Triangles& triangles) {
  const Eigen::Index n = positions.rows();
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int v = triangles(f, k);
      if (v < 0 || v >= n)
        throw InvalidInput(concat("face ", f, " names vertex ", v, ", but there are only ", n,
                                  " vertices (0 to ", n - 1, "); repair the face"));
      if (!positions.row(v).allFinite())
        throw InvalidInput(concat("vertex ", v, " of face ", f, " has a coordinate that is not finite; ",
                                  "remove it or give it a position"));
      if (v == triangles(f, (k + 1) % 3))
        throw InvalidInput(
            concat("face ", f, " names vertex ", v, " twice; batten repair IN -o OUT leaves the face out"));
    }
  }
}

}  // namespace

HalfedgeMesh::HalfedgeMesh(const Points& positions, const Triangles& triangles,
                           NonManifoldVertices vertices) {
  check_input(positions, triangles);
  const Eigen::Index n = positions.rows(), m = triangles.rows();
  positions_.resize(n);
  source_.resize(n);
  for (Eigen::Index v = 0; v < n; ++v) {
    positions_[v] = positions.row(v);
    source_[v] = static_cast<int>(v);
  }
  outgoing_.assign(n, kNone);
  origin_.assign(triangles.data(), triangles.data() + 3 * m);
  opposite_.assign(3 * m, kNone);
  marked_.assign(3 * m, 0);
  n_faces_ = static_cast<int>(m);

  const OutgoingLists lists(origin_, n);
  for (int h = 0; h < halfedge_capacity(); ++h) {
    const int u = from(h), v = to(h);
    for (int i = lists.start[u]; i < lists.start[u + 1]; ++i) {
      const int other = lists.order[i];
      if (other < h && to(other) == v)
        throw InvalidInput(
            concat("faces ", face(other), " and ", face(h), " run along the edge from vertex ", u,
                   " to vertex ", v, " in the same direction: the edge has more than two ",
                   "faces or one of them is turned inside out; batten repair IN -o OUT orients ",
                   "faces alike and separates sheets"));
    }
    for (int i = lists.start[v]; i < lists.start[v + 1]; ++i)
      if (to(lists.order[i]) == u) opposite_[h] = lists.order[i];
  }

  std::vector<char> reached(3 * m, 0);
  for (Eigen::Index v = 0; v < n; ++v) {
    for (int i = lists.start[v]; i < lists.start[v + 1]; ++i) {
      const int h = lists.order[i];
      if (reached[h] != 0) continue;
      int owner = static_cast<int>(v);
      if (outgoing_[v] != kNone) {
        if (vertices == NonManifoldVertices::Refuse)
          throw InvalidInput(
              concat("at vertex ", v, " several fans of faces meet in one point (faces ", face(outgoing_[v]),
                     " and ", face(h),
                     " are not joined around it); batten repair IN -o OUT gives each fan a vertex"
                     " of its own"));
        owner = vertex_capacity();
        positions_.push_back(Eigen::Vector3d(positions_[v]));
        source_.push_back(static_cast<int>(v));
        outgoing_.push_back(kNone);
      }
      set_outgoing(h);
      const int first = outgoing_[v];  // origins still say v: read where set_outgoing() put it
      int g = first;
      do {
        reached[g] = 1;
        g = rotated(g);
      } while (g != kNone && g != first);
      if (owner == v) continue;
      // The fan moves to its own vertex; the first fan's half-edge was overwritten just now.
      g = first;
      do {
        const int following = rotated(g);
        origin_[g] = owner;
        g = following;
      } while (g != kNone && g != first);
      outgoing_[owner] = first;
      set_outgoing(lists.order[lists.start[v]]);
    }
  }
  for (const int h : outgoing_) n_vertices_ += h != kNone ? 1 : 0;
}

void HalfedgeMesh::set_outgoing(int h) {
  const int first = h;
  // Clockwise: the half-edge after the opposite one.
  while (opposite_[h] != kNone) {
    h = next(opposite_[h]);
    if (h == first) break;
  }
  outgoing_[origin_[h]] = h;
}

int HalfedgeMesh::find(int u, int v) const {
  const int first = outgoing_[u];
  if (first == kNone) return kNone;
  int h = first;
  do {
    if (to(h) == v) return h;
    h = rotated(h);
  } while (h != kNone && h != first);
  return kNone;
}

int HalfedgeMesh::valence(int v) const {
  int n = 0;
  for_each_neighbour(v, [&](int) { ++n; });
  return n;
}

void HalfedgeMesh::set_marked(int h, bool marked) {
  marked_[h] = marked ? 1 : 0;
  if (opposite_[h] != kNone) marked_[opposite_[h]] = marked_[h];
}

bool HalfedgeMesh::can_collapse(int h) const {
  const int o = opposite_[h];
  const int u = from(h), v = to(h);
  // A face whose two other edges are both on the border would take its tip with it.
  const int w = tip(h);
  if (opposite_[next(h)] == kNone && opposite_[prev(h)] == kNone) return false;
  int x = kNone;
  if (o != kNone) {
    x = tip(o);
    if (opposite_[next(o)] == kNone && opposite_[prev(o)] == kNone) return false;
    // An inner edge between two border vertices would pinch the surface to a point.
    if (is_border_vertex(u) && is_border_vertex(v)) return false;
  }
  // Link condition: the neighbours that u and v share are the tips of their faces and no others.
  bool shares_other = false;
  for_each_neighbour(u, [&](int a) {
    if (a == w || a == x || a == v || shares_other) return;
    for_each_neighbour(v, [&](int b) { shares_other = shares_other || a == b; });
  });
  if (shares_other) return false;
  // An inner tip with three faces would be left between two faces with the same corners.
  const auto folds = [&](int t) { return t != kNone && !is_border_vertex(t) && valence(t) <= 3; };
  return !folds(w) && !folds(x);
}

int HalfedgeMesh::collapse(int h) {
  const int u = from(h), v = to(h);
  const int o = opposite_[h];
  for (int g = outgoing_[u], first = g;;) {  // the faces of u now belong to v
    const int following = rotated(g);
    origin_[g] = v;
    if (following == kNone || following == first) break;
    g = following;
  }
  int kept = kNone;  // some half-edge from v that stays
  for (const int side : {h, o}) {
    if (side == kNone) continue;
    const int a = opposite_[next(side)], b = opposite_[prev(side)];
    const char marked = static_cast<char>(marked_[next(side)] | marked_[prev(side)]);
    const int t = tip(side);
    link(a, b);
    for (const int g : {a, b})
      if (g != kNone) marked_[g] = marked;
    const int f = face(side);
    for (int k = 0; k < 3; ++k) origin_[3 * f + k] = opposite_[3 * f + k] = kNone;
    --n_faces_;
    // Exactly one of a and b starts at the tip, the other at v; whichever is there leads around both.
    for (const int g : {a, b}) {
      if (g == kNone) continue;
      const int at_tip = from(g) == t ? g : next(g);
      const int at_v = from(g) == t ? next(g) : g;
      set_outgoing(at_tip);
      kept = at_v;
      break;
    }
  }
  outgoing_[u] = kNone;
  --n_vertices_;
  set_outgoing(kept);
  return v;
}

bool HalfedgeMesh::can_flip(int h) const {
  const int o = opposite_[h];
  if (o == kNone || marked_[h] != 0) return false;
  const int w = tip(h), x = tip(o);
  return w != x && find(w, x) == kNone && find(x, w) == kNone;
}

void HalfedgeMesh::flip(int h) {
  const int o = opposite_[h];
  const int u = from(h), v = to(h), w = tip(h), x = tip(o);
  const int vw = next(h), wu = prev(h), ux = next(o), xv = prev(o);
  const int vw_out = opposite_[vw], wu_out = opposite_[wu], ux_out = opposite_[ux], xv_out = opposite_[xv];
  const char vw_marked = marked_[vw], wu_marked = marked_[wu], ux_marked = marked_[ux],
             xv_marked = marked_[xv];
  // Face of h: x → w → u; face of o: w → x → v. h runs x → w, o runs w → x.
  origin_[h] = x;
  origin_[vw] = w;  // now w → u
  origin_[wu] = u;  // now u → x
  origin_[o] = w;
  origin_[ux] = x;  // now x → v
  origin_[xv] = v;  // now v → w
  link(vw, wu_out);
  link(wu, ux_out);
  link(ux, xv_out);
  link(xv, vw_out);
  marked_[vw] = wu_marked;
  marked_[wu] = ux_marked;
  marked_[ux] = xv_marked;
  marked_[xv] = vw_marked;
  set_outgoing(wu);  // u
  set_outgoing(xv);  // v
  set_outgoing(vw);  // w
  set_outgoing(ux);  // x
}

int HalfedgeMesh::add_face() {
  const int f = face_capacity();
  origin_.resize(origin_.size() + 3, kNone);
  opposite_.resize(opposite_.size() + 3, kNone);
  marked_.resize(marked_.size() + 3, 0);
  ++n_faces_;
  return f;
}

int HalfedgeMesh::split_edge(int h, const Eigen::Vector3d& p) {
  const int o = opposite_[h];
  const int v = to(h);
  const char edge_marked = marked_[h];
  const int m = vertex_capacity();
  positions_.push_back(p);
  source_.push_back(kNone);
  outgoing_.push_back(kNone);
  ++n_vertices_;

  // Face (u, v, w) of h becomes (u, m, w) and a new face (m, v, w).
  const auto cut = [&](int side, int middle, int end, bool starts_at_middle) {
    // `side` runs along the old edge; the new face takes the part of the edge that `side` gives up.
    const int after = next(side), before = prev(side);
    const int f = add_face();
    const int t = origin_[before];
    const int along = 3 * f;
    if (starts_at_middle) {  // side: u → v keeps u → m; new face m → v → w
      origin_[along] = middle;
      origin_[along + 1] = end;
      origin_[along + 2] = t;
      link(along + 1, opposite_[after]);
      marked_[along + 1] = marked_[after];
      origin_[after] = middle;  // after: now m → w
      link(after, along + 2);   // w → m
      marked_[after] = marked_[along + 2] = 0;
    } else {  // side: v → u keeps m → u; new face v → m → x
      origin_[along] = end;
      origin_[along + 1] = middle;
      origin_[along + 2] = t;
      link(along + 2, opposite_[before]);
      marked_[along + 2] = marked_[before];
      origin_[side] = middle;
      link(before, along + 1);  // before: now x → m
      marked_[before] = marked_[along + 1] = 0;
    }
    marked_[along] = edge_marked;
    return along;
  };
  const int upper = cut(h, m, v, true);
  if (o != kNone) {
    const int lower = cut(o, m, v, false);
    link(upper, lower);
    set_outgoing(next(lower));  // m → x
    set_outgoing(lower);        // v
    set_outgoing(prev(lower));  // x
  } else {
    set_outgoing(upper);
  }
  set_outgoing(next(upper));  // v
  set_outgoing(prev(upper));  // w
  set_outgoing(h);            // u
  return m;
}

HalfedgeMesh::Compact HalfedgeMesh::compacted() const {
  Compact compact;
  compact.positions.resize(n_vertices_, 3);
  compact.triangles.resize(n_faces_, 3);
  compact.index.assign(outgoing_.size(), kNone);
  compact.vertices.reserve(n_vertices_);
  compact.faces.reserve(n_faces_);
  for (int v = 0; v < vertex_capacity(); ++v) {
    if (!has_vertex(v)) continue;
    compact.index[v] = static_cast<int>(compact.vertices.size());
    compact.positions.row(compact.index[v]) = positions_[v];
    compact.vertices.push_back(v);
  }
  for (int f = 0; f < face_capacity(); ++f) {
    if (!has_face(f)) continue;
    const auto row = static_cast<Eigen::Index>(compact.faces.size());
    for (int k = 0; k < 3; ++k) compact.triangles(row, k) = compact.index[origin_[3 * f + k]];
    compact.faces.push_back(f);
  }
  return compact;
}

std::string_view HalfedgeMesh::breach() const {
  int faces = 0, vertices = 0;
  std::vector<int> at_vertex(outgoing_.size(), 0);
  for (int h = 0; h < halfedge_capacity(); ++h) {
    if (!has_halfedge(h)) continue;
    if (h % 3 == 0) ++faces;
    if (origin_[h] == to(h)) return "a face names a vertex twice";
    if (!has_vertex(origin_[h])) return "a face names a removed vertex";
    ++at_vertex[origin_[h]];
    const int o = opposite_[h];
    if (o == kNone) continue;
    if (!has_halfedge(o)) return "an opposite half-edge was removed";
    if (opposite_[o] != h) return "opposite half-edges are not mutual";
    if (from(o) != to(h) || to(o) != from(h)) return "opposite half-edges join other vertices";
    if (marked_[o] != marked_[h]) return "the mark of an edge is on one side only";
    if (tip(o) == tip(h)) return "two faces have the same corners";
  }
  for (int v = 0; v < vertex_capacity(); ++v) {
    if (!has_vertex(v)) continue;
    ++vertices;
    if (origin_[outgoing_[v]] != v) return "the outgoing half-edge of a vertex starts elsewhere";
    int around = 0;
    bool border = false;
    for_each_outgoing(v, [&](int h) {
      ++around;
      border = border || opposite_[h] == kNone;
    });
    if (border != is_border_vertex(v))
      return "the outgoing half-edge of a border vertex is not on the border";
    if (around != at_vertex[v]) return "the faces around a vertex are not one fan";
  }
  if (faces != n_faces_) return "the number of faces is wrong";
  if (vertices != n_vertices_) return "the number of vertices is wrong";
  return {};
}

}  // namespace batten
