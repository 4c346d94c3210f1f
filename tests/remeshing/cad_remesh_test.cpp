#include "remeshing/cad_parts.hpp"
#include "sanitizers.hpp"

#include <cmath>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "batten/core/units.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/mesh/halfedge_mesh.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/remeshing/area_samples.hpp"
#include "batten/remeshing/remesh.hpp"

namespace batten {
namespace {

using Eigen::Vector3d;
using fixtures::rectangle;
using fixtures::ring;

/// A part and the width of its detail: facets of its finest cylinders, or its thickness.
struct Part {
  const char* name;
  TriangleMesh mesh;
  double detail, volume;
};

double polygon_area(int sides, double radius) {
  return 0.5 * sides * radius * radius * std::sin(2 * kPi / sides);
}
double side(int sides, double radius) {
  return 2 * radius * std::sin(kPi / sides);
}

std::vector<Part> parts() {
  std::vector<Part> result;
  for (const int n : {8, 10, 14, 22, 36, 57, 64})
    result.push_back({"rod", fixtures::rod(n, 1, 9), side(n, 1), 9 * polygon_area(n, 1)});
  result.push_back({"thin rod", fixtures::rod(18, 0.1, 10), side(18, 0.1), 10 * polygon_area(18, 0.1)});
  result.push_back({"disc", fixtures::rod(30, 2, 0.4, true), side(30, 2), 0.4 * polygon_area(30, 2)});
  result.push_back(
      {"plate",
       fixtures::plate(rectangle(0, 0, 5, 2), {ring(18, 0.5, 0, 1.2, 1), ring(26, 0.7, 0, 3.5, 0.9)}, 0.25),
       side(26, 0.7), 0.25 * (10 - polygon_area(18, 0.5) - polygon_area(26, 0.7))});
  result.push_back({"flange", fixtures::flange(40, 2.5, 0.6, 5, 0.2, 14, 0.3, 1, 0.7), side(14, 0.2),
                    0.3 * (polygon_area(40, 2.5) - 5 * polygon_area(14, 0.2)) + 0.7 * polygon_area(40, 1) -
                        polygon_area(40, 0.6)});
  result.push_back({"bracket", fixtures::bracket(3, 4, 2, 0.25, 28, 0.6), side(28, 0.6),
                    2 * 0.25 * (3 + 4 - 0.25) - 2 * 0.25 * polygon_area(28, 0.6)});
  result.push_back({"shaft", fixtures::stepped_shaft(28, {{0.7, 2}, {1.1, 0.5}, {0.6, 4}}), side(28, 0.7),
                    2 * polygon_area(28, 0.7) + 0.5 * polygon_area(28, 1.1) + 4 * polygon_area(28, 0.6)});
  return result;
}

double largest_distance(const TriangleMesh& from, const TriangleMesh& to, double spacing) {
  const TriangleTree tree(to.positions, to.triangles);
  double squared = 0;
  for (Eigen::Index v = 0; v < from.n_vertices(); ++v)
    squared = std::max(squared, tree.closest(Vector3d(from.positions.row(v))).squared_distance);
  for (const AreaSample& sample : area_samples(from.positions, from.triangles, spacing * spacing))
    squared = std::max(squared, tree.closest(sample.point).squared_distance);
  return std::sqrt(squared);
}

// The parts are what their formulas say, so that the tests below start from the right shapes.
TEST(RemeshParts, AreSolids) {
  for (const Part& part : parts()) {
    SCOPED_TRACE(part.name);
    const HalfedgeMesh mesh(part.mesh.positions, part.mesh.triangles);
    for (int h = 0; h < mesh.halfedge_capacity(); ++h) ASSERT_FALSE(mesh.is_border_edge(h));
    EXPECT_NEAR(enclosed_volume(part.mesh.positions, part.mesh.triangles), part.volume, 1e-9 * part.volume);
    EXPECT_TRUE(self_intersections(part.mesh.positions, part.mesh.triangles).empty());
    EXPECT_LT(degrees(mesh_quality(part.mesh.positions, part.mesh.triangles).min_angle), 16);
  }
}

// What a part from a CAD program must come out as, from edges finer than its detail to edges as long as it:
// the same solid (all of its corners, its volume, no distance), edges of the length asked for, nothing that
// crosses.
TEST(RemeshParts, StayAsTheyAre) {
  for (const Part& part : parts())
    for (const double ratio : {0.5, 1.0, 2.0}) {
      const double edge = ratio * part.detail;
      const double area = surface_area(part.mesh.positions, part.mesh.triangles);
      if (area > test::repeated(1200, 300) * edge * edge) continue;  // for the time it takes
      SCOPED_TRACE(std::string(part.name) + ", " + std::to_string(part.mesh.n_vertices()) +
                   " vertices, edge " + std::to_string(edge));
      RemeshOptions options;
      options.edge_length = edge;
      const TriangleMesh result = remesh(part.mesh, options).mesh;
      EXPECT_NEAR(enclosed_volume(result.positions, result.triangles), part.volume, 1e-6 * part.volume);
      EXPECT_LT(largest_distance(part.mesh, result, 0.2 * edge), 1e-6 * edge);
      EXPECT_LT(largest_distance(result, part.mesh, 0.2 * edge), 1e-6 * edge);
      EXPECT_TRUE(self_intersections(result.positions, result.triangles, 1).empty());
      EXPECT_NEAR(mesh_quality(result.positions, result.triangles).mean_edge, edge, 0.2 * edge);
      const HalfedgeMesh mesh(result.positions, result.triangles);
      EXPECT_EQ(mesh.breach(), "");
      EXPECT_EQ(2 * result.n_vertices() - result.n_triangles(),
                2 * part.mesh.n_vertices() - part.mesh.n_triangles());  // Euler
      std::set<std::tuple<double, double, double>> places;
      for (Eigen::Index v = 0; v < result.n_vertices(); ++v)
        places.emplace(result.positions(v, 0), result.positions(v, 1), result.positions(v, 2));
      std::size_t kept = 0;
      for (Eigen::Index v = 0; v < part.mesh.n_vertices(); ++v)
        kept +=
            places.count({part.mesh.positions(v, 0), part.mesh.positions(v, 1), part.mesh.positions(v, 2)});
      // All but the middles of the disc, which are flat.
      EXPECT_GE(static_cast<Eigen::Index>(kept) + 2, part.mesh.n_vertices());
    }
}

// Triangles of 1:100 in strips of a facet's width, without a line to keep but those of the part.
TEST(RemeshParts, HaveFairTrianglesWhereThereIsRoom) {
  RemeshOptions options;
  options.edge_length = 0.08;
  const TriangleMesh result = remesh(fixtures::rod(10, 0.5, 10), options).mesh;  // facets of 0.31
  EXPECT_GT(degrees(mesh_quality(result.positions, result.triangles).mean_min_angle), 45);
  EXPECT_GT(regular_share(result.triangles, result.n_vertices()), 0.7);
}

}  // namespace
}  // namespace batten
