#include "batten/subdivision/bspline_surface.hpp"

#include "subdivision/limit_cages.hpp"

#include <algorithm>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/subdivision/subdivide.hpp"

namespace batten {
namespace {

using Row = Eigen::RowVector3d;
using cages::creased_box;
using cages::quarter_point_error;
using cages::random_torus;

TEST(LimitBsplines, EqualTheLimitSurfaceWhereItIsRegular) {
  const BsplineSurface surface = limit_bsplines(random_torus());
  EXPECT_EQ(surface.patches.size(), 30u);
  EXPECT_EQ(surface.edges.size(), 60u);
  EXPECT_TRUE(surface.is_closed);
  EXPECT_EQ(surface.n_components, 1);
  EXPECT_EQ(surface.deviation, 0);
  for (const BsplinePatch& patch : surface.patches) EXPECT_TRUE(patch.is_exact);
  EXPECT_LT(quarter_point_error(random_torus(), surface), 1e-14);
}

// Outside the cells at extraordinary vertices (beside them at 1/4 and beyond, and at the vertex itself)
// patches are exact too, also at borders, creases, darts and corners.
TEST(LimitBsplines, EqualTheLimitSurfaceAwayFromExtraordinaryVertices) {
  for (const ControlCage& cage :
       {cages::cube(), cages::prism(5), cages::tetrahedron(), cages::cube_with_sharp_edges(), creased_box(),
        cages::star(6, 2, [](double x, double y) { return Row(x, y, 0.2 * x * y); })}) {
    const BsplineSurface surface = limit_bsplines(cage);
    EXPECT_LT(quarter_point_error(cage, surface), 1e-12);
    // The sharp vertex of the box is the tip of a cone, which halving approaches slowest.
    const double bound = cage.sharp_vertices.empty() ? 1e-5 : 1e-4;
    EXPECT_LE(surface.deviation, bound * bounding_box_diagonal(cage.mesh.positions));
    EXPECT_GE(surface.isolation, 2);
  }
}

// A dart, an extraordinary vertex and a corner: what the patches claim to deviate is held against limit
// points eight times denser than the cells they approximate in, by distances to a fine triangulation of the
// patches.
TEST(LimitBsplines, ReportTheirLargestDeviation) {
  const ControlCage cage = creased_box();
  const BsplineSurface coarse = limit_bsplines(cage, {.tolerance = 1, .most_isolation = 2});
  const BsplineSurface fine = limit_bsplines(cage, {.tolerance = 1e-12, .most_isolation = 5});
  EXPECT_EQ(coarse.isolation, 2);
  EXPECT_EQ(fine.isolation, 5);
  EXPECT_GT(coarse.deviation, 0);
  EXPECT_LT(fine.deviation, 0.2 * coarse.deviation);
  EXPECT_LT(fine.normal_jump, coarse.normal_jump);
  EXPECT_LT(fine.normal_jump, radians(4));
  constexpr int kSteps = 48;
  Points points(static_cast<Eigen::Index>(coarse.patches.size()) * (kSteps + 1) * (kSteps + 1), 3);
  Triangles triangles(static_cast<Eigen::Index>(coarse.patches.size()) * kSteps * kSteps * 2, 3);
  Eigen::Index p = 0, t = 0;
  for (const BsplinePatch& patch : coarse.patches) {
    const int first = static_cast<int>(p);
    for (int j = 0; j <= kSteps; ++j)
      for (int i = 0; i <= kSteps; ++i)
        points.row(p++) = evaluate(patch, static_cast<double>(i) / kSteps, static_cast<double>(j) / kSteps)
                              .position.transpose();
    for (int j = 0; j < kSteps; ++j)
      for (int i = 0; i < kSteps; ++i) {
        const int a = first + j * (kSteps + 1) + i, b = a + kSteps + 1;
        triangles.row(t++) << a, a + 1, b + 1;
        triangles.row(t++) << a, b + 1, b;
      }
  }
  const SubdividedSurface dense = subdivide(cage, {.levels = 5, .limit = true});
  const double largest = distances(TriangleTree(points, triangles).closest(dense.limit_positions)).maxCoeff();
  // The triangulation itself is off by the sagitta of its triangles, below 1e-4 here.
  EXPECT_LT(largest, 1.1 * coarse.deviation + 1e-4);
}

// The largest angle between the normals of both patches along all edges, found here by four times as many
// places along the whole of them.
TEST(LimitBsplines, ReportTheirLargestJumpOfTheNormal) {
  for (const ControlCage& cage : {cages::cube(), cages::prism(5), cages::prism(3)}) {
    const BsplineSurface surface = limit_bsplines(cage, {.tolerance = 1, .most_isolation = 2});
    double largest = 0;
    for (size_t e = 0; e < surface.edges.size(); ++e) {
      const BsplineEdge& edge = surface.edges[e];
      const auto normal_at = [&](int of, double t) {
        const BsplinePatch& patch = surface.patches[static_cast<size_t>(of)];
        const auto side = std::find(patch.edges.begin(), patch.edges.end(), static_cast<int>(e));
        const auto k = static_cast<size_t>(side - patch.edges.begin());
        const auto uv = on_patch_side(static_cast<int>(k), patch.vertices[k] == edge.vertices[0] ? t : 1 - t);
        const PatchPoint point = evaluate(patch, uv[0], uv[1]);
        return Eigen::Vector3d(point.along_u.cross(point.along_v));
      };
      for (int i = 1; i < 256; ++i) {
        const Eigen::Vector3d a = normal_at(edge.patches[0], i / 256.0),
                              b = normal_at(edge.patches[1], i / 256.0);
        largest = std::max(largest, std::atan2(a.cross(b).norm(), a.dot(b)));
      }
    }
    EXPECT_LE(surface.normal_jump, largest + 1e-12);
    EXPECT_GT(surface.normal_jump, 0.95 * largest);
  }
}

// Edges leave an extraordinary vertex in the tangent plane of the limit surface, whose normal comes from
// OpenSubdiv's limit masks; so do the patches between them.
TEST(LimitBsplines, EdgesLeaveVerticesInTheTangentPlane) {
  for (const ControlCage& cage : {cages::cube(), cages::prism(5), cages::tetrahedron(), random_torus()}) {
    const BsplineSurface surface = limit_bsplines(cage);
    const Points normals = subdivide(cage, {.levels = surface.levels, .limit = true}).limit_normals;
    double off = 0;
    for (const BsplineEdge& edge : surface.edges) {
      const Points& points = edge.curve.control_points;
      const Row first = points.row(1) - points.row(0),
                last = points.row(points.rows() - 2) - points.row(points.rows() - 1);
      off = std::max({off, std::abs(first.normalized().dot(normals.row(edge.vertices[0]))),
                      std::abs(last.normalized().dot(normals.row(edge.vertices[1])))});
    }
    EXPECT_LT(off, 1e-12);
  }
}

TEST(LimitBsplines, ShareTheirEdges) {
  for (const ControlCage& cage : {cages::cube_with_sharp_edges(), creased_box(), cages::prism(3)}) {
    const BsplineSurface surface = limit_bsplines(cage);
    static const double kSides[4][4] = {{0, 0, 1, 0}, {1, 0, 1, 1}, {1, 1, 0, 1}, {0, 1, 0, 0}};
    for (const BsplinePatch& patch : surface.patches)
      for (size_t k = 0; k < 4; ++k) {
        const BsplineEdge& edge = surface.edges[static_cast<size_t>(patch.edges[k])];
        const bool forward = edge.vertices[0] == patch.vertices[k];
        EXPECT_EQ(edge.vertices[forward ? 1 : 0], patch.vertices[(k + 1) % 4]);
        double gap = 0;
        for (int i = 0; i <= 100; ++i) {
          const double t = i / 100.0, s = forward ? t : 1 - t;
          const double u = kSides[k][0] + t * (kSides[k][2] - kSides[k][0]);
          const double v = kSides[k][1] + t * (kSides[k][3] - kSides[k][1]);
          gap = std::max(gap, (evaluate(patch, u, v).position - evaluate(edge.curve, s)).norm());
        }
        EXPECT_LT(gap, 1e-13);
      }
  }
}

// Derivatives against differences.
TEST(LimitBsplines, EvaluateWithDerivatives) {
  const BsplineSurface surface = limit_bsplines(cages::cube());
  const BsplinePatch& patch = surface.patches[2];
  constexpr double kStep = 1e-5;
  for (const double u : {0.1, 0.3, 0.6, 0.9})
    for (const double v : {0.05, 0.55}) {
      const PatchPoint here = evaluate(patch, u, v);
      const Eigen::Vector3d along_u =
          (evaluate(patch, u + kStep, v).position - evaluate(patch, u - kStep, v).position) / (2 * kStep);
      const Eigen::Vector3d along_v =
          (evaluate(patch, u, v + kStep).position - evaluate(patch, u, v - kStep).position) / (2 * kStep);
      EXPECT_LT((here.along_u - along_u).norm(), 1e-7);
      EXPECT_LT((here.along_v - along_v).norm(), 1e-7);
    }
}

TEST(LimitBsplines, ResolveSemiSharpFeaturesOrSayWhyNot) {
  ControlCage cage = cages::cube();
  cage.sharp_edges = {{4, 5, 1.5}, {5, 6, 1.5}};
  const BsplineSurface surface = limit_bsplines(cage);
  EXPECT_EQ(surface.levels, 2);
  EXPECT_EQ(surface.patches.size(), 96u);
  EXPECT_LT(quarter_point_error(cage, surface), 1e-12);
  cage.sharp_edges = {{4, 5, 8.5}};
  try {
    limit_bsplines(cage);
    ADD_FAILURE() << "accepted";
  } catch (const InvalidInput& problem) {
    EXPECT_NE(std::string(problem.what()).find("last 9 levels"), std::string::npos) << problem.what();
  }
  EXPECT_THROW(limit_bsplines(cages::cube(), {.tolerance = 0}), InvalidInput);
  EXPECT_THROW(limit_bsplines(cages::cube(), {.most_isolation = 7}), InvalidInput);
}

}  // namespace
}  // namespace batten
