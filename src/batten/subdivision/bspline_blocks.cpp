#include "batten/subdivision/bspline_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/index.hpp"
#include "batten/subdivision/bspline_basis_detail.hpp"

namespace batten {

namespace {

using Eigen::Vector3d;
using Knots = std::vector<double>;

/// Two patches are one polynomial spline across an edge where what they give for the control points there
/// differs by less than this, relative to the way to the next control points.
constexpr double kJoint = 1e-6;

/// A patch turned so that its side k becomes the first, the one with v = 0.
BsplinePatch turned(const BsplinePatch& patch, int k) {
  BsplinePatch result = patch;
  for (int turn = 0; turn < k; ++turn) {
    const BsplinePatch before = result;
    result.knots_u = before.knots_v;
    result.knots_v = before.knots_u;
    std::reverse(result.knots_v.begin(), result.knots_v.end());
    for (double& knot : result.knots_v) knot = 1 - knot;
    for (Eigen::Index j = 0; j < result.n_v(); ++j)
      for (Eigen::Index i = 0; i < result.n_u(); ++i)
        result.control_points.row(j * result.n_u() + i) =
            before.control_points.row(i * before.n_u() + before.n_u() - 1 - j);
    std::rotate(result.vertices.begin(), result.vertices.begin() + 1, result.vertices.end());
    std::rotate(result.edges.begin(), result.edges.begin() + 1, result.edges.end());
  }
  return result;
}

Vector3d polar(const BsplinePatch& patch, const detail::PolarWeights& u, const detail::PolarWeights& v) {
  Vector3d sum = Vector3d::Zero();
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i)
      sum += u.weights[at(i)] * v.weights[at(j)] *
             patch.control_points.row((v.first + j) * patch.n_u() + u.first + i).transpose();
  return sum;
}

/// A rectangle of patches, all turned alike: patch (i, j) is part j · columns + i.
struct Block {
  int columns = 0, rows = 0;
  std::vector<BsplinePatch> parts;
};

class BlockJoiner {
 public:
  explicit BlockJoiner(const BsplineSurface& surface)
      : surface_(surface),
        edges_at_(at(surface.vertices.rows())),
        patches_at_(at(surface.vertices.rows()), 0),
        is_line_(surface.edges.size(), 0) {
    for (std::size_t e = 0; e < surface.edges.size(); ++e)
      for (const int v : surface.edges[e].vertices) edges_at_[at(v)].push_back(static_cast<int>(e));
    for (const BsplinePatch& patch : surface.patches)
      for (const int v : patch.vertices) ++patches_at_[at(v)];
  }

  BsplineSurface joined(const Progress& progress) {
    find_lines();
    progress.report("blocks", 0.3);
    const std::vector<Block> blocks = find_blocks();
    return surface_of(blocks, progress);
  }

 private:
  bool share_a_patch(int e, int f) const {
    for (const int p : surface_.edges[at(e)].patches)
      for (const int q : surface_.edges[at(f)].patches)
        if (p >= 0 && p == q) return true;
    return false;
  }

  /// The edge that goes straight on at a vertex, or −1: there it ends.
  int straight_on(int e, int v) const {
    const std::vector<int>& edges = edges_at_[at(v)];
    const bool inside = edges.size() == 4 && patches_at_[at(v)] == 4;
    const bool on_border = edges.size() == 3 && patches_at_[at(v)] == 2;
    if (!inside && !on_border) return -1;
    for (const int f : edges)
      if (f != e && !share_a_patch(e, f)) return f;
    return -1;
  }

  /// Where lines begin: not four smooth patches, nor two on either side of a sharp edge that goes straight
  /// on, nor two at the border.
  bool is_irregular(int v) const {
    const std::vector<int>& edges = edges_at_[at(v)];
    if (edges.size() == 3 && patches_at_[at(v)] == 2) return false;
    if (edges.size() != 4 || patches_at_[at(v)] != 4) return true;
    std::vector<int> sharp;
    int n_joined = 0;
    for (const int e : edges) {
      if (surface_.edges[at(e)].is_sharp) sharp.push_back(e);
      n_joined += joins_[at(e)];
    }
    if (sharp.size() == 2) return straight_on(sharp[0], v) != sharp[1];
    return !sharp.empty() || n_joined < 2;
  }

