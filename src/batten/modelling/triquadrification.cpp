// Based on H 6.1; the search over all divisions is that of minimum-weight triangulation [klincsek1980] with
// quads as further parts.
#include "batten/modelling/triquadrification.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/units.hpp"
#include "batten/modelling/coons.hpp"
#include "batten/modelling/split_outline_detail.hpp"

namespace batten {

namespace {

using detail::SplitOutline;
using Eigen::Index;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kMostSides = 40;         ///< for dynamic programming: a tenth of a second
constexpr int kPointsOfDiagonal = 32;  ///< segments of its polyline

bool is_less(const SplitCost& a, const SplitCost& b) {
  return a.flaws != b.flaws ? a.flaws < b.flaws : a.angle() < b.angle() - 1e-9;
}

SplitCost cost_with_diagonals(const SplitOutline& face, const std::vector<std::vector<int>>& parts) {
  SplitCost total;
  for (const std::vector<int>& part : parts) {
    const auto size = static_cast<int>(part.size());
    total = total + face.cost_of_part(part.data(), size);
    // Each diagonal belongs to two parts and is counted where it runs from its lower corner.
    for (int k = 0; k < size; ++k) {
      const int i = part[at(k)], j = part[at((k + 1) % size)];
      if (i < j) total.flaws += face.flaws_of_diagonal(i, j);
    }
  }
  return total;
}

/// Cuts quads off until `enough` corners are left. @return those.
std::vector<int> cut_off_quads(const SplitOutline& face, const FacePatch& quad, int enough,
                               std::vector<std::vector<int>>& parts) {
  std::vector<int> left(at(face.n()));
  for (int k = 0; k < face.n(); ++k) left[at(k)] = k;
  while (static_cast<int>(left.size()) > enough) {
    const auto n = static_cast<int>(left.size());
    SplitCost best;
    int best_start = -1;
    for (int start = 0; start < n; ++start) {
      std::array<int, 4> part{};
      for (int k = 0; k < 4; ++k) part[at(k)] = left[at((start + k) % n)];
      // Not four corners of one edge of the quad (H 6.1.1): the part would have no area in its parameters.
      if (quad.on_one_side(part[0], part[1]) && quad.on_one_side(part[0], part[2]) &&
          quad.on_one_side(part[0], part[3]))
        continue;
      SplitCost cost = face.cost_of_part(part.data(), 4);
      cost.flaws += face.flaws_of_diagonal(part[0], part[3]);
      if (best_start < 0 || is_less(cost, best)) {
        best = cost;
        best_start = start;
      }
    }
    if (best_start < 0) break;
    std::vector<int> part(4);
    for (int k = 0; k < 4; ++k) part[at(k)] = left[at((best_start + k) % n)];
    std::vector<int> rest;
    for (int k = 3; k <= n; ++k) rest.push_back(left[at((best_start + k) % n)]);
    parts.push_back(std::move(part));
    left = std::move(rest);
  }
  return left;
}

/// Dynamic programming over a polygon of corners of a face: the part at the diagonal from the first to the
/// last corner of a range leaves two or three smaller ranges.
class OptimalSplit {
 public:
  OptimalSplit(const SplitOutline& face, const std::vector<int>& corners)
      : face_(face),
        corners_(corners),
        n_(static_cast<int>(corners.size())),
        cost_(at(n_) * at(n_)),
        choice_(at(n_) * at(n_), {-1, -1}) {
    for (int span = 2; span < n_; ++span)
      for (int i = 0; i + span < n_; ++i) find(i, i + span);
  }

  void collect(std::vector<std::vector<int>>& parts) const { collect(0, n_ - 1, parts); }

 private:
  size_t entry(int i, int j) const { return at(i) * at(n_) + at(j); }

  void find(int i, int j) {
    SplitCost best;
    bool found = false;
    const auto consider = [&](std::initializer_list<int> part, int k, int l) {
      std::array<int, 4> corner{};
      std::transform(part.begin(), part.end(), corner.begin(), [&](int c) { return corners_[at(c)]; });
      SplitCost cost = cost_[entry(i, k)] + cost_[entry(l < 0 ? k : l, j)];
      if (l >= 0) cost = cost + cost_[entry(k, l)];
      // Whatever the part itself costs is not below zero.
      if (found && !is_less(cost, best)) return;
      cost = cost + face_.cost_of_part(corner.data(), static_cast<int>(part.size()));
      if (found && !is_less(cost, best)) return;
      best = cost;
      found = true;
      choice_[entry(i, j)] = {k, l};
    };
    // Quads first: of equal divisions the one with fewer parts.
    for (int k = i + 1; k < j; ++k)
      for (int l = k + 1; l < j; ++l) consider({i, k, l, j}, k, l);
    for (int k = i + 1; k < j; ++k) consider({i, k, j}, k, -1);
    best.flaws += face_.flaws_of_diagonal(corners_[at(i)], corners_[at(j)]);
    cost_[entry(i, j)] = best;
  }

