#include "subdivision/cages.hpp"

#include <map>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/subdivision/subdivide.hpp"

namespace batten {
namespace {

using Row = Eigen::RowVector3d;

/// One level by the definition of [catmull1978] with the rules of [derose1998] for sharpness,
/// written as plainly as possible: maps from edges to sums. The second implementation.
struct PlainLevel {
  std::map<std::pair<int, int>, Row> edge_point;
  std::vector<Row> face_point, vertex_point;
};

PlainLevel plain_level(const ControlCage& cage) {
  const PolygonMesh& mesh = cage.mesh;
  PlainLevel level;
  std::map<std::pair<int, int>, std::vector<int>> faces_of_edge;
  std::map<int, std::vector<int>> faces_of_vertex;
  for (int f = 0; f < mesh.n_faces(); ++f) {
    const int begin = mesh.offsets[static_cast<size_t>(f)], end = mesh.offsets[static_cast<size_t>(f) + 1];
    Row sum = Row::Zero();
    for (int c = begin; c < end; ++c) {
      const int a = mesh.corners[static_cast<size_t>(c)],
                b = mesh.corners[static_cast<size_t>(c + 1 < end ? c + 1 : begin)];
      sum += mesh.positions.row(a);
      faces_of_edge[std::minmax(a, b)].push_back(f);
      faces_of_vertex[a].push_back(f);
    }
    level.face_point.push_back(sum / (end - begin));
  }
  std::map<std::pair<int, int>, double> sharpness;
  for (const SharpEdge& edge : cage.sharp_edges) sharpness[std::minmax(edge.from, edge.to)] = edge.sharpness;
  for (const auto& [edge, faces] : faces_of_edge) {
    const Row middle = 0.5 * (mesh.positions.row(edge.first) + mesh.positions.row(edge.second));
    Row smooth = middle;
    if (faces.size() == 2)
      smooth = 0.5 * middle + 0.25 * (level.face_point[static_cast<size_t>(faces[0])] +
                                      level.face_point[static_cast<size_t>(faces[1])]);
    const double s = faces.size() == 1 ? 1.0 : std::min(1.0, sharpness[edge]);
    level.edge_point[edge] = (1 - s) * smooth + s * middle;
  }
  for (int v = 0; v < mesh.positions.rows(); ++v) {
    const Row here = mesh.positions.row(v);
    const double n = static_cast<double>(faces_of_vertex[v].size());
    Row f = Row::Zero(), r = Row::Zero(), crease = Row::Zero();
    int n_sharp = 0, n_edges = 0;
    double sum_sharp = 0;
    for (const int face : faces_of_vertex[v]) f += level.face_point[static_cast<size_t>(face)] / n;
    for (const auto& [edge, faces] : faces_of_edge) {
      if (edge.first != v && edge.second != v) continue;
      const Row other = mesh.positions.row(edge.first == v ? edge.second : edge.first);
      r += 0.5 * (here + other) / n;
      ++n_edges;
      const double s = faces.size() == 1 ? 1.0 : sharpness[edge];
      if (s > 0) {
        ++n_sharp;
        sum_sharp += s;
        crease += other;
      }
    }
    const Row smooth = (f + 2 * r + (n - 3) * here) / n;
    const bool border_corner = n_edges == 2;
    Row point = smooth;
    if (n_sharp > 2 || border_corner)
      point = here;
    else if (n_sharp == 2)
      point = 0.75 * here + 0.125 * crease;
    if (n_sharp >= 2 && !border_corner) {
      const double s = std::min(1.0, sum_sharp / n_sharp);
      point = (1 - s) * smooth + s * point;
    }
    level.vertex_point.push_back(point);
  }
  return level;
}

void expect_plain_rules(const ControlCage& cage) {
  const SubdividedSurface surface = subdivide(cage, {.levels = 1});
  const PlainLevel plain = plain_level(cage);
  const Points& points = surface.cage.mesh.positions;
  ASSERT_EQ(points.rows(), static_cast<Eigen::Index>(plain.vertex_point.size() + plain.edge_point.size() +
                                                     plain.face_point.size()));
  for (size_t v = 0; v < plain.vertex_point.size(); ++v)
    EXPECT_LT((points.row(static_cast<Eigen::Index>(v)) - plain.vertex_point[v]).norm(), 1e-14) << v;
  ASSERT_EQ(surface.cage_edges.size(), plain.edge_point.size());
  for (size_t e = 0; e < surface.cage_edges.size(); ++e) {
    const Eigen::Index row = static_cast<Eigen::Index>(e);
    const auto& [a, b] = surface.cage_edges[e];
    EXPECT_EQ(surface.edge_chains(row, 0), a);
    EXPECT_EQ(surface.edge_chains(row, 2), b);
    EXPECT_LT((points.row(surface.edge_chains(row, 1)) - plain.edge_point.at(std::minmax(a, b))).norm(),
              1e-14);
  }
  // Each quad holds the centroid of the face it came from: it is the corner that is neither vertex nor edge.
  for (int f = 0; f < surface.cage.mesh.n_faces(); ++f) {
    const Row& wanted = plain.face_point[static_cast<size_t>(surface.face_parent[static_cast<size_t>(f)])];
    double nearest = 1;
    for (int c = 4 * f; c < 4 * f + 4; ++c)
      nearest =
          std::min(nearest, (points.row(surface.cage.mesh.corners[static_cast<size_t>(c)]) - wanted).norm());
    EXPECT_LT(nearest, 1e-14) << f;
  }
}

TEST(CatmullClark, FollowsThePlainRulesOnClosedCages) {
  expect_plain_rules(cages::cube());
  expect_plain_rules(cages::tetrahedron());
  expect_plain_rules(cages::prism(7));
  expect_plain_rules(cages::torus(5, 4));
}

TEST(CatmullClark, FollowsThePlainRulesAtBordersAndCreases) {
  expect_plain_rules(cages::grid(4, 3, [](int i, int j) { return Row(i, j, 0.3 * i * j); }));
  expect_plain_rules(cages::star(5, 2, [](double x, double y) { return Row(x, y, 0.1 * x * y); }));
  expect_plain_rules(cages::cube_with_sharp_edges());
  ControlCage half = cages::cube();
  half.sharp_edges = {{4, 5, 0.5}, {5, 6, 0.5}, {6, 7, 0.5}, {7, 4, 0.5}};
  expect_plain_rules(half);
}

TEST(CatmullClark, KeepsOneFaceOfABorderAsItsCorners) {
  const ControlCage one = cages::grid(2, 2, [](int i, int j) { return Row(i, j, 0); });
  const SubdividedSurface kept = subdivide(one, {.levels = 3, .limit = true});
  for (int v = 0; v < 4; ++v) EXPECT_EQ(kept.limit_positions.row(v), one.mesh.positions.row(v));
  const SubdividedSurface rounded = subdivide(one, {.levels = 3, .limit = true, .smooth_corners = true});
  // The closed cubic B-spline of the unit square passes its corners at (4 p + a + b)/6.
  EXPECT_LT((rounded.limit_positions.row(0) - Row(1.0 / 6, 1.0 / 6, 0)).norm(), 1e-14);
}

// The border of a corner of one face begins along its cage edge, as the one left eigenvector of 1/2 of its
// subdivision says: the normal is that of both edges, at every level.
TEST(CatmullClark, NormalsAtCornersOfOneFaceAreSquareToBothEdges) {
  Random random(2);
  const ControlCage cage = cages::grid(3, 3, [&](int i, int j) { return Row(i, j, random.uniform(-1, 1)); });
  const Points& p = cage.mesh.positions;
  const Row expected = (p.row(1) - p.row(0)).cross(p.row(3) - p.row(0)).normalized();
  for (const int levels : {0, 1, 3}) {
    const SubdividedSurface surface = subdivide(cage, {.levels = levels, .limit = true});
    EXPECT_LT((surface.limit_normals.row(0) - expected).norm(), 1e-12) << levels;
  }
}

// The tangent plane at a dart is that of a flat cage, and its normal looks to the side from which the faces
// are counter-clockwise, at any valence and wherever the sharp edge is.
TEST(CatmullClark, NormalsAtDartsLookOutwards) {
  for (int n = 3; n <= 9; ++n)
    for (int s = 0; s < n; ++s)
      for (const bool below : {false, true}) {
        ControlCage cage = cages::star(n, 2, [](double x, double y) { return Row(x, y, 0); });
        cage.sharp_edges = {{0, 1 + 6 * s, kInfinitelySharp}};
        if (below) cage.mesh.positions.col(1) *= -1;
        const SubdividedSurface surface = subdivide(cage, {.levels = 1, .limit = true});
        EXPECT_LT((surface.limit_normals.row(0) - Row(0, 0, below ? -1 : 1)).norm(), 1e-9) << n << ' ' << s;
      }
}

// Of what is said twice the stronger holds, in either order and sense.
TEST(CatmullClark, TheSharperOfTwoStatementsHolds) {
  ControlCage once = cages::cube(), sharper_first = once, sharper_last = once;
  once.sharp_edges = {{4, 5, 3}};
  once.sharp_vertices = {{0, 2}};
  sharper_first.sharp_edges = {{4, 5, 3}, {5, 4, 1}};
  sharper_first.sharp_vertices = {{0, 2}, {0, 1}};
  sharper_last.sharp_edges = {{5, 4, 1}, {4, 5, 3}};
  sharper_last.sharp_vertices = {{0, 1}, {0, 2}};
  const SubdividedSurface expected = subdivide(once, {.levels = 2});
  for (const ControlCage& cage : {sharper_first, sharper_last})
    EXPECT_EQ(subdivide(cage, {.levels = 2}).cage.mesh.positions, expected.cage.mesh.positions);
}

// The limit surface does not depend on the level at which it is asked for.
TEST(CatmullClark, GivesTheSameLimitAtEveryLevel) {
  for (const ControlCage& cage : {cages::cube(), cages::tetrahedron(), cages::prism(5), cages::torus(6, 5),
                                  cages::cube_with_sharp_edges()}) {
    const SubdividedSurface coarse = subdivide(cage, {.levels = 0, .limit = true});
    const SubdividedSurface fine = subdivide(cage, {.levels = 3, .limit = true});
    const Eigen::Index n = cage.mesh.positions.rows();
    EXPECT_LT((coarse.limit_positions - fine.limit_positions.topRows(n)).cwiseAbs().maxCoeff(), 1e-13);
    for (Eigen::Index v = 0; v < fine.limit_normals.rows(); ++v)
      EXPECT_NEAR(fine.limit_normals.row(v).norm(), 1, 1e-12);
  }
  const SubdividedSurface coarse = subdivide(cages::torus(6, 5), {.levels = 0, .limit = true});
  const SubdividedSurface fine = subdivide(cages::torus(6, 5), {.levels = 3, .limit = true});
  EXPECT_LT((coarse.limit_normals - fine.limit_normals.topRows(30)).cwiseAbs().maxCoeff(), 1e-12);
}

// At a regular vertex the limit is (16 p + 4 Σ edges + Σ diagonals)/36, the bicubic B-spline at its knot.
TEST(CatmullClark, IsTheBicubicSplineOnAGrid) {
  Random random(5);
  Points p(49, 3);
  for (int k = 0; k < 49; ++k) p.row(k) << random.normal(), random.normal(), random.normal();
  const ControlCage cage = cages::grid(7, 7, [&](int i, int j) { return Row(p.row(7 * j + i)); });
  const SubdividedSurface surface = subdivide(cage, {.levels = 2, .limit = true});
  const double b[3] = {1.0 / 6, 4.0 / 6, 1.0 / 6};
  for (int j = 1; j < 6; ++j)
    for (int i = 1; i < 6; ++i) {
      Row expected = Row::Zero();
      for (int dj = 0; dj < 3; ++dj)
        for (int di = 0; di < 3; ++di) expected += b[di] * b[dj] * p.row(7 * (j + dj - 1) + i + di - 1);
      EXPECT_LT((surface.limit_positions.row(7 * j + i) - expected).norm(), 1e-13);
    }
}

// H fig. 7.6: sharp are the top's four edges and two uprights.
TEST(CatmullClark, KeepsSharpEdgesStraightCornersExactAndTheTopPlane) {
  const SubdividedSurface surface = subdivide(cages::cube_with_sharp_edges(), {.levels = 4, .limit = true});
  const Points& points = surface.limit_positions;
  // Corners 4 and 5 join three sharp edges; 6 and 7 two, a crease that bends: the curve of the crease.
  EXPECT_EQ(Row(points.row(4)), Row(-1, -1, 1));
  EXPECT_EQ(Row(points.row(5)), Row(1, -1, 1));
  double off_plane = 0, off_line = 0;
  for (size_t f = 0; f < surface.face_parent.size(); ++f)
    if (surface.face_parent[f] == 1)
      for (size_t c = 4 * f; c < 4 * f + 4; ++c)
        off_plane = std::max(off_plane, std::abs(points(surface.cage.mesh.corners[c], 2) - 1));
  for (size_t e = 0; e < surface.cage_edges.size(); ++e)
    if (surface.cage_edges[e] == std::array<int, 2>{4, 5} ||
        surface.cage_edges[e] == std::array<int, 2>{5, 4})
      for (Eigen::Index k = 0; k < surface.edge_chains.cols(); ++k) {
        const Row p = points.row(surface.edge_chains(static_cast<Eigen::Index>(e), k));
        off_line = std::max(off_line, std::hypot(p(1) + 1, p(2) - 1));
      }
  EXPECT_LT(off_plane, 1e-14);
  EXPECT_LT(off_line, 1e-14);
}

// A sharpness of 2 is used up by two levels; what is left stands on the pieces of the edge.
TEST(CatmullClark, LeavesLessSharpnessAtEveryLevel) {
  ControlCage cage = cages::cube();
  cage.sharp_edges = {{4, 5, 2.5}, {0, 1, kInfinitelySharp}};
  cage.sharp_vertices = {{2, 1.0}, {3, 12.0}};
  const SubdividedSurface surface = subdivide(cage, {.levels = 2});
  ASSERT_EQ(surface.cage.sharp_edges.size(), 8u);
  double least = 1e9;
  for (const SharpEdge& edge : surface.cage.sharp_edges) least = std::min(least, edge.sharpness);
  EXPECT_EQ(least, 0.5);
  ASSERT_EQ(surface.cage.sharp_vertices.size(), 1u);
  EXPECT_EQ(surface.cage.sharp_vertices[0].vertex, 3);
  // Refining in two goes is refining in one.
  const SubdividedSurface rest = subdivide(surface.cage, {.levels = 2, .limit = true});
  const SubdividedSurface whole = subdivide(cage, {.levels = 4, .limit = true});
  ASSERT_EQ(rest.limit_positions.rows(), whole.limit_positions.rows());
  for (int v = 0; v < 8; ++v)
    EXPECT_LT((rest.limit_positions.row(v) - whole.limit_positions.row(v)).norm(), 1e-14);
}

TEST(CatmullClark, TracesFacesAndEdgesBackToTheCage) {
  const ControlCage cage = cages::torus(6, 5);
  const SubdividedSurface surface = subdivide(cage, {.levels = 3});
  std::vector<int> n_children(30, 0);
  for (const int parent : surface.face_parent) ++n_children[static_cast<size_t>(parent)];
  EXPECT_EQ(n_children, std::vector<int>(30, 64));
  EXPECT_EQ(surface.edge_chains.rows(), 60);
  EXPECT_EQ(surface.edge_chains.cols(), 9);
  // Neighbours of a chain are corners of one quad.
  std::map<std::pair<int, int>, int> sides;
  for (size_t c = 0; c < surface.cage.mesh.corners.size(); ++c)
    ++sides[std::minmax(surface.cage.mesh.corners[c], surface.cage.mesh.corners[c % 4 == 3 ? c - 3 : c + 1])];
  for (Eigen::Index e = 0; e < 60; ++e)
    for (Eigen::Index k = 0; k < 8; ++k)
      EXPECT_EQ(sides[std::minmax(surface.edge_chains(e, k), surface.edge_chains(e, k + 1))], 2);
}

}  // namespace
}  // namespace batten
