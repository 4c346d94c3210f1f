#include "batten/subdivision/bspline_surface.hpp"

#include "subdivision/cages.hpp"

#include <algorithm>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/subdivision/step.hpp"
#include "batten/subdivision/subdivide.hpp"

namespace batten {
namespace {

using Row = Eigen::RowVector3d;

ControlCage random_torus() {
  ControlCage cage = cages::torus(6, 5);
  Random random(3);
  for (Eigen::Index v = 0; v < 30; ++v)
    for (int k = 0; k < 3; ++k) cage.mesh.positions(v, k) += 0.1 * random.normal();
  return cage;
}

/// Two cubes glued along a face and open on one side, with a dart, a crease and a sharp corner.
ControlCage creased_box() {
  ControlCage cage = cages::cube();
  cage.mesh.positions.conservativeResize(12, 3);
  cage.mesh.positions.bottomRows(4) << -1, -1, 2.5, 1, -1, 2.5, 1.3, 1, 2.5, -1, 1, 2.2;
  cage.mesh.corners.erase(cage.mesh.corners.begin() + 4, cage.mesh.corners.begin() + 8);  // the top
  cage.mesh.offsets.pop_back();
  cages::add_face(cage.mesh, {4, 5, 9, 8});
  cages::add_face(cage.mesh, {5, 6, 10, 9});
  cages::add_face(cage.mesh, {6, 7, 11, 10});
  cages::add_face(cage.mesh, {7, 4, 8, 11});
  cage.sharp_edges = {
      {0, 1, kInfinitelySharp}, {1, 2, kInfinitelySharp}, {2, 6, kInfinitelySharp}, {4, 8, kInfinitelySharp}};
  cage.sharp_vertices = {{3, kInfinitelySharp}};
  return cage;
}

/// The largest distance of patch points at multiples of 1/4 from the limit points of the mesh that has
/// exactly these places as vertices, over the diameter. They come from OpenSubdiv's limit masks, not from its
/// patches.
double quarter_point_error(const ControlCage& cage, const BsplineSurface& surface) {
  const SubdividedSurface fine = subdivide(cage, {.levels = surface.levels + 2, .limit = true});
  double worst = 0;
  for (const BsplinePatch& patch : surface.patches)
    for (int j = 0; j <= 4; ++j)
      for (int i = 0; i <= 4; ++i) {
        const Row p = evaluate(patch, 0.25 * i, 0.25 * j).position.transpose();
        worst = std::max(worst, (fine.limit_positions.rowwise() - p).rowwise().norm().minCoeff());
      }
  return worst / bounding_box_diagonal(cage.mesh.positions);
}

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

/// The volume of the limit surface from meshes of limit points, extrapolated: their error is of second order
/// in the length of edges, and linear edges between exact points are all that is wrong with them.
double limit_volume(const ControlCage& cage) {
  const auto at_level = [&](int levels) {
    const SubdividedSurface surface = subdivide(cage, {.levels = levels, .limit = true});
    const Eigen::Index n = surface.cage.mesh.n_faces();
    Triangles triangles(2 * n, 3);
    for (Eigen::Index f = 0; f < n; ++f) {
      const int* c = &surface.cage.mesh.corners[static_cast<size_t>(4 * f)];
      // Alternate diagonals would not matter: the error is that of bilinear quads up to third order.
      triangles.row(2 * f) << c[0], c[1], c[2];
      triangles.row(2 * f + 1) << c[0], c[2], c[3];
    }
    return enclosed_volume(surface.limit_positions, triangles);
  };
  const double coarse = at_level(4), fine = at_level(5);
  return fine + (fine - coarse) / 3;
}

class Step : public testing::Test {
 protected:
  void SetUp() override {
    if (!has_step()) GTEST_SKIP() << "this build has no Open Cascade";
  }
};

// The acceptance of CAD: one valid closed shell, gaps of at most 1e-6 of the diameter, the volume within 0.05
// % of the limit surface's, all read back by Open Cascade from the text.
TEST_F(Step, ReadsBackAsOneValidClosedShellOfTheRightVolume) {
  for (const ControlCage& cage : {cages::cube(), cages::cube_with_sharp_edges(), random_torus(),
                                  cages::prism(5), cages::tetrahedron()}) {
    const BsplineSurface surface = limit_bsplines(cage);
    const StepModel model = read_step(format_step(surface));
    EXPECT_EQ(model.n_solids, 1);
    EXPECT_EQ(model.n_shells, 1);
    EXPECT_EQ(model.n_faces, static_cast<int>(surface.patches.size()));
    EXPECT_EQ(model.n_edges, static_cast<int>(surface.edges.size()));
    EXPECT_EQ(model.n_vertices, static_cast<int>(surface.vertices.rows()));
    EXPECT_TRUE(model.is_valid);
    EXPECT_TRUE(model.is_closed);
    EXPECT_LT(model.largest_gap, 1e-6 * model.diameter);
    const double expected = 1e9 * limit_volume(cage);  // metres to millimetres
    EXPECT_NEAR(model.volume, expected, 5e-4 * expected);
  }
}

// What is in the file is the limit surface: every patch that is exact, to 1e-12 of the diameter.
TEST_F(Step, KeepsEveryRegularPatchExact) {
  for (const ControlCage& cage : {random_torus(), cages::cube_with_sharp_edges()}) {
    const BsplineSurface surface = limit_bsplines(cage);
    const StepModel model = read_step(format_step(surface, {.millimetres_per_unit = 10}));
    ASSERT_EQ(model.patches.size(), surface.patches.size());
    BsplineSurface back = surface;
    for (size_t f = 0; f < back.patches.size(); ++f) {
      back.patches[f].knots_u = model.patches[f].knots_u;
      back.patches[f].knots_v = model.patches[f].knots_v;
      back.patches[f].control_points = model.patches[f].control_points / 10;
    }
    EXPECT_LT(quarter_point_error(cage, back), 1e-12);
  }
}

TEST_F(Step, WritesOpenSurfacesAsShellsAndSeveralComponentsAsSeveralBodies) {
  const StepModel open = read_step(format_step(limit_bsplines(creased_box())));
  EXPECT_EQ(open.n_solids, 0);
  EXPECT_EQ(open.n_shells, 1);
  EXPECT_TRUE(open.is_valid);
  EXPECT_FALSE(open.is_closed);
  ControlCage two = cages::cube();
  const ControlCage other = cages::cube();
  two.mesh.positions.conservativeResize(16, 3);
  two.mesh.positions.bottomRows(8) = other.mesh.positions.rowwise() + Row(5, 0, 0);
  for (const int c : other.mesh.corners) two.mesh.corners.push_back(c + 8);
  for (int f = 0; f < 6; ++f) two.mesh.offsets.push_back(two.mesh.offsets.back() + 4);
  const StepModel bodies = read_step(format_step(limit_bsplines(two)));
  EXPECT_EQ(bodies.n_solids, 2);
  EXPECT_TRUE(bodies.is_closed);
  EXPECT_TRUE(bodies.is_valid);
}

TEST_F(Step, TurnsSolidsThatAreInsideOut) {
  ControlCage cage = cages::cube();
  for (size_t f = 0; f < 6; ++f)
    std::reverse(cage.mesh.corners.begin() + static_cast<long>(4 * f),
                 cage.mesh.corners.begin() + static_cast<long>(4 * f) + 4);
  const StepModel model = read_step(format_step(limit_bsplines(cage)));
  EXPECT_TRUE(model.is_valid);
  EXPECT_GT(model.volume, 0);
}

TEST_F(Step, DeclaresMillimetresAndIsTheSameTextTwice) {
  const BsplineSurface surface = limit_bsplines(cages::cube());
  const std::string text = format_step(surface, {.name = "Würfel 'A'"});
  EXPECT_NE(text.find("SI_UNIT(.MILLI.,.METRE.)"), std::string::npos);
  EXPECT_EQ(text.substr(0, 13), "ISO-10303-21;");
  EXPECT_TRUE(format_step(surface, {.name = "Würfel 'A'"}) == text);
}

TEST_F(Step, RefusesWhatIsNoStepFile) {
  EXPECT_THROW(read_step(""), InvalidInput);
  EXPECT_THROW(read_step("solid cube"), InvalidInput);
  EXPECT_THROW(read_step("ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n"),
               InvalidInput);
  EXPECT_THROW(format_step(BsplineSurface()), InvalidInput);
  const BsplineSurface cube = limit_bsplines(cages::cube());
  EXPECT_THROW(format_step(cube, {.millimetres_per_unit = 0}), InvalidInput);
  EXPECT_THROW(format_step(cube, {.millimetres_per_unit = 1e-6}), InvalidInput) << "edges of 1e-6 mm";
}

}  // namespace
}  // namespace batten
