#include "sanitizers.hpp"
#include "tool_models.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/sketch/polyline_mesh.hpp"
#include "batten/sketch/tools.hpp"

namespace batten {
namespace {

using namespace strokes;
using Eigen::Vector3d;

TEST(InsertCurve, FirstBoundaryIsADisc) {
  // Two vertices because an edge has two ends (H 3.3), and one face: χ = 1.
  expect_counts(disc(), 2, 2, 1, 1, 0);
}

TEST(InsertCurve, SquareDrawnInOneStrokeHasItsCorners) {
  PolylineMesh mesh;
  insert(mesh, {polygon({kO, kX, kX + kY, kY, kO}), true});
  expect_counts(mesh, 4, 4, 1, 1, 0);
  for (const SketchVertex& vertex : mesh.vertices()) {
    EXPECT_FALSE(vertex.is_seam);
    // The corners of the unit square, exactly where they were drawn.
    EXPECT_LT((vertex.position - vertex.position.array().round().matrix()).norm(), 1e-12);
  }
}

TEST(InsertCurve, ChordDividesTheFaceAndSeamsVanish) {
  PolylineMesh mesh = disc();
  const EditReport report = insert(mesh, {polygon({-kX, kX}), false});
  EXPECT_EQ(report.euler_change, 0);
  expect_counts(mesh, 2, 3, 2, 1, 0);
  for (const SketchVertex& vertex : mesh.vertices()) EXPECT_FALSE(vertex.is_seam);
}

TEST(InsertCurve, StrokeOverSeveralFacesDividesEachOfThem) {
  // H fig. 5.7: from border to border across another curve: two faces become four.
  PolylineMesh mesh = disc();
  insert(mesh, {polygon({-kX, kX}), false});
  insert(mesh, {polygon({-kY, kY}), false});
  expect_counts(mesh, 5, 8, 4, 1, 0);
}

TEST(InsertCurve, ThreeGreatCirclesMakeAClosedSphereOfEightTriangles) {
  const PolylineMesh mesh = octahedral_sphere();
  expect_counts(mesh, 6, 12, 8, 0, 0);  // the octahedron
  for (const SketchFace& face : mesh.faces()) EXPECT_EQ(face.sides.size(), face.alive ? 3u : 0u);
  // The polylines stay on the unit sphere: chords sag by 1e-5 of the length, the fit is as good.
  for (const SketchEdge& edge : mesh.edges()) {
    if (!edge.alive) continue;
    for (int k = 0; k <= 50; ++k)
      EXPECT_NEAR(edge.polyline->at(edge.polyline->length() * k / 50).norm(), 1, 2e-4);
  }
}

TEST(InsertCurve, MetCurvesKeepTheirShapeAndHoldTheStroke) {
  // The stroke passes the old curve at a distance of 0.02 and is drawn onto it; the old curve does not move.
  PolylineMesh mesh = disc();
  insert(mesh, {polygon({-kX, kX}), false});
  insert(mesh, {polygon({-kY + 0.02 * kZ, kY + 0.02 * kZ}), false}, {.snap = 0.05});
  expect_counts(mesh, 5, 8, 4, 1, 0);
  for (const SketchVertex& vertex : mesh.vertices())
    EXPECT_LT(std::abs(vertex.position.z()), 1e-9);  // removed ones lie at the origin
}

TEST(InsertCurve, EndsNearAVertexSnapToIt) {
  PolylineMesh mesh;
  insert(mesh, {polygon({kO, kX, kX + kY, kY, kO}), true});
  insert(mesh, {polygon({Vector3d(0.01, -0.005, 0), Vector3d(0.99, 1.01, 0)}), false}, {.snap = 0.03});
  expect_counts(mesh, 4, 5, 2, 1, 0);  // the diagonal, from corner to corner
}

TEST(InsertCurve, StrokeOverAnOpeningClosesIt) {
  PolylineMesh mesh = tube();
  expect_counts(mesh, 4, 6, 2, 2, 0);
  const EditReport report = insert(mesh, {polygon({kY, -kY}), false});
  EXPECT_EQ(report.euler_change, 1);
  EXPECT_EQ(mesh.counts().boundary_loops, 1);
  insert(mesh, {polygon({kY + kZ, kZ - kY}), false});
  EXPECT_EQ(mesh.counts().boundary_loops, 0);
  EXPECT_EQ(mesh.counts().genus, 0);
  EXPECT_EQ(mesh.broken_invariant(), "");
}

TEST(InsertCurve, SideCanBeNamedWhereBothFit) {
  // A stroke over a square may divide its face or close its back.
  for (const Into into : {Into::Face, Into::Opening}) {
    PolylineMesh mesh;
    insert(mesh, {polygon({kO, kX, kX + kY, kY, kO}), true});
    const EditReport report = insert(mesh, {polygon({kO, kZ, kX + kZ, kX}), false}, {.into = into});
    EXPECT_EQ(report.euler_change, into == Into::Opening ? 1 : 0);
    EXPECT_EQ(mesh.counts().faces, into == Into::Opening ? 3 : 2);
    EXPECT_EQ(mesh.counts().boundary_loops, into == Into::Opening ? 0 : 1);
    EXPECT_EQ(mesh.broken_invariant(), "");
  }
}

TEST(InsertCurve, SecondBoundaryFarAwayIsAnotherComponent) {
  PolylineMesh mesh = disc();
  insert(mesh, circle(3 * kZ, kX, kY));
  EXPECT_EQ(mesh.counts().components, 2);
  EXPECT_EQ(mesh.counts().boundary_loops, 2);
}

TEST(InsertCurve, RefusalsNameTheCurveAndTheDistance) {
  PolylineMesh mesh = disc();
  const auto insertion = [](const DrawnStroke& stroke, double snap) {
    return [stroke, snap](PolylineMesh& m) { return insert_curve(m, stroke, {.snap = snap}); };
  };
  // 0.3 short of the border at one end.
  std::string text = refusal(mesh, insertion({polygon({-0.7 * kX, kX}), false}, 0.01));
  EXPECT_CONTAINS(text, "starts 0.3 from the nearest curve, c0");
  EXPECT_CONTAINS(text, "0.315");  // 5 % more than 0.3
  text = refusal(mesh, insertion({polygon({-kX, 0.6 * kX}), false}, 0.01));
  EXPECT_CONTAINS(text, "ends 0.4 from the nearest curve, c0");
  // Within a face, meeting nothing.
  text = refusal(mesh, insertion(circle(kO, 0.3 * kX, 0.3 * kY), 0.01));
  EXPECT_CONTAINS(text, "hole");
  EXPECT_CONTAINS(text, "0.7 away");
  // Rule 2 of H 5.1.1: c1 is passed at a distance of nearly 0.2 (the tip is rounded off) although it lies on
  // the way.
  insert(mesh, {polygon({-kX, kX}), false});
  text = refusal(mesh, insertion({polygon({-kY, 0.2 * kZ, kY}, 50), false}, 0.05));
  EXPECT_CONTAINS(text, "passes c1 at a distance of 0.196");
  // Along a curve.
  text = refusal(mesh, insertion({polygon({-kX + 0.005 * kY, kX + 0.005 * kY}), false}, 0.02));
  EXPECT_CONTAINS(text, "runs along c1");
}

// Ribs over one outline, as of a seat or a wing: each begins and ends on it, and the outermost bound faces of
// two corners. Whatever the order, the model is the same: as many vertices, edges and faces, and the same
// lengths.
TEST(InsertCurve, ParallelRibsInAnyOrderMakeOneModel) {
  const auto rim = [](double t) { return Vector3d(std::cos(t), std::sin(t), 0.3 * std::cos(2 * t)); };
  std::vector<DrawnStroke> ribs;
  for (const double y : {-0.8, -0.45, 0.0, 0.3, 0.7}) {
    const double t = std::asin(y);
    Points points(41, 3);
    for (Eigen::Index i = 0; i <= 40; ++i) {
      const double u = static_cast<double>(i) / 40;
      points.row(i) = ((1 - u) * rim(kPi - t) + u * rim(t) + 0.4 * u * (1 - u) * kZ).transpose();
    }
    ribs.push_back({points, false});
  }
  Points outline(160, 3);
  for (Eigen::Index i = 0; i < 160; ++i)
    outline.row(i) = rim(2 * kPi * static_cast<double>(i) / 160 + 0.1).transpose();
  const auto lengths = [](const PolylineMesh& mesh) {
    std::vector<double> all;
    for (const auto& edge : mesh.edges())
      if (edge.alive) all.push_back(edge.polyline->length());
    std::sort(all.begin(), all.end());
    return all;
  };
  std::vector<double> first;
  std::vector<std::size_t> order{0, 1, 2, 3, 4};
  int n_orders = 0;
  do {
    PolylineMesh mesh;
    insert(mesh, {outline, true});
    for (const std::size_t k : order) insert(mesh, ribs[k]);
    const std::vector<double> now = lengths(mesh);
    ASSERT_EQ(now.size(), 15U);  // ten pieces of the outline and the ribs
    EXPECT_EQ(std::count_if(mesh.faces().begin(), mesh.faces().end(), [](const auto& f) { return f.alive; }),
              6);
    if (first.empty()) first = now;
    for (std::size_t k = 0; k < now.size(); ++k) ASSERT_NEAR(now[k], first[k], 1e-4);
  } while (++n_orders < test::repeated(120, 12) && std::next_permutation(order.begin(), order.end()));
}

TEST(InsertCurve, BadStrokesAreRefused) {
  PolylineMesh mesh;
  const auto refused = [&](const Points& points, bool closed) {
    return refusal(mesh, [&](PolylineMesh& m) { return insert_curve(m, {points, closed}, {}); });
  };
  EXPECT_CONTAINS(refused(Points(0, 3), true), "no points");
  EXPECT_CONTAINS(refused(Points::Zero(1, 3), true), "no length");
  EXPECT_CONTAINS(refused(Points::Ones(50, 3), true), "no length");
  Points nan = circle(kO, kX, kY).points;
  nan(7, 1) = std::nan("");
  EXPECT_CONTAINS(refused(nan, true), "point 7");
  EXPECT_CONTAINS(refused(polygon({kO, kX}), false), "closed curve");
  EXPECT_CONTAINS(refused(Points(1e200 * circle(kO, kX, kY).points), true), "1e100");
  // A figure of eight.
  Points eight(100, 3);
  for (int i = 0; i < 100; ++i) {
    const double t = 2 * kPi * i / 100;
    eight.row(i) << std::sin(t), std::sin(2 * t), 0;
  }
  EXPECT_CONTAINS(refused(eight, true), "meets itself");
}

TEST(InsertCurve, MillionPointsAreThinnedToTheSameCurve) {
  PolylineMesh mesh;
  insert(mesh, circle(kO, kX, kY, 1000000));
  for (const SketchEdge& edge : mesh.edges())
    for (Eigen::Index i = 0; i < edge.polyline->n_points(); ++i)
      EXPECT_NEAR(edge.polyline->points().row(i).norm(), 1, 1e-4);
}

TEST(InsertCurve, SnappingFartherThanTheStrokeIsToldAsSuch) {
  PolylineMesh mesh;
  insert(mesh, circle(kO, kX, kY));
  InsertOptions wide;
  wide.snap = 1000;
  const std::string sentence = refusal(mesh, [&](PolylineMesh& m) {
    return insert_curve(m, {polygon({kX, kZ, -kX}), false}, wide);
  });
  EXPECT_CONTAINS(sentence, "within the snapping distance of 1e+03 both of its ends are one place");
  EXPECT_CONTAINS(sentence, "smaller snapping distance");
}

TEST(InsertCurve, OptionsNameWhatIsWrong) {
  PolylineMesh mesh = disc();
  const auto expect_refused = [&](double InsertOptions::*field, double value, const char* name) {
    InsertOptions options;
    options.*field = value;
    const std::string problem = options.problem().value_or("none");
    EXPECT_EQ(problem.find(std::string(name) + " must "), 0U) << problem;
    EXPECT_CONTAINS(
        refusal(mesh, [&](PolylineMesh& m) { return insert_curve(m, circle(kO, kX, kZ), options); }),
        problem);
  };
  expect_refused(&InsertOptions::snap, -0.1, "snap");
  expect_refused(&InsertOptions::snap, std::nan(""), "snap");
  expect_refused(&InsertOptions::snap_factor, 0, "snap_factor");
  expect_refused(&InsertOptions::reach_factor, -1, "reach_factor");
  expect_refused(&InsertOptions::sharpness, 1.5, "sharpness");
  expect_refused(&InsertOptions::sharpness, -0.5, "sharpness");
  EXPECT_EQ((InsertOptions{.snap = 0.1, .sharpness = 1}.problem()), std::nullopt);
}

}  // namespace
}  // namespace batten
