#include "batten/scan/samples.hpp"

#include <map>

namespace batten {

int SampledScan::n_samples() const {
  int n = 0;
  for (const SampledCurve& curve : curves) n += curve.n_samples();
  return n;
}

double SampledScan::length() const {
  double sum = 0;
  for (const SampledCurve& curve : curves) sum += curve.length();
  return sum;
}

VertexNumbering number_vertices(const SampledScan& scan) {
  VertexNumbering numbering;
  std::map<int, int> vertex_of_node;
  for (const SampledCurve& curve : scan.curves)
    for (const int id : curve.node_ids) vertex_of_node.emplace(id, 0);
  for (auto& [id, vertex] : vertex_of_node) vertex = numbering.n_nodes++;
  numbering.vertices.resize(scan.curves.size());
  for (size_t c = 0; c < scan.curves.size(); ++c) {
    const SampledCurve& curve = scan.curves[c];
    std::vector<int>& vertices = numbering.vertices[c];
    vertices.assign(curve.n_samples(), -1);
    for (size_t j = 0; j < curve.node_samples.size(); ++j)
      vertices[curve.node_samples[j]] = vertex_of_node[curve.node_ids[j]];
    if (curve.closed && vertices.front() < 0) vertices.front() = vertices.back() = numbering.n_nodes++;
  }
  numbering.n_vertices = numbering.n_nodes;
  for (std::vector<int>& vertices : numbering.vertices)
    for (int& vertex : vertices)
      if (vertex < 0) vertex = numbering.n_vertices++;
  return numbering;
}

FrameNumbering number_frames(const SampledScan& scan) {
  FrameNumbering numbering;
  numbering.frames.resize(scan.curves.size());
  const VertexNumbering vertices = number_vertices(scan);
  std::vector<std::vector<int>> visits(vertices.n_nodes);
  std::vector<char> on_edge(vertices.n_nodes, 0);  // nodes of sharp curves: no normal in common
  for (size_t c = 0; c < scan.curves.size(); ++c) {
    const SampledCurve& curve = scan.curves[c];
    const int n = curve.n_samples();
    for (int k = 0; k < n; ++k) {
      const bool same_as_first = curve.smooth_seam && k == n - 1;
      const int frame = same_as_first ? numbering.frames[c].front() : numbering.n_frames++;
      numbering.frames[c].push_back(frame);
      const int vertex = vertices.vertices[c][k];
      if (vertex < vertices.n_nodes && !same_as_first) visits[vertex].push_back(frame);
      if (vertex < vertices.n_nodes && curve.sharp) on_edge[vertex] = 1;
    }
  }
  for (size_t node = 0; node < visits.size(); ++node) {
    if (on_edge[node]) continue;
    const std::vector<int>& frames = visits[node];
    for (size_t i = 0; i < frames.size(); ++i)
      for (size_t j = 0; j < i; ++j) numbering.node_pairs.emplace_back(frames[i], frames[j]);
  }
  return numbering;
}

}  // namespace batten
