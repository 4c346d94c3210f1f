#include <limits>

#include <gtest/gtest.h>

#include "batten/render/colour_scale_detail.hpp"

namespace batten {
namespace {

using detail::ColourScale;

TEST(ColourScale, OfErrorsEndsWhereOneInAHundredIsLarger) {
  Eigen::VectorXd errors(1001);
  for (int i = 0; i <= 1000; ++i) errors[i] = i;
  const ColourScale scale = detail::error_scale(errors, "mm", 0);
  EXPECT_EQ(scale.low, 0);
  EXPECT_EQ(scale.high, 990);
  EXPECT_EQ(scale.title, "mm");
  EXPECT_EQ(scale.note, "max 1e+03");
  EXPECT_EQ(detail::error_scale(errors, "mm", 5).high, 5);
}

TEST(ColourScale, OfCurvaturesIsEvenAboutZero) {
  const Eigen::VectorXd values = Eigen::VectorXd::LinSpaced(101, -100, 0);
  const ColourScale scale = detail::curvature_scale(values, "H", 0);
  EXPECT_EQ(scale.high, 97);
  EXPECT_EQ(scale.low, -97);
  EXPECT_TRUE(scale.diverging);
}

TEST(ColourScale, ValuesThatAreNotFiniteAreGreyAndDoNotCount) {
  Eigen::VectorXd errors(3);
  errors << 1, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity();
  const ColourScale scale = detail::error_scale(errors, "mm", 0);
  EXPECT_EQ(scale.high, 1);
  EXPECT_EQ(scale.colour(errors[1]), detail::kGrey);
  EXPECT_EQ(detail::ColourTable(scale)(errors[2]), detail::kGrey);
  EXPECT_EQ(detail::error_scale(Eigen::VectorXd(), "mm", 0).high, 1);
}

TEST(ColourTable, AgreesWithItsScale) {
  const ColourScale scale = detail::curvature_scale(Eigen::VectorXd::LinSpaced(50, -2, 3), "H", 0);
  const detail::ColourTable table(scale);
  for (const double value : {-9.0, -2.9, -1.0, 0.0, 0.7, 2.9, 9.0})
    EXPECT_LT((table(value) - scale.colour(std::clamp(value, scale.low, scale.high))).cwiseAbs().maxCoeff(),
              0.01F)
        << value;
}

TEST(Ticks, AreRoundNumbersWithinTheScale) {
  EXPECT_EQ(detail::ticks(0, 1), (std::vector<double>{0, 0.2, 0.4, 0.6000000000000001, 0.8, 1}));
  EXPECT_EQ(detail::ticks(-12, 12), (std::vector<double>{-10, -5, 0, 5, 10}));
}

}  // namespace
}  // namespace batten
