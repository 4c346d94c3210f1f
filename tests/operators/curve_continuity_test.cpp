#include "batten/operators/curve_continuity.hpp"

#include "operators/sample_meshes.hpp"

#include <cmath>
#include <iostream>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;

/// A closed circle of radius 1 times r in the plane of a and b, its first point repeated.
Points circle(const Vector3d& a, const Vector3d& b, int n, const Vector3d& centre = Vector3d::Zero()) {
  Points points(n + 1, 3);
  for (int i = 0; i <= n; ++i) {
    const double t = 2 * kPi * (i % n) / n;
    points.row(i) = (centre + std::cos(t) * a + std::sin(t) * b).transpose();
  }
  return points;
}

/// The figures of one curve, the first of a list by which neighbourhoods end.
CurveContinuity measured(const TriangleMesh& mesh, const std::vector<Points>& curves, size_t which = 0) {
  return continuity_figures(curve_continuity(mesh.positions, mesh.triangles, curves)[which]);
}

Points segment(const Vector3d& a, const Vector3d& b) {
  Points points(2, 3);
  points << a.transpose(), b.transpose();
  return points;
}

/// A strip of width 1 along y and n cells each way: from x = −1 flat up to x = 0, then `bend` of arc length.
TriangleMesh strip(int n, const std::function<Vector3d(double x, double y)>& bend) {
  return samples::mapped_grid(2 * n + 1, n + 1, false, false, [&](double u, double v) {
    const double x = 2 * u - 1;
    return x <= 0 ? Vector3d(x, v, 0) : bend(x, v);
  });
}

// A sphere is smooth and has no cubic term: what remains is of the fourth order of its height, h³ in the
// normal.
TEST(CurveContinuity, FindsNoJumpOnASphereAndConvergesWithTheThirdPower) {
  std::vector<CurveContinuity> found;
  for (const int n : {16, 32}) {
    const TriangleMesh mesh = samples::octasphere(n, 2);
    const Points equator = circle(2 * Vector3d::UnitX(), 2 * Vector3d::UnitY(), 4 * n);
    found.push_back(measured(mesh, {equator}));
    EXPECT_GT(found.back().n_samples, 2 * n);
    EXPECT_EQ(found.back().n_one_sided + found.back().n_unfitted, 0);
  }
  std::cout << "sphere: normal jump " << degrees(found[0].max_normal_jump) << " and "
            << degrees(found[1].max_normal_jump) << " degrees, curvature jump " << found[0].max_curvature_jump
            << " and " << found[1].max_curvature_jump << '\n';
  EXPECT_LT(degrees(found[0].max_normal_jump), 0.2);
  EXPECT_GT(std::log2(found[0].max_normal_jump / found[1].max_normal_jump), 2.5);
  EXPECT_LT(found[1].max_curvature_jump, 0.01);
  EXPECT_LT(found[1].max_gap, 1e-4);
  // The curve bends on the sphere, the edges of the mesh are its chords: h²/8R.
  EXPECT_LT(found[1].max_distance, 2e-3);
}

// Along the top circle of a torus the profile has no symmetry in the height: cubic terms are there, so the
// measured curvatures of both sides differ in proportion to h, the normals still by h³.
TEST(CurveContinuity, ConvergesOnATorus) {
  std::vector<CurveContinuity> found;
  for (const int n : {32, 64}) {
    const TriangleMesh mesh = samples::torus(n);
    const Points top = circle(2 * Vector3d::UnitX(), 2 * Vector3d::UnitY(), 2 * n, 0.7 * Vector3d::UnitZ());
    found.push_back(measured(mesh, {top}));
  }
  std::cout << "torus: normal jump " << degrees(found[0].max_normal_jump) << " and "
            << degrees(found[1].max_normal_jump) << " degrees, curvature jump " << found[0].max_curvature_jump
            << " and " << found[1].max_curvature_jump << '\n';
  // The neighbourhood still reaches over a quarter of the radius of the tube.
  EXPECT_LT(degrees(found[1].max_normal_jump), 0.1);
  EXPECT_GT(std::log2(found[0].max_normal_jump / found[1].max_normal_jump), 2.5);
  EXPECT_GT(std::log2(found[0].max_curvature_jump / found[1].max_curvature_jump), 0.9);
}

