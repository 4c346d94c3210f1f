#include "batten/modelling/coons.hpp"

#include "modelling/sides_over.hpp"

#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "batten/core/units.hpp"

namespace batten {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using namespace test;

constexpr int kDense = 400;  // pieces of a curve

/// The curve of a map over the line between two places.
SharedPolyline curve(const std::function<Vector3d(Vector2d)>& map, const Vector2d& from, const Vector2d& to) {
  Points points(kDense + 1, 3);
  for (int i = 0; i <= kDense; ++i) {
    const double t = static_cast<double>(i) / kDense;
    points.row(i) = map((1 - t) * from + t * to).transpose();
  }
  return std::make_shared<Polyline>(points);
}

const std::vector<Vector2d> kSquare{{0, 0}, {1, 0}, {1, 1}, {0, 1}};

CoonsPatch patch_over(const std::function<Vector3d(Vector2d)>& map) {
  const auto sides = sides_over(map, kSquare, kDense);
  return CoonsPatch({sides[0], sides[1], sides[2], sides[3]});
}

TEST(CoonsPatch, GoesThroughItsFourCurves) {
  const auto wave = [](const Vector2d& p) {
    return Vector3d(p.x(), p.y(), 0.3 * std::sin(3 * p.x()) + p.x() * p.y() * p.y());
  };
  const auto sides = sides_over(wave, kSquare, kDense);
  const CoonsPatch patch({sides[0], sides[1], sides[2], sides[3]});
  for (int i = 0; i <= 10; ++i) {
    const double t = i / 10.0;
    EXPECT_LT((patch.at(t, 0) - sides[0]->at(t * sides[0]->length())).norm(), 1e-14);
    EXPECT_LT((patch.at(1, t) - sides[1]->at(t * sides[1]->length())).norm(), 1e-14);
    EXPECT_LT((patch.at(t, 1) - sides[2]->at((1 - t) * sides[2]->length())).norm(), 1e-14);
    EXPECT_LT((patch.at(0, t) - sides[3]->at((1 - t) * sides[3]->length())).norm(), 1e-14);
  }
}

// Bilinear blending reproduces x(u, v) = f(u) + g(v): here a saddle swept from two circular arcs, whose arc
// lengths are u and v themselves.
TEST(CoonsPatch, ReproducesSurfacesOfTranslation) {
  const auto swept = [](const Vector2d& p) {
    return Vector3d(std::sin(p.x()), std::sin(p.y()), std::cos(p.x()) - std::cos(p.y()));
  };
  const CoonsPatch patch = patch_over(swept);
  for (const double u : {0.1, 0.35, 0.8})
    for (const double v : {0.25, 0.6}) EXPECT_LT((patch.at(u, v) - swept({u, v})).norm(), 1e-5);
}

TEST(CoonsPatch, FindsTheParametersOfItsPoints) {
  const CoonsPatch patch = patch_over([](const Vector2d& p) {
    return Vector3d(2 * p.x(), p.y() + 0.2 * p.x() * p.x(), 0.5 * std::sin(kPi * p.x()));
  });
  for (const Vector2d& place : {Vector2d(0.5, 0.5), Vector2d(0.13, 0.77), Vector2d(1, 0.4), Vector2d(0, 0)})
    EXPECT_LT((patch.nearest(patch.at(place.x(), place.y())) - place).norm(), 1e-4) << place.transpose();
}

// H fig. 6.1: the corners of the quad are those with the smallest angles, and the others lie on its sides at
// their share of the length.
TEST(AssociateQuad, TakesTheFourSmallestAngles) {
  const FacePatch face = associate_quad(
      sides_over(flat, {{0.25, 0}, {1, 0}, {1.02, 0.5}, {1, 1}, {0.5, 1.02}, {0, 1}, {0, 0}}, kDense));
  EXPECT_EQ(face.parameters[1], Vector2d(0, 0));  // the first corner of the quad in the order of the face
  EXPECT_EQ(face.parameters[3], Vector2d(1, 0));
  EXPECT_EQ(face.parameters[5], Vector2d(1, 1));
  EXPECT_EQ(face.parameters[6], Vector2d(0, 1));
  EXPECT_NEAR((face.parameters[2] - Vector2d(0.5, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((face.parameters[4] - Vector2d(1, 0.5)).norm(), 0, 1e-12);
  EXPECT_NEAR((face.parameters[0] - Vector2d(0, 0.75)).norm(), 0, 1e-12);
  EXPECT_TRUE(face.on_one_side(1, 2));
  EXPECT_TRUE(face.on_one_side(1, 6));
  EXPECT_FALSE(face.on_one_side(0, 2));
  for (size_t k = 0; k < 7; ++k) {
    const Vector3d there = face.patch.at(face.parameters[k].x(), face.parameters[k].y());
    const std::vector<Vector2d> corners{{0.25, 0}, {1, 0}, {1.02, 0.5}, {1, 1}, {0.5, 1.02}, {0, 1}, {0, 0}};
    EXPECT_LT((there - flat(corners[k])).norm(), 1e-12) << k;
  }
}

// Joints in the sides, flat or on half a tube, leave four corners; a fifth corner or a reflex one does not.
TEST(AssociateQuad, KnowsFacesOfFourCorners) {
  const auto has_four = [](const std::function<Vector3d(Vector2d)>& map,
                           const std::vector<Vector2d>& corners) {
    return associate_quad(sides_over(map, corners, kDense)).has_four_corners;
  };
  const auto cone = [](const Vector2d& p) {
    const double radius = 1 + 0.5 * p.y();
    return Vector3d(radius * std::cos(kPi * p.x()), radius * std::sin(kPi * p.x()), p.y());
  };
  for (const auto& map : {std::function<Vector3d(Vector2d)>(flat), std::function<Vector3d(Vector2d)>(cone)}) {
    EXPECT_TRUE(has_four(map, kSquare));
    EXPECT_TRUE(has_four(map, {{0, 0}, {0.5, 0}, {1, 0}, {1, 1}, {0, 1}}));
    EXPECT_TRUE(has_four(map, {{0, 0}, {0.3, 0}, {1, 0}, {1, 1}, {0.6, 1}, {0, 1}, {0, 0.5}}));
  }
  std::vector<Vector2d> pentagon;
  for (int k = 0; k < 5; ++k) pentagon.emplace_back(std::cos(2 * kPi * k / 5), std::sin(2 * kPi * k / 5));
  EXPECT_FALSE(has_four(flat, pentagon));
  EXPECT_FALSE(has_four(flat, {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}));
}

TEST(AssociateQuad, GivesTrianglesASideWithoutLengthAndHalvesTheSidesOfDigons) {
  // A needle: its two long sides meet at corner 1.
  const FacePatch triangle = associate_quad(sides_over(flat, {{0, 0}, {4, 0.5}, {0, 1}}, kDense));
  EXPECT_EQ(triangle.parameters[1], Vector2d(0.5, 0));
  for (const double u : {0.0, 0.3, 1.0})
    EXPECT_LT((triangle.patch.at(u, 0) - Vector3d(4, 0.5, 0)).norm(), 1e-14);
  EXPECT_LT((triangle.patch.at(1, 1) - Vector3d(0, 1, 0)).norm(), 1e-14);
  const auto circle = [](const Vector2d& p) { return Vector3d(std::cos(p.x()), std::sin(p.x()), 0); };
  const FacePatch disc =
      associate_quad({curve(circle, {0, 0}, {kPi, 0}), curve(circle, {kPi, 0}, {2 * kPi, 0})});
  // Four equal arcs: the middle of the patch is that of the circle.
  EXPECT_LT(disc.patch.at(0.5, 0.5).norm(), 1e-4);
  EXPECT_LT((disc.patch.at(1, 0) - Vector3d(0, 1, 0)).norm(), 1e-4);
}

}  // namespace
}  // namespace batten
