#include <algorithm>
#include <cmath>
#include <numeric>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/subdivision/cage_topology_detail.hpp"

namespace batten::detail {

namespace {

void check_faces(const PolygonMesh& mesh) {
  const int n = static_cast<int>(mesh.positions.rows());
  if (mesh.n_faces() < 1) throw InvalidInput("the cage has no faces; give it one at least");
  if (mesh.offsets.front() != 0 || at(mesh.offsets.back()) != mesh.corners.size())
    throw InvalidInput("the offsets of the faces do not span their corners");
  for (int v = 0; v < n; ++v)
    if (!mesh.positions.row(v).allFinite())
      throw InvalidInput(concat("vertex ", v, " has a coordinate that is not finite; correct it"));
  std::vector<int> last_face(at(n), -1);
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const int begin = mesh.offsets[at(f)], end = mesh.offsets[at(f) + 1];
    if (end - begin < 3)
      throw InvalidInput(concat("face ", f, " has ", end - begin, " corners; a face needs three at least"));
    for (int c = begin; c < end; ++c) {
      const int v = mesh.corners[at(c)];
      if (v < 0 || v >= n) throw InvalidInput(concat("face ", f, " names vertex ", v, ", but there are ", n));
      if (last_face[at(v)] == f)
        throw InvalidInput(concat("face ", f, " names vertex ", v, " twice; split the face there"));
      last_face[at(v)] = f;
    }
  }
  for (int v = 0; v < n; ++v)
    if (last_face[at(v)] < 0) throw InvalidInput(concat("vertex ", v, " belongs to no face; leave it out"));
}

/// Sides grouped by their lower vertex, each group sorted by the higher one: edges in linear time.
void find_edges(const PolygonMesh& mesh, CageTopology& topology) {
  const size_t n = static_cast<size_t>(mesh.positions.rows()), n_corners = mesh.corners.size();
  const auto vertex = [&](int c) { return mesh.corners[at(c)]; };
  const auto end_vertex = [&](int c) { return vertex(topology.next[at(c)]); };
  std::vector<int> begin(n + 1, 0), grouped(n_corners);
  for (int c = 0; c < static_cast<int>(n_corners); ++c) ++begin[at(std::min(vertex(c), end_vertex(c))) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<int> fill(begin.begin(), begin.end() - 1);
  for (int c = 0; c < static_cast<int>(n_corners); ++c)
    grouped[at(fill[at(std::min(vertex(c), end_vertex(c)))]++)] = c;
  topology.edge_of_corner.assign(n_corners, -1);
  topology.edges.reserve(n_corners / 2 + 1);
  topology.sides.reserve(n_corners / 2 + 1);
  for (size_t v = 0; v < n; ++v) {
    const auto higher = [&](int c) { return std::max(vertex(c), end_vertex(c)); };
    // In the order of corners within equal edges: the first face comes first.
    std::sort(grouped.begin() + begin[v], grouped.begin() + begin[v + 1],
              [&](int a, int b) { return higher(a) != higher(b) ? higher(a) < higher(b) : a < b; });
    for (int k = begin[v]; k < begin[v + 1];) {
      int last = k + 1;
      while (last < begin[v + 1] && higher(grouped[at(last)]) == higher(grouped[at(k)])) ++last;
      const int a = grouped[at(k)], b = last - k > 1 ? grouped[at(k) + 1] : -1;
      const auto name = [&] {
        return concat("the edge between vertices ", vertex(a), " and ", end_vertex(a));
      };
      if (last - k > 2)
        throw InvalidInput(concat(name(), " belongs to ", last - k,
                                  " faces; separate them, an edge may belong to two at most"));
      if (b >= 0 && vertex(a) == vertex(b))
        throw InvalidInput(concat("faces ", topology.face_of_corner[at(a)], " and ",
                                  topology.face_of_corner[at(b)], " run along ", name(),
                                  " in the same sense; turn one of them around"));
      const int edge = static_cast<int>(topology.edges.size());
      topology.edges.push_back({vertex(a), end_vertex(a)});
      topology.sides.push_back({a, b});
      topology.edge_of_corner[at(a)] = edge;
      if (b >= 0) topology.edge_of_corner[at(b)] = edge;
      k = last;
    }
  }
}

/// Walks around every vertex; all its corners must be met.
void check_fans(const PolygonMesh& mesh, CageTopology& topology) {
  const size_t n = static_cast<size_t>(mesh.positions.rows());
  std::vector<int> n_corners(n, 0);
  topology.corner_of_vertex.assign(n, -1);
  topology.is_border.assign(n, 0);
  for (int c = 0; c < static_cast<int>(mesh.corners.size()); ++c) {
    const size_t v = at(mesh.corners[at(c)]);
    ++n_corners[v];
    const bool border = topology.opposite(c) < 0;
    if (topology.corner_of_vertex[v] < 0 || border) topology.corner_of_vertex[v] = c;
    if (border) topology.is_border[v] = 1;
  }
  for (size_t v = 0; v < n; ++v) {
    // Counter-clockwise: the side before a corner, seen from its other face, leaves the same vertex.
    int met = 0, c = topology.corner_of_vertex[v];
    do {
      ++met;
      c = topology.opposite(topology.previous[at(c)]);
    } while (c >= 0 && c != topology.corner_of_vertex[v]);
    if (met != n_corners[v])
      throw InvalidInput(
          concat("the faces around vertex ", v, " do not form one fan; give each fan a vertex of its own"));
  }
}

}  // namespace

CageTopology cage_topology(const PolygonMesh& mesh) {
  check_faces(mesh);
  CageTopology topology;
  const size_t n_corners = mesh.corners.size();
  topology.next.resize(n_corners);
  topology.previous.resize(n_corners);
  topology.face_of_corner.resize(n_corners);
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const int begin = mesh.offsets[at(f)], end = mesh.offsets[at(f) + 1];
    for (int c = begin; c < end; ++c) {
      topology.next[at(c)] = c + 1 < end ? c + 1 : begin;
      topology.previous[at(c)] = c > begin ? c - 1 : end - 1;
      topology.face_of_corner[at(c)] = f;
    }
  }
  find_edges(mesh, topology);
  check_fans(mesh, topology);
  return topology;
}

