#include "sanitizers.hpp"
#include "tool_models.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/sketch/polyline_mesh.hpp"
#include "batten/sketch/tools.hpp"

namespace batten {
namespace {

using namespace strokes;
using Eigen::Vector3d;

// What squares of coordinates cannot hold is refused, whatever the determinant says.
TEST(Transform, ModelsStayWithinTheRangeOfNumbers) {
  PolylineMesh mesh;
  EXPECT_CONTAINS(
      refusal(mesh, [](PolylineMesh& m) { return transform_model(m, Eigen::Matrix4d::Identity()); }),
      "nothing to move");
  mesh = octahedral_sphere();
  const auto scaled = [&](double x, double y, double z) {
    const Eigen::Matrix4d matrix = Eigen::Vector4d(x, y, z, 1).asDiagonal();
    return refusal(mesh, [&](PolylineMesh& m) { return transform_model(m, matrix); });
  };
  EXPECT_CONTAINS(scaled(1e300, 1e300, 1e300), "beyond 1e+100");
  EXPECT_CONTAINS(scaled(1e-300, 1e-300, 1e-300), "below 1e-100");
  EXPECT_CONTAINS(scaled(1, 1, 0), "flattens");
  EXPECT_CONTAINS(scaled(0, 0, 0), "flattens");
  for (const double size : {1e-40, 1e40}) {  // cubes of these are out of range, the model is not
    const Eigen::Matrix4d matrix = Eigen::Vector4d(size, size, size, 1).asDiagonal();
    edit(mesh, [&](PolylineMesh& m) { return transform_model(m, matrix); });
    EXPECT_EQ(mesh.broken_invariant(), "");
    const Eigen::Matrix4d back = Eigen::Vector4d(1 / size, 1 / size, 1 / size, 1).asDiagonal();
    edit(mesh, [&](PolylineMesh& m) { return transform_model(m, back); });
  }
}

TEST(Transform, MirrorsTurnFacesSoThatTheyStayOutside) {
  PolylineMesh mesh = octahedral_sphere();
  const auto volume = [](const PolylineMesh& m) {  // of the octahedron of the corners
    double sum = 0;
    for (const SketchFace& face : m.faces()) {
      if (!face.alive) continue;
      const auto corner = [&](size_t k) { return m.vertex(m.start_of(face.sides[k])).position; };
      sum += corner(0).cross(corner(1)).dot(corner(2)) / 6;
    }
    return sum;
  };
  const double before = volume(mesh);
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix(0, 0) = -2;
  edit(mesh, [&](PolylineMesh& m) { return transform_model(m, matrix); });
  EXPECT_NEAR(volume(mesh), 2 * before, 1e-6);
  EXPECT_EQ(mesh.broken_invariant(), "");
}

/// An open space curve without symmetry, its parameter from a to b.
Points without_symmetry(double a, double b, int n) {
  Points points(n, 3);
  for (int i = 0; i < n; ++i) {
    const double t = a + (b - a) * i / (n - 1);
    points.row(i) << t + 0.3 * t * t, 0.4 * std::sin(4 * t) + 0.2 * t,
        0.3 * t * t * t + 0.1 * std::cos(9 * t);
  }
  return points;
}

TEST(Align, FindsThePoseOfACurveWithoutSymmetryInEveryTry) {
  // Moved at random. Exact data: the residual is that of arithmetic.
  const Points points = without_symmetry(0, 1, 200);
  const Polyline curve(points);
  Random random(5);
  constexpr int kTries = test::repeated(1000, 50);
  int wrong = 0;
  for (int k = 0; k < kTries; ++k) {
    const Eigen::Quaterniond q =
        Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal()).normalized();
    const Vector3d shift = 3 * random.normal3();
    Points moved = (points * q.toRotationMatrix().transpose()).rowwise() + shift.transpose();
    if (k % 2) moved = moved.colwise().reverse().eval();  // drawn from the other end
    const Alignment found = align_curves(curve, Polyline(moved));
    double worst = 0;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      const Vector3d p = points.row(i);
      worst = std::max(
          worst,
          ((found.matrix.topLeftCorner<3, 3>() * p + found.matrix.topRightCorner<3, 1>()) - (q * p + shift))
              .norm());
    }
    if (worst > 1e-4 * curve.length()) ++wrong;
  }
  EXPECT_EQ(wrong, 0);
}