  /// Whether the patches at an edge are one spline across it.
  bool joins(int e) const {
    const BsplineEdge& edge = surface_.edges[at(e)];
    if (edge.patches[1] < 0 || edge.is_sharp) return false;
    std::array<BsplinePatch, 2> sides;  // the edge is v = 0 of both, in opposite directions
    for (std::size_t k = 0; k < 2; ++k) {
      const BsplinePatch& patch = surface_.patches[at(edge.patches[k])];
      const auto side = std::find(patch.edges.begin(), patch.edges.end(), e) - patch.edges.begin();
      sides[k] = turned(patch, static_cast<int>(side));
    }
    for (const double s : {0.1, 0.5, 0.9}) {
      const detail::PolarWeights u0 = detail::polar_weights(sides[0].knots_u, s, {s, s, s}),
                                 u1 = detail::polar_weights(sides[1].knots_u, 1 - s, {1 - s, 1 - s, 1 - s});
      const double in0 = 0.5 * sides[0].knots_v[4], in1 = 0.5 * sides[1].knots_v[4];
      const double step = sides[0].knots_v[4];
      const Vector3d on = polar(sides[0], u0, detail::polar_weights(sides[0].knots_v, in0, {0, 0, 0}));
      for (const detail::PolarArguments& a : {detail::PolarArguments{0, 0, step}, {0, step, step}}) {
        const Vector3d here = polar(sides[0], u0, detail::polar_weights(sides[0].knots_v, in0, a));
        const Vector3d there =
            polar(sides[1], u1, detail::polar_weights(sides[1].knots_v, in1, {-a[0], -a[1], -a[2]}));
        if (!((here - there).norm() <= kJoint * (here - on).norm())) return false;
      }
    }
    return true;
  }

  /// Blocks end at an edge, and at all that goes straight on from it.
  void mark(int e) {
    if (is_line_[at(e)]) return;
    is_line_[at(e)] = 1;
    for (int v : surface_.edges[at(e)].vertices)
      for (int next = straight_on(e, v); next >= 0 && !is_line_[at(next)]; next = straight_on(next, v)) {
        is_line_[at(next)] = 1;
        const std::array<int, 2>& ends = surface_.edges[at(next)].vertices;
        v = ends[0] == v ? ends[1] : ends[0];
      }
  }

  void find_lines() {
    joins_.resize(surface_.edges.size());
    for (std::size_t e = 0; e < joins_.size(); ++e) joins_[e] = joins(static_cast<int>(e));
    for (std::size_t e = 0; e < joins_.size(); ++e)
      if (!joins_[e]) mark(static_cast<int>(e));
    for (std::size_t v = 0; v < edges_at_.size(); ++v)
      if (is_irregular(static_cast<int>(v)))
        for (const int e : edges_at_[v]) mark(e);
  }

  /// Where a patch stands in its block, and which of its sides lies at v = 0 there.
  struct Place {
    int i = 0, j = 0, turn = 0;
  };

  std::vector<Block> find_blocks() {
    for (;;) {
      std::vector<Block> blocks;
      std::vector<char> is_done(surface_.patches.size(), 0);
      bool all = true;
      for (std::size_t p = 0; p < surface_.patches.size() && all; ++p)
        if (!is_done[p]) all = add_block(static_cast<int>(p), is_done, blocks);
      if (all) return blocks;
    }
  }

  /// Goes from patch to patch over edges that are no lines. @return false where the patches are no rectangle
  /// with four sides of its own: a ring, for one; it is cut by more lines then, and blocks are to be found
  /// again.
  bool add_block(int start, std::vector<char>& is_done, std::vector<Block>& blocks) {
    std::map<int, Place> places{{start, {}}};
    std::map<std::pair<int, int>, int> patch_at{{{0, 0}, start}};
    std::vector<int> queue{start};
    for (std::size_t next = 0; next < queue.size(); ++next) {
      const int p = queue[next];
      const Place here = places.at(p);
      for (int k = 0; k < 4; ++k) {  // sides of the block's directions: v = 0, u = 1, v = 1, u = 0
        const int e = surface_.patches[at(p)].edges[at((k + here.turn) % 4)];
        if (is_line_[at(e)]) continue;
        const BsplineEdge& edge = surface_.edges[at(e)];
        const int q = edge.patches[0] == p ? edge.patches[1] : edge.patches[0];
        const std::array<int, 4>& theirs = surface_.patches[at(q)].edges;
        const int side = static_cast<int>(std::find(theirs.begin(), theirs.end(), e) - theirs.begin());
        const Place there{here.i + (k == 1) - (k == 3), here.j + (k == 2) - (k == 0), (side - k + 6) % 4};
        const auto [known, is_new] = places.try_emplace(q, there);
        const auto [taken, is_free] = patch_at.try_emplace({there.i, there.j}, q);
        if (q == p || known->second.i != there.i || known->second.j != there.j ||
            known->second.turn != there.turn || taken->second != q) {
          mark(e);
          return false;
        }
        if (is_new) queue.push_back(q);
      }
    }
    return add_rectangle(places, patch_at, is_done, blocks);
  }

