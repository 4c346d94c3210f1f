#include "batten/core/disjoint_sets.hpp"

#include <algorithm>
#include <numeric>

namespace batten {

DisjointSets::DisjointSets(int n) : parent_(at(n)), n_sets_(n) {
  std::iota(parent_.begin(), parent_.end(), 0);
}

int DisjointSets::add() {
  parent_.push_back(size());
  ++n_sets_;
  return size() - 1;
}

bool DisjointSets::unite(int a, int b) {
  a = root(a);
  b = root(b);
  if (a == b) return false;
  parent_[at(std::max(a, b))] = std::min(a, b);
  --n_sets_;
  return true;
}

std::vector<int> DisjointSets::labels() {
  std::vector<int> label(parent_.size());
  int next = 0;
  // A root is the smallest of its set, so its label is there before it is asked for.
  for (int i = 0; i < size(); ++i) {
    const int first = root(i);
    label[at(i)] = first == i ? next++ : label[at(first)];
  }
  return label;
}

}  // namespace batten
