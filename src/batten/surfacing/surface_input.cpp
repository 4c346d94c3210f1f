#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/surfacing/surface_input_detail.hpp"

namespace batten {

std::optional<std::string> SurfaceOptions::problem() const {
  if (base_order < 1 || base_order > 3) return concat("base_order must be 1, 2 or 3, got ", base_order);
  if (rebuilds < -1 || rebuilds > 20)
    return concat("rebuilds must be -1 (automatic) or 0 to 20, got ", rebuilds);
  if (!(soft_weight > 0) || !std::isfinite(soft_weight))
    return concat("soft_weight must be positive, got ", soft_weight);
  if (!(edge_length >= 0) || !std::isfinite(edge_length))
    return concat("edge_length must be >= 0, got ", edge_length);
  if (!(max_triangles > 0)) return concat("max_triangles must be positive, got ", max_triangles);
  return std::nullopt;
}

std::optional<std::string> SurfaceMoveOptions::problem() const {
  if (reach != SurfaceReach::Touched && reach != SurfaceReach::All)
    return concat("reach must be Touched or All, got number ", static_cast<int>(reach));
  return std::nullopt;
}

}  // namespace batten

namespace batten::detail {

using Eigen::Index;
using Eigen::RowVector3d;

void check_cycles(const std::vector<NetworkCycle>& cycles, const CurveNetwork& network) {
  if (cycles.empty()) throw InvalidInput("there is no cycle to fill");
  for (std::size_t c = 0; c < cycles.size(); ++c)
    for (const NetworkCycle::Loop& loop : cycles[c].loops)
      for (const int v : loop.vertices)
        if (v < 0 || v >= network.positions.rows())
          throw InvalidInput(concat("cycle ", c, " names vertex ", v,
                                    ", but the network has the vertices 0 to ",
                                    network.positions.rows() - 1));
}

void check_surface_input(const CurveNetwork& network, const SurfaceOptions& options) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  if (network.curves.empty()) throw InvalidInput("the network has no curves; there is nothing to surface");
  if (!network.has_normals())
    throw InvalidInput(
        "the network has no normals, which the surface is built from; give one unit normal per vertex");
  network_topology(network);  // indices in range, curves long enough
  for (std::size_t c = 0; c < network.curves.size(); ++c)
    for (const int v : network.curves[c].vertices)
      if (!network.positions.row(v).allFinite() || !network.normals.row(v).allFinite())
        throw InvalidInput(concat("vertex ", v, " of ", curve_name(network, static_cast<int>(c)),
                                  " has a coordinate that is not a number; repair or remove it"));
}

ScaledNetwork scaled_network(const CurveNetwork& network) {
  RowVector3d low = RowVector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const NetworkCurve& curve : network.curves)
    for (const int v : curve.vertices) {
      low = low.cwiseMin(network.positions.row(v));
      high = high.cwiseMax(network.positions.row(v));
    }
  ScaledNetwork result;
  result.diameter = (high - low).norm();
  if (!(result.diameter > 0) || !std::isfinite(result.diameter))
    throw InvalidInput("the network has no extent; all its vertices lie at one place");
  result.centre = 0.5 * (low + high);
  rescale_network(network, result);
  return result;
}

void rescale_network(const CurveNetwork& network, ScaledNetwork& scaled) {
  scaled.positions = (network.positions.rowwise() - scaled.centre) / scaled.diameter;
  scaled.normals = network.normals;
  for (Index v = 0; v < scaled.normals.rows(); ++v)
    if (scaled.normals.row(v).norm() > 0) scaled.normals.row(v).normalize();
}