  bool add_rectangle(const std::map<int, Place>& places, const std::map<std::pair<int, int>, int>& patch_at,
                     std::vector<char>& is_done, std::vector<Block>& blocks) {
    int low_i = 0, low_j = 0, high_i = 0, high_j = 0;
    for (const auto& [p, place] : places) {
      low_i = std::min(low_i, place.i);
      low_j = std::min(low_j, place.j);
      high_i = std::max(high_i, place.i);
      high_j = std::max(high_j, place.j);
    }
    Block block;
    block.columns = high_i - low_i + 1;
    block.rows = high_j - low_j + 1;
    if (patch_at.size() != at(block.columns) * at(block.rows)) {  // lines that end inside: none of ours do
      for (const auto& [p, place] : places)
        for (const int e : surface_.patches[at(p)].edges) mark(e);
      return false;
    }
    for (int j = low_j; j <= high_j; ++j)
      for (int i = low_i; i <= high_i; ++i) {
        const int p = patch_at.at({i, j});
        block.parts.push_back(turned(surface_.patches[at(p)], places.at(p).turn));
      }
    if (!has_own_sides(block)) return false;
    for (const auto& [p, place] : places) is_done[at(p)] = 1;
    blocks.push_back(std::move(block));
    return true;
  }

  const BsplinePatch& part(const Block& block, int i, int j) const {
    return block.parts[at(j) * at(block.columns) + at(i)];
  }

  std::array<int, 4> corners(const Block& block) const {
    const int i = block.columns - 1, j = block.rows - 1;
    return {part(block, 0, 0).vertices[0], part(block, i, 0).vertices[1], part(block, i, j).vertices[2],
            part(block, 0, j).vertices[3]};
  }

  /// Whether the corners differ. A tube of one block has them twice: its seam would be two sides of it, which
  /// not every program takes; it is cut in its middle.
  bool has_own_sides(const Block& block) {
    const std::array<int, 4> c = corners(block);
    if (block.columns > 1 && (c[0] == c[1] || c[3] == c[2])) {
      mark(part(block, block.columns / 2, 0).edges[3]);
      return false;
    }
    if (block.rows > 1 && (c[0] == c[3] || c[1] == c[2])) {
      mark(part(block, 0, block.rows / 2).edges[0]);
      return false;
    }
    return true;
  }

  /// Clamped knots of all parts in a row, or column: inner ones of each where any across has them, and one at
  /// each joint.
  static Knots knots_of(const Block& block, bool along_u) {
    const int n = along_u ? block.columns : block.rows, across = along_u ? block.rows : block.columns;
    Knots result(4, 0.0);
    for (int i = 0; i < n; ++i) {
      Knots inner;
      for (int j = 0; j < across; ++j) {
        const BsplinePatch& patch =
            block.parts[along_u ? at(j) * at(block.columns) + at(i) : at(i) * at(block.columns) + at(j)];
        const Knots& knots = along_u ? patch.knots_u : patch.knots_v;
        Knots both;  // as often as in either
        std::set_union(inner.begin(), inner.end(), knots.begin() + 4, knots.end() - 4,
                       std::back_inserter(both));
        inner = std::move(both);
      }
      for (const double knot : inner) result.push_back((i + knot) / n);
      result.push_back((i + 1.0) / n);
    }
    result.insert(result.end(), 3, 1.0);
    return result;
  }