// A stroke that goes on beyond both ends has another middle and other axes: the curve has to slide along it.
TEST(Align, SlidesAlongAStrokeThatGoesOnBeyondItsEnds) {
  const Points points = without_symmetry(0, 1, 200);
  const Alignment found = align_curves(Polyline(points), Polyline(without_symmetry(-0.04, 1.08, 300)));
  double worst = 0;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Vector3d p = points.row(i);
    worst = std::max(
        worst, (found.matrix.topLeftCorner<3, 3>() * p + found.matrix.topRightCorner<3, 1>() - p).norm());
  }
  EXPECT_LT(worst, 1e-3);
}

TEST(Align, TriesManyTurnsWhereAxesAreEqual) {
  // Three lobes of one plane curve: both axes in the plane are equal, so that principal axes say nothing.
  const auto lobes = [](double phase, double begin) {
    Points points(241, 3);
    for (int i = 0; i <= 240; ++i) {
      const double t = begin + 2 * kPi * i / 240, r = 1 + 0.4 * std::cos(3 * t);
      points.row(i) << r * std::cos(t + phase), r * std::sin(t + phase), 0.15 * std::sin(3 * t);
    }
    return points;
  };
  const Polyline curve(lobes(0, 0));
  for (const double phase : {0.3, 1.0, 2.2, 4.0})
    for (const double begin : {0.0, 0.5, 1.7, 2.9, 4.6}) {
      const Alignment found = align_curves(curve, Polyline(lobes(phase, begin)));
      EXPECT_LT(found.rms, 1e-4 * curve.length()) << phase << " " << begin;
      EXPECT_TRUE(found.ambiguous);  // thirds of a turn fit as well
    }
}

/// A circle of radius r, its first point repeated.
Polyline round(double r) {
  return Polyline(arc(kO, r * kX, r * kY, 0, 2 * kPi, 360));
}

// Circles of radii 1 and 1.1 about one centre are 0.1 apart everywhere, seen from either.
TEST(Align, TellsTheDistanceThatIsLeft) {
  const Alignment found = align_curves(round(1), round(1.1));
  EXPECT_NEAR(found.rms, 0.1, 1e-3);
  EXPECT_NEAR(align_curves(round(1.1), round(1)).rms, 0.1, 1e-3);
}

TEST(Align, RefusesAStrokeOfAnotherShape) {
  try {
    align_curves(round(1), Polyline(polygon({-kX, kX})));
    ADD_FAILURE() << "a line was taken for a circle";
  } catch (const RefusedEdit& refused) {
    EXPECT_CONTAINS(refused.what(), "does not have the shape");
  }
}

// An oval fits as well after half a turn; a trembling hand, which makes one of both a little better, does not
// decide between them.
TEST(Align, SaysThatASymmetricCurveFitsInMoreThanOneWay) {
  Random random(4);
  const auto oval = [&](double tremor) {
    Points points(241, 3);
    for (int i = 0; i <= 240; ++i) {
      const double t = 2 * kPi * i / 240;
      points.row(i) = (Vector3d(2 * std::cos(t), std::sin(t), 0) + tremor * random.normal3()).transpose();
    }
    return Polyline(points);
  };
  const Polyline curve = oval(0);
  for (int k = 0; k < 5; ++k) EXPECT_TRUE(align_curves(curve, oval(0.02)).ambiguous) << k;
}

}  // namespace
}  // namespace batten
