#include "batten/subdivision/step.hpp"

#include "subdivision/limit_cages.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/subdivision/bspline_surface.hpp"
#include "batten/subdivision/subdivide.hpp"

namespace batten {
namespace {

using Row = Eigen::RowVector3d;
using cages::creased_box;
using cages::quarter_point_error;
using cages::random_torus;

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

// What is in the file is the limit surface: every patch that is exact, to the eight decimals of millimetres.
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
    EXPECT_LT(quarter_point_error(cage, back), 1e-8);
  }
}

TEST_F(Step, IgesHoldsTheSameSolid) {
  const std::string path = testing::TempDir() + "batten_step_test.igs";
  for (const ControlCage& cage : {cages::cube(), cages::cube_with_sharp_edges()}) {
    const BsplineSurface surface = limit_bsplines(cage);
    const std::string text = format_iges(surface, {.millimetres_per_unit = 10, .name = "block"});
    EXPECT_EQ(text,
              format_iges(surface, {.millimetres_per_unit = 10, .name = "block"}));  // no date, no number
    EXPECT_EQ(text, format_cad(CadFormat::Iges, surface, {.millimetres_per_unit = 10, .name = "block"}));
    std::ofstream(path) << text;
    const StepModel model = read_iges(path);
    EXPECT_EQ(model.n_solids, 1);
    EXPECT_EQ(model.n_faces, static_cast<int>(surface.patches.size()));
    EXPECT_EQ(model.n_edges, static_cast<int>(surface.edges.size()));
    EXPECT_TRUE(model.is_valid);
    EXPECT_TRUE(model.is_closed);
    const double expected = 1000 * limit_volume(cage);
    EXPECT_NEAR(model.volume, expected, 5e-4 * expected);
  }
  std::ofstream(path) << "no IGES";
  EXPECT_THROW(read_iges(path), InvalidInput);
  std::filesystem::remove(path);
}

TEST_F(Step, FacesAndEdgesHaveTheirNames) {
  const BsplineSurface surface = limit_bsplines(cages::cube());
  StepOptions options;
  options.face_names = {"", "left", "d\xc3\xa9j\xc3\xa0 vu's"};
  options.edge_names = {"first"};
  const std::string text = format_step(surface, options);
  EXPECT_NE(text.find("ADVANCED_FACE('left'"), std::string::npos);
  EXPECT_NE(text.find("ADVANCED_FACE('d__j__ vu_s'"), std::string::npos);
  EXPECT_NE(text.find("EDGE_CURVE('first'"), std::string::npos);
  EXPECT_NE(text.find("ADVANCED_FACE(''"), std::string::npos);
}

TEST(CadFormat, IsToldByTheExtension) {
  EXPECT_EQ(cad_format("step"), CadFormat::Step);
  EXPECT_EQ(cad_format("stp"), CadFormat::Step);
  EXPECT_EQ(cad_format("iges"), CadFormat::Iges);
  EXPECT_EQ(cad_format("igs"), CadFormat::Iges);
  EXPECT_FALSE(cad_format("ply"));
}

TEST_F(Step, WritesOpenSurfacesAsShellsAndSeveralComponentsAsSeveralBodies) {
  // A solid is bounded by closed shells (ISO 10303-42); readers mend what says otherwise, so the text is
  // asked.
  const std::string text = format_step(limit_bsplines(creased_box()));
  EXPECT_NE(text.find("OPEN_SHELL"), std::string::npos);
  EXPECT_EQ(text.find("MANIFOLD_SOLID_BREP"), std::string::npos);
  const StepModel open = read_step(text);
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
  EXPECT_EQ(StepOptions{.millimetres_per_unit = 0}.problem(), "millimetres_per_unit must be > 0, got 0");
  EXPECT_FALSE(StepOptions().problem());
  EXPECT_THROW(format_step(cube, {.millimetres_per_unit = 0}), InvalidInput);
  EXPECT_THROW(format_step(cube, {.millimetres_per_unit = 1e-6}), InvalidInput) << "edges of 1e-6 mm";
}

}  // namespace
}  // namespace batten
