#include <algorithm>
#include <array>
#include <cmath>
#include <deque>

#include <Eigen/Geometry>

#include "batten/core/index.hpp"
#include "batten/core/units.hpp"
#include "batten/modelling/face_parts_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Pieces so many times longer than wide are divided, until they are half of that; into so many at most.
constexpr double kLongPiece = 4;
constexpr int kMostParts = 16;
/// Quadrilaterals so many times longer than wide are to have rows and columns.
constexpr double kLongFace = 2;
/// A face asks its neighbours for other numbers of parts so many times at most.
constexpr int kMostTurns = 8;

class Planner {
 public:
  Planner(size_t n_edges, const std::vector<const FaceSides*>& faces)
      : faces_(faces), parts_(n_edges, 1), faces_of_edge_(n_edges, {-1, -1}) {
    for (size_t f = 0; f < faces.size(); ++f) {
      if (!faces[f]) continue;
      for (const int e : faces[f]->edges) {
        auto& both = faces_of_edge_[at(e)];
        both[both[0] < 0 ? 0 : 1] = static_cast<int>(f);
      }
    }
  }

  std::vector<int> run() {
    for (const FaceSides* face : faces_) {
      if (!face) continue;
      for (size_t k = 0; k < face->edges.size(); ++k) {
        int& parts = parts_[at(face->edges[k])];
        parts = std::max(parts, face->parts[k]);
      }
    }
    for (const FaceSides* face : faces_)
      if (face && !face->corners.empty()) divide_long_pieces(*face);
    std::deque<int> waiting;
    std::vector<int> turns(faces_.size(), 0);
    std::vector<char> waits(faces_.size(), 0);
    const auto ask = [&](int f) {
      if (f < 0 || waits[at(f)] || turns[at(f)] == kMostTurns || !is_long(*faces_[at(f)])) return;
      waits[at(f)] = 1;
      waiting.push_back(f);
    };
    for (size_t f = 0; f < faces_.size(); ++f)
      if (faces_[f]) ask(static_cast<int>(f));
    while (!waiting.empty()) {
      const int f = waiting.front();
      waiting.pop_front();
      waits[at(f)] = 0;
      ++turns[at(f)];
      for (const int e : equalise(*faces_[at(f)]))
        for (const int other : faces_of_edge_[at(e)])
          if (other != f) ask(other);
    }
    return std::move(parts_);
  }

 private:
  static std::vector<size_t> between(const FaceSides& face, size_t c) {
    return sides_between(face.corners, face.edges.size(), c);
  }

  static double length_between(const FaceSides& face, size_t c) {
    double sum = 0;
    for (const size_t k : between(face, c)) sum += face.lengths[k];
    return sum;
  }

  static bool is_long(const FaceSides& face) {
    if (face.corners.empty()) return false;
    const double one = length_between(face, 0) + length_between(face, 2),
                 other = length_between(face, 1) + length_between(face, 3);
    return std::max(one, other) > kLongFace * std::min(one, other);
  }

  void divide_long_pieces(const FaceSides& face) {
    for (size_t c = 0; c < 2; ++c) {
      const auto mean = [&](size_t one, size_t other) {
        return (length_between(face, one) + length_between(face, other)) /
               static_cast<double>(between(face, one).size() + between(face, other).size());
      };
      const double along = mean(c, c + 2), across = mean(c + 1, (c + 3) % 4);
      if (!(along > kLongPiece * across)) continue;
      const int wanted =
          static_cast<int>(std::lround(std::min<double>(2 * along / (kLongPiece * across), kMostParts)));
      for (const size_t side : {c, c + 2})
        for (const size_t k : between(face, side)) {
          int& parts = parts_[at(face.edges[k])];
          parts = std::max(parts, wanted);
        }
    }
  }

  /// Gives opposite sides the same number of parts. @return the edges that got more.
  std::vector<int> equalise(const FaceSides& face) {
    std::vector<int> raised;
    for (size_t c = 0; c < 2; ++c) {
      const std::vector<size_t> one = between(face, c), other = between(face, c + 2);
      const auto count = [&](const std::vector<size_t>& sides) {
        int sum = 0;
        for (const size_t k : sides) sum += parts_[at(face.edges[k])];
        return sum;
      };
      const bool first_has_less = count(one) < count(other);
      const std::vector<size_t>& less = first_has_less ? one : other;
      int lack = std::abs(count(one) - count(other));
      for (; lack > 0; --lack) {
        const auto part = [&](size_t k) { return face.lengths[k] / parts_[at(face.edges[k])]; };
        const size_t longest = *std::max_element(less.begin(), less.end(),
                                                 [&](size_t a, size_t b) { return part(a) < part(b); });
        if (parts_[at(face.edges[longest])] == kMostParts) break;
        ++parts_[at(face.edges[longest])];
        raised.push_back(face.edges[longest]);
      }
    }
    return raised;
  }

  const std::vector<const FaceSides*>& faces_;
  std::vector<int> parts_;
  std::vector<std::array<int, 2>> faces_of_edge_;
};

}  // namespace

std::vector<size_t> corners_of_quadrilateral(const std::vector<Points>& sides) {
  constexpr double kCornerFrom = kPi / 4;  // hands and holes do not make smooth joints quite straight
  const size_t n = sides.size();
  std::vector<std::pair<double, size_t>> turns;
  for (size_t k = 0; k < n; ++k) {
    const Points &last = sides[(k + n - 1) % n], &next = sides[k];
    const Vector3d in = last.row(last.rows() - 1) - last.row(last.rows() - 2),
                   out = next.row(1) - next.row(0);
    turns.emplace_back(-std::atan2(in.cross(out).norm(), in.dot(out)), k);
  }
  if (n < 4) return {};
  std::sort(turns.begin(), turns.end());
  if (n > 4 && (-turns[4].first > kCornerFrom || -turns[3].first < kCornerFrom)) return {};
  std::vector<size_t> corners;
  for (size_t k = 0; k < 4; ++k) corners.push_back(turns[k].second);
  std::sort(corners.begin(), corners.end());
  return corners;
}

std::vector<size_t> sides_between(const std::vector<size_t>& corners, size_t n_sides, size_t c) {
  std::vector<size_t> sides;
  for (size_t k = corners[c]; k != corners[(c + 1) % 4]; k = (k + 1) % n_sides) sides.push_back(k);
  return sides;
}

double polyline_length(const Points& points) {
  double length = 0;
  for (Index j = 0; j + 1 < points.rows(); ++j) length += (points.row(j + 1) - points.row(j)).norm();
  return length;
}

std::vector<int> parts_of_edges(size_t n_edges, const std::vector<const FaceSides*>& faces) {
  return Planner(n_edges, faces).run();
}

}  // namespace batten::detail
