#include <vector>

#include <gtest/gtest.h>

#include "batten/modelling/face_splitter_detail.hpp"

namespace batten {
namespace {

using detail::FaceSplitter;
using detail::PlanePoints;
using Eigen::Vector2d;

/// Straight sides of m segments between corners.
PlanePoints boundary(const std::vector<Vector2d>& corners, int m) {
  PlanePoints points(static_cast<Eigen::Index>(corners.size()) * m, 2);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const auto k = static_cast<size_t>(i / m);
    const double t = static_cast<double>(i % m) / m;
    points.row(i) = (1 - t) * corners[k] + t * corners[(k + 1) % corners.size()];
  }
  return points;
}

double doubled_area(const detail::FaceSplit& split) {
  double sum = 0;
  for (const std::array<int, 4>& q : split.quads) {
    const Vector2d a = split.domain.row(q[2]) - split.domain.row(q[0]),
                   b = split.domain.row(q[3]) - split.domain.row(q[1]);
    sum += a.x() * b.y() - a.y() * b.x();
  }
  return sum;
}

const std::vector<Vector2d> kUnitSquare{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
const std::vector<Vector2d> kLetter{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};  // an L

// m² equal squares, each cut into two triangles with a right angle, whose quality is 4 √3 A / Σ l² = √3 / 2.
TEST(FaceSplitter, ASquareBecomesEqualSquares) {
  FaceSplitter splitter(4, 4, boundary(kUnitSquare, 4));
  for (const detail::FaceSplit& split : {splitter.run(detail::kWhole), splitter.run_grid({0, 1, 2, 3})}) {
    EXPECT_EQ(split.quads.size(), 16U);
    EXPECT_EQ(split.domain.rows(), 25);
    EXPECT_EQ(split.n_boundary, 16);
    EXPECT_NEAR(doubled_area(split), 2, 1e-12);
    EXPECT_NEAR(splitter.shape(), std::sqrt(3.0) / 2, 1e-12);
    EXPECT_TRUE(splitter.is_valid());
  }
}

// The concave corner, 270°, is cut off into two pieces; kept whole, the face is one, of as much area.
TEST(FaceSplitter, ConcaveCornersAreCutOffWhereWanted) {
  FaceSplitter splitter(6, 4, boundary(kLetter, 4));
  const detail::FaceSplit cut = splitter.run(detail::kReflexFrom);
  EXPECT_EQ(cut.n_pieces, 2);
  ASSERT_EQ(cut.cuts.size(), 1U);
  EXPECT_EQ(cut.cuts[0][0], 3 * 4) << "from the corner (1, 1)";
  EXPECT_NEAR(doubled_area(cut), 6, 1e-12);
  EXPECT_TRUE(splitter.is_valid());
  const detail::FaceSplit whole = splitter.run(detail::kWhole);
  EXPECT_EQ(whole.n_pieces, 1);
  EXPECT_TRUE(whole.cuts.empty());
  EXPECT_NEAR(doubled_area(whole), 6, 1e-12);
}

// The foot of a T: the sides of its bays, drawn on, end at a third and two thirds of the side opposite, which
// therefore has three parts.
TEST(FaceSplitter, SidesAreDividedWhereTheSidesOfABayEnd) {
  const std::vector<Vector2d> tee{{0, 0}, {3, 0}, {3, 1}, {2, 1}, {2, 3}, {1, 3}, {1, 1}, {0, 1}};
  FaceSplitter splitter(8, 4, boundary(tee, 4));
  EXPECT_EQ(splitter.parts_at_concave_corners()[0], 3);
}

}  // namespace
}  // namespace batten
