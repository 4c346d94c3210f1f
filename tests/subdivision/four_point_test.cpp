#include <vector>

#include <gtest/gtest.h>

#include "batten/subdivision/four_point_detail.hpp"

namespace batten::detail {
namespace {

using Row = Eigen::RowVector3d;

/// A cubic curve over knots at uneven distances, two further ones on each side of the middle piece.
constexpr double kKnots[] = {-3.5, -1, 0, 1.5, 2, 4.5};

Row polynomial(double t, int degree) {
  Row sum(1, -2, 0.5);
  double power = 1;
  for (int k = 1; k <= degree; ++k) {
    power *= t;
    sum += power * Row(0.3 * k, 1 - k, 0.7);
  }
  return sum;
}

/// The rule where so many points lie beyond each end.
Row middle(int degree, int n_before, int n_after) {
  return four_point(polynomial(kKnots[2], degree), polynomial(kKnots[3], degree), kKnots[3] - kKnots[2],
                    [&](int side, int k) -> FurtherPoint {
                      if (k >= (side == 0 ? n_before : n_after)) return {};
                      const int i = side == 0 ? 1 - k : 4 + k;
                      const double interval =
                          side == 0 ? kKnots[i + 1] - kKnots[i] : kKnots[i] - kKnots[i - 1];
                      return {true, polynomial(kKnots[i], degree), interval};
                    });
}

// Four points give a cubic, wherever they lie; three a parabola and two a line.
TEST(FourPoint, ReproducesWhatItsPointsDetermine) {
  struct Case {
    int before, after, degree;
  };
  for (const auto& [before, after, degree] :
       std::vector<Case>{{2, 2, 3}, {1, 1, 3}, {2, 0, 3}, {0, 2, 3}, {1, 0, 2}, {0, 1, 2}, {0, 0, 1}}) {
    EXPECT_LT((middle(degree, before, after) - polynomial(0.75, degree)).norm(), 1e-13)
        << before << ' ' << after;
    EXPECT_GT((middle(degree + 1, before, after) - polynomial(0.75, degree + 1)).norm(), 1e-3);
  }
}

// The classical weights −1, 9, 9, −1 over 16 [dyn1987].
TEST(FourPoint, HasTheClassicalWeightsOnEvenKnots) {
  const double knots[] = {0, 1, -1, 2};
  const double expected[] = {9.0 / 16, 9.0 / 16, -1.0 / 16, -1.0 / 16};
  for (int i = 0; i < 4; ++i) {
    Row points[4] = {Row::Zero(), Row::Zero(), Row::Zero(), Row::Zero()};
    points[i].x() = 1;
    EXPECT_NEAR(interpolated(knots, points, 4, 0.5).x(), expected[i], 1e-15);
  }
}

}  // namespace
}  // namespace batten::detail
