#include "operators/sample_meshes.hpp"

#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/operators/curvature.hpp"
#include "batten/surfacing/fairing_detail.hpp"

namespace batten::detail {
namespace {

/// Vertices of a square of n × n that lie on its border or on every third line: patches of 2 × 2 vertices.
std::vector<char> lines_of(int n) {
  std::vector<char> held(static_cast<std::size_t>(n * n));
  for (int v = 0; v < n * n; ++v) held[static_cast<std::size_t>(v)] = v / n % 3 == 0 || v % n % 3 == 0;
  return held;
}

constexpr int kSide = 10;

struct Systems {
  TriangleMesh mesh = samples::square(kSide, 0.6);
  std::vector<char> held = lines_of(kSide);
  std::vector<char> border = border_vertices(mesh.triangles, mesh.n_vertices());
  EdgeLengths lengths = edge_lengths(mesh.positions, mesh.triangles);

  FairingSystems with(FairingFactors factors) const {
    FairingSystems systems(held, border, {}, factors);
    systems.set_metric(mesh.triangles, lengths);
    return systems;
  }
};

Eigen::MatrixXd random_columns(Random& random, Eigen::Index rows, int columns) {
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return random.normal(); });
}

// The same least squares problem, once as K R M⁻¹ K over everything and once patch by patch. Held vertices of
// the border have no row, those inside couple the patches.
TEST(PatchSystems, SolveWhatOneFactorOfAllSolves) {
  const Systems s;
  FairingSystems whole = s.with(FairingFactors::Whole), patches = s.with(FairingFactors::Patches);
  Random random(1);
  const Eigen::MatrixXd target = random_columns(random, s.mesh.n_vertices(), 3),
                        values = random_columns(random, s.mesh.n_vertices(), 3);
  EXPECT_EQ(whole.patches(), nullptr);
  ASSERT_NE(patches.patches(), nullptr);
  EXPECT_EQ(patches.patches()->n_patches(), 9);
  const auto expect_near = [](const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
    EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-11 * b.cwiseAbs().maxCoeff());
  };
  for (const int order : {1, 2, 3})
    expect_near(patches.polyharmonic(order, values), whole.polyharmonic(order, values));
  expect_near(patches.fit_laplacian(target, values), whole.fit_laplacian(target, values));
  expect_near(patches.biharmonic_with_curvature(target, values),
              whole.biharmonic_with_curvature(target, values));
}

// A dense system over the vertices of the chosen patches: rows of the normal equations of |K d − t|² in R
// M⁻¹.
TEST(PatchSystems, DisplaceSomePatchesAndHoldTheOthers) {
  const Systems s;
  FairingSystems systems = s.with(FairingFactors::Patches);
  PatchSystems& patches = *systems.patches();
  const Eigen::MatrixXd K = systems.stiffness();
  const Eigen::MatrixXd A = K * systems.inverse_mass().asDiagonal() * K;
  Random random(2);
  const Eigen::Index n = s.mesh.n_vertices();
  // The node at (3, 3) belongs to four patches of which all may move.
  std::vector<int> chosen;
  const int node = 3 * kSide + 3;
  for (int p = 0; p < patches.n_patches(); ++p)
    if (std::count(patches.rim(p).begin(), patches.rim(p).end(), node) > 0) chosen.push_back(p);
  ASSERT_LT(static_cast<int>(chosen.size()), patches.n_patches());
  Eigen::MatrixXd target = Eigen::MatrixXd::Zero(n, 2), displacement = target;
  std::vector<int> free;
  for (const int p : chosen) {
    for (const int v : patches.vertices(p)) {
      free.push_back(v);
      target.row(v) = random_columns(random, 1, 2);
    }
    for (const int v : patches.rim(p)) target.row(v) = random_columns(random, 1, 2);
  }
  displacement.row(node) << 1, -2;
  Eigen::MatrixXd right = K * (systems.inverse_mass().asDiagonal() * target) - A * displacement;
  const Eigen::MatrixXd inner = A(free, free);
  const Eigen::MatrixXd expected = inner.ldlt().solve(Eigen::MatrixXd(right(free, Eigen::all)));
  patches.displace(chosen, &target, displacement);
  EXPECT_LT((displacement(free, Eigen::all) - expected).norm(), 1e-11 * expected.norm());
  for (Eigen::Index v = 0; v < n; ++v)
    if (v != node && std::count(free.begin(), free.end(), v) == 0) {
      EXPECT_TRUE(displacement.row(v).isZero(0)) << v;
    }
}

// Nothing of an earlier metric, and nothing of another set of patches, is left in a kept solver.
TEST(PatchSystems, KeptSolverIsAsGoodAsAFreshOne) {
  Systems s;
  FairingSystems kept = s.with(FairingFactors::Patches);
  Random random(3);
  const Eigen::MatrixXd values = random_columns(random, s.mesh.n_vertices(), 3);
  for (int round = 0; round < 20; ++round) {
    for (Eigen::Index v = 0; v < s.mesh.n_vertices(); ++v) s.mesh.positions(v, 2) = 0.02 * random.normal();
    s.lengths = edge_lengths(s.mesh.positions, s.mesh.triangles);
    kept.set_metric(s.mesh.triangles, s.lengths);
    Eigen::MatrixXd displacement = Eigen::MatrixXd::Zero(s.mesh.n_vertices(), 1);
    kept.patches()->displace({round % 9}, nullptr, displacement);
    EXPECT_TRUE(displacement.isZero(0));
    FairingSystems fresh = s.with(FairingFactors::Patches);
    EXPECT_EQ(kept.polyharmonic(2, values), fresh.polyharmonic(2, values)) << round;
  }
}

}  // namespace
}  // namespace batten::detail
