#include "batten/subdivision/four_point_detail.hpp"

namespace batten::detail {

Eigen::RowVector3d interpolated(const double* knots, const Eigen::RowVector3d* points, int n, double t) {
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  for (int i = 0; i < n; ++i) {
    double weight = 1;
    for (int j = 0; j < n; ++j)
      if (j != i) weight *= (t - knots[j]) / (knots[i] - knots[j]);
    sum += weight * points[i];
  }
  return sum;
}

}  // namespace batten::detail
