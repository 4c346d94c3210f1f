#include "batten/sketch/tools.hpp"

#include "strokes.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/sketch/polyline_mesh.hpp"

namespace batten {
namespace {

using namespace strokes;
using Eigen::Vector3d;

EditReport insert(PolylineMesh& mesh, const DrawnStroke& stroke, const InsertOptions& options = {}) {
  return edit(mesh, [&](PolylineMesh& m) { return insert_curve(m, stroke, options); });
}

/// The message of a refusal; the model must be as it was.
std::string refusal(PolylineMesh& mesh, const std::function<EditReport(PolylineMesh&)>& tool) {
  const PolylineMesh before = mesh;
  try {
    edit(mesh, tool);
  } catch (const RefusedEdit& refused) {
    EXPECT_TRUE(mesh == before) << "a refused edit changed the model";
    EXPECT_FALSE(refused.reason().empty());
    EXPECT_FALSE(refused.remedy().empty());
    return refused.what();
  }
  return "not refused";
}

#define EXPECT_CONTAINS(text, part) EXPECT_NE(std::string(text).find(part), std::string::npos) << (text)

void expect_counts(const PolylineMesh& mesh, int vertices, int edges, int faces, int borders, int genus) {
  EXPECT_EQ(mesh.broken_invariant(), "");
  const SketchCounts counts = mesh.counts();
  EXPECT_EQ(counts.vertices, vertices);
  EXPECT_EQ(counts.edges, edges);
  EXPECT_EQ(counts.faces, faces);
  EXPECT_EQ(counts.boundary_loops, borders);
  EXPECT_EQ(counts.genus, genus);
}

PolylineMesh disc() {
  PolylineMesh mesh;
  insert(mesh, circle(kO, kX, kY));
  return mesh;
}

/// Three great circles (H fig. 7.7).
PolylineMesh octahedral_sphere() {
  PolylineMesh mesh = disc();
  insert(mesh, circle(kO, kX, kZ));
  insert(mesh, circle(kO, kY, kZ));
  return mesh;
}

/// A tube of radius 1 along z.
PolylineMesh tube(int n_profiles = 2) {
  PolylineMesh mesh;
  std::vector<DrawnStroke> profiles;
  for (int k = 0; k < n_profiles; ++k) profiles.push_back(circle(k * kZ, kX, kY));
  const Vector3d top = (n_profiles - 1) * kZ;
  edit(mesh, [&](PolylineMesh& m) {
    return skin_profiles(
        m, profiles,
        {DrawnStroke{polygon({kX, kX + top}), false}, DrawnStroke{polygon({-kX, top - kX}), false}});
  });
  return mesh;
}

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
  } while (std::next_permutation(order.begin(), order.end()));
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

// What squares of coordinates cannot hold is refused, whatever the determinant says.
TEST(Transform, ModelsStayWithinTheRangeOfNumbers) {
  PolylineMesh mesh;
  EXPECT_CONTAINS(
      refusal(mesh, [](PolylineMesh& m) { return transform_model(m, Eigen::Matrix4d::Identity()); }),
      "nothing to move");
  mesh = octahedral_sphere();
  const auto scaled = [&](double x, double y, double z) {
    const Eigen::Matrix4d matrix = Eigen::Vector4d(x, y, z, 1).asDiagonal();
    return refusal(mesh, [&](PolylineMesh& m) { return transform_model(m, matrix); });
  };
  EXPECT_CONTAINS(scaled(1e300, 1e300, 1e300), "beyond 1e+100");
  EXPECT_CONTAINS(scaled(1e-300, 1e-300, 1e-300), "below 1e-100");
  EXPECT_CONTAINS(scaled(1, 1, 0), "flattens");
  EXPECT_CONTAINS(scaled(0, 0, 0), "flattens");
  for (const double size : {1e-40, 1e40}) {  // cubes of these are out of range, the model is not
    const Eigen::Matrix4d matrix = Eigen::Vector4d(size, size, size, 1).asDiagonal();
    edit(mesh, [&](PolylineMesh& m) { return transform_model(m, matrix); });
    EXPECT_EQ(mesh.broken_invariant(), "");
    const Eigen::Matrix4d back = Eigen::Vector4d(1 / size, 1 / size, 1 / size, 1).asDiagonal();
    edit(mesh, [&](PolylineMesh& m) { return transform_model(m, back); });
  }
}

TEST(Transform, MirrorsTurnFacesSoThatTheyStayOutside) {
  PolylineMesh mesh = octahedral_sphere();
  const auto volume = [](const PolylineMesh& m) {  // of the octahedron of the corners
    double sum = 0;
    for (const SketchFace& face : m.faces()) {
      if (!face.alive) continue;
      const auto corner = [&](size_t k) { return m.vertex(m.start_of(face.sides[k])).position; };
      sum += corner(0).cross(corner(1)).dot(corner(2)) / 6;
    }
    return sum;
  };
  const double before = volume(mesh);
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix(0, 0) = -2;
  edit(mesh, [&](PolylineMesh& m) { return transform_model(m, matrix); });
  EXPECT_NEAR(volume(mesh), 2 * before, 1e-6);
  EXPECT_EQ(mesh.broken_invariant(), "");
}

TEST(Align, FindsThePoseOfACurveWithoutSymmetryInEveryTry) {
  // An open space curve without symmetry, moved at random. Exact data: the residual is that of arithmetic.
  Points points(200, 3);
  for (int i = 0; i < 200; ++i) {
    const double t = i / 199.0;
    points.row(i) << t + 0.3 * t * t, 0.4 * std::sin(4 * t) + 0.2 * t,
        0.3 * t * t * t + 0.1 * std::cos(9 * t);
  }
  const Polyline curve(points);
  Random random(5);
#ifdef __SANITIZE_ADDRESS__
  constexpr int kTries = 50;  // the sanitizers look at the code, not at the statistics
#else
  constexpr int kTries = 1000;
#endif
  int wrong = 0;
  for (int k = 0; k < kTries; ++k) {
    const Eigen::Quaterniond q =
        Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal()).normalized();
    const Vector3d shift = 3 * random.normal3();
    Points moved = (points * q.toRotationMatrix().transpose()).rowwise() + shift.transpose();
    if (k % 2) moved = moved.colwise().reverse().eval();  // drawn from the other end
    const Alignment found = align_curves(curve, Polyline(moved));
    double worst = 0;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      const Vector3d p = points.row(i);
      worst = std::max(
          worst,
          ((found.matrix.topLeftCorner<3, 3>() * p + found.matrix.topRightCorner<3, 1>()) - (q * p + shift))
              .norm());
    }
    if (worst > 1e-4 * curve.length()) ++wrong;
  }
  EXPECT_EQ(wrong, 0);
}

TEST(Align, TriesManyTurnsWhereAxesAreEqual) {
  // Three lobes of one plane curve: both axes in the plane are equal, so that principal axes say nothing.
  const auto lobes = [](double phase) {
    Points points(241, 3);
    for (int i = 0; i <= 240; ++i) {
      const double t = 2 * kPi * i / 240, r = 1 + 0.4 * std::cos(3 * t);
      points.row(i) << r * std::cos(t + phase), r * std::sin(t + phase), 0.15 * std::sin(3 * t);
    }
    return points;
  };
  const Polyline curve(lobes(0));
  for (const double phase : {0.3, 1.0, 2.2, 4.0}) {
    const Alignment found = align_curves(curve, Polyline(lobes(phase)));
    EXPECT_LT(found.rms, 1e-4 * curve.length()) << phase;
    EXPECT_TRUE(found.ambiguous);  // thirds of a turn fit as well
  }
}

}  // namespace
}  // namespace batten