// Both sides are planes, which a quadric holds exactly; up to rounding the jump is the angle of the fold.
TEST(CurveContinuity, IsExactOnTwoPlanes) {
  for (const double fold_deg : {0.01, 1.0, 40.0, 120.0}) {
    const double fold = radians(fold_deg);
    const TriangleMesh mesh =
        strip(12, [&](double x, double y) { return Vector3d(x * std::cos(fold), y, x * std::sin(fold)); });
    const CurveContinuity found = measured(mesh, {segment(Vector3d::Zero(), Vector3d::UnitY())});
    EXPECT_GT(found.n_samples, 5);
    EXPECT_NEAR(found.max_normal_jump, fold, 1e-9);
    EXPECT_NEAR(found.mean_normal_jump, fold, 1e-9);
    EXPECT_NEAR(found.max_curvature_jump, 0, 1e-9);
    EXPECT_NEAR(found.max_gap, 0, 1e-12);
    EXPECT_NEAR(found.max_distance, 0, 1e-12);
    EXPECT_NEAR(found.worst.x(), 0, 1e-12);
  }
}

// A plane that runs on as a cylinder is smooth in its normal and not in its curvature, which jumps by 1/r.
TEST(CurveContinuity, FindsTheCurvatureJumpOfACylinderOnAPlane) {
  const double r = 0.8;
  std::vector<double> normal_jumps;
  for (const int n : {20, 40}) {
    const TriangleMesh mesh = strip(
        n, [&](double x, double y) { return Vector3d(r * std::sin(x / r), y, r * (1 - std::cos(x / r))); });
    const CurveContinuity found = measured(mesh, {segment(Vector3d::Zero(), Vector3d::UnitY())});
    std::cout << "cylinder on plane: normal jump " << degrees(found.max_normal_jump)
              << " degrees, curvature jump " << found.mean_curvature_jump << " of " << 1 / r << '\n';
    EXPECT_NEAR(found.mean_curvature_jump * r, 1, n == 20 ? 0.04 : 0.01);
    EXPECT_NEAR(found.max_curvature_jump * r, 1, n == 20 ? 0.04 : 0.01);
    normal_jumps.push_back(found.max_normal_jump);
  }
  EXPECT_LT(degrees(normal_jumps[0]), 0.1);
  EXPECT_GT(std::log2(normal_jumps[0] / normal_jumps[1]), 2.5);
}

/// The cube of side 1, n cells on each edge, vertices of the edges shared.
TriangleMesh cube(int n) {
  TriangleMesh mesh;
  std::map<std::array<int, 3>, int> index;
  std::vector<Vector3d> points;
  std::vector<std::array<int, 3>> list;
  for (int axis = 0; axis < 3; ++axis)
    for (const int level : {0, n})
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const auto vertex = [&](int a, int b) {
            std::array<int, 3> key{};
            key[static_cast<size_t>(axis)] = level;
            key[static_cast<size_t>((axis + 1) % 3)] = i + a;
            key[static_cast<size_t>((axis + 2) % 3)] = j + b;
            const auto [place, is_new] = index.emplace(key, static_cast<int>(points.size()));
            if (is_new) points.push_back(Vector3d(key[0], key[1], key[2]) / n);
            return place->second;
          };
          const int a = vertex(0, 0), b = vertex(1, 0), c = vertex(1, 1), d = vertex(0, 1);
          if (level == n) {
            list.push_back({a, b, c});
            list.push_back({a, c, d});
          } else {
            list.push_back({a, c, b});
            list.push_back({a, d, c});
          }
        }
  mesh.positions.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (size_t i = 0; i < points.size(); ++i)
    mesh.positions.row(static_cast<Eigen::Index>(i)) = points[i].transpose();
  mesh.triangles.resize(static_cast<Eigen::Index>(list.size()), 3);
  for (size_t f = 0; f < list.size(); ++f)
    mesh.triangles.row(static_cast<Eigen::Index>(f)) << list[f][0], list[f][1], list[f][2];
  return mesh;
}

