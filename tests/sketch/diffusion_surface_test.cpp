#include "batten/sketch/diffusion_surface.hpp"

#include "strokes.hpp"

#include <cmath>
#include <iostream>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/sketch/model_network.hpp"
#include "batten/subdivision/subdivide.hpp"
#include "batten/surfacing/surface.hpp"

namespace batten {
namespace {

using namespace strokes;
using Eigen::Vector3d;

PolylineMesh model(const std::vector<std::pair<DrawnStroke, InsertOptions>>& drawn) {
  PolylineMesh mesh;
  for (const auto& [stroke, options] : drawn)
    edit(mesh, [&, &s = stroke, &o = options](PolylineMesh& m) { return insert_curve(m, s, o); });
  return mesh;
}

PolylineMesh three_great_circles() {
  return model({{circle(kO, kX, kY, 200), {}}, {circle(kO, kX, kZ, 200), {}}, {circle(kO, kY, kZ, 200), {}}});
}

/// The unit cube with sharp edges around its top and two sharp uprights (H fig. 7.6).
PolylineMesh cube() {
  const Vector3d x = kX, y = kY, z = kZ;
  return model({{{polygon({kO, x, x + y, y, kO}), true}, {}},
                {{polygon({kO, z, x + z, x}), false}, {.into = Into::Opening}},
                {{polygon({y, y + z, x + y + z, x + y}), false}, {}},
                {{polygon({z, y + z}), false}, {.sharpness = 1}},
                {{polygon({x + z, x + y + z}), false}, {.sharpness = 1}}});
}

double largest_radius_error(const Points& points) {
  return (points.rowwise().norm().array() - 1).abs().maxCoeff();
}

TEST(DiffusionSurface, ThreeGreatCirclesBecomeASphere) {
  // H fig. 7.7. Bounds of the issue: 0.5 % with 16 n quads, 0.15 % with 64 n; n = 8 · 3 here.
  const PolylineMesh mesh = three_great_circles();
  for (const auto& [splits, bound] : {std::pair(3, 5e-3), std::pair(4, 1.5e-3)}) {
    const DiffusionSurface surface = diffusion_surface(mesh, {.splits = splits});
    EXPECT_EQ(surface.refined.mesh.n_faces(), 8 * 3 << (2 * splits - 2));
    const double error = largest_radius_error(surface.refined.mesh.positions);
    RecordProperty("largest_error_" + std::to_string(splits), std::to_string(error));
    std::cout << "largest error of the radius with " << surface.refined.mesh.n_faces() << " quads: " << error
              << '\n';
    EXPECT_LT(error, bound) << splits;
  }
}

TEST(DiffusionSurface, FollowsRotationAndScale) {
  // The flow knows no axes and no unit: a moved model gives the moved surface, up to rounding.
  PolylineMesh mesh = cube();
  const DiffusionSurface before = diffusion_surface(mesh, {.splits = 2, .rounds = 3});
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() << 0, -300, 0, 0, 0, 300, -300, 0, 0;
  matrix.topRightCorner<3, 1>() << 5, 6, 7;
  edit(mesh, [&](PolylineMesh& m) { return transform_model(m, matrix); });
  const DiffusionSurface after = diffusion_surface(mesh, {.splits = 2, .rounds = 3});
  const Points moved = (before.refined.mesh.positions * matrix.topLeftCorner<3, 3>().transpose()).rowwise() +
                       matrix.topRightCorner<3, 1>().transpose();
  EXPECT_LT((moved - after.refined.mesh.positions).rowwise().norm().maxCoeff(), 300 * 1e-6);
}

TEST(DiffusionSurface, FaceWithinSharpEdgesIsPlanar) {
  // H fig. 7.6: nothing diffuses over sharp edges, so the top face has the curvature of a plane.
  PolylineMesh mesh = cube();
  // The top pieces of the two bows and their uprights are edges of c1 and c2; make the tops sharp.
  mesh.begin();
  for (size_t e = 0; e < mesh.edges().size(); ++e) {
    const SketchEdge& edge = mesh.edges()[e];
    const auto high = [&](int v) { return mesh.vertex(v).position.z() > 0.5; };
    if (edge.alive && high(edge.vertices[0]) && high(edge.vertices[1]))
      mesh.set_sharpness(static_cast<int>(e), 1);
  }
  mesh.commit();
  const DiffusionSurface surface = diffusion_surface(mesh);
  ASSERT_EQ(mesh.counts().faces, 6);
  int top = -1;
  for (size_t f = 0; f < mesh.faces().size(); ++f) {
    if (!mesh.faces()[f].alive) continue;
    bool high = true;
    for (const int side : mesh.faces()[f].sides)
      high = high && mesh.vertex(mesh.start_of(side)).position.z() > 0.5;
    if (high) top = static_cast<int>(f);
  }
  ASSERT_GE(top, 0);
  double height = 0;
  const PolygonMesh& refined = surface.refined.mesh;
  for (size_t q = 0; q < surface.face_of_quad.size(); ++q)
    if (surface.face_of_quad[q] == top)
      for (size_t k = 0; k < 4; ++k)
        height = std::max(height, std::abs(refined.positions(refined.corners[4 * q + k], 2) - 1));
  EXPECT_LT(height, 1e-3);
}

TEST(DiffusionSurface, DrawnCurvesAreKeptExactlyOrSoftly) {
  const PolylineMesh mesh = three_great_circles();
  const DiffusionSurface exact = diffusion_surface(mesh, {.rounds = 2});
  const DiffusionSurface soft = diffusion_surface(mesh, {.rounds = 2, .fidelity = 1});
  for (size_t e = 0; e < mesh.edges().size(); ++e) {
    if (!mesh.edges()[e].alive) continue;
    const Points samples = mesh.edges()[e].polyline->sampled(8);
    for (Eigen::Index k = 0; k < samples.rows(); ++k) {
      const int v = exact.vertices_of_edge[e][static_cast<size_t>(k)];
      EXPECT_EQ(exact.refined.mesh.positions.row(v), samples.row(k));
      EXPECT_LT((soft.refined.mesh.positions.row(v) - samples.row(k)).norm(), 0.02);
    }
  }
  EXPECT_NE(soft.refined.mesh.positions, exact.refined.mesh.positions);
}

TEST(DiffusionSurface, LimitSurfaceGoesThroughTheRefinedMesh) {
  // The limit points of OpenSubdiv are a second implementation of the stencils behind `cage`; the cube has
  // creases, corners and darts, the disc a border.
  PolylineMesh sharp = cube();
  for (const PolylineMesh& mesh : {sharp, three_great_circles(), model({{circle(kO, kX, kY), {}}})}) {
    const DiffusionSurface surface = diffusion_surface(mesh, {.splits = 2});
    const SubdividedSurface fine = subdivide(surface.cage, {.levels = 1, .limit = true});
    const Points& refined = surface.refined.mesh.positions;
    EXPECT_LT((fine.limit_positions.topRows(refined.rows()) - refined).rowwise().norm().maxCoeff(), 1e-6);
  }
}

TEST(DiffusionSurface, FinishedSphereIsWithinThreePerMille) {
  // Bound of the issue: the mean of the finished surface within 0.3 %.
  const DiffusionSurface surface = diffusion_surface(three_great_circles());
  const SubdividedSurface fine = subdivide(surface.cage, {.levels = 2, .limit = true});
  const double mean = (fine.limit_positions.rowwise().norm().array() - 1).abs().mean();
  std::cout << "mean error of the finished sphere: " << mean << '\n';
  EXPECT_LT(mean, 3e-3);
}

TEST(NetworkOfModel, IsFilledIntoTheSameSphere) {
  // Curvature surfacing with estimated normals; bound of the issue: 0.3 % in the mean.
  const PolylineMesh mesh = three_great_circles();
  const CurveNetwork network = network_of_model(mesh, diffusion_surface(mesh, {.splits = 4}));
  EXPECT_EQ(network.curves.size(), 12u);
  for (Eigen::Index v = 0; v < network.positions.rows(); ++v)
    EXPECT_GT(network.positions.row(v).normalized().dot(network.normals.row(v)), std::cos(0.02));
  const SurfaceResult filled = surface_network(network);
  EXPECT_EQ(filled.n_cycles, 8);
  const double mean = (filled.mesh.positions.rowwise().norm().array() - 1).abs().mean();
  std::cout << "mean error of the filled sphere: " << mean << '\n';
  EXPECT_LT(mean, 3e-3);
}

TEST(DiffusionSurface, BadOptionsAndEmptyModelsAreNamed) {
  EXPECT_THROW(diffusion_surface(PolylineMesh()), InvalidInput);
  EXPECT_THROW(diffusion_surface(three_great_circles(), {.splits = 0}), InvalidInput);
  EXPECT_THROW(diffusion_surface(three_great_circles(), {.time_step = 0}), InvalidInput);
  EXPECT_THROW(
      diffusion_surface(three_great_circles(), {}, Progress([](std::string_view, double) { return false; })),
      Cancelled);
}

}  // namespace
}  // namespace batten