  void collect(int i, int j, std::vector<std::vector<int>>& parts) const {
    if (j - i < 2) return;
    const auto [k, l] = choice_[entry(i, j)];
    std::vector<int> part{corners_[at(i)], corners_[at(k)]};
    if (l >= 0) part.push_back(corners_[at(l)]);
    part.push_back(corners_[at(j)]);
    parts.push_back(std::move(part));
    collect(i, k, parts);
    if (l >= 0) collect(k, l, parts);
    collect(l >= 0 ? l : k, j, parts);
  }

  const SplitOutline& face_;
  const std::vector<int>& corners_;
  int n_;
  std::vector<SplitCost> cost_;
  std::vector<std::pair<int, int>> choice_;
};

}  // namespace

FaceSplit split_face(const std::vector<SharedPolyline>& sides, SplitSearch search) {
  if (sides.size() < 3) throw InvalidInput("a face needs three sides or more to be divided");
  const SplitOutline face(sides);
  FaceSplit split;
  const int enough = search == SplitSearch::Greedy ? 4 : kMostSides;
  std::vector<int> left;
  if (face.n() > enough) {
    left = cut_off_quads(face, associate_quad(sides), enough, split.parts);
  } else {
    left.resize(sides.size());
    for (int k = 0; k < face.n(); ++k) left[at(k)] = k;
  }
  if (left.size() == 3 || (search == SplitSearch::Greedy && left.size() == 4))
    split.parts.push_back(left);
  else
    OptimalSplit(face, left).collect(split.parts);
  split.cost = cost_with_diagonals(face, split.parts);
  return split;
}

SplitCost cost_of_split(const std::vector<SharedPolyline>& sides,
                        const std::vector<std::vector<int>>& parts) {
  return cost_with_diagonals(SplitOutline(sides), parts);
}

FaceDiagonals diagonals_of_split(const std::vector<SharedPolyline>& sides, const FaceSplit& split) {
  FaceDiagonals result;
  std::vector<Diagonal>& diagonals = result.diagonals;
  const auto n = static_cast<int>(sides.size());
  for (const std::vector<int>& part : split.parts)
    for (size_t k = 0; k < part.size(); ++k) {
      const int i = part[k], j = part[(k + 1) % part.size()];
      if (i < j && j != i + 1 && !(i == 0 && j == n - 1)) diagonals.push_back({i, j, nullptr});
    }
  if (diagonals.empty()) return result;
  const SplitOutline face(sides);
  FacePatch quad = associate_quad(sides);
  const auto straight = [&](const Diagonal& diagonal) {
    Points line(2, 3);
    line << face.corner(diagonal.from).transpose(), face.corner(diagonal.to).transpose();
    return line;
  };
  std::vector<Points> curves;
  // The patch maps a straight side of its square onto a side with a reflex corner: it may stay within the
  // face and still be far from what its outline suggests.
  bool any_along_border = false;
  bool is_good = !face.is_simple() || !face.has_reflex_corner();
  for (const Diagonal& diagonal : diagonals) {
    const bool along_border = quad.on_one_side(diagonal.from, diagonal.to);
    any_along_border = any_along_border || along_border;
    curves.push_back(along_border ? straight(diagonal)  // of H 6.4.2
                                  : quad.patch.along(quad.parameters[at(diagonal.from)],
                                                     quad.parameters[at(diagonal.to)], kPointsOfDiagonal));
    if (face.is_simple() && (along_border || face.leaves(curves.back()))) is_good = false;
  }
  if (!is_good)
    for (size_t d = 0; d < diagonals.size(); ++d)
      curves[d] = face.lifted(face.flat(face.corner(diagonals[d].from)),
                              face.flat(face.corner(diagonals[d].to)), kPointsOfDiagonal);
  else if (!any_along_border)
    result.patch = std::move(quad);
  for (size_t d = 0; d < diagonals.size(); ++d) {
    curves[d].row(0) = face.corner(diagonals[d].from).transpose();
    curves[d].row(curves[d].rows() - 1) = face.corner(diagonals[d].to).transpose();
    diagonals[d].polyline = std::make_shared<Polyline>(std::move(curves[d]));
  }
  return result;
}

}  // namespace batten
