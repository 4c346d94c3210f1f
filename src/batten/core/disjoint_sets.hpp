#pragma once
#include <vector>

#include "batten/core/index.hpp"

namespace batten {

/// Elements 0 … n − 1 in sets that are united one pair at a time (union-find). Each set is known by its
/// smallest element, so that the outcome does not depend on the order of the unions.
///
/// Paths are halved at every look-up (R. E. Tarjan, J. van Leeuwen, "Worst-case analysis of set union
/// algorithms", J. ACM 31, 1984): O(log n) per call when taken over many.
class DisjointSets {
 public:
  /// Every element on its own.
  explicit DisjointSets(int n);
  /// One more element, on its own. @return its number.
  int add();

  int size() const { return static_cast<int>(parent_.size()); }
  int n_sets() const { return n_sets_; }

  /// The smallest element of the set that holds `i`. @pre 0 ≤ i < size().
  int root(int i) {
    while (parent_[at(i)] != i) i = parent_[at(i)] = parent_[at(parent_[at(i)])];
    return i;
  }
  bool joined(int a, int b) { return root(a) == root(b); }
  /// Unites the sets of `a` and `b`. @return false when they were one already.
  bool unite(int a, int b);

  /// Per element the number of its set, 0 … n_sets() − 1, in the order of the smallest elements.
  std::vector<int> labels();

 private:
  std::vector<int> parent_;  // never larger than the element itself
  int n_sets_ = 0;
};

}  // namespace batten
