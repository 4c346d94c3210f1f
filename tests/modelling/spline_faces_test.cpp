#include "batten/modelling/spline_faces.hpp"

#include "modelling/patched_shapes.hpp"

#include <cmath>
#include <set>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/subdivision/step.hpp"

namespace batten {
namespace {

/// Sides of faces are their edges' curves, to the last bits: what a CAD program calls watertight.
void expect_shared_sides(const BsplineSurface& surface) {
  for (const BsplinePatch& patch : surface.patches)
    for (int k = 0; k < 4; ++k) {
      const BsplineEdge& edge =
          surface.edges[static_cast<std::size_t>(patch.edges[static_cast<std::size_t>(k)])];
      const bool forward = edge.vertices[0] == patch.vertices[static_cast<std::size_t>(k)] &&
                           edge.vertices[1] == patch.vertices[static_cast<std::size_t>((k + 1) % 4)];
      for (double t = 0; t <= 1; t += 0.125) {
        const auto [u, v] = on_patch_side(k, t);
        EXPECT_LT((evaluate(patch, u, v).position - evaluate(edge.curve, forward ? t : 1 - t)).norm(), 1e-12);
      }
    }
}

/// The largest of f over points of all faces.
template <typename Function>
double largest_over(const BsplineSurface& surface, const Function& f) {
  double largest = 0;
  for (const BsplinePatch& patch : surface.patches)
    for (double u = 0; u <= 1; u += 0.0625)
      for (double v = 0; v <= 1; v += 0.0625) largest = std::max(largest, f(evaluate(patch, u, v)));
  return largest;
}

void expect_solid_of_volume(const BsplineSurface& surface, double volume, double relative) {
  if (!has_step()) GTEST_SKIP() << "built without Open Cascade";
  StepOptions options;
  options.millimetres_per_unit = 10;
  const StepModel model = read_step(format_step(surface, options));
  EXPECT_TRUE(model.is_valid);
  EXPECT_TRUE(model.is_closed);
  EXPECT_EQ(model.n_solids, 1);
  EXPECT_EQ(model.n_faces, static_cast<int>(surface.patches.size()));
  EXPECT_NEAR(model.volume, 1000 * volume, 1000 * volume * relative);
}

TEST(SplineFaces, ASphereOfTrianglesIsSmoothAndRound) {
  const test::PatchedMesh sphere = test::octant_sphere();
  const SplineFaces faces = spline_faces(sphere.mesh, sphere.patches);
  EXPECT_EQ(faces.surface.patches.size(), 24u);  // three for each patch of three sides
  EXPECT_TRUE(faces.surface.is_closed);
  EXPECT_EQ(faces.n_sharp, 0);
  EXPECT_LT(faces.surface.deviation, 1e-4 * bounding_box_diagonal(sphere.mesh.positions));
  EXPECT_LT(faces.surface.normal_jump, radians(0.1));
  expect_shared_sides(faces.surface);
  // Between the vertices, too, and with the normals of a sphere.
  EXPECT_LT(largest_over(faces.surface, [](const PatchPoint& p) { return std::abs(p.position.norm() - 1); }),
            5e-4);
  EXPECT_LT(
      largest_over(faces.surface,
                   [](const PatchPoint& p) {
                     return p.along_u.cross(p.along_v).normalized().cross(p.position.normalized()).norm();
                   }),
      radians(0.5));
  expect_solid_of_volume(faces.surface, 4 * kPi / 3, 1e-3);
}

TEST(SplineFaces, AnOutlineWithoutCornersGetsARingOfFaces) {
  const test::PatchedMesh sphere = test::half_spheres();
  const SplineFaces faces = spline_faces(sphere.mesh, sphere.patches);
  EXPECT_EQ(faces.surface.patches.size(), 10u);  // four around and one within, twice
  EXPECT_LT(faces.surface.deviation, 1e-4 * bounding_box_diagonal(sphere.mesh.positions));
  EXPECT_LT(faces.surface.normal_jump, radians(0.1));
  expect_shared_sides(faces.surface);
  // No face folds anywhere, at the four nodes in the middle of straight curves neither.
  EXPECT_LT(largest_over(faces.surface,
                         [](const PatchPoint& p) {
                           return 1 - p.along_u.cross(p.along_v).normalized().dot(p.position.normalized());
                         }),
            1e-3);
}

TEST(SplineFaces, APatchOfFourSidesIsOneFace) {
  const test::PatchedMesh torus = test::torus_of_patches(0.35, 5, 3);
  const SplineFaces faces = spline_faces(torus.mesh, torus.patches);
  EXPECT_EQ(faces.surface.patches.size(), 15u);
  std::set<int> patches;
  for (const BsplinePatch& patch : faces.surface.patches) patches.insert(patch.face);
  EXPECT_EQ(patches.size(), 15u);
  EXPECT_LT(faces.surface.deviation, 1e-4 * bounding_box_diagonal(torus.mesh.positions));
  EXPECT_LT(faces.surface.normal_jump, radians(0.1));
  expect_shared_sides(faces.surface);
  expect_solid_of_volume(faces.surface, 2 * kPi * kPi * 0.35 * 0.35, 1e-3);
}

TEST(SplineFaces, TighterTolerancesTakeMoreKnots) {
  const test::PatchedMesh torus = test::torus_of_patches(0.35, 3, 2, 40);
  SplineFacesOptions loose, tight;
  loose.tolerance = 1e-2;
  tight.tolerance = 1e-5;
  const SplineFaces few = spline_faces(torus.mesh, torus.patches, loose),
                    many = spline_faces(torus.mesh, torus.patches, tight);
  EXPECT_LT(few.surface.patches[0].control_points.rows(), many.surface.patches[0].control_points.rows());
  EXPECT_LT(many.surface.deviation, few.surface.deviation / 4);
}

TEST(SplineFaces, RimsAndEdgesStaySharp) {
  const test::PatchedMesh cylinder = test::cylinder_of_patches(1.5);
  const SplineFaces round = spline_faces(cylinder.mesh, cylinder.patches);
  EXPECT_EQ(round.surface.patches.size(), 14u);  // four around, five in each disc
  EXPECT_EQ(round.n_sharp, 8);
  EXPECT_LT(round.surface.normal_jump, radians(0.1));
  expect_shared_sides(round.surface);
  expect_solid_of_volume(round.surface, 1.5 * kPi, 4e-3);  // of the 64-gon it is 1.6e-3 less

  const test::PatchedMesh cube = test::cube_of_patches();
  const SplineFaces flat = spline_faces(cube.mesh, cube.patches);
  EXPECT_EQ(flat.surface.patches.size(), 6u);
  EXPECT_EQ(flat.n_sharp, 12);
  EXPECT_LT(flat.surface.deviation, 1e-9);
  expect_solid_of_volume(flat.surface, 1, 1e-9);
}

TEST(SplineFaces, OpenSurfacesKeepTheirBorder) {
  test::PatchedMeshBuilder builder;
  const auto saddle = [](double u, double v) { return Eigen::Vector3d(u, v, 0.3 * (u * u - v * v)); };
  builder.grid(saddle, {-1, 0, -1, 1}, 20, 40, 3);
  builder.grid(saddle, {0, 1, -1, 1}, 20, 40, 7);
  const test::PatchedMesh mesh = builder.build();
  const SplineFaces faces = spline_faces(mesh.mesh, mesh.patches);
  EXPECT_EQ(faces.surface.patches.size(), 2u);
  EXPECT_FALSE(faces.surface.is_closed);
  EXPECT_EQ(faces.surface.edges.size(), 7u);
  const auto off = [&](const PatchPoint& p) {
    return std::abs(p.position.z() - saddle(p.position.x(), p.position.y()).z());
  };
  EXPECT_LT(largest_over(faces.surface, off), 2e-4);  // of a diameter of 2.9
}

TEST(SplineFaces, DoesNotDependOnUnitAndPlace) {
  const test::PatchedMesh torus = test::torus_of_patches(0.3, 3, 3, 12);
  test::PatchedMesh moved = torus;
  moved.mesh.positions *= 1e-3;
  moved.mesh.positions.rowwise() += Eigen::RowVector3d(0.5, -0.2, 0.1);
  const SplineFaces a = spline_faces(torus.mesh, torus.patches), b = spline_faces(moved.mesh, moved.patches);
  ASSERT_EQ(a.surface.patches.size(), b.surface.patches.size());
  for (std::size_t f = 0; f < a.surface.patches.size(); ++f) {
    Points expected = 1e-3 * a.surface.patches[f].control_points;
    expected.rowwise() += Eigen::RowVector3d(0.5, -0.2, 0.1);
    EXPECT_LT((b.surface.patches[f].control_points - expected).norm(), 1e-3 * 1e-5);
  }
}

template <typename Function>
void expect_refused(const Function& call, const std::string& words) {
  try {
    call();
    FAIL() << "not refused: " << words;
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }
}

TEST(SplineFaces, RefusesWhatHasNoFaces) {
  test::PatchedMesh torus = test::torus_of_patches(0.3, 3, 3, 6);
  expect_refused([&] { spline_faces(torus.mesh, {1, 2, 3}); }, "patch_of_triangle has 3 entries");
  SplineFacesOptions options;
  options.tolerance = 0;
  expect_refused([&] { spline_faces(torus.mesh, torus.patches, options); }, "tolerance");
  options = {};
  options.most_patches = 8;
  expect_refused([&] { spline_faces(torus.mesh, torus.patches, options); }, "9 B-spline faces");
  const std::vector<int> one(torus.patches.size(), 0);
  expect_refused([&] { spline_faces(torus.mesh, one); }, "closes without any curve");
  std::vector<int> hole = one;
  for (std::size_t f = 0; f < hole.size(); ++f)
    if (torus.patches[f] == 4) hole[f] = 1;
  expect_refused([&] { spline_faces(torus.mesh, hole); }, "handle");
  TriangleMesh turned = torus.mesh;
  turned.triangles.row(5).reverseInPlace();
  expect_refused([&] { spline_faces(turned, torus.patches); }, "");
}

TEST(SplineFaces, CanBeCancelled) {
  const test::PatchedMesh sphere = test::octant_sphere();
  int reports = 0;
  spline_faces(sphere.mesh, sphere.patches, {},
               Progress([&](std::string_view, double) { return ++reports > 0; }));
  ASSERT_GT(reports, 4);
  for (const int stop : {1, reports / 2, reports}) {
    int seen = 0;
    EXPECT_THROW(spline_faces(sphere.mesh, sphere.patches, {},
                              Progress([&](std::string_view, double) { return ++seen < stop; })),
                 Cancelled);
  }
}

}  // namespace
}  // namespace batten
