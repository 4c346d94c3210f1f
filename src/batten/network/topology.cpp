#include <algorithm>

#include "batten/core/disjoint_sets.hpp"
#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/network/curve_network.hpp"

namespace batten {

namespace {

void check_curve(const CurveNetwork& network, std::size_t c) {
  const std::vector<int>& vertices = network.curves[c].vertices;
  if (vertices.size() < 2)
    throw InvalidInput(concat(curve_name(network, static_cast<int>(c)), " has ", vertices.size(),
                              " vertices; a curve needs at least two, so complete or remove it"));
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (vertices[i] < 0 || vertices[i] >= network.positions.rows())
      throw InvalidInput(concat(curve_name(network, static_cast<int>(c)), " names vertex ", vertices[i],
                                ", but the network has the vertices 0 to ", network.positions.rows() - 1));
    if (i > 0 && vertices[i] == vertices[i - 1])
      throw InvalidInput(concat(curve_name(network, static_cast<int>(c)), " repeats vertex ", vertices[i],
                                " at place ", i, "; remove the repetition"));
  }
}

}  // namespace

std::string curve_name(const CurveNetwork& network, int curve) {
  const std::string& name = network.curves[curve].name;
  return name.empty() ? concat("curve ", curve) : concat("curve ", curve, " (", name, ")");
}

NetworkTopology network_topology(const CurveNetwork& network) {
  const auto n = static_cast<int>(network.positions.rows());
  std::vector<int> degree(n, 0);
  std::vector<char> is_node(n, 0);
  for (std::size_t c = 0; c < network.curves.size(); ++c) {
    check_curve(network, c);
    const NetworkCurve& curve = network.curves[c];
    for (std::size_t i = 0; i + 1 < curve.vertices.size(); ++i) {
      ++degree[curve.vertices[i]];
      ++degree[curve.vertices[i + 1]];
    }
    if (!curve.closed()) is_node[curve.vertices.front()] = is_node[curve.vertices.back()] = 1;
  }
  for (int v = 0; v < n; ++v)
    if (degree[v] > 2) is_node[v] = 1;
  for (const int v : network.tagged_nodes) {
    if (v < 0 || v >= n)
      throw InvalidInput(
          concat("the node list names vertex ", v, ", but the network has the vertices 0 to ", n - 1));
    if (degree[v] > 0) is_node[v] = 1;
  }
  for (const NetworkCurve& curve : network.curves)
    if (curve.closed() &&
        std::none_of(curve.vertices.begin(), curve.vertices.end(), [&](int v) { return is_node[v]; }))
      is_node[curve.vertices.front()] = 1;

  NetworkTopology topology;
  topology.node_of_vertex.assign(n, -1);
  for (int v = 0; v < n; ++v)
    if (is_node[v]) {
      topology.node_of_vertex[v] = static_cast<int>(topology.nodes.size());
      topology.nodes.push_back(v);
    }

  for (std::size_t c = 0; c < network.curves.size(); ++c) {
    const NetworkCurve& curve = network.curves[c];
    std::vector<int> walk = curve.vertices;
    if (curve.closed()) {  // begin the walk at a node, so that every segment runs from node to node
      walk.pop_back();
      std::rotate(walk.begin(), std::find_if(walk.begin(), walk.end(), [&](int v) { return is_node[v]; }),
                  walk.end());
      walk.push_back(walk.front());
    }
    NetworkSegment segment{static_cast<int>(c), curve.boundary, {walk.front()}, -1, -1};
    for (std::size_t i = 1; i < walk.size(); ++i) {
      segment.vertices.push_back(walk[i]);
      if (!is_node[walk[i]]) continue;
      segment.from = topology.node_of_vertex[segment.vertices.front()];
      segment.to = topology.node_of_vertex[walk[i]];
      topology.segments.push_back(segment);
      segment.vertices = {walk[i]};
    }
  }

  DisjointSets components(static_cast<int>(topology.nodes.size()));
  for (const NetworkSegment& segment : topology.segments) components.unite(segment.from, segment.to);
  topology.component_of_node = components.labels();
  topology.n_components = components.n_sets();
  return topology;
}

}  // namespace batten
