#include <algorithm>
#include <utility>

#include <Eigen/Dense>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/network/end_parabola.hpp"
#include "batten/strokes/link_graph_detail.hpp"

namespace batten::detail {

using Eigen::Vector3d;

Vector3d link_direction(const CurveNetwork& network, const LinkGraph& graph, int half_edge, double size) {
  const NetworkLink& link = graph.links[at(half_edge / 2)];
  const std::vector<int>& vertices = link.vertices;
  const size_t n = vertices.size();
  const double window = std::min(0.3 * link.length, 0.05 * size);
  const auto walk = [&](size_t i) {
    return Vector3d(network.positions.row(vertices[half_edge % 2 == 0 ? i : n - 1 - i]));
  };
  EndParabola parabola(walk(0));
  for (size_t i = 1; i < n && (i < 3 || parabola.length() < window); ++i) parabola.add(walk(i));
  const Vector3d chord = parabola.chord(), tangent = parabola.tangent();
  return tangent.norm() > 0 && tangent.dot(chord) > 0 ? tangent.normalized() : chord.normalized();
}

double network_size(const CurveNetwork& network, const LinkGraph& graph) {
  Vector3d mean = Vector3d::Zero();
  double count = 0, greatest = 0;
  for (const NetworkLink& link : graph.links)
    for (const int v : link.vertices) {
      mean += network.positions.row(v).transpose();
      ++count;
    }
  if (count > 0) mean /= count;
  for (const NetworkLink& link : graph.links)
    for (const int v : link.vertices)
      greatest = std::max(greatest, (network.positions.row(v).transpose() - mean).norm());
  return 2 * greatest;
}

LinkGraph link_graph(const CurveNetwork& network) {
  LinkGraph graph;
  graph.topology = network_topology(network);
  const std::vector<NetworkSegment>& segments = graph.topology.segments;
  for (const NetworkSegment& segment : segments)
    for (size_t i = 0; i < segment.vertices.size(); ++i) {
      const int v = segment.vertices[i];
      if (!network.positions.row(v).allFinite())
        throw InvalidInput(concat("vertex ", v, " of ", curve_name(network, segment.curve),
                                  " has a coordinate that is not a number; repair or remove it"));
      if (i > 0 && network.positions.row(v) == network.positions.row(segment.vertices[i - 1]))
        throw InvalidInput(concat("the vertices ", segment.vertices[i - 1], " and ", v, " of ",
                                  curve_name(network, segment.curve),
                                  " lie at the same place; merge them into one"));
    }
  std::vector<std::vector<int>> leaving(graph.topology.nodes.size());
  for (size_t s = 0; s < segments.size(); ++s) {
    leaving[at(segments[s].from)].push_back(static_cast<int>(2 * s));
    leaving[at(segments[s].to)].push_back(static_cast<int>(2 * s + 1));
  }
  for (size_t n = 0; n < leaving.size(); ++n)
    if (leaving[n].size() == 1)
      throw InvalidInput(concat(curve_name(network, segments[at(leaving[n][0] / 2)].curve),
                                " ends at vertex ", graph.topology.nodes[n],
                                " without meeting another curve; join it to the network or remove it"));
  const auto passed = [&](int n) {
    const std::vector<int>& half_edges = leaving[at(n)];
    return half_edges.size() == 2 && half_edges[0] / 2 != half_edges[1] / 2 &&
           segments[at(half_edges[0] / 2)].boundary == segments[at(half_edges[1] / 2)].boundary;
  };
  graph.half_edges.resize(leaving.size());
  std::vector<char> taken(segments.size(), 0);
  const auto walk = [&](int first) {
    const auto l = static_cast<int>(graph.links.size());
    NetworkLink link;
    link.border = segments[at(first / 2)].boundary;
    int half_edge = first;
    while (true) {
      const NetworkSegment& segment = segments[at(half_edge / 2)];
      taken[at(half_edge / 2)] = 1;
      link.half_edges.push_back(half_edge);
      const bool forwards = half_edge % 2 == 0;
      std::vector<int> vertices = segment.vertices;
      if (!forwards) std::reverse(vertices.begin(), vertices.end());
      if (link.from < 0) {
        link.from = forwards ? segment.from : segment.to;
        link.vertices.push_back(vertices.front());
      }
      link.vertices.insert(link.vertices.end(), vertices.begin() + 1, vertices.end());
      link.to = forwards ? segment.to : segment.from;
      if (link.to == link.from || !passed(link.to)) break;
      const std::vector<int>& next = leaving[at(link.to)];
      half_edge = next[0] == (half_edge ^ 1) ? next[1] : next[0];
    }
    for (size_t i = 1; i < link.vertices.size(); ++i)
      link.length +=
          (network.positions.row(link.vertices[i]) - network.positions.row(link.vertices[i - 1])).norm();
    graph.half_edges[at(link.from)].push_back(2 * l);
    graph.half_edges[at(link.to)].push_back(2 * l + 1);
    graph.links.push_back(std::move(link));
  };
  for (size_t n = 0; n < leaving.size(); ++n)
    if (!passed(static_cast<int>(n)))
      for (const int d : leaving[n])
        if (!taken[at(d / 2)]) walk(d);
  for (size_t s = 0; s < segments.size(); ++s)  // what is left are closed chains
    if (!taken[s]) walk(static_cast<int>(2 * s));
  return graph;
}

}  // namespace batten::detail