std::vector<Points> cube_edges() {
  std::vector<Points> edges;
  for (int axis = 0; axis < 3; ++axis)
    for (int k = 0; k < 4; ++k) {
      Vector3d from;
      from[axis] = 0;
      from[(axis + 1) % 3] = k & 1;
      from[(axis + 2) % 3] = k >> 1;
      Vector3d to = from;
      to[axis] = 1;
      edges.push_back(segment(from, to));
    }
  return edges;
}

// Right angles everywhere, also next to the corners: no neighbourhood goes over another edge of the list.
TEST(CurveContinuity, SeesRightAnglesAlongTheEdgesOfACubeUpToItsCorners) {
  const TriangleMesh mesh = cube(10);
  const auto found = curve_continuity(mesh.positions, mesh.triangles, cube_edges());
  ASSERT_EQ(found.size(), 12u);
  for (const auto& samples : found) {
    const CurveContinuity edge = continuity_figures(samples);
    EXPECT_GT(edge.n_samples, 7);
    EXPECT_EQ(edge.n_unfitted + edge.n_one_sided, 0);
    EXPECT_NEAR(edge.max_normal_jump, kPi / 2, 1e-9);
    EXPECT_NEAR(edge.mean_normal_jump, kPi / 2, 1e-9);
    EXPECT_NEAR(edge.max_curvature_jump, 0, 1e-9);
  }
  // A curve in the middle of a face meets nothing, as long as the edges at its ends are known.
  std::vector<Points> curves = cube_edges();
  curves.push_back(segment({0, 0.5, 1}, {1, 0.5, 1}));
  const CurveContinuity across = measured(mesh, curves, 12);
  EXPECT_GT(across.n_samples, 7);
  EXPECT_NEAR(across.max_normal_jump, 0, 1e-9);
}

// Angles have no unit and no frame, lengths go with the scale, curvatures against it.
TEST(CurveContinuity, FollowsRotationAndScale) {
  const TriangleMesh mesh = samples::torus(24);
  const Points curve = circle(2 * Vector3d::UnitX(), 2 * Vector3d::UnitY(), 48, 0.7 * Vector3d::UnitZ());
  const CurveContinuity before = measured(mesh, {curve});
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.9, Vector3d(1, 2, -2) / 3).toRotationMatrix();
  for (const double scale : {1e-3, 1e3}) {
    const Points moved =
        (scale * mesh.positions * turn.transpose()).rowwise() + scale * Eigen::RowVector3d(5, -7, 11);
    const Points moved_curve =
        (scale * curve * turn.transpose()).rowwise() + scale * Eigen::RowVector3d(5, -7, 11);
    const CurveContinuity after = measured({moved, mesh.triangles, {}, {}}, {moved_curve});
    EXPECT_EQ(after.n_samples, before.n_samples);
    EXPECT_NEAR(after.max_normal_jump, before.max_normal_jump, 1e-7);
    EXPECT_NEAR(after.max_curvature_jump * scale, before.max_curvature_jump, 1e-6);
    EXPECT_NEAR(after.mean_distance / scale, before.mean_distance, 1e-9);
  }
}

