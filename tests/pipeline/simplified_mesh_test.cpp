#include "batten/pipeline/simplified_mesh.hpp"

#include "mesh/shapes.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/mesh/adjacency.hpp"

namespace batten {
namespace {

/// A plane sheet of 10 × 10 cells with a hill.
TriangleMesh hill() {
  return fixtures::as_mesh(fixtures::grid(10, 10, false, false, [](double u, double v) {
    return Eigen::Vector3d(u, v, 0.2 * std::exp(-20 * ((u - 0.5) * (u - 0.5) + (v - 0.5) * (v - 0.5))));
  }));
}

TEST(SimplifiedMesh, IsThatOfTheRoomBelowHeldAgainstTheInput) {
  const TriangleMesh mesh = hill();
  SimplifiedMeshOptions options;
  options.simplify.faces = 60;
  const SimplifiedMesh result = simplified_mesh(mesh, options);
  const TriangleMesh below = simplify(mesh, options.simplify).mesh;
  EXPECT_EQ(result.simplified.mesh.positions, below.positions);
  EXPECT_EQ(result.simplified.mesh.triangles, below.triangles);
  EXPECT_NEAR(result.removed, 1 - below.n_triangles() / 200.0, 1e-15);
  EXPECT_EQ(result.crossings, 0u);
  EXPECT_EQ(result.input_crossings, 0u);
  // A is the input, so A to B are the distances of the input's vertices from the result.
  EXPECT_EQ(result.distances.a_to_b.vertex_distances.size(), mesh.n_vertices());
  EXPECT_EQ(result.distances.b_to_a.vertex_distances.size(), below.n_vertices());
  EXPECT_TRUE(result.warnings.empty());
}

TEST(SimplifiedMesh, RelativeErrorsAreOfTheDiameter) {
  const TriangleMesh mesh = hill();
  SimplifiedMeshOptions relative;
  SimplifiedMeshOptions absolute;
  relative.max_error = Length{0.005, Length::Kind::Relative};
  absolute.simplify.max_error = 0.005 * bounding_box_diagonal(mesh.positions);
  const SimplifiedMesh by_part = simplified_mesh(mesh, relative);
  EXPECT_EQ(by_part.simplified.mesh.positions, simplified_mesh(mesh, absolute).simplified.mesh.positions);
  EXPECT_LT(by_part.simplified.mesh.n_triangles(), mesh.n_triangles());
  EXPECT_LE(by_part.distances.a_to_b.samples.max, 1.05 * 0.005 * by_part.diameter);
}

TEST(LevelMeshes, MapToTheNextCoarserLevel) {
  TriangleMesh mesh = hill();
  mesh.vertex_values["any"] = Eigen::VectorXd::Zero(mesh.n_vertices());
  SimplifiedMeshOptions options;
  options.simplify.faces = 40;
  options.simplify.levels = 3;
  options.simplify.keep_levels = true;
  const SimplifiedMesh result = simplified_mesh(mesh, options);
  const std::vector<TriangleMesh> levels = level_meshes(mesh, result.simplified.levels);
  ASSERT_EQ(levels.size(), result.simplified.levels.size() + 1);
  EXPECT_EQ(levels.front().positions, mesh.positions);
  EXPECT_EQ(levels.front().vertex_values.count("any"), 0u);
  EXPECT_EQ(levels.back().positions, result.simplified.mesh.positions);
  EXPECT_TRUE(levels.back().vertex_values.empty());
  for (std::size_t i = 0; i + 1 < levels.size(); ++i) {
    const Eigen::VectorXd& map = levels[i].vertex_values.at("coarser_vertex");
    ASSERT_EQ(map.size(), levels[i].n_vertices());
    // Every vertex of the coarser level stands for one at least; −1 and whole numbers only.
    std::vector<char> used(static_cast<std::size_t>(levels[i + 1].n_vertices()), 0);
    for (const double v : map) {
      ASSERT_EQ(v, std::floor(v));
      ASSERT_LT(v, levels[i + 1].n_vertices());
      if (v >= 0) used[static_cast<std::size_t>(v)] = 1;
    }
    EXPECT_EQ(std::count(used.begin(), used.end(), 1), levels[i + 1].n_vertices());
  }
}

TEST(SimplifiedMesh, BadOptionsAreNamedAndWorkIsCancelled) {
  SimplifiedMeshOptions options;
  EXPECT_TRUE(options.problem().has_value());  // no criterion
  EXPECT_THROW(simplified_mesh(hill(), options), InvalidInput);
  options.max_error = Length{-1, Length::Kind::Relative};
  EXPECT_NE(options.problem().value_or("").find("max_error"), std::string::npos);
  options.max_error = Length{0.1, Length::Kind::Relative};
  EXPECT_FALSE(options.problem().has_value());
  options.simplify.faces = 10;  // two criteria
  EXPECT_TRUE(options.problem().has_value());
  options.max_error.reset();
  EXPECT_THROW(simplified_mesh({}, options), InvalidInput);
  EXPECT_THROW(simplified_mesh(hill(), options, Progress([](std::string_view, double) { return false; })),
               Cancelled);
}

}  // namespace
}  // namespace batten
