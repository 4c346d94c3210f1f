#include "batten/subdivision/limit_stencils.hpp"

#include "subdivision/cages.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/subdivision/subdivide.hpp"

namespace batten {
namespace {

using Eigen::Index;

/// Largest difference from the limit points of OpenSubdiv, which makes as many levels as sharpness lasts.
double worst_difference(const ControlCage& cage) {
  const Points rows = limit_stencils(cage) * cage.mesh.positions;
  const Points limit = subdivide(cage, {.levels = 0, .limit = true}).limit_positions;
  return (rows - limit.topRows(rows.rows())).rowwise().norm().maxCoeff();
}

/// A cage of quads with vertices of valence 3 to 6, closed or with a border, shaken so that no symmetry hides
/// a wrong weight.
ControlCage shaken(ControlCage cage, Random& random) {
  for (Index v = 0; v < cage.mesh.positions.rows(); ++v)
    for (int c = 0; c < 3; ++c) cage.mesh.positions(v, c) += random.uniform(-0.2, 0.2);
  return cage;
}

/// Six quads around one vertex.
ControlCage fan() {
  ControlCage cage;
  cage.mesh.positions.resize(13, 3);
  cage.mesh.positions.row(0).setZero();
  for (int k = 0; k < 6; ++k) {
    cage.mesh.positions.row(1 + 2 * k) << std::cos(kPi * k / 3), std::sin(kPi * k / 3), 0;
    cage.mesh.positions.row(2 + 2 * k) << 1.5 * std::cos(kPi * (k + 0.5) / 3),
        1.5 * std::sin(kPi * (k + 0.5) / 3), 0.1;
    cages::add_face(cage.mesh, {0, 1 + 2 * k, 2 + 2 * k, 1 + (2 * k + 2) % 12});
  }
  return cage;
}

TEST(LimitStencils, AreTheLimitPointsForAnySharpness) {
  Random random(3);
  for (int turn = 0; turn < 60; ++turn) {
    ControlCage cage = shaken(turn % 3 == 0   ? cages::cube()
                              : turn % 3 == 1 ? cages::torus(5, 4)
                                              : fan(),
                              random);
    const PolygonMesh& mesh = cage.mesh;
    for (size_t first = 0; first < mesh.corners.size(); first += 4)
      for (size_t k = 0; k < 4; ++k) {
        if (random.uniform(0, 1) > 0.3) continue;
        // Fractions, whole levels, and for ever; opposite sides may name an edge twice.
        const double any[] = {0.3, 1, 1.7, 2, 3.25, kInfinitelySharp};
        cage.sharp_edges.push_back({mesh.corners[first + k], mesh.corners[first + (k + 1) % 4],
                                    any[static_cast<size_t>(random.uniform(0, 6))]});
      }
    if (turn % 4 == 0) cage.sharp_vertices.push_back({2, 1.4});
    EXPECT_LT(worst_difference(cage), 1e-6) << "turn " << turn;
  }
}

// Two quads back to back: every vertex has two edges and two faces, for which the general weights do not
// hold.
TEST(LimitStencils, AreTheLimitPointsAtVerticesOfTwoEdges) {
  Random random(4);
  ControlCage pillow;
  pillow.mesh.positions.resize(4, 3);
  pillow.mesh.positions << 0, 0, 0, 2, 0, 0, 2, 2, 1, 0, 2, 0;
  cages::add_face(pillow.mesh, {0, 1, 2, 3});
  cages::add_face(pillow.mesh, {3, 2, 1, 0});
  EXPECT_LT(worst_difference(shaken(pillow, random)), 1e-6);
  const SparseMatrix rows = limit_stencils(pillow);
  EXPECT_LT((rows * Eigen::VectorXd::Ones(4) - Eigen::VectorXd::Ones(4)).norm(), 1e-14);
}

TEST(LimitStencils, RowsSumToOne) {
  ControlCage cage = cages::cube_with_sharp_edges();
  cage.sharp_edges.push_back({2, 6, 1.5});
  const SparseMatrix rows = limit_stencils(cage);
  EXPECT_LT((rows * Eigen::VectorXd::Ones(rows.cols()) - Eigen::VectorXd::Ones(rows.rows())).norm(), 1e-12);
}

TEST(LimitStencils, RefuseOtherFacesThanQuads) {
  ControlCage cage;
  cage.mesh.positions = Points::Random(3, 3);
  cages::add_face(cage.mesh, {0, 1, 2});
  EXPECT_THROW(limit_stencils(cage), InvalidInput);
}

}  // namespace
}  // namespace batten
