#include <utility>

#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/strokes/network_pieces_detail.hpp"

namespace batten::detail {

double length_of(const CurveNetwork& network, const std::vector<int>& vertices) {
  double length = 0;
  for (size_t k = 1; k < vertices.size(); ++k)
    length += (position(network, vertices[k]) - position(network, vertices[k - 1])).norm();
  return length;
}

std::string coordinates(const Eigen::Vector3d& p) {
  return concat("(", p.x(), ", ", p.y(), ", ", p.z(), ")");
}

CurveNetwork compacted(CurveNetwork network) {
  std::vector<int> number(at(static_cast<int>(network.positions.rows())), -1);
  const bool has_normals = network.has_normals();
  for (const NetworkCurve& curve : network.curves)
    for (const int v : curve.vertices) number[at(v)] = 0;
  int n = 0;
  for (size_t v = 0; v < number.size(); ++v)
    if (number[v] == 0) {
      number[v] = n;
      if (has_normals) network.normals.row(n) = network.normals.row(static_cast<Eigen::Index>(v)).eval();
      network.positions.row(n++) = network.positions.row(static_cast<Eigen::Index>(v)).eval();
    }
  network.positions.conservativeResize(n, 3);
  if (has_normals) network.normals.conservativeResize(n, 3);
  for (NetworkCurve& curve : network.curves)
    for (int& v : curve.vertices) v = number[at(v)];
  std::vector<int> tagged;
  for (const int v : network.tagged_nodes)
    if (number[at(v)] >= 0) tagged.push_back(number[at(v)]);
  network.tagged_nodes = std::move(tagged);
  return network;
}

CurveNetwork in_segments(const CurveNetwork& network) {
  CurveNetwork result = network;
  result.curves.clear();
  for (const NetworkSegment& segment : network_topology(network).segments)
    result.curves.push_back({network.curves[at(segment.curve)].name, segment.boundary, segment.vertices,
                             network.curves[at(segment.curve)].sharp});
  return result;
}

}  // namespace batten::detail
