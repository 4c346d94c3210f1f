#pragma once
#include <vector>

#include "batten/network/curve_network.hpp"

// Private to the room.
namespace batten::detail {

/// Finds the segments of a network that have no patch on one of their sides, or one patch on both.
class OpenSegments {
 public:
  /// @param topology must outlive this.
  explicit OpenSegments(const NetworkTopology& topology);

  /// Takes out the segments that end in nothing, and those that then do, each after the one behind it.
  std::vector<int> take_tails();
  /// Takes out the bridges among those that are left: segments that no other way round closes; ascending. By
  /// depth-first search, linear time.
  std::vector<int> take_bridges();
  bool is_kept(int segment) const;

 private:
  int other_end(int segment, int node) const;

  const NetworkTopology& topology_;
  std::vector<std::vector<int>> incident_;  ///< per node: its segments
  std::vector<char> kept_;
};

}  // namespace batten::detail