int edge_between(const CageTopology& topology, const PolygonMesh& mesh, int from, int to, const char* what) {
  const int n = static_cast<int>(mesh.positions.rows());
  if (from >= 0 && from < n && to >= 0 && to < n) {
    const int first = topology.corner_of_vertex[at(from)];
    int c = first;
    do {
      if (mesh.corners[at(topology.next[at(c)])] == to) return topology.edge_of_corner[at(c)];
      const int before = topology.previous[at(c)];
      if (mesh.corners[at(before)] == to) return topology.edge_of_corner[at(before)];
      c = topology.opposite(before);
    } while (c >= 0 && c != first);
  }
  throw InvalidInput(concat(what, " between vertices ", from, " and ", to,
                            " is no edge of a face; name the two ends of an edge"));
}

std::vector<double> edge_sharpness(const ControlCage& cage, const CageTopology& topology) {
  std::vector<double> sharpness(topology.edges.size(), 0.0);
  for (const SharpEdge& edge : cage.sharp_edges) {
    if (!(edge.sharpness >= 0))
      throw InvalidInput(concat("the sharpness of the edge between vertices ", edge.from, " and ", edge.to,
                                " must be 0 or more, got ", edge.sharpness));
    double& known = sharpness[at(edge_between(topology, cage.mesh, edge.from, edge.to, "the sharp edge"))];
    known = std::max(known, edge.sharpness);
  }
  return sharpness;
}

std::vector<double> vertex_sharpness(const ControlCage& cage) {
  std::vector<double> sharpness(static_cast<size_t>(cage.mesh.positions.rows()), 0.0);
  for (const SharpVertex& corner : cage.sharp_vertices) {
    if (corner.vertex < 0 || at(corner.vertex) >= sharpness.size())
      throw InvalidInput(
          concat("the sharp vertex ", corner.vertex, " does not exist; there are ", sharpness.size()));
    if (!(corner.sharpness >= 0))
      throw InvalidInput(
          concat("the sharpness of vertex ", corner.vertex, " must be 0 or more, got ", corner.sharpness));
    sharpness[at(corner.vertex)] = std::max(sharpness[at(corner.vertex)], corner.sharpness);
  }
  return sharpness;
}

double sharpness_after(double sharpness, int levels) {
  constexpr double kForEver = 10;  // OpenSubdiv's Sdc::Crease::SHARPNESS_INFINITE
  return sharpness >= kForEver ? kInfinitelySharp : std::max(0.0, sharpness - levels);
}

}  // namespace batten::detail
