#include "batten/core/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "batten/core/random.hpp"

namespace batten {
namespace {

using Values = std::vector<double>;

double median_of(Values values) {
  return median(values);
}
double upper_median_of(Values values) {
  return upper_median(values);
}
double percentile_of(Values values, double share) {
  return percentile(values, share);
}

TEST(Median, IsTheMiddleOrTheMeanOfBothMiddleValues) {
  EXPECT_EQ(median_of({}), 0);
  EXPECT_EQ(median_of({7}), 7);
  EXPECT_EQ(median_of({3, 1, 2}), 2);
  EXPECT_EQ(median_of({4, 1, 3, 2}), 2.5);
  EXPECT_EQ(median_of({1, 1, 5, 5}), 3);
}

TEST(UpperMedian, IsTheLargerOfBothMiddleValues) {
  EXPECT_EQ(upper_median_of({}), 0);
  EXPECT_EQ(upper_median_of({7}), 7);
  EXPECT_EQ(upper_median_of({3, 1, 2}), 2);
  EXPECT_EQ(upper_median_of({4, 1, 3, 2}), 3);
}

TEST(Percentile, TakesTheRankBelowTheShare) {
  EXPECT_EQ(percentile_of({}, 0.5), 0);
  Values values;
  for (int i = 100; i >= 0; --i) values.push_back(i);
  EXPECT_EQ(percentile(values, 0), 0);
  EXPECT_EQ(percentile(values, 1), 100);
  EXPECT_EQ(percentile(values, 0.25), 25);
  EXPECT_EQ(percentile(values, 0.259), 25);
}

TEST(OrderStatistics, AgreeWithSortingWhateverTheOrder) {
  Random random(5);
  for (const int n : {1, 2, 9, 100, 1001}) {
    Values sorted;
    for (int i = 0; i < n; ++i) sorted.push_back(std::round(10 * random.normal()));  // with equal ones
    Values mixed = sorted;
    std::sort(sorted.begin(), sorted.end());
    for (int rank = 0; rank < n; rank += 1 + n / 7) EXPECT_EQ(order_statistic(mixed, rank), sorted[rank]);
    EXPECT_EQ(median(mixed), 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]));
    Values negated = mixed;
    for (double& value : negated) value = -value;
    EXPECT_EQ(median(negated), -median(mixed));
  }
}

// The standard error of the estimate is 1.17 σ / √n: 0.6 % at 40,000 values. Wild values make up a tenth,
// which moves the median of a normal distribution's absolute values by at most a factor Φ⁻¹(0.778) /
// Φ⁻¹(0.75) = 1.13.
TEST(DeviationByMedian, IsThatOfANormalDistributionAndBarelyMindsWildValues) {
  Random random(3);
  Values values;
  for (int i = 0; i < 40000; ++i) values.push_back(5 + 2 * random.normal());
  Values copy = values;
  EXPECT_NEAR(deviation_by_median(copy, 5), 2, 4 * 0.006 * 2);
  for (int i = 0; i < 4000; ++i) values[10 * i] = 1e9;
  EXPECT_LT(deviation_by_median(values, 5), 2 * 1.16);
}

}  // namespace
}  // namespace batten
