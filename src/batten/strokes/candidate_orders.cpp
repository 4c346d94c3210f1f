#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include <Eigen/Dense>

#include "batten/core/index.hpp"
#include "batten/core/units.hpp"
#include "batten/strokes/candidate_orders_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Vector3d;

/// Cost of one radian that the sectors of a node turn beyond the least possible: a crossing read wrongly
/// turns by a half turn more, as much as a patch that changes to the other side along a curve.
constexpr double kSectorCost = 1 / kPi;
/// Orders are tried one and all up to this number of curves at a node (720); beyond it those seen along
/// likely axes.
constexpr std::size_t kMostPermuted = 7;
/// Of the pairs of curves at a node, so many are looked along; all of them up to 14 curves.
constexpr std::size_t kMostPairs = 100;

/// Orders by their places, each beginning with place 0.
using Sequences = std::set<std::vector<int>>;

/// Axes along which the half-edges of a node may be seen in order.
std::vector<Vector3d> likely_axes(const std::vector<Vector3d>& tangents) {
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& t : tangents) {
    moments += t * t.transpose();
    sum += t;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moments);
  std::vector<Vector3d> axes;
  axes.reserve(4);
  for (int i = 0; i < 3; ++i) axes.emplace_back(solver.eigenvectors().col(i));
  if (sum.norm() > 1e-6) axes.push_back(sum.normalized());
  const size_t stride = 1 + tangents.size() * (tangents.size() - 1) / 2 / kMostPairs;
  size_t pair = 0;
  for (size_t i = 0; i < tangents.size(); ++i)
    for (size_t j = 0; j < i; ++j) {
      if (pair++ % stride != 0) continue;
      const Vector3d normal = tangents[i].cross(tangents[j]);
      if (normal.norm() > 0.2) axes.push_back(normal.normalized());
    }
  return axes;
}

Sequences all_sequences(int k) {
  Sequences sequences;
  std::vector<int> sequence(at(k));
  std::iota(sequence.begin(), sequence.end(), 0);
  do sequences.insert(sequence);
  while (std::next_permutation(sequence.begin() + 1, sequence.end()));
  return sequences;
}

/// Those seen along likely axes, from both sides, and with two neighbours exchanged.
Sequences likely_sequences(const std::vector<Vector3d>& tangents) {
  const auto k = static_cast<int>(tangents.size());
  Sequences sequences;
  const auto add = [&](std::vector<int> sequence) {
    std::rotate(sequence.begin(), std::find(sequence.begin(), sequence.end(), 0), sequence.end());
    sequences.insert(sequence);
    std::reverse(sequence.begin() + 1, sequence.end());
    sequences.insert(std::move(sequence));
  };
  for (const Vector3d& axis : likely_axes(tangents)) {
    const Vector3d u = axis.unitOrthogonal(), w = axis.cross(u);
    std::vector<std::pair<double, int>> around;
    around.reserve(at(k));
    for (int i = 0; i < k; ++i)
      around.emplace_back(std::atan2(tangents[at(i)].dot(w), tangents[at(i)].dot(u)), i);
    std::sort(around.begin(), around.end());
    std::vector<int> sequence;
    sequence.reserve(around.size());
    for (const auto& [angle, i] : around) sequence.push_back(i);
    add(sequence);
    for (int i = 0; i < k; ++i) {  // neighbours may be told apart wrongly
      std::swap(sequence[at(i)], sequence[at((i + 1) % k)]);
      add(sequence);
      std::swap(sequence[at(i)], sequence[at((i + 1) % k)]);
    }
  }
  return sequences;
}

/// The order of a sequence, without cost and mirror image.
NodeOrder order_of(const std::vector<int>& sequence) {
  const std::size_t k = sequence.size();
  NodeOrder order;
  order.sequence = sequence;
  order.left.resize(k);
  order.right.resize(k);
  for (std::size_t p = 0; p < k; ++p) {
    const int i = sequence[p], next = sequence[(p + 1) % k];
    order.left[at(i)] = next;
    order.right[at(next)] = i;
  }
  return order;
}

}  // namespace

std::vector<NodeOrder> candidate_orders(const std::vector<Vector3d>& tangents,
                                        const std::vector<int>& borders) {
  std::vector<NodeOrder> orders;
  const auto k = static_cast<int>(tangents.size());
  if (k == 0) return orders;
  const bool at_border = borders.size() == 2;
  std::map<std::vector<int>, int> number;
  double least = std::numeric_limits<double>::infinity();
  for (const std::vector<int>& sequence :
       tangents.size() <= kMostPermuted ? all_sequences(k) : likely_sequences(tangents)) {
    NodeOrder order = order_of(sequence);
    // Between the two pieces of a border lies the outside, which may turn as far as it likes.
    if (at_border && k > 2) {
      const int a = borders[0], b = borders[1];
      if (order.left[at(a)] != b && order.left[at(b)] != a) continue;
    }
    for (int i = 0; i < k; ++i) {
      const int j = order.left[at(i)];
      if (at_border && std::min(i, j) == borders[0] && std::max(i, j) == borders[1]) continue;
      order.cost += kSectorCost * std::acos(std::clamp(tangents[at(i)].dot(tangents[at(j)]), -1.0, 1.0));
    }
    least = std::min(least, order.cost);
    number[sequence] = static_cast<int>(orders.size());
    orders.push_back(std::move(order));
  }
  for (NodeOrder& order : orders) {
    order.cost -= least;
    std::vector<int> sequence = order.sequence;
    std::reverse(sequence.begin() + 1, sequence.end());
    order.mirrored = number.at(sequence);
  }
  return orders;
}

}  // namespace batten::detail
