#include "batten/mesh/spatial_order.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace batten {

namespace {

/// Bits of x spread to every third place: the building block of the Morton code.
std::uint64_t spread_bits(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffffULL;
  x = (x | x << 16) & 0x1f0000ff0000ffULL;
  x = (x | x << 8) & 0x100f00f00f00f00fULL;
  x = (x | x << 4) & 0x10c30c30c30c30c3ULL;
  return (x | x << 2) & 0x1249249249249249ULL;
}

}  // namespace

std::vector<int> spatial_order(const Points& points) {
  if (points.rows() == 0) return {};
  const Eigen::RowVector3d low = points.colwise().minCoeff();
  const double extent = (points.colwise().maxCoeff() - low).maxCoeff();
  const double scale = extent > 0 ? 1023 / extent : 0;
  std::vector<std::pair<std::uint64_t, int>> keys(points.rows());
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    std::uint64_t key = 0;
    for (int k = 0; k < 3; ++k)
      key |= spread_bits(static_cast<std::uint64_t>((points(i, k) - low[k]) * scale)) << k;
    keys[i] = {key, static_cast<int>(i)};
  }
  std::sort(keys.begin(), keys.end());
  std::vector<int> order(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) order[i] = keys[i].second;
  return order;
}

}  // namespace batten
