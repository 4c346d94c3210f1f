#include "batten/sketch/tools.hpp"

#include "models.hpp"
#include "tool_models.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/sketch/polyline_mesh.hpp"

namespace batten {
namespace {

using namespace strokes;
using Eigen::Vector3d;

TEST(DeleteCurve, UndoesWhatInsertionDivided) {
  PolylineMesh mesh = disc();
  insert(mesh, {polygon({-kX, kX}), false});
  insert(mesh, {polygon({-kY, kY}), false});
  edit(mesh, [](PolylineMesh& m) { return delete_curve(m, 2); });
  expect_counts(mesh, 2, 3, 2, 1, 0);  // as with the first chord alone
  edit(mesh, [](PolylineMesh& m) { return delete_curve(m, 1); });
  expect_counts(mesh, 2, 2, 1, 1, 0);  // the disc, with two seams again
}

// Where a curve is sharp on one side of a vertex alone, the vertex is needed to say so.
TEST(DeleteCurve, LeavesVerticesWhereSharpnessChanges) {
  PolylineMesh mesh = disc();
  insert(mesh, {polygon({-kX, kX}), false});
  insert(mesh, {polygon({-kY, kY}), false});
  const auto ends = mesh.edge(mesh.edges_of_curve(1).front()).vertices;
  edit(mesh, [&](PolylineMesh& m) { return set_curve_sharpness(m, 1, 1, ends); });
  edit(mesh, [](PolylineMesh& m) { return delete_curve(m, 2); });
  std::vector<double> sharpness;
  for (const int e : mesh.edges_of_curve(1)) sharpness.push_back(mesh.edge(e).sharpness);
  std::sort(sharpness.begin(), sharpness.end());
  EXPECT_EQ(sharpness, (std::vector<double>{0, 1}));
  EXPECT_EQ(mesh.broken_invariant(), "");
}

TEST(DeleteCurve, RefusesToLeaveCurvesHanging) {
  PolylineMesh mesh = disc();
  insert(mesh, {polygon({-kX, kX}), false});
  insert(mesh, {polygon({kO, kY}), false});  // ends on c1
  EXPECT_CONTAINS(refusal(mesh, [](PolylineMesh& m) { return delete_curve(m, 1); }), "c2 ends on c1");
  EXPECT_CONTAINS(refusal(mesh, [](PolylineMesh& m) { return delete_curve(m, 9); }), "no curve c9");
}

TEST(DeleteCurve, RefusesToMakeAFaceThatIsNoDisc) {
  // The two faces of a tube meet along both spines; with one spine less there would be an annulus.
  PolylineMesh mesh = tube();
  EXPECT_CONTAINS(refusal(mesh, [](PolylineMesh& m) { return delete_curve(m, 2); }), "on both sides");
}

TEST(CutHole, WithinAFaceTiesTheHoleToTheCorners) {
  PolylineMesh mesh;
  insert(mesh, {polygon({kO, kX, kX + kY, kY, kO}), true});
  const EditReport report = edit(
      mesh, [](PolylineMesh& m) { return cut_hole(m, circle(Vector3d(0.5, 0.5, 0), 0.2 * kX, 0.2 * kY)); });
  EXPECT_EQ(report.euler_change, -1);
  EXPECT_EQ(report.curves.size(), 5u);  // the rim and four ties (n = 4)
  expect_counts(mesh, 8, 12, 4, 2, 0);  // an annulus of four quads
}

TEST(CutHole, DrawnInEitherSenseIsTheSame) {
  for (const double sense : {1.0, -1.0}) {
    PolylineMesh mesh;
    insert(mesh, {polygon({kO, kX, kX + kY, kY, kO}), true});
    edit(mesh, [&](PolylineMesh& m) {
      return cut_hole(m, circle(Vector3d(0.5, 0.5, 0), 0.2 * kX, sense * 0.2 * kY));
    });
    expect_counts(mesh, 8, 12, 4, 2, 0);
  }
}

// A stroke need not lie on the fan of the curves of a face, but not off it by more than a third of its size.
TEST(CutHole, RefusesAStrokeFarFromEveryFace) {
  PolylineMesh mesh;
  insert(mesh, {polygon({kO, kX, kX + kY, kY, kO}), true});
  const auto cut = [](double height) {
    return [height](PolylineMesh& m) {
      return cut_hole(m, circle(Vector3d(0.5, 0.5, height), 0.2 * kX, 0.2 * kY));
    };
  };
  EXPECT_CONTAINS(refusal(mesh, cut(0.6)), "lies 0.6 from the nearest face, f0");
  edit(mesh, cut(0.2));
  expect_counts(mesh, 8, 12, 4, 2, 0);
}

TEST(CutHole, AcrossCurvesTakesAwayWhatLiesInside) {
  PolylineMesh mesh = disc();
  insert(mesh, {polygon({-kX, kX}), false});
  insert(mesh, {polygon({-kY, kY}), false});
  const EditReport report =
      edit(mesh, [](PolylineMesh& m) { return cut_hole(m, circle(kO, 0.3 * kX, 0.3 * kY)); });
  EXPECT_EQ(report.euler_change, -1);
  EXPECT_EQ(report.curves.size(), 1u);  // no ties (n = 0)
  expect_counts(mesh, 8, 12, 4, 2, 0);
}

TEST(GlueBorders, TubeBetweenTwoDiscsAndHandleOnOne) {
  // Two annuli glued at their holes: a tube with two borders.
  PolylineMesh mesh;
  insert(mesh, {polygon({kO, kX, kX + kY, kY, kO}), true});
  insert(mesh, {polygon({kZ, kX + kZ, kX + kY + kZ, kY + kZ, kZ}), true});
  for (const double z : {0.0, 1.0})
    edit(mesh,
         [&](PolylineMesh& m) { return cut_hole(m, circle(Vector3d(0.5, 0.5, z), 0.2 * kX, 0.2 * kY)); });
  EXPECT_EQ(mesh.counts().components, 2);
  EXPECT_EQ(mesh.counts().boundary_loops, 4);
  const Vector3d a(0.7, 0.5, 0), b(0.3, 0.5, 0);
  const EditReport report = edit(mesh, [&](PolylineMesh& m) {
    return glue_borders(m, {polygon({a, a + kZ}), false}, {polygon({b + kZ, b}), false}, std::nullopt);
  });
  EXPECT_EQ(report.euler_change, 0);
  EXPECT_EQ(mesh.broken_invariant(), "");
  EXPECT_EQ(mesh.counts().components, 1);
  EXPECT_EQ(mesh.counts().boundary_loops, 2);
  EXPECT_EQ(mesh.counts().genus, 0);
  // H fig. 5.5: two holes in one sheet, glued: a handle.
  PolylineMesh sheet;
  insert(sheet, {polygon({kO, 4 * kX, 4 * kX + 2 * kY, 2 * kY, kO}), true});
  insert(sheet, {polygon({2 * kX, 2 * kX + 2 * kY}), false});
  for (const double x : {1.0, 3.0})
    edit(sheet, [&](PolylineMesh& m) { return cut_hole(m, circle(Vector3d(x, 1, 0), 0.3 * kX, 0.3 * kY)); });
  edit(sheet, [&](PolylineMesh& m) {
    return glue_borders(m, {arc(Vector3d(2, 1, 0), -0.7 * kX, 0.7 * kZ, 0, kPi), false},
                        {arc(Vector3d(2, 1, 0), -1.3 * kX, 1.3 * kZ, 0, kPi), false}, std::nullopt);
  });
  EXPECT_EQ(sheet.broken_invariant(), "");
  EXPECT_EQ(sheet.counts().boundary_loops, 1);
  EXPECT_EQ(sheet.counts().genus, 1);
}

PolylineMesh straight_model(const Points& positions, std::vector<std::array<int, 4>> quads) {
  PolygonMesh cage;
  cage.positions = positions;
  for (const auto& quad : quads) {
    cage.corners.insert(cage.corners.end(), quad.begin(), quad.end());
    cage.offsets.push_back(static_cast<int>(cage.corners.size()));
  }
  return models::model_of_cage(cage, [&](int from, int to) {
    return polygon({Vector3d(positions.row(from)), Vector3d(positions.row(to))});
  });
}

/// The corners of two squares, one above the other.
Points two_squares() {
  Points positions(8, 3);
  positions << -1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1;
  return positions;
}

bool have_a_face(const PolylineMesh& mesh, int curve, int other) {
  return std::any_of(mesh.faces().begin(), mesh.faces().end(), [&](const SketchFace& face) {
    const auto has = [&](int c) {
      return std::any_of(face.sides.begin(), face.sides.end(),
                         [&](int side) { return mesh.edge(edge_of(side)).curve == c; });
    };
    return face.alive && has(curve) && has(other);
  });
}

// Two squares of four curves each, tied at two corners. The curves that are named bound one face of the tube,
// straight or twisted, in whatever order they are named; without names the tube is straight.
TEST(GlueBorders, CurvesNameTheHalvesThatFaceEachOther) {
  const PolylineMesh squares = straight_model(two_squares(), {{0, 1, 2, 3}, {4, 5, 6, 7}});
  const Points& p = two_squares();
  const DrawnStroke first{polygon({Vector3d(p.row(1)), Vector3d(p.row(5))}), false},
      second{polygon({Vector3d(p.row(3)), Vector3d(p.row(7))}), false};
  const auto glued = [&](const std::optional<std::array<int, 2>>& halves) {
    PolylineMesh mesh = squares;
    edit(mesh, [&](PolylineMesh& m) { return glue_borders(m, first, second, halves); });
    EXPECT_EQ(mesh.broken_invariant(), "");
    EXPECT_EQ(mesh.counts().boundary_loops, 0);
    EXPECT_EQ(mesh.counts().genus, 0);
    return mesh;
  };
  // c1 and c2 lead from corner 1 over 2 to 3; above them c5 and c6, on the other side c7 and c4.
  for (const auto& halves : {std::optional<std::array<int, 2>>(), std::optional(std::array{1, 5}),
                             std::optional(std::array{5, 1}), std::optional(std::array{4, 0})}) {
    const PolylineMesh mesh = glued(halves);
    EXPECT_TRUE(have_a_face(mesh, 1, 5));
    EXPECT_FALSE(have_a_face(mesh, 1, 7));
  }
  for (const auto& halves : {std::array{1, 7}, std::array{7, 1}, std::array{0, 6}}) {
    const PolylineMesh mesh = glued(halves);
    EXPECT_TRUE(have_a_face(mesh, 1, 7));
    EXPECT_FALSE(have_a_face(mesh, 1, 5));
  }
}

// The two borders of one tube glued to each other around its outside: straight that is a torus, twisted it
// would be a bottle of Klein.
TEST(GlueBorders, RefusesNamesThatMakeTheSurfaceOneSided) {
  const PolylineMesh tube =
      straight_model(two_squares(), {{0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}});
  const Vector3d out = (kX + kY) / (2 * std::sqrt(2.0));
  const DrawnStroke first{arc(Vector3d(-1, -1, 0.5), -0.5 * kZ, -out, 0, kPi), false},
      second{arc(Vector3d(1, 1, 0.5), -0.5 * kZ, out, 0, kPi), false};
  const auto glue = [&](std::array<int, 2> halves) {
    return [&, halves](PolylineMesh& m) { return glue_borders(m, first, second, halves); };
  };
  PolylineMesh mesh = tube;
  // c0 leads from corner 0 to 1, c2 back above it, c9 above the opposite side.
  EXPECT_CONTAINS(refusal(mesh, glue({0, 9})), "one-sided");
  edit(mesh, glue({0, 2}));
  EXPECT_EQ(mesh.broken_invariant(), "");
  EXPECT_EQ(mesh.counts().boundary_loops, 0);
  EXPECT_EQ(mesh.counts().genus, 1);
}

TEST(GlueBorders, RefusesOneBorderAndCurvesInside) {
  PolylineMesh mesh = tube();
  const auto glue = [](const Points& first, const Points& second) {
    return [=](PolylineMesh& m) {
      return glue_borders(m, {first, false}, {second, false}, std::nullopt, {.snap = 0.02});
    };
  };
  EXPECT_CONTAINS(refusal(mesh, glue(polygon({kY, -kY}), polygon({kX, -kX}))), "same border");
  EXPECT_CONTAINS(refusal(mesh, glue(polygon({0.5 * kY, -kY}), polygon({kX, -kX}))),
                  "starts 0.5 from the nearest curve");
}

TEST(SkinProfiles, GivesTwoFacesForEachSection) {
  for (const int n : {2, 3, 5}) {
    const PolylineMesh mesh = tube(n);
    // V = 2n, E = 2n + 2(n − 1), F = 2(n − 1); χ = 0, two borders.
    expect_counts(mesh, 2 * n, 2 * n + 2 * (n - 1), 2 * (n - 1), 2, 0);
  }
}

TEST(SkinProfiles, ProfilesDrawnInAnySenseAndFromAnyPointAreTheSame) {
  PolylineMesh mesh;
  edit(mesh, [](PolylineMesh& m) {
    return skin_profiles(
        m, {circle(kO, kX, kY), circle(kZ, kY, kX), circle(2 * kZ, -kX, kY)},
        {DrawnStroke{polygon({kX, kX + 2 * kZ}), false}, DrawnStroke{polygon({2 * kZ - kX, -kX}), false}});
  });
  expect_counts(mesh, 6, 10, 4, 2, 0);
  // Faces lie on one side of the plane of the spines: halves were not crossed.
  for (const SketchFace& face : mesh.faces()) {
    if (!face.alive) continue;
    double least = 1, most = -1;
    for (const int side : face.sides) {
      const Points& points = mesh.edge(edge_of(side)).polyline->points();
      least = std::min(least, points.col(1).minCoeff());
      most = std::max(most, points.col(1).maxCoeff());
    }
    EXPECT_TRUE(least > -1e-3 || most < 1e-3) << least << " " << most;
  }
}

TEST(SkinProfiles, RefusesASpineThatMissesAProfile) {
  PolylineMesh mesh;
  const std::string text = refusal(mesh, [](PolylineMesh& m) {
    return skin_profiles(
        m, {circle(kO, kX, kY), circle(kZ, 0.5 * kX, 0.5 * kY)},
        {DrawnStroke{polygon({kX, kX + kZ}), false}, DrawnStroke{polygon({-kX, -0.5 * kX + kZ}), false}},
        {.snap = 0.05});
  });
  EXPECT_CONTAINS(text, "passes profile 2 at a distance of 0.5");
}

TEST(MirrorCurve, ClosesACurveOverItsChord) {
  // Half a circle over the diameter of a disc; the image is the other half, in the plane of the curve.
  PolylineMesh mesh = disc();
  insert(mesh, {arc(kO, kX, kZ, 0, kPi), false});
  const EditReport report = edit(mesh, [](PolylineMesh& m) { return mirror_curve(m, 1, std::nullopt); });
  EXPECT_EQ(report.euler_change, 1);  // it closes the back
  EXPECT_EQ(mesh.counts().boundary_loops, 0);
  for (const int e : mesh.edges_of_curve(report.curves.front())) {
    const Points& points = mesh.edge(e).polyline->points();
    EXPECT_LT(points.col(2).maxCoeff(), 1e-6);
    for (Eigen::Index i = 0; i < points.rows(); ++i) EXPECT_NEAR(points.row(i).norm(), 1, 2e-4);
  }
}

TEST(MirrorStroke, MakesAFirstBoundaryOfAHalf) {
  PolylineMesh mesh;
  edit(mesh, [](PolylineMesh& m) {
    return mirror_stroke(m, {arc(kO, kX, kY, 0, kPi), false}, Points(polygon({kX, -kX}, 1)));
  });
  expect_counts(mesh, 2, 2, 1, 1, 0);
  for (const SketchEdge& edge : mesh.edges())
    for (Eigen::Index i = 0; i < edge.polyline->n_points(); ++i)
      EXPECT_NEAR(edge.polyline->points().row(i).norm(), 1, 2e-4);
}

// Half an oval that begins 0.1 above the axis, and one that ends there: five times the snapping distance.
TEST(MirrorStroke, RefusesAStrokeThatDoesNotReachTheAxis) {
  InsertOptions options;
  options.snap = 0.02;
  for (const bool at_start : {true, false}) {
    Points half = arc(kO, kX, kY, std::asin(0.1), kPi, 100);
    if (!at_start) half = Points(half.colwise().reverse());
    PolylineMesh mesh;
    const std::string text = refusal(mesh, [&](PolylineMesh& m) {
      return mirror_stroke(m, {half, false}, Points(polygon({kX, -kX}, 1)), options);
    });
    EXPECT_CONTAINS(text, at_start ? "starts 0.1 from the axis" : "ends 0.1 from the axis");
  }
}

TEST(Sharpness, TagsEveryPieceOfACurve) {
  PolylineMesh mesh = octahedral_sphere();
  edit(mesh, [](PolylineMesh& m) { return set_curve_sharpness(m, 1, 1); });
  int sharp = 0;
  for (const SketchEdge& edge : mesh.edges()) sharp += edge.alive && edge.sharpness == 1 ? 1 : 0;
  EXPECT_EQ(sharp, 4);
  EXPECT_CONTAINS(refusal(mesh, [](PolylineMesh& m) { return set_curve_sharpness(m, 1, 2); }),
                  "0 (smooth) to 1 (sharp)");
}

TEST(Sharpness, TagsAPartBetweenTwoVertices) {
  PolylineMesh mesh = octahedral_sphere();
  const std::vector<int> edges = mesh.edges_of_curve(1);
  const auto [from, to] = mesh.edge(edges.front()).vertices;
  edit(mesh, [&, f = from, t = to](PolylineMesh& m) {
    return set_curve_sharpness(m, 1, 1, std::array{f, t});
  });
  for (const int e : edges) EXPECT_EQ(mesh.edge(e).sharpness, e == edges.front() ? 1 : 0);
  EXPECT_CONTAINS(refusal(mesh,
                          [](PolylineMesh& m) {
                            return set_curve_sharpness(m, 1, 1, std::array{0, 999});
                          }),
                  "v999");
}

}  // namespace
}  // namespace batten
