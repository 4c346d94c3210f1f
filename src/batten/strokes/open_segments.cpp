#include <algorithm>

#include "batten/core/index.hpp"
#include "batten/strokes/open_segments_detail.hpp"

namespace batten::detail {

OpenSegments::OpenSegments(const NetworkTopology& topology)
    : topology_(topology), incident_(topology.nodes.size()), kept_(topology.segments.size(), 1) {
  const std::vector<NetworkSegment>& segments = topology.segments;
  for (size_t s = 0; s < segments.size(); ++s) {
    incident_[at(segments[s].from)].push_back(static_cast<int>(s));
    if (segments[s].to != segments[s].from) incident_[at(segments[s].to)].push_back(static_cast<int>(s));
  }
}

bool OpenSegments::is_kept(int segment) const {
  return kept_[at(segment)] != 0;
}

int OpenSegments::other_end(int segment, int node) const {
  const NetworkSegment& ends = topology_.segments[at(segment)];
  return ends.from == node ? ends.to : ends.from;
}

std::vector<int> OpenSegments::take_tails() {
  const std::vector<NetworkSegment>& segments = topology_.segments;
  std::vector<int> taken;
  std::vector<int> queue;
  std::vector<int> valence(topology_.nodes.size(), 0);
  for (size_t s = 0; s < segments.size(); ++s) {
    ++valence[at(segments[s].from)];
    ++valence[at(segments[s].to)];
  }
  for (size_t n = 0; n < valence.size(); ++n)
    if (valence[n] == 1) queue.push_back(static_cast<int>(n));
  while (!queue.empty()) {
    const int node = queue.back();
    queue.pop_back();
    if (valence[at(node)] != 1) continue;
    for (const int s : incident_[at(node)]) {
      if (!kept_[at(s)]) continue;
      kept_[at(s)] = 0;
      taken.push_back(s);
      --valence[at(node)];
      if (--valence[at(other_end(s, node))] == 1) queue.push_back(other_end(s, node));
    }
  }
  return taken;
}

std::vector<int> OpenSegments::take_bridges() {
  std::vector<int> order(topology_.nodes.size(), -1), low(topology_.nodes.size(), 0);
  int clock = 0;
  struct Visit {
    int node, by;
    size_t next;
  };
  std::vector<int> bridges;
  for (size_t start = 0; start < order.size(); ++start) {
    if (order[start] >= 0) continue;
    std::vector<Visit> stack{{static_cast<int>(start), -1, 0}};
    order[start] = low[start] = clock++;
    while (!stack.empty()) {
      const int node = stack.back().node, by = stack.back().by;
      if (stack.back().next < incident_[at(node)].size()) {
        const int s = incident_[at(node)][stack.back().next++];
        if (!kept_[at(s)] || s == by) continue;
        const int to = other_end(s, node);
        if (order[at(to)] < 0) {
          order[at(to)] = low[at(to)] = clock++;
          stack.push_back({to, s, 0});
        } else {
          low[at(node)] = std::min(low[at(node)], order[at(to)]);
        }
        continue;
      }
      stack.pop_back();
      if (by < 0) continue;
      const int parent = stack.back().node;
      low[at(parent)] = std::min(low[at(parent)], low[at(node)]);
      if (low[at(node)] > order[at(parent)]) bridges.push_back(by);
    }
  }
  std::sort(bridges.begin(), bridges.end());
  for (const int s : bridges) kept_[at(s)] = 0;
  return bridges;
}

}  // namespace batten::detail
