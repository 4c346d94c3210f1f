#pragma once
#include <functional>
#include <queue>
#include <utility>
#include <vector>

#include "batten/core/index.hpp"
#include "batten/mesh/box_tree.hpp"

namespace batten {

/// A hierarchy over boxes that come, go and change, each under a number of its owner's choice: every one of
/// these costs O(log n), as do searches beside their answers. What searches give depends on the boxes alone,
/// not on the order in which they came.
class DynamicBoxTree {
 public:
  /// Gives an item a box, in place of the one it had, if any. @pre item ≥ 0.
  void set(int item, const Box& box);
  /// Takes an item away; one that is not here is passed over.
  void remove(int item);
  /// Other items in place of all: O(n log n), with a better tree than one by one. @pre no item twice.
  void assign(const std::vector<std::pair<int, Box>>& items);

  bool empty() const { return root_ < 0; }
  /// The box around everything. @pre not empty.
  const Box& bounds() const { return nodes_[at(root_)].box; }
  /// The items whose boxes meet a box, increasing.
  std::vector<int> meeting(const Box& box) const;
  /// Visits items by increasing bound, until the next bound is greater than what the last visit has returned.
  /// @param bound of a box: at most that of every box within it.
  /// @param visit is given an item and returns the greatest bound that is still of interest.
  template <typename Bound, typename Visit>
  void visit_nearest(Bound bound, Visit visit) const;

 private:
  struct Node {
    Box box;
    int parent = -1;
    int left = -1;   // −1: a leaf
    int right = -1;  // of a leaf: the item
    int height = 0;
    bool is_leaf() const { return left < 0; }
  };

  int new_node();
  int build(std::vector<std::pair<int, Box>>& items, size_t begin, size_t end);
  void insert(int leaf);
  void take_out(int leaf);
  void mend_upwards(int node);
  int balanced(int node);
  void gather(int node);
  void replace_child(int parent, int old, int by);

  std::vector<Node> nodes_;
  std::vector<int> free_;     // nodes without use
  std::vector<int> leaf_of_;  // by item, −1: none
  int root_ = -1;
};

template <typename Bound, typename Visit>
void DynamicBoxTree::visit_nearest(Bound bound, Visit visit) const {
  if (empty()) return;
  using Entry = std::pair<double, int>;  // bound, node
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  queue.emplace(bound(bounds()), root_);
  bool is_limited = false;
  double limit = 0;
  while (!queue.empty()) {
    const auto [least, index] = queue.top();
    queue.pop();
    if (is_limited && least > limit) return;
    const Node& node = nodes_[at(index)];
    if (node.is_leaf()) {
      limit = visit(node.right);
      is_limited = true;
      continue;
    }
    for (const int child : {node.left, node.right}) {
      const double b = bound(nodes_[at(child)].box);
      if (!is_limited || b <= limit) queue.emplace(b, child);
    }
  }
}

}  // namespace batten
