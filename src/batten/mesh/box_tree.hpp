#pragma once
#include <algorithm>
#include <numeric>
#include <vector>

#include <Eigen/Core>

namespace batten {

/// An axis-aligned box; it contains its border.
struct Box {
  Eigen::Vector3d low, high;

  /// Whether both have a point in common.
  bool meets(const Box& other) const {
    return (low.array() <= other.high.array()).all() && (other.low.array() <= high.array()).all();
  }
  /// Grows until the other box lies within.
  void include(const Box& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
  }
};

/// A hierarchy over boxes, split at the median along the longest side: finds those that meet a box in O(log
/// n) and the answers. It refers to the boxes; they must outlive it.
class BoxTree {
 public:
  /// Time O(n log n).
  explicit BoxTree(const std::vector<Box>& boxes) : boxes_(boxes), order_(boxes.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    if (!order_.empty()) build(0, static_cast<int>(order_.size()));
  }

  /// Calls visit(i) for every box that meets `box`, until visit returns false.
  template <typename Visit>
  void query(const Box& box, Visit visit) const {
    if (nodes_.empty()) return;
    std::vector<int> stack{0};
    while (!stack.empty()) {
      const Node& node = nodes_[static_cast<size_t>(stack.back())];
      stack.pop_back();
      if (!node.box.meets(box)) continue;
      if (node.right >= 0) {
        stack.push_back(node.right);
        stack.push_back(static_cast<int>(&node - nodes_.data()) + 1);
        continue;
      }
      for (int k = node.begin; k < node.end; ++k) {
        const int i = order_[static_cast<size_t>(k)];
        if (boxes_[static_cast<size_t>(i)].meets(box) && !visit(i)) return;
      }
    }
  }

 private:
  struct Node {
    Box box;
    int begin = 0, end = 0;
    int right = -1;  // of an inner node; its left child follows it
  };

  int build(int begin, int end) {  // depth log2(n): the halves are equal
    const auto index = static_cast<int>(nodes_.size());
    nodes_.emplace_back();
    Box box = boxes_[static_cast<size_t>(order_[static_cast<size_t>(begin)])];
    for (int k = begin; k < end; ++k)
      box.include(boxes_[static_cast<size_t>(order_[static_cast<size_t>(k)])]);
    int right = -1;
    constexpr int kLeaf = 4;
    if (end - begin > kLeaf) {
      int axis = 0;
      (box.high - box.low).maxCoeff(&axis);
      const int middle = begin + (end - begin) / 2;
      const auto centre = [&](int i) {
        return boxes_[static_cast<size_t>(i)].low(axis) + boxes_[static_cast<size_t>(i)].high(axis);
      };
      std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                       [&](int i, int j) {
                         const double a = centre(i), b = centre(j);
                         return a != b ? a < b : i < j;
                       });
      build(begin, middle);
      right = build(middle, end);
    }
    nodes_[static_cast<size_t>(index)] = {box, begin, end, right};
    return index;
  }

  const std::vector<Box>& boxes_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
};

}  // namespace batten