// The same where a curve turns within the neighbourhood and does not follow the edges: there the side of a
// triangle is told by the piece of the curve beside it, not by that at the sample, in whatever unit.
TEST(CurveContinuity, FollowsTheScaleAlongACurveThatTurnsWithinTheNeighbourhood) {
  const TriangleMesh mesh = samples::octasphere(24, 1);
  const Vector3d axis = Vector3d(1, 2, 3).normalized(), a = axis.unitOrthogonal(), b = axis.cross(a);
  // Five edges in radius: within a neighbourhood of two the circle turns by 25 degrees to either side.
  const double radius = 0.3;
  const Points curve = circle(radius * a, radius * b, 61, std::sqrt(1 - radius * radius) * axis);
  const CurveContinuity before = measured(mesh, {curve});
  EXPECT_GT(before.n_samples, 20);
  EXPECT_EQ(before.n_unfitted, 0);
  EXPECT_LT(degrees(before.max_normal_jump), 1);
  for (const double scale : {1e-3, 1e3}) {
    const CurveContinuity after = measured({scale * mesh.positions, mesh.triangles, {}, {}}, {scale * curve});
    EXPECT_EQ(after.n_samples, before.n_samples);
    EXPECT_NEAR(after.max_normal_jump, before.max_normal_jump, 1e-7);
    EXPECT_NEAR(after.mean_normal_jump, before.mean_normal_jump, 1e-7);
    EXPECT_NEAR(after.max_curvature_jump * scale, before.max_curvature_jump, 1e-6);
    EXPECT_NEAR(after.max_gap / scale, before.max_gap, 1e-9);
  }
}

// A curve that does not follow the edges of the mesh is measured as well, by the sides of its points.
TEST(CurveContinuity, TakesCurvesAcrossTheTrianglesOfASmoothSurface) {
  const TriangleMesh mesh = samples::octasphere(24, 1);
  const Vector3d a = Vector3d(1, 2, 3).normalized(), b = a.cross(Vector3d::UnitX()).normalized();
  const CurveContinuity found = measured(mesh, {circle(a, b, 100)});
  EXPECT_GT(found.n_samples, 50);
  EXPECT_EQ(found.n_unfitted, 0);
  EXPECT_LT(degrees(found.max_normal_jump), 0.2);
}

// A surface that ends at the curve has one side; there is no jump.
TEST(CurveContinuity, CountsBordersAsOneSided) {
  const TriangleMesh mesh = samples::square(12);
  const CurveContinuity found = measured(mesh, {segment(Vector3d::Zero(), Vector3d::UnitX())});
  EXPECT_EQ(found.n_samples, 0);
  EXPECT_GT(found.n_one_sided, 5);
  EXPECT_EQ(found.max_normal_jump, 0);
}

TEST(CurveContinuity, NamesBadInput) {
  const TriangleMesh mesh = samples::square(5);
  EXPECT_TRUE(curve_continuity(mesh.positions, mesh.triangles, {}).empty());
  Points bad = segment(Vector3d::Zero(), Vector3d::UnitX());
  EXPECT_THROW(curve_continuity(mesh.positions, mesh.triangles, {bad.topRows(1)}), InvalidInput);
  EXPECT_THROW(curve_continuity(mesh.positions, Triangles(0, 3), {bad}), InvalidInput);
  EXPECT_THROW(curve_continuity(mesh.positions, mesh.triangles, {bad}, {.radius = 1}), InvalidInput);
  EXPECT_THROW(curve_continuity(mesh.positions, mesh.triangles, {bad}, {.max_samples = 0}), InvalidInput);
  // A curve without length has a place and no direction.
  const CurveContinuity point = measured(mesh, {segment(Vector3d::Zero(), Vector3d::Zero())});
  EXPECT_EQ(point.n_samples, 0);
  bad(0, 0) = std::nan("");
  EXPECT_THROW(curve_continuity(mesh.positions, mesh.triangles, {bad}), InvalidInput);
  EXPECT_THROW(
      curve_continuity(mesh.positions, mesh.triangles, {segment(Vector3d::Zero(), Vector3d::UnitX())}, {},
                       Progress([](std::string_view, double) { return false; })),
      Cancelled);
}

}  // namespace
}  // namespace batten
