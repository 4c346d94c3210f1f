#pragma once
#include <cstdint>

#include <Eigen/Core>

namespace batten {

/// Seeded random numbers that are the same on every platform (xoshiro256**; std's distributions are not).
class Random {
 public:
  /// The same seed gives the same numbers.
  explicit Random(std::uint64_t seed);
  /// An independent stream: what one consumer draws does not shift the numbers of another.
  Random(std::uint64_t seed, std::uint64_t stream);

  /// 64 random bits.
  std::uint64_t bits();
  /// Uniform in [0, 1).
  double uniform();
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Uniform integer in 0 … n − 1; n at least 1.
  std::uint64_t below(std::uint64_t n);
  /// Standard normal.
  double normal();
  Eigen::Vector3d normal3() {
    const double x = normal(), y = normal(), z = normal();
    return {x, y, z};
  }
  /// Uniform on the unit sphere.
  Eigen::Vector3d direction();

 private:
  std::uint64_t state_[4];
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace batten