int calm_crowded_normals(const CurveNetwork& network, ScaledNetwork& s) {
  constexpr double kCrowded = 0.3;
  std::vector<int> degree(network.positions.rows(), 0);
  for (const NetworkCurve& curve : network.curves)
    for (std::size_t i = 0; i + 1 < curve.vertices.size(); ++i) {
      ++degree[curve.vertices[i]];
      ++degree[curve.vertices[i + 1]];
    }
  int changed = 0;
  for (const NetworkCurve& curve : network.curves) {
    const std::size_t n = curve.vertices.size();
    std::vector<double> along(n, 0);
    for (std::size_t i = 1; i < n; ++i)
      along[i] =
          along[i - 1] + (s.positions.row(curve.vertices[i]) - s.positions.row(curve.vertices[i - 1])).norm();
    const double gap = kCrowded * along.back() / static_cast<double>(n - 1);
    std::vector<std::size_t> kept = {0};
    for (std::size_t i = 1; i < n; ++i) {
      const bool node = degree[curve.vertices[i]] != 2 || i + 1 == n;
      // A sample just before a node gives way to the node.
      while (node && kept.size() > 1 && along[i] - along[kept.back()] < gap &&
             degree[curve.vertices[kept.back()]] == 2)
        kept.pop_back();
      if (node || along[i] - along[kept.back()] >= gap) kept.push_back(i);
    }
    for (std::size_t k = 0; k + 1 < kept.size(); ++k)
      for (std::size_t i = kept[k] + 1; i < kept[k + 1]; ++i) {
        const double t = (along[i] - along[kept[k]]) / (along[kept[k + 1]] - along[kept[k]]);
        const RowVector3d mean =
            (1 - t) * s.normals.row(curve.vertices[kept[k]]) + t * s.normals.row(curve.vertices[kept[k + 1]]);
        if (mean.norm() < 1e-9) continue;
        s.normals.row(curve.vertices[i]) = mean.normalized();
        ++changed;
      }
  }
  return changed;
}

void check_coincident(const CurveNetwork& network, const ScaledNetwork& s,
                      const std::vector<NetworkCycle>& given) {
  struct Place {
    std::array<std::int64_t, 3> cell;
    int vertex, curve;
    bool operator<(const Place& o) const { return std::tie(cell, vertex) < std::tie(o.cell, o.vertex); }
  };
  std::vector<Place> places;
  std::vector<char> seen(network.positions.rows(), 0);
  for (std::size_t c = 0; c < network.curves.size(); ++c)
    for (const int v : network.curves[c].vertices) {
      if (seen[v]) continue;
      seen[v] = 1;
      Place place{{}, v, static_cast<int>(c)};
      for (int k = 0; k < 3; ++k) place.cell[k] = std::llround(s.positions(v, k) / 0.7548776662466927e-9);
      places.push_back(place);
    }
  std::sort(places.begin(), places.end());
  std::vector<std::vector<std::size_t>> cycles_of(given.empty() ? 0 : seen.size());
  for (std::size_t c = 0; c < given.size(); ++c)
    for (const NetworkCycle::Loop& loop : given[c].loops)
      for (const int v : loop.vertices)
        if (cycles_of[v].empty() || cycles_of[v].back() != c) cycles_of[v].push_back(c);
  const auto share_a_cycle = [&](int a, int b) {
    for (const std::size_t c : cycles_of[a])
      if (std::binary_search(cycles_of[b].begin(), cycles_of[b].end(), c)) return true;
    return false;
  };
  for (std::size_t i = 1; i < places.size(); ++i)
    for (std::size_t j = i; j-- > 0 && places[j].cell == places[i].cell;)
      if (given.empty() || share_a_cycle(places[j].vertex, places[i].vertex))
        throw InvalidInput(
            concat("the vertices ", places[j].vertex, " of ", curve_name(network, places[j].curve), " and ",
                   places[i].vertex, " of ", curve_name(network, places[i].curve),
                   " lie at the same place; merge them into one vertex so that the curves are joined"));
}

Eigen::VectorXd soft_weights(const CurveNetwork& network, const ScaledNetwork& scaled, Eigen::Index n,
                             double unit) {
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(n);
  for (const NetworkCurve& curve : network.curves)
    for (std::size_t i = 0; i + 1 < curve.vertices.size(); ++i) {
      const int a = curve.vertices[i], b = curve.vertices[i + 1];
      const double length = (scaled.positions.row(a) - scaled.positions.row(b)).norm();
      weights[a] += 0.5 * length * unit;
      weights[b] += 0.5 * length * unit;
    }
  for (Eigen::Index v = 0; v < network.positions.rows(); ++v)
    if (weights[v] == 0) weights[v] = 1;
  return weights;
}

}  // namespace batten::detail
