#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "batten/core/index.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/box_tree.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/strokes/network_pieces_detail.hpp"
#include "batten/strokes/overdrawn_strokes_detail.hpp"

namespace batten::detail {

namespace {

using Vector = Eigen::Vector3d;

/// Strokes drawn over each other run within this angle.
const double kSameDirection = std::cos(radians(25));
/// Less than this many tolerances along each other is a crossing or a touch, not a stroke drawn twice.
constexpr double kOverdraw = 6;
/// What is left between two overdrawn pieces counts when it is this many tolerances long.
constexpr double kRest = 3;

class OverdrawRemover {
 public:
  OverdrawRemover(const CurveNetwork& network, double tolerance) : network_(network), tolerance_(tolerance) {
    for (size_t c = 0; c < network.curves.size(); ++c) {
      const std::vector<int>& vertices = network.curves[c].vertices;
      lengths_.push_back(length_of(network, vertices));
      double along = 0;
      first_.push_back(static_cast<int>(edges_.size()));
      for (size_t k = 0; k + 1 < vertices.size(); ++k) {
        const Vector a = position(network, vertices[k]), b = position(network, vertices[k + 1]);
        edges_.push_back({static_cast<int>(c), a, b, along});
        along += (b - a).norm();
        boxes_.push_back({a.cwiseMin(b), a.cwiseMax(b)});
      }
    }
    first_.push_back(static_cast<int>(edges_.size()));
  }

  CurveNetwork run(int& n_dropped) {
    const BoxTree tree(boxes_);
    std::vector<int> by_length(network_.curves.size());
    std::iota(by_length.begin(), by_length.end(), 0);
    std::stable_sort(by_length.begin(), by_length.end(),
                     [&](int a, int b) { return lengths_[at(a)] > lengths_[at(b)]; });
    rank_.resize(by_length.size());
    for (size_t i = 0; i < by_length.size(); ++i) rank_[at(by_length[i])] = static_cast<int>(i);
    dropped_.assign(edges_.size(), 0);
    for (const int c : by_length) {
      std::vector<char> covered;
      for (int e = first_[at(c)]; e < first_[at(c) + 1]; ++e) covered.push_back(is_covered(tree, e));
      n_dropped += drop_runs(c, covered);
    }
    CurveNetwork result = network_;
    result.curves.clear();
    for (size_t c = 0; c < network_.curves.size(); ++c) {
      const NetworkCurve& curve = network_.curves[c];
      NetworkCurve piece{curve.name, curve.boundary, {}, curve.sharp};
      for (int e = first_[c]; e < first_[c + 1]; ++e) {
        const size_t k = at(e - first_[c]);
        if (dropped_[at(e)]) {
          if (piece.vertices.size() > 1) result.curves.push_back(piece);
          piece.vertices.clear();
          continue;
        }
        if (piece.vertices.empty()) piece.vertices.push_back(curve.vertices[k]);
        piece.vertices.push_back(curve.vertices[k + 1]);
      }
      if (piece.vertices.size() > 1) result.curves.push_back(std::move(piece));
    }
    return compacted(std::move(result));
  }

 private:
  struct Edge {
    int curve;
    Vector a, b;
    double along;  ///< arc length from the beginning of its curve to a
  };

  /// The middle of an edge lies beside a longer stroke, or an earlier place of the same, that goes its way.
  bool is_covered(const BoxTree& tree, int e) const {
    const Edge& edge = edges_[at(e)];
    const Vector middle = 0.5 * (edge.a + edge.b), direction = (edge.b - edge.a).normalized();
    const Box around{middle.array() - tolerance_, middle.array() + tolerance_};
    bool covered = false;
    tree.query(around, [&](int f) {
      const Edge& other = edges_[at(f)];
      if (dropped_[at(f)]) return true;
      if (other.curve == edge.curve ? other.along > edge.along - 2 * kOverdraw * tolerance_
                                    : rank_[at(other.curve)] > rank_[at(edge.curve)])
        return true;
      if (closest_point_on_segment(middle, other.a, other.b).squared_distance > tolerance_ * tolerance_)
        return true;
      covered = std::abs((other.b - other.a).normalized().dot(direction)) > kSameDirection;
      return !covered;
    });
    return covered;
  }

  /// Marks the covered runs that are long enough; short rests between or beside them go along.
  int drop_runs(int c, std::vector<char>& covered) {
    const int first = first_[at(c)], n = static_cast<int>(covered.size());
    const auto length = [&](int begin, int end) {
      double sum = 0;
      for (int k = begin; k < end; ++k) sum += (edges_[at(first + k)].b - edges_[at(first + k)].a).norm();
      return sum;
    };
    const auto runs = [&] {
      std::vector<std::array<int, 2>> list;
      for (int k = 0; k < n;) {
        int end = k;
        while (end < n && covered[at(end)] == covered[at(k)]) ++end;
        list.push_back({k, end});
        k = end;
      }
      return list;
    };
    for (const auto& [begin, end] : runs())
      if (covered[at(begin)] && length(begin, end) < kOverdraw * tolerance_ &&
          length(begin, end) < 0.8 * lengths_[at(c)])
        std::fill(covered.begin() + begin, covered.begin() + end, 0);
    for (const auto& [begin, end] : runs())
      if (!covered[at(begin)] && length(begin, end) < kRest * tolerance_ && n > end - begin)
        std::fill(covered.begin() + begin, covered.begin() + end, 1);
    int dropped = 0;
    for (const auto& [begin, end] : runs()) {
      if (!covered[at(begin)]) continue;
      ++dropped;
      std::fill(dropped_.begin() + first + begin, dropped_.begin() + first + end, 1);
    }
    return dropped;
  }

  const CurveNetwork& network_;
  double tolerance_;
  std::vector<Edge> edges_;
  std::vector<int> first_;  ///< per curve: its first edge; and the total
  std::vector<Box> boxes_;
  std::vector<double> lengths_;
  std::vector<int> rank_;
  std::vector<char> dropped_;
};

}  // namespace

CurveNetwork without_overdrawn(const CurveNetwork& network, double tolerance, int& n_dropped) {
  return OverdrawRemover(network, tolerance).run(n_dropped);
}

}  // namespace batten::detail