  BsplinePatch patch_of(const Block& block) const {
    BsplinePatch result;
    result.knots_u = knots_of(block, true);
    result.knots_v = knots_of(block, false);
    result.face = block.parts.front().face;
    result.is_exact = std::all_of(block.parts.begin(), block.parts.end(),
                                  [](const BsplinePatch& patch) { return patch.is_exact; });
    result.vertices = corners(block);
    result.control_points.resize(result.n_u() * result.n_v(), 3);
    const auto local = [](const detail::ControlSite& site, int n) {  // in the part that holds it
      const int i = std::clamp(static_cast<int>(site.inside * n), 0, n - 1);
      detail::ControlSite moved = site;
      for (double& argument : moved.arguments) argument = argument * n - i;
      moved.inside = site.inside * n - i;
      return std::pair(i, moved);
    };
    for (Eigen::Index b = 0; b < result.n_v(); ++b) {
      const auto [j, v] = local(detail::control_site(result.knots_v, b), block.rows);
      for (Eigen::Index a = 0; a < result.n_u(); ++a) {
        const auto [i, u] = local(detail::control_site(result.knots_u, a), block.columns);
        const BsplinePatch& patch = part(block, i, j);
        result.control_points.row(b * result.n_u() + a) =
            polar(patch, detail::polar_weights(patch.knots_u, u.inside, u.arguments),
                  detail::polar_weights(patch.knots_v, v.inside, v.arguments))
                .transpose();
      }
    }
    return result;
  }

  /// The edges of the given surface along side k of a block, in order.
  std::vector<int> side_of(const Block& block, int k) const {
    std::vector<int> edges;
    const int n = k % 2 == 0 ? block.columns : block.rows;
    for (int s = 0; s < n; ++s) {
      const int back = n - 1 - s;
      const BsplinePatch& patch = k == 0   ? part(block, s, 0)
                                  : k == 1 ? part(block, block.columns - 1, s)
                                  : k == 2 ? part(block, back, block.rows - 1)
                                           : part(block, 0, back);
      edges.push_back(patch.edges[at(k)]);
    }
    return edges;
  }

  /// Side k of a patch as a curve, from vertex k on.
  static BsplineCurve curve_of(const BsplinePatch& patch, int k) {
    const BsplinePatch side = turned(patch, k);
    return {side.knots_u, side.control_points.topRows(side.n_u())};
  }

  BsplineSurface surface_of(const std::vector<Block>& blocks, const Progress& progress) const {
    BsplineSurface result = surface_;  // with its figures
    result.edges.clear();
    result.patches.clear();
    std::map<int, int> vertex_of, edge_of;  // of the given surface; edges by the smallest along the side
    const auto vertex = [&](int v) {
      return vertex_of.try_emplace(v, static_cast<int>(vertex_of.size())).first->second;
    };
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      progress.report("blocks", 0.4 + 0.6 * static_cast<double>(b) / static_cast<double>(blocks.size()));
      BsplinePatch patch = patch_of(blocks[b]);
      for (int& v : patch.vertices) v = vertex(v);
      for (int k = 0; k < 4; ++k) {
        const std::vector<int> edges = side_of(blocks[b], k);
        const auto [known, is_new] = edge_of.try_emplace(*std::min_element(edges.begin(), edges.end()),
                                                         static_cast<int>(result.edges.size()));
        if (is_new) {
          BsplineEdge edge;
          edge.curve = curve_of(patch, k);
          edge.vertices = {patch.vertices[at(k)], patch.vertices[at((k + 1) % 4)]};
          edge.patches = {static_cast<int>(b), -1};
          edge.is_sharp = surface_.edges[at(edges.front())].is_sharp;
          result.edges.push_back(edge);
        } else {
          result.edges[at(known->second)].patches[1] = static_cast<int>(b);
        }
        patch.edges[at(k)] = known->second;
      }
      result.patches.push_back(std::move(patch));
    }
    result.vertices.resize(static_cast<Eigen::Index>(vertex_of.size()), 3);
    for (const auto& [before, now] : vertex_of) result.vertices.row(now) = surface_.vertices.row(before);
    return result;
  }

  const BsplineSurface& surface_;
  std::vector<std::vector<int>> edges_at_;  ///< per vertex
  std::vector<int> patches_at_;             ///< per vertex, how many
  std::vector<char> joins_;                 ///< per edge
  std::vector<char> is_line_;               ///< per edge
};

}  // namespace

BsplineSurface joined_bsplines(const BsplineSurface& surface, const Progress& progress) {
  return BlockJoiner(surface).joined(progress);
}

}  // namespace batten
