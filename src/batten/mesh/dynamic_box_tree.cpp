// A height-balanced binary tree of boxes: a new leaf goes where the sizes of boxes grow least, and rotations
// on the way back keep the heights of siblings within one of each other or so ([goldsmith1987];
// AVL).
#include "batten/mesh/dynamic_box_tree.hpp"

#include <algorithm>

namespace batten {

namespace {

/// The size of a box, as the sum of its sides: areas and volumes of boxes around straight curves are 0.
double margin(const Box& box) {
  return (box.high - box.low).sum();
}

Box merged(Box a, const Box& b) {
  a.include(b);
  return a;
}

}  // namespace

void DynamicBoxTree::set(int item, const Box& box) {
  if (at(item) >= leaf_of_.size()) leaf_of_.resize(at(item) + 1, -1);
  int leaf = leaf_of_[at(item)];
  if (leaf >= 0)
    take_out(leaf);
  else
    leaf = new_node();
  leaf_of_[at(item)] = leaf;
  nodes_[at(leaf)] = {box, -1, -1, item, 0};
  insert(leaf);
}

void DynamicBoxTree::remove(int item) {
  if (at(item) >= leaf_of_.size() || leaf_of_[at(item)] < 0) return;
  take_out(leaf_of_[at(item)]);
  free_.push_back(leaf_of_[at(item)]);
  leaf_of_[at(item)] = -1;
}

void DynamicBoxTree::assign(const std::vector<std::pair<int, Box>>& items) {
  nodes_.clear();
  free_.clear();
  leaf_of_.clear();
  root_ = -1;
  if (items.empty()) return;
  int largest = 0;
  for (const auto& [item, box] : items) largest = std::max(largest, item);
  leaf_of_.resize(at(largest) + 1, -1);
  nodes_.reserve(2 * items.size());
  std::vector<std::pair<int, Box>> order = items;
  root_ = build(order, 0, order.size());
}

int DynamicBoxTree::build(std::vector<std::pair<int, Box>>& items, size_t begin, size_t end) {
  const int index = new_node();
  if (end - begin == 1) {
    nodes_[at(index)] = {items[begin].second, -1, -1, items[begin].first, 0};
    leaf_of_[at(items[begin].first)] = index;
    return index;
  }
  Box all = items[begin].second;
  for (size_t k = begin; k < end; ++k) all.include(items[k].second);
  int axis = 0;
  (all.high - all.low).maxCoeff(&axis);
  const size_t middle = begin + (end - begin) / 2;
  const auto to = [&](size_t k) { return items.begin() + static_cast<std::ptrdiff_t>(k); };
  std::nth_element(to(begin), to(middle), to(end), [&](const auto& a, const auto& b) {
    const double x = a.second.low(axis) + a.second.high(axis), y = b.second.low(axis) + b.second.high(axis);
    return x != y ? x < y : a.first < b.first;
  });
  const int left = build(items, begin, middle), right = build(items, middle, end);
  nodes_[at(index)].left = left;
  nodes_[at(index)].right = right;
  for (const int child : {left, right}) nodes_[at(child)].parent = index;
  gather(index);
  return index;
}

int DynamicBoxTree::new_node() {
  if (free_.empty()) {
    nodes_.emplace_back();
    return static_cast<int>(nodes_.size()) - 1;
  }
  const int node = free_.back();
  free_.pop_back();
  return node;
}

/// Box and height of an inner node from its children.
void DynamicBoxTree::gather(int index) {
  Node& node = nodes_[at(index)];
  const Node &left = nodes_[at(node.left)], &right = nodes_[at(node.right)];
  node.box = merged(left.box, right.box);
  node.height = 1 + std::max(left.height, right.height);
}

/// @param parent −1: the root is replaced.
void DynamicBoxTree::replace_child(int parent, int old, int by) {
  if (parent < 0)
    root_ = by;
  else if (nodes_[at(parent)].left == old)
    nodes_[at(parent)].left = by;
  else
    nodes_[at(parent)].right = by;
  if (by >= 0) nodes_[at(by)].parent = parent;
}

void DynamicBoxTree::insert(int leaf) {
  if (root_ < 0) {
    root_ = leaf;
    return;
  }
  const Box box = nodes_[at(leaf)].box;
  int sibling = root_;
  while (!nodes_[at(sibling)].is_leaf()) {
    const Node& node = nodes_[at(sibling)];
    // Beside this node: a new parent for both. Below it: this box grows, and what happens there.
    const double together = margin(merged(node.box, box)), grown = together - margin(node.box);
    double below[2];
    for (const bool is_right : {false, true}) {
      const Node& child = nodes_[at(is_right ? node.right : node.left)];
      below[is_right ? 1 : 0] =
          grown + margin(merged(child.box, box)) - (child.is_leaf() ? 0 : margin(child.box));
    }
    if (together < std::min(below[0], below[1])) break;
    sibling = below[1] < below[0] ? node.right : node.left;
  }
  const int parent = nodes_[at(sibling)].parent;
  const int joint = new_node();
  replace_child(parent, sibling, joint);
  Node& node = nodes_[at(joint)];
  node.left = sibling;
  node.right = leaf;
  nodes_[at(sibling)].parent = nodes_[at(leaf)].parent = joint;
  mend_upwards(joint);
}

/// Takes a leaf out of the tree; its node stays reserved.
void DynamicBoxTree::take_out(int leaf) {
  const int parent = nodes_[at(leaf)].parent;
  if (parent < 0) {
    root_ = -1;
    return;
  }
  const Node& node = nodes_[at(parent)];
  const int sibling = node.left == leaf ? node.right : node.left;
  const int above = node.parent;
  replace_child(above, parent, sibling);
  free_.push_back(parent);
  mend_upwards(above);
}

/// Boxes, heights and balance from a node up to the root.
void DynamicBoxTree::mend_upwards(int node) {
  while (node >= 0) {
    gather(node);
    node = nodes_[at(balanced(node))].parent;
  }
}

/// Rotates the higher child of a node into its place where heights differ by more than one.
/// @return what is in its place then.
int DynamicBoxTree::balanced(int index) {
  const int left = nodes_[at(index)].left, right = nodes_[at(index)].right;
  const int difference = nodes_[at(right)].height - nodes_[at(left)].height;
  if (difference >= -1 && difference <= 1) return index;
  const int high = difference > 0 ? right : left;
  const int a = nodes_[at(high)].left, b = nodes_[at(high)].right;
  // The higher grandchild stays with the child that rises, the other takes the child's place; of equals the
  // one with which the lower box is the smaller.
  int stays = nodes_[at(a)].height > nodes_[at(b)].height ? a : b;
  if (nodes_[at(a)].height == nodes_[at(b)].height) {
    const Box& low = nodes_[at(difference > 0 ? left : right)].box;
    if (margin(merged(low, nodes_[at(b)].box)) < margin(merged(low, nodes_[at(a)].box))) stays = a;
  }
  const int moves = stays == a ? b : a;
  replace_child(nodes_[at(index)].parent, index, high);
  replace_child(index, high, moves);
  nodes_[at(high)].left = stays;
  nodes_[at(high)].right = index;
  nodes_[at(index)].parent = high;
  gather(index);
  gather(high);
  return high;
}

std::vector<int> DynamicBoxTree::meeting(const Box& box) const {
  std::vector<int> found, stack;
  if (!empty()) stack.push_back(root_);
  while (!stack.empty()) {
    const Node& node = nodes_[at(stack.back())];
    stack.pop_back();
    if (!node.box.meets(box)) continue;
    if (node.is_leaf()) {
      found.push_back(node.right);
    } else {
      stack.push_back(node.left);
      stack.push_back(node.right);
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace batten
