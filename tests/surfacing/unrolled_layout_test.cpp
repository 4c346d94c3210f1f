#include "network/sample_networks.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/units.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/network/cycles.hpp"
#include "batten/surfacing/layout_detail.hpp"
#include "batten/surfacing/surface.hpp"
#include "batten/surfacing/surface_input_detail.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;
using samples::NetworkBuilder;

/// A piece of a cylinder of radius 1 over an angle, height 1: one patch with its border tagged.
CurveNetwork half_pipe(int n, double angle) {
  NetworkBuilder builder;
  const auto normal = [](const Vector3d& p) { return Vector3d(p.x(), p.y(), 0); };
  const auto place = [&](double t, double z) {
    return Vector3d(std::cos(angle * t), std::sin(angle * t), z);
  };
  for (const double z : {0.0, 1.0})
    builder.curve(
        n, true, [&](double t) { return place(t, z); }, normal);
  for (const double t : {0.0, 1.0})
    builder.curve(
        n, true, [&](double z) { return place(t, z); }, normal);
  return builder.build();
}

// Developable: rolled out it is a rectangle of the length of the arc (a polygon of chords) and height 1, even
// over 300 degrees, which no projection holds.
TEST(UnrolledLayout, IsExactForAPieceOfACylinder) {
  const int n = 40;
  const double angle = radians(300), arc = 2 * n * std::sin(angle / n / 2);
  const CurveNetwork network = half_pipe(n, angle);
  const auto scaled = detail::scaled_network(network);
  const auto cycles = find_cycles(network).cycles;
  ASSERT_EQ(cycles.size(), 1U);
  // A unit of about the length of an edge, as surfaces have it: corners are rounded to a part of it.
  const auto laid_out = detail::lay_out_unrolled(scaled, cycles[0], 1 / (n * scaled.diameter));
  ASSERT_TRUE(laid_out.has_value());
  double area = 0;
  const auto& corners = laid_out->region.corners;
  for (Eigen::Index i = 0; i < corners.rows(); ++i) {
    const Eigen::RowVector2d a = corners.row(i), b = corners.row((i + 1) % corners.rows());
    area += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  EXPECT_NEAR(area / (n * n), arc, 1e-6);
}

// Mean distance from the cylinder, in % of the diameter. It is met at the vertices up to the chords of the
// curves, whose sagitta falls with the square of the step.
TEST(UnrolledLayout, ErrorOfAPipeFallsWithTheSquareOfTheStep) {
  const auto error = [](int n) {
    const SurfaceResult surface = surface_network(half_pipe(n, radians(300)));
    EXPECT_EQ(surface.patches_in_space, 0);
    EXPECT_EQ(surface.folded_triangles, 0);
    const auto& mesh = surface.mesh;
    double sum = 0;
    for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f) {
      const Eigen::RowVector3d middle =
          (mesh.positions.row(mesh.triangles(f, 0)) + mesh.positions.row(mesh.triangles(f, 1)) +
           mesh.positions.row(mesh.triangles(f, 2))) /
          3;
      sum += std::abs(middle.leftCols(2).norm() - 1);
    }
    return sum / static_cast<double>(mesh.n_triangles());
  };
  const double coarse = error(12), middle = error(24), fine = error(48);
  EXPECT_GT(std::log2(coarse / middle), 1.5) << coarse << " " << middle;
  EXPECT_GT(std::log2(middle / fine), 1.5) << middle << " " << fine;
}

/// Two equators of a torus (4, 2) and k meridians, steps of about 0.8.
CurveNetwork torus_of_meridians(int k) {
  NetworkBuilder builder;
  const auto normal = [](const Vector3d& p) {
    const double r = std::hypot(p.x(), p.y());
    return Vector3d(p.x() * (1 - 4 / r), p.y() * (1 - 4 / r), p.z());
  };
  const auto place = [](double u, double v) {
    return Vector3d((4 + 2 * std::cos(v)) * std::cos(u), (4 + 2 * std::cos(v)) * std::sin(u),
                    2 * std::sin(v));
  };
  for (const double v : {0.0, kPi})
    builder.curve(
        48, false, [&](double t) { return place(2 * kPi * t, v); }, normal);
  for (int i = 0; i < k; ++i)
    builder.curve(
        24, false, [&](double t) { return place(2 * kPi * i / k, 2 * kPi * t); }, normal);
  return builder.build();
}

// Quarter tubes stand upright on the plane of their normals at both ends. More curves are never worse.
TEST(UnrolledLayout, MoreMeridiansOfATorusAreBetter) {
  double before = 1e9;
  for (const int k : {6, 8, 12}) {
    const SurfaceResult surface = surface_network(torus_of_meridians(k));
    EXPECT_EQ(surface.patches_in_space, 0) << k;
    EXPECT_EQ(surface.folded_triangles, 0) << k;
    EXPECT_GT(degrees(mesh_quality(surface.mesh.positions, surface.mesh.triangles).min_angle), 15) << k;
    double sum = 0;
    for (Eigen::Index v = 0; v < surface.mesh.n_vertices(); ++v) {
      const Eigen::RowVector3d p = surface.mesh.positions.row(v);
      sum += std::abs(std::hypot(std::hypot(p.x(), p.y()) - 4, p.z()) - 2);
    }
    const double error = sum / static_cast<double>(surface.mesh.n_vertices());
    EXPECT_LT(error, before) << k;
    EXPECT_LT(error, 2e-4 * bounding_box_diagonal(surface.mesh.positions)) << k;
    before = error;
  }
}

}  // namespace
}  // namespace batten
