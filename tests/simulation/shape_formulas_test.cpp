#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/simulation/shape_formulas_detail.hpp"

namespace batten::detail {
namespace {

using Eigen::Vector3d;

// Central differences are off by the third derivative times h² / 6.
TEST(ShapeFormulas, GradientsAreThoseOfTheFunctions) {
  Random random(3);
  for (const std::string& word : choice_words<AnalyticShape>()) {
    const ImplicitFunction surface = shape_function(parse_choice<AnalyticShape>(word));
    for (int i = 0; i < 50; ++i) {
      const Vector3d x(random.uniform(0.2, 1), random.uniform(-1, 1), random.uniform(-1, 1));
      Vector3d gradient, scratch;
      surface(x, gradient);
      for (int k = 0; k < 3; ++k) {
        const Vector3d step = 1e-5 * Vector3d::Unit(k);
        EXPECT_NEAR(gradient[k], (surface(x + step, scratch) - surface(x - step, scratch)) / 2e-5, 1e-8)
            << word;
      }
    }
  }
}

TEST(ShapeFormulas, TheBumpyCubeIsMetInEveryDirection) {
  Random random(4);
  for (int i = 0; i < 200; ++i) {
    const Vector3d direction =
        Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)).normalized();
    const Vector3d point = on_bumpy_cube(direction);
    Vector3d gradient;
    EXPECT_LT(std::abs(bumpy_cube(point, gradient)), 1e-14);
    EXPECT_LT((point.normalized() - direction).norm(), 1e-14);
    EXPECT_GT(gradient.dot(direction), 0);  // star-shaped
  }
}

}  // namespace
}  // namespace batten::detail
