#include "sanitizers.hpp"
#include "strokes.hpp"

#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/sketch/contacts_detail.hpp"

// Where strokes meet curves that lie near each other, measured in the snapping distance.
namespace batten {
namespace {

using namespace strokes;
using Eigen::Index;
using Eigen::Vector3d;

constexpr double kSnap = 0.01;

Vector3d at(double x, double y) {
  return {x, y, 0};
}

void insert_within(PolylineMesh& mesh, const DrawnStroke& stroke, double snap) {
  edit(mesh, [&](PolylineMesh& m) { return insert_curve(m, stroke, {.snap = snap}); });
}

DrawnStroke line(std::initializer_list<Vector3d> corners) {
  return {polygon(corners, 100), false};
}

/// The unit square with straight curves, each of which ends on others.
PolylineMesh square(const std::vector<std::pair<Vector3d, Vector3d>>& curves) {
  PolylineMesh mesh;
  insert_within(mesh, {polygon({kO, kX, kX + kY, kY, kO}, 100), true}, kSnap);
  for (const auto& [from, to] : curves) insert_within(mesh, line({from, to}), 1e-4);
  return mesh;
}

/// c1 and c2 upright, so far apart.
PolylineMesh strip(double width) {
  return square({{at(0.5, 0), at(0.5, 1)}, {at(0.5 + width, 0), at(0.5 + width, 1)}});
}

/// The square with a slit of this width from above to its middle.
PolylineMesh slit(double width) {
  PolylineMesh mesh;
  const double l = 0.5 - width / 2, r = 0.5 + width / 2;
  const Points border = polygon(
      {at(0, 0), at(1, 0), at(1, 1), at(r, 1), at(r, 0.5), at(l, 0.5), at(l, 1), at(0, 1), at(0, 0)}, 100);
  insert_within(mesh, {border, true}, 1e-5);
  return mesh;
}

/// A curve that goes up, turns round in a half circle and comes down again at this distance.
PolylineMesh hairpin(double width) {
  PolylineMesh mesh = square({{at(0, 0.1), at(1, 0.1)}, {at(0.5, 0), at(0.5, 0.1)}});
  const double r = width / 2;
  const Points up = polygon({at(0.5 - r, 0.1), at(0.5 - r, 0.6)}, 150),
               down = polygon({at(0.5 + r, 0.6), at(0.5 + r, 0.1)}, 150),
               turn = arc(at(0.5, 0.6), -r * kX, r * kY, 0, kPi, 100);
  Points points(up.rows() + turn.rows() + down.rows() - 2, 3);
  points << up, turn.middleRows(1, turn.rows() - 2), down;
  insert_within(mesh, {points, false}, 1e-5);
  return mesh;
}

/// The model with one more curve, which has to follow its stroke.
SketchCounts counts_after(PolylineMesh mesh, const DrawnStroke& stroke) {
  const int curve = mesh.n_curves();
  insert_within(mesh, stroke, kSnap);
  EXPECT_EQ(mesh.broken_invariant(), "");
  Segments segments(stroke.points.rows() - 1, 2);
  for (Index i = 0; i + 1 < stroke.points.rows(); ++i)
    segments.row(i) << static_cast<int>(i), static_cast<int>(i) + 1;
  const SegmentTree tree(stroke.points, segments);
  for (const int e : mesh.edges_of_curve(curve)) {
    const Points& points = mesh.edge(e).polyline->points();
    for (Index i = 0; i < points.rows(); ++i)
      EXPECT_LT(std::sqrt(tree.closest(Vector3d(points.row(i))).squared_distance), kSnap);
  }
  return mesh.counts();
}

/// Off the model and with a noise that a pen has.
DrawnStroke shaken(DrawnStroke stroke, std::uint64_t seed) {
  Random random(seed);
  for (Index i = 0; i < stroke.points.rows(); ++i)
    stroke.points.row(i) += (0.3 * kSnap * kZ + 0.01 * kSnap * random.normal3()).transpose();
  return stroke;
}

// What a stroke over two curves gives does not depend on how near each other they lie, down to a twentieth of
// the snapping distance.
TEST(Contacts, CurvesNearerThanTwiceTheSnapAreStillTwo) {
  const DrawnStroke across = line({at(0, 0.4), at(1, 0.4)}), higher = line({at(0, 0.75), at(1, 0.75)});
  const DrawnStroke ring{polygon({at(0.2, 0.2), at(0.8, 0.2), at(0.8, 0.8), at(0.2, 0.8), at(0.2, 0.2)}, 100),
                         true};
  const auto to = [](double x) { return line({at(0, 0.4), at(x, 0.4)}); };
  for (const bool by_hand : {false, true}) {
    const auto drawn = [&](const DrawnStroke& stroke) { return by_hand ? shaken(stroke, 5) : stroke; };
    for (const double snaps : {6.0, 3.9, 2.1, 1.9, 1.5, 1.0, 0.5, 0.2}) {
      if (test::kSanitized && snaps != 3.9 && snaps != 1.5) continue;
      const double w = snaps * kSnap;
      SCOPED_TRACE(concat(snaps, by_hand ? " snaps, by hand" : " snaps"));
      // Square and strip: V 8, E 10, F 3, borders 1. Each crossing adds a vertex and divides an edge and a
      // face.
      EXPECT_EQ(counts_after(strip(w), drawn(across)), (SketchCounts{4, 12, 17, 6, 1, 1, 0}));
      EXPECT_EQ(counts_after(strip(w), drawn(to(0.5 + w))), (SketchCounts{4, 11, 15, 5, 1, 1, 0}));
      EXPECT_EQ(counts_after(strip(w), drawn(to(0.5))), (SketchCounts{4, 10, 13, 4, 1, 1, 0}));
      EXPECT_EQ(counts_after(strip(w), drawn(ring)), (SketchCounts{4, 16, 22, 7, 1, 1, 0}));
      const auto more = [](SketchCounts counts, int vertices, int edges, int faces, int borders) {
        return SketchCounts{counts.curves + 1,    counts.vertices + vertices, counts.edges + edges,
                            counts.faces + faces, counts.components,          counts.boundary_loops + borders,
                            counts.genus};
      };
      // Over the slit the stroke is a lid: the opening, which is also the outside, is closed by two faces.
      EXPECT_EQ(counts_after(slit(w), drawn(higher)), more(slit(w).counts(), 4, 7, 4, -1));
      EXPECT_EQ(counts_after(hairpin(w), drawn(across)), more(hairpin(w).counts(), 4, 7, 3, 0));
    }
  }
}

// The nearer one where a stroke ends beside two curves.
TEST(Contacts, StrokeEndsOnTheNearerOfTwo) {
  PolylineMesh mesh = strip(0.8 * kSnap);
  for (const auto& [past, curve] :
       {std::pair(-0.1, 1), std::pair(0.1, 1), std::pair(0.7, 2), std::pair(0.9, 2)}) {
    const Stroke stroke =
        prepare_stroke(line({at(0, 0.4), at(0.5 + past * kSnap, 0.4)}).points, {.snap = kSnap});
    const auto contacts = detail::find_contacts(mesh, stroke, kSnap);
    ASSERT_GE(contacts.size(), 2u) << past;
    EXPECT_EQ(mesh.edge(contacts.back().edge).curve, curve) << past;
    EXPECT_EQ(contacts.back().arc, stroke.length) << past;
    EXPECT_EQ(contacts.size(), curve == 1 ? 2u : 3u) << past;
  }
}

// A stroke past two curves, one below and one above it, lies nearer to each than the snap. The snap that is
// advised meets the nearer one alone.
TEST(Contacts, CurvesOnBothSidesOfAStrokeAreRefusedWithARemedy) {
  PolylineMesh mesh = square({{at(0.5, 0), at(0.5, 1)}});
  // An upright plate over c1.
  DrawnStroke above{
      polygon({at(0.5, 0.2), at(0.5, 0.7), at(0.5, 0.7) + kZ, at(0.5, 0.2) + kZ, at(0.5, 0.2)}, 100), true};
  above.points.col(2).array() += 1.5 * kSnap;
  insert_within(mesh, above, 1e-3);
  DrawnStroke stroke = line({at(0, 0.4), at(0.6, 0.4), at(0.6, 0)});
  stroke.points.col(2).array() = 0.7 * kSnap;
  try {
    insert_within(mesh, stroke, kSnap);
    FAIL() << "was not refused";
  } catch (const RefusedEdit& refused) {
    EXPECT_EQ(
        refused.reason(),
        "the stroke meets c1 and c2 in places 0.015 apart, too near each other for the snapping distance of "
        "0.01 to tell which is meant");
    EXPECT_EQ(refused.remedy(), "give a snap of 0.0076 or less, or draw it clear of one of them");
  }
  const SketchCounts before = mesh.counts();
  insert_within(mesh, stroke, 0.0076);
  EXPECT_EQ(mesh.counts().vertices, before.vertices + 4);  // both ends, c1, and the corner of the stroke
  EXPECT_EQ(mesh.broken_invariant(), "");
}

TEST(Contacts, CurvesThatLieOnEachOtherAreRefused) {
  PolylineMesh mesh = strip(0.04 * kSnap);
  const PolylineMesh before = mesh;
  try {
    insert_within(mesh, line({at(0, 0.4), at(1, 0.4)}), kSnap);
    FAIL() << "was not refused";
  } catch (const RefusedEdit& refused) {
    EXPECT_NE(refused.reason().find("c1"), std::string::npos);
    EXPECT_NE(refused.reason().find("c2"), std::string::npos);
    EXPECT_NE(refused.reason().find("0.0004 apart"), std::string::npos) << refused.reason();
    EXPECT_EQ(refused.remedy(), "draw it where they lie apart");
  }
  EXPECT_TRUE(mesh == before);
}

// A stroke that crosses a curve, turns, and crosses it again beside the first place.
TEST(Contacts, WayThereAndBackMeetsACurveTwice) {
  const PolylineMesh mesh = square({{at(0.5, 0), at(0.5, 1)}});
  const double y = 0.4, gap = 1.5 * kSnap;
  // A drop that is open by the gap where it passes the curve, wide on both sides of it.
  const DrawnStroke loop{polygon({at(0.5, y), at(0.7, y - 0.1), at(0.7, y + 0.2), at(0.5, y + gap),
                                  at(0.3, y + 0.2), at(0.3, y - 0.1), at(0.5, y)},
                                 100),
                         true};
  // Both crossings are corners of the stroke or near them; four corners more. The faces on both sides are
  // divided by a piece from crossing to crossing.
  const SketchCounts counts = counts_after(mesh, loop);
  EXPECT_EQ(counts.vertices, 12);
  EXPECT_EQ(counts.faces, 4);
}

}  // namespace
}  // namespace batten
