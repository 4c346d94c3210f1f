#include "subdivision/cages.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/subdivision/four_point_detail.hpp"
#include "batten/subdivision/subdivide.hpp"

namespace batten {
namespace {

using Row = Eigen::RowVector3d;

double bicubic(double x, double y) {
  return 0.3 * x * x * x - 0.2 * x * x * y + 0.1 * x * x * x * y * y * y - y * y + 0.4 * x * y + 1;
}

TEST(Nuliss, GoesThroughTheVerticesOfTheCage) {
  for (const SubdivisionScheme scheme :
       {SubdivisionScheme::Nuliss, SubdivisionScheme::NulissMod, SubdivisionScheme::Linear})
    for (const ControlCage& cage : {cages::cube(), cages::tetrahedron(), cages::prism(6), cages::torus(5, 4),
                                    cages::cube_with_sharp_edges()}) {
      const SubdividedSurface surface = subdivide(cage, {.scheme = scheme, .levels = 3, .limit = true});
      const Eigen::Index n = cage.mesh.positions.rows();
      EXPECT_EQ(surface.cage.mesh.positions.topRows(n), cage.mesh.positions);
      EXPECT_EQ(surface.limit_positions.topRows(n), cage.mesh.positions);
      EXPECT_EQ(surface.edge_chains.col(0).size(), static_cast<Eigen::Index>(surface.cage_edges.size()));
    }
}

// Each row of four points gives the cubic through them, at the border too, and rows of edge points likewise:
// a bicubic function over a grid with uniform knots comes back exactly.
TEST(Nuliss, ReproducesBicubicFunctionsOnRegularGridsWithUniformKnots) {
  const ControlCage cage = cages::grid(6, 5, [](int i, int j) { return Row(i, j, bicubic(i, j)); });
  const SubdividedSurface surface =
      subdivide(cage, {.scheme = SubdivisionScheme::Nuliss, .levels = 4, .knot_exponent = 0});
  double error = 0;
  for (Eigen::Index v = 0; v < surface.cage.mesh.positions.rows(); ++v) {
    const Row p = surface.cage.mesh.positions.row(v);
    error = std::max(error, std::abs(p(2) - bicubic(p(0), p(1))));
    EXPECT_NEAR(16 * p(0), std::round(16 * p(0)), 1e-12);
  }
  EXPECT_LT(error, 1e-11);
}

// Uneven rows and columns, with the tensor-product knots of that grid (chord lengths, all z = 0): x and y are
// linear functions of the knots, so every row keeps its straight line and its spacing.
TEST(Nuliss, KeepsAFlatUnevenGridInPlaceWithItsKnots) {
  const double x[5] = {0, 1, 1.01, 4, 5}, y[4] = {0, 3, 3.5, 5};
  const ControlCage cage = cages::grid(5, 4, [&](int i, int j) { return Row(x[i], y[j], 0); });
  const SubdividedSurface with_knots =
      subdivide(cage, {.scheme = SubdivisionScheme::Nuliss, .levels = 3, .knot_exponent = 1});
  const SubdividedSurface linear = subdivide(cage, {.scheme = SubdivisionScheme::Linear, .levels = 3});
  EXPECT_LT((with_knots.cage.mesh.positions - linear.cage.mesh.positions).cwiseAbs().maxCoeff(), 1e-12);
  const SubdividedSurface without =
      subdivide(cage, {.scheme = SubdivisionScheme::Nuliss, .levels = 3, .knot_exponent = 0});
  EXPECT_GT((without.cage.mesh.positions - linear.cage.mesh.positions).cwiseAbs().maxCoeff(), 0.05);
}

// Where opposite sides differ in length no tensor product tells the knots: half of a side has half of its
// interval, an edge between two of them half of their mean, a strip the mean of both (docs/subdivide.md).
// Three cells of width 1 below and of 1, 2, 1 above: the lower strips of level 1 have the intervals (b/2 + (b
// + t)/4)/2 = (3 b + t)/8. A face point of level 2 follows from the edge points of that level by the cubic
// along one strip and, at the border, by the parabola ⅜, ¾, −⅛ across.
TEST(Nuliss, HalvesTheKnotIntervalsOfEveryStrip) {
  const double top[4] = {0, 1, 3, 4};
  const ControlCage cage =
      cages::grid(4, 2, [&](int i, int j) { return j == 0 ? Row(i, 0, 0) : Row(top[i], 1, 0); });
  const SubdividedSurface surface =
      subdivide(cage, {.scheme = SubdivisionScheme::Nuliss, .levels = 2, .knot_exponent = 1});
  // Corner c of level 1 becomes the quad of its vertex, the middle of its side, its face point and the middle
  // of the side before; corner k of cell i becomes face 4 i + k.
  const auto point = [&](int face, int side, int which) {
    const auto quad = static_cast<size_t>(4 * face + side);
    return Row(
        surface.cage.mesh.positions.row(surface.cage.mesh.corners[4 * quad + static_cast<size_t>(which)]));
  };
  const auto edge_point = [&](int face, int side) { return point(face, side, 1); };
  const int face = 4;  // the lower left quarter of the middle cell
  const double before = (3.0 + 1) / 8, own = (3.0 + 2) / 8;
  const double knots[4] = {-before, 0, own, 2 * own};
  const Row along_strip[4] = {edge_point(0, 1), edge_point(face, 3), edge_point(face, 1), edge_point(5, 0)};
  const Row along = detail::interpolated(knots, along_strip, 4, own / 2);
  const Row across =
      0.375 * edge_point(face, 0) + 0.75 * edge_point(face, 2) - 0.125 * edge_point(face + 3, 3);
  EXPECT_LT((point(face, 0, 2) - (along + across) / 2).norm(), 1e-13);
}

double torus_error(int n) {
  const SubdividedSurface surface =
      subdivide(cages::torus(n, n), {.scheme = SubdivisionScheme::Nuliss, .levels = 2, .knot_exponent = 0});
  double worst = 0;
  for (Eigen::Index v = 0; v < surface.cage.mesh.positions.rows(); ++v) {
    const Row p = surface.cage.mesh.positions.row(v);
    worst = std::max(worst, std::abs(std::hypot(std::hypot(p(0), p(1)) - 2, p(2)) - 0.7));
  }
  return worst;
}

// Local cubics: the error falls with the fourth power of the spacing.
TEST(Nuliss, ConvergesAtFourthOrderOnATorus) {
  const double order = std::log2(torus_error(16) / torus_error(32));
  EXPECT_NEAR(order, 4, 0.2);
  EXPECT_LT(torus_error(32), 2e-4);
}

/// The largest angle between the normals of the fine faces around vertex 0 and its limit normal.
double normal_spread(const ControlCage& cage, int levels, double knot_exponent) {
  const SubdividedSurface surface = subdivide(
      cage,
      {.scheme = SubdivisionScheme::Nuliss, .levels = levels, .limit = true, .knot_exponent = knot_exponent});
  const PolygonMesh& mesh = surface.cage.mesh;
  double widest = 0;
  for (size_t c = 0; c < mesh.corners.size(); ++c) {
    if (mesh.corners[c] != 0) continue;
    const Row here = mesh.positions.row(0);
    const auto corner = [&](size_t k) { return mesh.corners[c / 4 * 4 + (c + k) % 4]; };
    const Row normal = (mesh.positions.row(corner(1)) - here).cross(mesh.positions.row(corner(3)) - here);
    widest = std::max(
        widest, std::acos(std::clamp(normal.normalized().dot(Row(surface.limit_normals.row(0))), -1.0, 1.0)));
  }
  return widest;
}

// Around a smooth vertex the directions of all its faces must tend to one normal, the limit normal. What is
// not linear shrinks by 1/4 a level (times the number of the level, as in the four-point scheme of curves),
// what is linear by 1/2: the angle falls by (1/2)^2 * 5/3 = 0.42 from level 3 to level 5.
TEST(Nuliss, HasATangentPlaneAtExtraordinaryVertices) {
  for (const int n : {3, 5, 6, 8, 12}) {
    Random random(static_cast<std::uint64_t>(n));
    const ControlCage rough = cages::star(n, 2, [&](double x, double y) {
      return Row(x + 0.1 * random.normal(), y + 0.1 * random.normal(), 0.3 * random.normal());
    });
    for (const double exponent : {0.0, 0.5}) {
      const double coarse = normal_spread(rough, 3, exponent), fine = normal_spread(rough, 5, exponent);
      EXPECT_LT(fine, 0.55 * coarse) << "valence " << n << ", exponent " << exponent;
      EXPECT_LT(fine, 0.6) << "valence " << n << ", exponent " << exponent;
    }
  }
}

/// The first points along the spokes of a star after so many levels, seen from its middle.
Points first_on_spokes(const ControlCage& cage, int n, int rings, int levels) {
  const SubdividedSurface surface =
      subdivide(cage, {.scheme = SubdivisionScheme::Nuliss, .levels = levels, .knot_exponent = 0});
  Points first(n, 3);
  for (size_t e = 0; e < surface.cage_edges.size(); ++e) {
    const auto& [a, b] = surface.cage_edges[e];
    if (a != 0 && b != 0) continue;
    const Eigen::Index k = a == 0 ? 1 : surface.edge_chains.cols() - 2;
    first.row((a + b - 1) / (rings * (rings + 1))) =
        surface.cage.mesh.positions.row(surface.edge_chains(static_cast<Eigen::Index>(e), k)) -
        surface.cage.mesh.positions.row(0);
  }
  return first;
}

// The eigenvalues of docs/subdivide.md, seen in the Fourier modes of the spokes: what is linear around the
// vertex (mode 1) is halved at every level, everything else is quartered (from level 4 to 5 with a factor of
// 5/4, as these eigenvalues are double).
TEST(Nuliss, HalvesTheLinearPartAndQuartersTheRestAtEveryValence) {
  for (const int n : {3, 5, 6, 7, 10}) {
    Random random(static_cast<std::uint64_t>(100 + n));
    const ControlCage cage = cages::star(n, 2, [&](double x, double y) {
      return Row(x + 0.2 * random.normal(), y + 0.2 * random.normal(), 0.3 * random.normal());
    });
    const Points coarse = first_on_spokes(cage, n, 2, 4), fine = first_on_spokes(cage, n, 2, 5);
    for (int mode = 0; 2 * mode <= n; ++mode) {
      double before = 0, after = 0;
      for (const bool sine : {false, true}) {
        Row of_coarse = Row::Zero(), of_fine = Row::Zero();
        for (int j = 0; j < n; ++j) {
          const double angle = 2 * kPi * mode * j / n, weight = sine ? std::sin(angle) : std::cos(angle);
          of_coarse += weight * coarse.row(j);
          of_fine += weight * fine.row(j);
        }
        before += of_coarse.squaredNorm();
        after += of_fine.squaredNorm();
      }
      const double ratio = std::sqrt(after / before);
      if (mode == 1) {
        EXPECT_NEAR(ratio, 0.5, 0.01) << "valence " << n;
      } else {
        EXPECT_LT(ratio, 0.36) << "valence " << n << ", mode " << mode;
      }
    }
  }
}

/// The largest angle between two quads that share a side near vertex 0.
double largest_fold(const SubdividedSurface& surface, double radius) {
  const PolygonMesh& mesh = surface.cage.mesh;
  std::map<std::pair<int, int>, Row> normal_of_side;
  double widest = 0;
  for (size_t f = 0; f + 1 < mesh.offsets.size(); ++f) {
    const auto corner = [&](size_t k) { return mesh.corners[4 * f + k % 4]; };
    if ((mesh.positions.row(corner(0)) - mesh.positions.row(0)).norm() > radius) continue;
    const Row normal = (mesh.positions.row(corner(2)) - mesh.positions.row(corner(0)))
                           .cross(mesh.positions.row(corner(3)) - mesh.positions.row(corner(1)))
                           .normalized();
    for (size_t k = 0; k < 4; ++k) {
      const auto [it, is_new] = normal_of_side.insert({std::minmax(corner(k), corner(k + 1)), normal});
      if (!is_new) widest = std::max(widest, std::acos(std::clamp(it->second.dot(normal), -1.0, 1.0)));
    }
  }
  return widest;
}

// Neighbouring faces fold less at every level, also beside the rays where rows of both kinds meet.
TEST(Nuliss, UnfoldsAroundExtraordinaryVerticesLevelByLevel) {
  for (const int n : {3, 5, 7}) {
    const ControlCage dome =
        cages::star(n, 3, [](double x, double y) { return Row(x, y, -0.1 * (x * x + 0.5 * x * y)); });
    const auto fold = [&](int levels) {
      return largest_fold(subdivide(dome, {.scheme = SubdivisionScheme::Nuliss, .levels = levels}), 0.6);
    };
    EXPECT_LT(fold(5), 0.45 * fold(3)) << n;
  }
}

TEST(Nuliss, IsASphereToOnePercentOnARefinedCube) {
  // The corners of a cube refined once and pushed out to the unit sphere: 26 vertices, 8 of valence 3.
  ControlCage cage = subdivide(cages::cube(), {.scheme = SubdivisionScheme::Linear, .levels = 1}).cage;
  cage.mesh.positions.rowwise().normalize();
  const SubdividedSurface surface =
      subdivide(cage, {.scheme = SubdivisionScheme::Nuliss, .levels = 4, .limit = true});
  double radius_error = 0, angle = 0;
  for (Eigen::Index v = 0; v < surface.cage.mesh.positions.rows(); ++v) {
    const Row p = surface.cage.mesh.positions.row(v);
    radius_error = std::max(radius_error, std::abs(p.norm() - 1));
    angle = std::max(angle,
                     std::acos(std::clamp(p.normalized().dot(Row(surface.limit_normals.row(v))), -1.0, 1.0)));
  }
  EXPECT_LT(radius_error, 0.02);
  EXPECT_LT(angle, 0.1);
}

// Level 1 of a triangle or a pentagon: exact for z = 0.2 (x² + y²) over a regular n-gon (docs/subdivide.md).
TEST(Nuliss, PlacesFacePointsOfPolygonsOnTheParaboloid) {
  constexpr double kFlat = 0.2;
  for (const int n : {3, 5, 6}) {
    ControlCage cage;
    cage.mesh.positions.resize(n, 3);
    for (int k = 0; k < n; ++k) {
      const double a = 2 * kPi * k / n;
      cage.mesh.positions.row(k) << std::cos(a), std::sin(a), kFlat;
      cage.mesh.corners.push_back(k);
      // The middle of each polyline lies on the paraboloid; it is flat there, so that it is nearest to the
      // chord.
      EdgePolyline arc{k, (k + 1) % n, Points(4, 3)};
      const double parameters[4] = {0, 0.49, 0.51, 1}, b = 2 * kPi * (k + 1) / n;
      for (int i = 0; i < 4; ++i) {
        const double t = parameters[i], apothem = std::cos(kPi / n);
        arc.points.row(i) << (1 - t) * std::cos(a) + t * std::cos(b), (1 - t) * std::sin(a) + t * std::sin(b),
            i == 0 || i == 3 ? kFlat : kFlat * apothem * apothem;
      }
      cage.polylines.push_back(arc);
    }
    cage.mesh.offsets.push_back(n);
    const SubdividedSurface surface = subdivide(cage, {.scheme = SubdivisionScheme::NulissMod, .levels = 1});
    EXPECT_LT(surface.cage.mesh.positions.bottomRows(1).norm(), 1e-12) << n;  // its vertex, the origin
  }
}

/// The distance of a point from a polyline.
double distance(const Points& polyline, const Row& q) {
  double best = 1e300;
  for (Eigen::Index k = 1; k < polyline.rows(); ++k) {
    const Row along = polyline.row(k) - polyline.row(k - 1);
    const double t = std::clamp((q - polyline.row(k - 1)).dot(along) / along.squaredNorm(), 0.0, 1.0);
    best = std::min(best, (polyline.row(k - 1) + t * along - q).norm());
  }
  return best;
}

/// One quad over [0, 1]² whose sides are arcs of n segments over their chords.
ControlCage arched_quad(double height, int n = 20) {
  ControlCage cage = cages::grid(2, 2, [](int i, int j) { return Row(i, j, 0); });
  const int sides[4][2] = {{0, 1}, {1, 3}, {3, 2}, {0, 2}};  // the last one against the face's sense
  for (const auto& [a, b] : sides) {
    EdgePolyline arc{a, b, Points(n + 1, 3)};
    for (int k = 0; k <= n; ++k) {
      const double t = static_cast<double>(k) / n;
      arc.points.row(k) = (1 - t) * cage.mesh.positions.row(a) + t * cage.mesh.positions.row(b);
      arc.points(k, 2) = 4 * height * t * (1 - t);
    }
    cage.polylines.push_back(arc);
  }
  return cage;
}

TEST(NulissMod, KeepsAllPointsOfDrawnEdgesOnTheirPolylines) {
  const ControlCage cage = arched_quad(0.3);
  const SubdividedSurface surface = subdivide(cage, {.scheme = SubdivisionScheme::NulissMod, .levels = 4});
  for (const EdgePolyline& polyline : cage.polylines)
    for (size_t e = 0; e < surface.cage_edges.size(); ++e) {
      const auto& [a, b] = surface.cage_edges[e];
      if (std::minmax(a, b) != std::minmax(polyline.from, polyline.to)) continue;
      for (Eigen::Index k = 0; k < surface.edge_chains.cols(); ++k)
        EXPECT_LT(distance(polyline.points, surface.cage.mesh.positions.row(
                                                surface.edge_chains(static_cast<Eigen::Index>(e), k))),
                  1e-12);
    }
  // What is left of the polylines: one piece for each piece of the four sides, joined end to end.
  EXPECT_EQ(surface.cage.polylines.size(), 64u);
  for (const EdgePolyline& piece : surface.cage.polylines) {
    EXPECT_LT((piece.points.row(0) - surface.cage.mesh.positions.row(piece.from)).norm(), 1e-12);
    EXPECT_LT((piece.points.bottomRows(1) - surface.cage.mesh.positions.row(piece.to)).norm(), 1e-12);
  }
}

// What H 6.3.1 pays for following the polylines: spokes that arch up in turn leave the middle of a flat star
// in directions of no one plane, and no level brings the normals there together. Nuliss, which takes the
// vertices alone, stays flat.
TEST(NulissMod, HasNoTangentPlaneWherePolylinesHaveNone) {
  for (const int n : {3, 5, 6}) {
    ControlCage cage = cages::star(n, 2, [](double x, double y) { return Row(x, y, 0); });
    constexpr int kPoints = 40, kRings = 2;
    for (int s = 0; s < n; s += 2) {
      const int first = 1 + s * kRings * (kRings + 1);
      EdgePolyline arch{0, first, Points(kPoints + 1, 3)};
      for (int i = 0; i <= kPoints; ++i) {
        const double t = static_cast<double>(i) / kPoints;
        arch.points.row(i) = t * cage.mesh.positions.row(first);
        arch.points(i, 2) = 1.2 * t * (1 - t);
      }
      cage.polylines.push_back(arch);
    }
    const auto spread = [&](SubdivisionScheme scheme, int levels) {
      const SubdividedSurface surface = subdivide(cage, {.scheme = scheme, .levels = levels});
      const PolygonMesh& mesh = surface.cage.mesh;
      std::vector<Row> normals;
      for (size_t c = 0; c < mesh.corners.size(); ++c) {
        if (mesh.corners[c] != 0) continue;
        const auto corner = [&](size_t k) -> Row {
          return mesh.positions.row(mesh.corners[c / 4 * 4 + (c + k) % 4]) - mesh.positions.row(0);
        };
        normals.push_back(corner(1).cross(corner(3)).normalized());
      }
      double widest = 0;
      for (const Row& a : normals)
        for (const Row& b : normals) widest = std::max(widest, std::acos(std::clamp(a.dot(b), -1.0, 1.0)));
      return widest;
    };
    EXPECT_LT(spread(SubdivisionScheme::Nuliss, 5), 1e-6) << n;
    const double coarse = spread(SubdivisionScheme::NulissMod, 3),
                 fine = spread(SubdivisionScheme::NulissMod, 5);
    EXPECT_GT(coarse, 0.5) << n;
    EXPECT_GT(fine, 0.8 * coarse) << n;
  }
}

// Four equal arches of height h: the Coons patch has (h + h) in its middle, twice the height of one. With an
// odd number of segments the middle of an arch is flat and nearest to its chord.
TEST(NulissMod, PlacesTheFirstFacePointOnTheCoonsPatch) {
  const SubdividedSurface surface =
      subdivide(arched_quad(0.3, 21), {.scheme = SubdivisionScheme::NulissMod, .levels = 1});
  const double crown = 4 * 0.3 * 10 / 21 * 11 / 21;
  EXPECT_LT((surface.cage.mesh.positions.row(8) - Row(0.5, 0.5, 2 * crown)).norm(), 1e-12);
  const SubdividedSurface plain =
      subdivide(arched_quad(0.3), {.scheme = SubdivisionScheme::Nuliss, .levels = 1});
  EXPECT_LT((plain.cage.mesh.positions.row(8) - Row(0.5, 0.5, 0)).norm(), 1e-12)
      << "Nuliss takes knots alone";
}

// The parameters of the Coons patch are counted along its own sides, whichever way the polyline was drawn or
// the other face runs along the edge. Of the second of two unit squares three sides are straight; the fourth,
// from the first face, is straight up to its middle and then has a peak, so that its middle has the fraction
// f = ½ / (½ + 2 √(1 + 1/16)) of the length. By hand: u = ½, v = (½ + f)/2, and the straight sides leave the
// mean of the place at v on the fourth and of that opposite.
TEST(NulissMod, CountsTheParametersOfTheCoonsPatchAlongTheSidesOfTheFace) {
  const double leg = std::sqrt(1 + 1.0 / 16), whole = 0.5 + 2 * leg, f = 0.5 / whole, v = (0.5 + f) / 2;
  const double up = (v * whole - 0.5) / leg;  // of the first leg of the peak
  for (const bool turned : {false, true}) {
    ControlCage cage = cages::grid(3, 2, [](int i, int j) { return Row(i, j, 0); });
    for (const auto& [a, b] : {std::pair{1, 2}, std::pair{5, 2}, std::pair{5, 4}}) {
      EdgePolyline side{a, b, Points(2, 3)};
      side.points << cage.mesh.positions.row(a), cage.mesh.positions.row(b);
      cage.polylines.push_back(side);
    }
    EdgePolyline peak{1, 4, Points(4, 3)};
    peak.points << 1, 0, 0, 1, 0.5, 0, 1, 0.75, 1, 1, 1, 0;
    if (turned) peak = {4, 1, Points(peak.points.colwise().reverse())};
    cage.polylines.push_back(peak);
    const SubdividedSurface surface =
        subdivide(cage, {.scheme = SubdivisionScheme::NulissMod, .levels = 1, .knot_exponent = 0});
    const Row expected = (Row(1, 0.5 + 0.25 * up, up) + Row(2, v, 0)) / 2;
    EXPECT_LT((surface.cage.mesh.positions.row(14) - expected).norm(), 1e-12) << turned;
  }
}

TEST(Linear, CutsPolylinesHalfwayAlongTheirLength) {
  const SubdividedSurface surface =
      subdivide(arched_quad(0.3), {.scheme = SubdivisionScheme::Linear, .levels = 2});
  // Symmetric arcs: halfway is the crown.
  for (size_t e = 0; e < 4; ++e)
    EXPECT_NEAR(surface.cage.mesh.positions(surface.edge_chains(static_cast<Eigen::Index>(e), 2), 2), 0.3,
                1e-12);
  EXPECT_LT((surface.cage.mesh.positions.row(8) - Row(0.5, 0.5, 0)).norm(), 1e-15);
}

TEST(Nuliss, KeepsSharpEdgesStraightAndTheTopPlane) {
  const SubdividedSurface surface =
      subdivide(cages::cube_with_sharp_edges(), {.scheme = SubdivisionScheme::Nuliss, .levels = 4});
  const Points& points = surface.cage.mesh.positions;
  for (size_t f = 0; f < surface.face_parent.size(); ++f)
    if (surface.face_parent[f] == 1) {
      for (size_t c = 4 * f; c < 4 * f + 4; ++c)
        EXPECT_NEAR(points(surface.cage.mesh.corners[c], 2), 1, 1e-13);
    }
  for (size_t e = 0; e < surface.cage_edges.size(); ++e)
    if (surface.cage_edges[e][0] + surface.cage_edges[e][1] == 9 &&
        std::abs(surface.cage_edges[e][0] - surface.cage_edges[e][1]) == 1)
      for (Eigen::Index k = 0; k < 17; ++k) {
        const int v = surface.edge_chains(static_cast<Eigen::Index>(e), k);
        EXPECT_LT(std::hypot(points(v, 1) + 1, points(v, 2) - 1), 1e-13);
      }
}

TEST(Nuliss, MovesWithTheCageAndDoesNotDependOnItsNumbering) {
  Random random(11);
  ControlCage cage = cages::prism(5);
  for (Eigen::Index v = 0; v < 10; ++v)
    for (int k = 0; k < 3; ++k) cage.mesh.positions(v, k) += 0.1 * random.normal();
  const SubdivisionOptions options{.scheme = SubdivisionScheme::Nuliss, .levels = 3};
  const Points plain = subdivide(cage, options).cage.mesh.positions;
  for (const double scale : {1e-3, 1e3}) {
    const Eigen::Matrix3d rotation =
        Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    ControlCage moved = cage;
    moved.mesh.positions = (scale * cage.mesh.positions * rotation).rowwise() + scale * Row(1, -2, 3);
    const Points expected = (scale * plain * rotation).rowwise() + scale * Row(1, -2, 3);
    EXPECT_LT((subdivide(moved, options).cage.mesh.positions - expected).cwiseAbs().maxCoeff(),
              1e-12 * scale);
  }
  ControlCage renumbered = cage;  // vertex v becomes 9 − v, faces begin one corner later
  renumbered.mesh.positions = Points(cage.mesh.positions.colwise().reverse());
  for (size_t f = 0; f + 1 < cage.mesh.offsets.size(); ++f) {
    const auto begin = renumbered.mesh.corners.begin() + cage.mesh.offsets[f];
    const auto end = renumbered.mesh.corners.begin() + cage.mesh.offsets[f + 1];
    std::for_each(begin, end, [](int& v) { v = 9 - v; });
    std::rotate(begin, begin + 1, end);
  }
  const Points other = subdivide(renumbered, options).cage.mesh.positions;
  ASSERT_EQ(other.rows(), plain.rows());
  for (Eigen::Index v = 0; v < plain.rows(); ++v)
    EXPECT_LT((other.rowwise() - plain.row(v)).rowwise().norm().minCoeff(), 1e-12) << v;
}

TEST(Nuliss, TakesEdgesWithoutLength) {
  ControlCage cage = cages::grid(4, 4, [](int i, int j) { return Row(std::max(i, 1), j, 0); });
  const SubdividedSurface surface =
      subdivide(cage, {.scheme = SubdivisionScheme::Nuliss, .levels = 3, .limit = true});
  EXPECT_TRUE(surface.cage.mesh.positions.allFinite());
  EXPECT_TRUE(surface.limit_normals.allFinite());
  cage.mesh.positions.setZero();
  EXPECT_TRUE(subdivide(cage, {.scheme = SubdivisionScheme::Nuliss}).cage.mesh.positions.isZero(0));
}

TEST(NulissMod, RefusesPolylinesThatDoNotFitTheirEdge) {
  const auto message = [](const ControlCage& cage) {
    try {
      subdivide(cage, {.scheme = SubdivisionScheme::NulissMod});
    } catch (const InvalidInput& problem) {
      return std::string(problem.what());
    }
    return std::string("accepted");
  };
  ControlCage cage = arched_quad(0.3);
  cage.polylines[1].points.row(0) += Row(0.1, 0, 0);
  EXPECT_NE(message(cage).find("between vertices 1 and 3 does not begin"), std::string::npos)
      << message(cage);
  cage = arched_quad(0.3);
  cage.polylines[1].to = 2;
  EXPECT_NE(message(cage).find("is no edge"), std::string::npos);
  cage = arched_quad(0.3);
  cage.polylines[2] = cage.polylines[1];
  EXPECT_NE(message(cage).find("given twice"), std::string::npos);
}

}  // namespace
}  // namespace batten
