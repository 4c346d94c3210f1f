// Limit masks of Catmull–Clark in closed form: Halstead, Kass and DeRose 1993; with creases and borders
// Biermann, Levin and Zorin 2000.
#include "batten/subdivision/limit_stencils.hpp"

#include <vector>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/subdivision/cage_topology_detail.hpp"
#include "batten/subdivision/catmull_clark_detail.hpp"

namespace batten {

namespace {

/// Below this many levels of sharpness an edge counts as smooth: halfway between none and the four levels of
/// a sharpness that is common.
constexpr double kSharpFrom = 2;

}  // namespace

SparseMatrix limit_stencils(const ControlCage& cage) {
  const PolygonMesh& mesh = cage.mesh;
  for (Eigen::Index f = 0; f < mesh.n_faces(); ++f)
    if (mesh.offsets[static_cast<size_t>(f) + 1] - mesh.offsets[static_cast<size_t>(f)] != 4)
      throw InvalidInput(concat("face ", f, " of the cage is no quad; subdivide the cage once"));
  const detail::CageTopology topology = detail::cage_topology(mesh);
  const std::vector<double> sharpness = detail::edge_sharpness(cage, topology);
  const auto at = [](int i) { return static_cast<size_t>(i); };
  const auto vertex = [&](int corner) { return mesh.corners[at(corner)]; };
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(9 * static_cast<size_t>(mesh.positions.rows()));
  std::vector<int> neighbours, opposite, creases;
  for (int v = 0; v < static_cast<int>(mesh.positions.rows()); ++v) {
    // Around the vertex, counter-clockwise; at a border from the one side to the other.
    neighbours.clear(), opposite.clear(), creases.clear();
    int n_faces = 0, first_crease = 0;
    const int first = topology.corner_of_vertex[at(v)];
    const auto meet = [&](int edge, int neighbour, bool border) {
      neighbours.push_back(neighbour);
      if (!border && sharpness[at(edge)] < kSharpFrom) return;
      if (creases.empty()) first_crease = static_cast<int>(neighbours.size()) - 1;
      creases.push_back(neighbour);
    };
    for (int corner = first;;) {
      const int edge = topology.edge_of_corner[at(corner)];
      meet(edge, vertex(topology.next[at(corner)]), topology.opposite(corner) < 0);
      opposite.push_back(vertex(topology.next[at(topology.next[at(corner)])]));
      ++n_faces;
      const int side = topology.previous[at(corner)], across = topology.opposite(side);
      if (across < 0) meet(topology.edge_of_corner[at(side)], vertex(side), true);
      if (across < 0 || across == first) break;
      corner = across;
    }
    const int n = static_cast<int>(neighbours.size());
    if (creases.size() > 2 || (n_faces == 1 && creases.size() == 2)) {
      entries.emplace_back(v, v, 1);
    } else if (creases.size() == 2) {
      entries.emplace_back(v, v, 2.0 / 3);
      for (const int w : creases) entries.emplace_back(v, w, 1.0 / 6);
    } else if (creases.size() == 1) {
      const Eigen::RowVectorXd mask = detail::dart_masks(n).row(0);
      entries.emplace_back(v, v, mask(0));
      for (int k = 0; k < n; ++k) {
        entries.emplace_back(v, neighbours[at((first_crease + k) % n)], mask(1 + k));
        entries.emplace_back(v, opposite[at((first_crease + k) % n)], mask(1 + n + k));
      }
    } else if (n == 2) {  // the general weights are not those of the rules for two edges
      entries.emplace_back(v, v, 1.0 / 8);
      for (const int w : neighbours) entries.emplace_back(v, w, 3.0 / 8);
      for (const int w : opposite) entries.emplace_back(v, w, 1.0 / 16);
    } else {
      const double share = 1.0 / (n * (n + 5));
      entries.emplace_back(v, v, n * n * share);
      for (const int w : neighbours) entries.emplace_back(v, w, 4 * share);
      for (const int w : opposite) entries.emplace_back(v, w, share);
    }
  }
  SparseMatrix stencils(mesh.positions.rows(), mesh.positions.rows());
  stencils.setFromTriplets(entries.begin(), entries.end());
  return stencils;
}

}  // namespace batten
