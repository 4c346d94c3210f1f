#include <cmath>
#include <vector>

#include "batten/core/index.hpp"
#include "batten/core/units.hpp"
#include "batten/implicit/held_values_detail.hpp"
#include "batten/implicit/stroke_field.hpp"

namespace batten {

namespace {

// Where the field is held to the distance from the hull of the strokes, in diameters.
constexpr int kOuterGrid = 16;
constexpr double kOuterMargin = 0.15, kOuterNear = 0.03, kOuterFar = 0.15;
constexpr double kBulge = 0.35, kOuterLeast = 0.01;
constexpr double kKeptOutside = 0.5;
constexpr int kMostOuter = 400;
constexpr double kHeldSmoothing = 1e-2;
constexpr int kHullDirections = 400;

/// Directions spread over the sphere along a spiral.
Points sphere_directions(int n) {
  const double golden = kPi * (3 - std::sqrt(5.0));
  Points directions(n, 3);
  for (int k = 0; k < n; ++k) {
    const double z = 1 - (2 * k + 1.0) / n, r = std::sqrt(1 - z * z);
    directions.row(k) << r * std::cos(golden * k), r * std::sin(golden * k), z;
  }
  return directions;
}

}  // namespace

Points rows_of(const Points& points, const std::vector<int>& rows) {
  Points chosen(static_cast<Eigen::Index>(rows.size()), 3);
  for (std::size_t k = 0; k < rows.size(); ++k)
    chosen.row(static_cast<Eigen::Index>(k)) = points.row(rows[k]);
  return chosen;
}

/// A surface bulges out of the hull of its strokes, by less the nearer they are: a point is outside by its
/// distance from the hull (taken as the body of many sides) less a share of its distance from the strokes.
HeldValues points_outside(const Points& samples) {
  const Points directions = sphere_directions(kHullDirections);
  Eigen::VectorXd support(directions.rows());
  std::vector<Eigen::RowVector3d>
      kept;  // first those beyond the corners of the hull, where a field swells most
  for (Eigen::Index k = 0; k < directions.rows(); ++k) {
    Eigen::Index corner = 0;
    support[k] = (samples * directions.row(k).transpose()).maxCoeff(&corner);
    kept.emplace_back(samples.row(corner) + kOuterNear * directions.row(k));
  }
  const Eigen::RowVector3d low = samples.colwise().minCoeff().array() - kOuterMargin;
  const Eigen::RowVector3d high = samples.colwise().maxCoeff().array() + kOuterMargin;
  for (int i = 0; i <= kOuterGrid; ++i)
    for (int j = 0; j <= kOuterGrid; ++j)
      for (int k = 0; k <= kOuterGrid; ++k) {
        const Eigen::RowVector3d part(i, j, k);
        const Eigen::RowVector3d q = low + part.cwiseProduct(high - low) / kOuterGrid;
        const double hull = (directions * q.transpose() - support).maxCoeff();
        if (hull > kOuterNear && hull < kOuterFar) kept.push_back(q);
      }
  Points grid(0, 3);
  std::vector<double> distance;
  for (const Eigen::RowVector3d& q : kept) {
    const double hull = (directions * q.transpose() - support).maxCoeff();
    const double strokes = std::sqrt((samples.rowwise() - q).rowwise().squaredNorm().minCoeff());
    if (hull - kBulge * strokes < kOuterLeast) continue;
    grid.conservativeResize(grid.rows() + 1, 3);
    grid.bottomRows<1>() = q;
    distance.push_back(hull - kBulge * strokes);
  }
  const std::vector<int> chosen = farthest_points(grid, kMostOuter, kOuterLeast);
  HeldValues outside;
  outside.points = rows_of(grid, chosen);
  outside.values.resize(outside.points.rows());
  for (std::size_t k = 0; k < chosen.size(); ++k)
    outside.values[static_cast<Eigen::Index>(k)] = distance[at(chosen[k])];
  outside.smoothing = Eigen::VectorXd::Constant(outside.size(), kHeldSmoothing);
  return outside;
}

bool add_not_outside(const HeldValues& outside, const HermiteField& field, std::set<int>& rows) {
  const std::size_t before = rows.size();
  for (Eigen::Index k = 0; k < outside.points.rows(); ++k)
    if (field.value(outside.points.row(k).transpose()) < kKeptOutside * outside.values[k])
      rows.insert(static_cast<int>(k));
  return rows.size() > before;
}

HeldValues HeldValues::part(const std::set<int>& rows) const {
  const std::vector<int> chosen(rows.begin(), rows.end());
  HeldValues part;
  part.points = rows_of(points, chosen);
  part.values = values(chosen);
  part.smoothing = smoothing(chosen);
  return part;
}

void HeldValues::append(const HeldValues& more) {
  points.conservativeResize(points.rows() + more.size(), 3);
  points.bottomRows(more.size()) = more.points;
  values.conservativeResize(points.rows());
  values.tail(more.size()) = more.values;
  smoothing.conservativeResize(points.rows());
  smoothing.tail(more.size()) = more.smoothing;
}

FieldConditions with_held(const FieldConditions& on_strokes, const HeldValues& held) {
  FieldConditions all = on_strokes;
  const Eigen::Index n = on_strokes.sites.rows(), more = held.size();
  all.sites.conservativeResize(n + more, 3);
  all.sites.bottomRows(more) = held.points;
  all.values.conservativeResize(n + more);
  all.values.tail(more) = held.values;
  all.smoothing.conservativeResize(n + more);
  all.smoothing.tail(more) = held.smoothing;
  return all;
}

}  // namespace batten
