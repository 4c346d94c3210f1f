#include "batten/sketch/tools.hpp"

#include "tool_models.hpp"

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
