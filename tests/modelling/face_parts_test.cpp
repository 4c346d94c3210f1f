#include "sketch/straight_sides.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/modelling/face_parts_detail.hpp"
#include "batten/modelling/face_split_detail.hpp"

namespace batten::detail {
namespace {

using Eigen::Vector3d;
using test::straight_sides;

/// A face with straight sides; @param edges of the model, per side.
FaceSides face(const std::vector<Vector3d>& corners, const std::vector<int>& edges) {
  const std::vector<Points> sides = straight_sides(corners, 8);
  FaceSides face{edges, {}, corners_of_quadrilateral(sides), parts_at_concave_corners(sides)};
  for (const Points& side : sides) face.lengths.push_back(polyline_length(side));
  return face;
}

std::vector<int> parts(size_t n_edges, const std::vector<FaceSides>& faces) {
  std::vector<const FaceSides*> pointers;
  for (const FaceSides& one : faces) pointers.push_back(&one);
  return parts_of_edges(n_edges, pointers);
}

/// The sides of a face cut into their parts, sampled for so many splits.
std::vector<Points> parted_sides(const std::vector<Vector3d>& corners, const std::vector<int>& parts,
                                 int splits) {
  std::vector<Vector3d> all;
  for (size_t k = 0; k < corners.size(); ++k)
    for (int i = 0; i < parts[k]; ++i)
      all.emplace_back(corners[k] + (corners[(k + 1) % corners.size()] - corners[k]) * i / parts[k]);
  return straight_sides(all, 1 << splits);
}

TEST(PartsOfEdges, AreOneOnFacesThatAreNotLong) {
  EXPECT_EQ(parts(4, {face({{0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {0, 1, 0}}, {0, 1, 2, 3})}),
            (std::vector<int>{1, 1, 1, 1}));
  EXPECT_EQ(parts(3, {face({{0, 0, 0}, {9, 0, 0}, {0, 1, 0}}, {0, 1, 2})}), (std::vector<int>{1, 1, 1}));
}

TEST(PartsOfEdges, MakeLongPiecesTwiceAsLongAsWide) {
  const std::vector<Vector3d> corners{{0, 0, 0}, {12, 0, 0}, {12, 1, 0}, {0, 1, 0}};
  const std::vector<int> found = parts(4, {face(corners, {0, 1, 2, 3})});
  EXPECT_EQ(found, (std::vector<int>{6, 1, 6, 1}));
  const FaceSplit split = split_face_into_quads(parted_sides(corners, found, 2), 2);
  EXPECT_TRUE(split.is_grid);
  EXPECT_EQ(split.quads.size(), 6u * 16);
  for (const std::array<int, 4>& quad : split.quads)  // rows and columns: all of them rectangles of 2 × 1
    for (size_t k = 0; k < 4; ++k) {
      const double length = (split.domain.row(quad[k]) - split.domain.row(quad[(k + 1) % 4])).norm();
      EXPECT_NEAR(std::min(std::abs(length - 0.5), std::abs(length - 0.25)), 0, 1e-9);
    }
}

TEST(PartsOfEdges, AreEqualOnOppositeSidesThroughAStackOfLongFaces) {
  // Bands 8 × 2, one upon the other; the lowest has a vertex in the middle of its lower side. At the top lies
  // a square, which needs no rows and columns.
  const auto x = [](double along, double up) { return Vector3d(along, up, 0); };
  const std::vector<int> found =
      parts(14, {face({x(0, 0), x(4, 0), x(8, 0), x(8, 2), x(0, 2)}, {0, 1, 2, 3, 4}),
                 face({x(0, 2), x(8, 2), x(8, 4), x(0, 4)}, {3, 5, 6, 7}),
                 face({x(0, 4), x(8, 4), x(8, 6), x(0, 6)}, {6, 8, 9, 10}),
                 face({x(0, 6), x(8, 6), x(8, 14), x(0, 14)}, {9, 11, 12, 13})});
  EXPECT_EQ(found, (std::vector<int>{1, 1, 1, 2, 1, 1, 2, 1, 1, 2, 1, 1, 1, 1}));
}

TEST(PartsOfEdges, EndWhereFacesAskEachOtherForEver) {
  // A ring of two bands that share both long edges, one of them in two pieces on one side only: nothing makes
  // them equal.
  const std::vector<Vector3d> band{{0, 0, 0}, {8, 0, 0}, {8, 1, 0}, {0, 1, 0}};
  const std::vector<Vector3d> broken{{0, 0, 0}, {4, 0, 0}, {8, 0, 0}, {8, 1, 0}, {0, 1, 0}};
  for (const int count : parts(6, {face(band, {0, 1, 2, 3}), face(broken, {0, 2, 4, 2, 5})})) {
    EXPECT_GE(count, 1);
    EXPECT_LE(count, 16);
  }
}

TEST(PartsOfEdges, LetCutsFromConcaveCornersMeetTheOppositeSide) {
  // A T: the sides of its stem, drawn on, meet the top at two fifths and three fifths. With vertices there
  // the cuts leave three right angles at both corners.
  const std::vector<Vector3d> corners{{2, 0, 0}, {3, 0, 0}, {3, 3, 0}, {5, 3, 0},
                                      {5, 4, 0}, {0, 4, 0}, {0, 3, 0}, {2, 3, 0}};
  const std::vector<int> found = parts_at_concave_corners(straight_sides(corners, 8));
  EXPECT_EQ(found, (std::vector<int>{1, 1, 1, 1, 3, 1, 1, 1}));
  const FaceSplit split = split_face_into_quads(parted_sides(corners, found, 2), 2);
  EXPECT_EQ(split.n_pieces, 4);
  // An L and a plus have their cuts already.
  const std::vector<Vector3d> l{{0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}};
  EXPECT_EQ(parts_at_concave_corners(straight_sides(l, 8)), std::vector<int>(6, 1));
  const std::vector<Vector3d> plus{{1, -1, 0}, {3, -1, 0}, {3, 1, 0},   {1, 1, 0},   {1, 3, 0},   {-1, 3, 0},
                                   {-1, 1, 0}, {-3, 1, 0}, {-3, -1, 0}, {-1, -1, 0}, {-1, -3, 0}, {1, -3, 0}};
  EXPECT_EQ(parts_at_concave_corners(straight_sides(plus, 8)), std::vector<int>(12, 1));
  EXPECT_EQ(split_face_into_quads(straight_sides(plus, 4), 2).n_pieces, 5);
}

}  // namespace
}  // namespace batten::detail
