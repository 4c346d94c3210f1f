// Limit masks of Catmull–Clark in closed form: [halstead1993]; with creases and borders
// [biermann2000]; semi-sharp edges by [derose1998].
#include "batten/subdivision/limit_stencils.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/subdivision/cage_topology_detail.hpp"
#include "batten/subdivision/catmull_clark_detail.hpp"

namespace batten {

namespace {

/// A vertex with the faces around it: the limit point needs no others, for what subdivision makes of them
/// comes from them alone.
struct Ring {
  int n_edges = 0, n_faces = 0;   // as many faces as edges, one less on a border
  std::vector<double> sharpness;  // per edge, infinite on a border
  double corner = 0;              // sharpness of the vertex

  int size() const { return 1 + n_edges + n_faces; }
  /// Columns: the vertex, the other ends of its edges counter-clockwise, and between the edges k and k + 1 of
  /// each face the corner opposite.
  int edge(int k) const { return 1 + (k + n_edges) % n_edges; }
  int diagonal(int k) const { return 1 + n_edges + (k + n_faces) % n_faces; }
  bool is_closed() const { return n_faces == n_edges; }

  std::vector<int> sharp_edges() const {
    std::vector<int> sharp;
    for (int k = 0; k < n_edges; ++k)
      if (sharpness[at(k)] > 0) sharp.push_back(k);
    return sharp;
  }
  /// One level on.
  Ring child() const {
    Ring ring = *this;
    ring.corner = detail::sharpness_after(corner, 1);
    for (double& s : ring.sharpness) s = detail::sharpness_after(s, 1);
    return ring;
  }
  bool is_semi_sharp() const {
    const auto ends = [](double s) { return s > 0 && std::isfinite(detail::sharpness_after(s, 0)); };
    return ends(corner) || std::any_of(sharpness.begin(), sharpness.end(), ends);
  }
};

using Mask = Eigen::RowVectorXd;

Mask at_column(const Ring& ring, int column) {
  Mask mask = Mask::Zero(ring.size());
  mask(column) = 1;
  return mask;
}

bool is_corner(const Ring& ring, const std::vector<int>& sharp) {
  return ring.corner > 0 || sharp.size() > 2 || (ring.n_faces == 1 && sharp.size() == 2);
}

/// Weights of the vertex point.
Mask vertex_mask(const Ring& ring) {
  const std::vector<int> sharp = ring.sharp_edges();
  Mask mask = at_column(ring, 0);
  if (is_corner(ring, sharp)) return mask;
  if (sharp.size() == 2) {
    mask(0) = 0.75;
    for (const int k : sharp) mask(ring.edge(k)) = 0.125;
    return mask;
  }
  const double n = ring.n_edges;
  mask(0) = 1 - 7 / (4 * n);
  for (int k = 0; k < ring.n_edges; ++k) {
    mask(ring.edge(k)) = 3 / (2 * n * n);
    mask(ring.diagonal(k)) = 1 / (4 * n * n);
  }
  return mask;
}

/// The vertex point where sharpness may end within the level: rules of before and after are blended by the
/// mean of what is left.
Mask blended_vertex_mask(const Ring& ring, const Ring& child) {
  double left = 0;
  int n_ending = 0;
  const auto count = [&](double before, double after) {
    if (!(before > 0) || after > 0) return;
    left += before;
    ++n_ending;
  };
  count(ring.corner, child.corner);
  for (int k = 0; k < ring.n_edges; ++k) count(ring.sharpness[at(k)], child.sharpness[at(k)]);
  if (n_ending == 0) return vertex_mask(ring);
  const double share = std::min(left / n_ending, 1.0);
  return share * vertex_mask(ring) + (1 - share) * vertex_mask(child);
}

/// The ring of the next level from this one.
Eigen::MatrixXd subdivision_matrix(const Ring& ring, const Ring& child) {
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(ring.size(), ring.size());
  S.row(0) = blended_vertex_mask(ring, child);
  for (int k = 0; k < ring.n_edges; ++k) {
    const double sharp = std::min(ring.sharpness[at(k)], 1.0);
    auto row = S.row(ring.edge(k));
    for (const int end : {0, ring.edge(k)}) row(end) += sharp / 2 + (1 - sharp) * 3 / 8;
    if (sharp >= 1) continue;
    for (const int side : {ring.edge(k - 1), ring.edge(k + 1), ring.diagonal(k - 1), ring.diagonal(k)})
      row(side) += (1 - sharp) / 16;
  }
  for (int k = 0; k < ring.n_faces; ++k)
    for (const int corner : {0, ring.edge(k), ring.edge(k + 1), ring.diagonal(k)})
      S(ring.diagonal(k), corner) += 0.25;
  return S;
}

/// Weights of the limit point where nothing is semi-sharp.
Mask limit_mask(const Ring& ring) {
  const std::vector<int> sharp = ring.sharp_edges();
  Mask mask = at_column(ring, 0);
  if (is_corner(ring, sharp)) return mask;
  if (sharp.size() == 2) {
    mask(0) = 2.0 / 3;
    for (const int k : sharp) mask(ring.edge(k)) = 1.0 / 6;
    return mask;
  }
  const int n = ring.n_edges;
  if (sharp.size() == 1) {
    const Mask dart = detail::dart_masks(n).row(0);
    mask(0) = dart(0);
    for (int k = 0; k < n; ++k) {
      mask(ring.edge(sharp[0] + k)) = dart(1 + k);
      mask(ring.diagonal(sharp[0] + k)) = dart(1 + n + k);
    }
    return mask;
  }
  // The general weights are not those of the rules for two edges.
  const double whole = n == 2 ? 8 : n * (n + 5), own = n == 2 ? 1 : n * n, edge = n == 2 ? 3 : 4,
               diagonal = n == 2 ? 0.5 : 1;
  mask(0) = own / whole;
  for (int k = 0; k < n; ++k) {
    mask(ring.edge(k)) = edge / whole;
    mask(ring.diagonal(k)) = diagonal / whole;
  }
  return mask;
}

}  // namespace

SparseMatrix limit_stencils(const ControlCage& cage) {
  const PolygonMesh& mesh = cage.mesh;
  for (Eigen::Index f = 0; f < mesh.n_faces(); ++f)
    if (mesh.offsets[static_cast<size_t>(f) + 1] - mesh.offsets[static_cast<size_t>(f)] != 4)
      throw InvalidInput(concat("face ", f, " of the cage is no quad; subdivide the cage once"));
  const detail::CageTopology topology = detail::cage_topology(mesh);
  const std::vector<double> sharpness = detail::edge_sharpness(cage, topology),
                            corners = detail::vertex_sharpness(cage);
  const auto vertex = [&](int corner) { return mesh.corners[at(corner)]; };
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(9 * static_cast<size_t>(mesh.positions.rows()));
  std::vector<int> neighbours, opposite;
  for (int v = 0; v < static_cast<int>(mesh.positions.rows()); ++v) {
    // Around the vertex, counter-clockwise; at a border from the one side to the other.
    neighbours.clear(), opposite.clear();
    Ring ring;
    ring.corner = detail::sharpness_after(corners[at(v)], 0);
    const int first = topology.corner_of_vertex[at(v)];
    const auto meet = [&](int edge, int neighbour, bool border) {
      neighbours.push_back(neighbour);
      ring.sharpness.push_back(border ? kInfinitelySharp : detail::sharpness_after(sharpness[at(edge)], 0));
    };
    for (int corner = first;;) {
      meet(topology.edge_of_corner[at(corner)], vertex(topology.next[at(corner)]),
           topology.opposite(corner) < 0);
      opposite.push_back(vertex(topology.next[at(topology.next[at(corner)])]));
      const int side = topology.previous[at(corner)], across = topology.opposite(side);
      if (across < 0) meet(topology.edge_of_corner[at(side)], vertex(side), true);
      if (across < 0 || across == first) break;
      corner = across;
    }
    ring.n_edges = static_cast<int>(neighbours.size());
    ring.n_faces = static_cast<int>(opposite.size());
    Eigen::MatrixXd levels;  // of subdivision, until nothing semi-sharp is left
    while (ring.is_semi_sharp()) {
      const Ring child = ring.child();
      const Eigen::MatrixXd level = subdivision_matrix(ring, child);
      levels = levels.size() > 0 ? (level * levels).eval() : level;
      ring = child;
    }
    Mask mask = limit_mask(ring);
    if (levels.size() > 0) mask = (mask * levels).eval();
    entries.emplace_back(v, v, mask(0));
    for (size_t k = 0; k < neighbours.size(); ++k)
      entries.emplace_back(v, neighbours[k], mask(1 + static_cast<Eigen::Index>(k)));
    for (size_t k = 0; k < opposite.size(); ++k)
      entries.emplace_back(v, opposite[k], mask(1 + ring.n_edges + static_cast<Eigen::Index>(k)));
  }
  SparseMatrix stencils(mesh.positions.rows(), mesh.positions.rows());
  stencils.setFromTriplets(entries.begin(), entries.end());
  return stencils;
}

}  // namespace batten
