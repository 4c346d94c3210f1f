#include "batten/remeshing/surface_fit.hpp"

#include "mesh/shapes.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"

namespace batten {
namespace {

struct FittedSurface {
  Shape shape;
  SurfaceFitResult result;
};

/// A square grid of n × n cells, with `height` at its vertices, fitted to one of `reference` heights.
template <typename Height, typename Reference>
FittedSurface fitted(int n, const Height& height, const Reference& reference, bool hold_border,
                     const SurfaceFitOptions& options = {}) {
  FittedSurface fit;
  fit.shape = fixtures::grid(n, n, false, false,
                             [&](double u, double v) { return Eigen::Vector3d(u, v, height(u, v)); });
  const Shape fine = fixtures::grid(
      8 * n, 8 * n, false, false, [&](double u, double v) { return Eigen::Vector3d(u, v, reference(u, v)); });
  std::vector<char> fixed(static_cast<size_t>(fit.shape.positions.rows()), 0);
  for (Eigen::Index v = 0; v < fit.shape.positions.rows(); ++v) {
    const double x = fit.shape.positions(v, 0), y = fit.shape.positions(v, 1);
    if (hold_border && (x == 0 || y == 0 || x == 1 || y == 1)) fixed[static_cast<size_t>(v)] = 1;
  }
  fit.result = fitted_to_surface(
      fit.shape.positions, fit.shape.triangles, fixed,
      sample_reference(fit.shape.positions, fit.shape.triangles, fine.positions, fine.triangles), options);
  return fit;
}

double level(double, double) {
  return 0;
}

// Small dents over a plane: the plane is the fit, and one step of the linearised problem finds it but for the
// square of the slopes.
TEST(FittedToSurface, FlattensSmallDents) {
  Random random(2);
  const auto dents = [&](double, double) { return 1e-3 * random.normal(); };
  const FittedSurface fit = fitted(10, dents, level, false);
  EXPECT_TRUE(fit.result.solve.converged);
  const double before = fit.shape.positions.col(2).cwiseAbs().maxCoeff(),
               after = fit.result.positions.col(2).cwiseAbs().maxCoeff();
  EXPECT_GT(before, 1e-3);
  EXPECT_LT(after, 0.02 * before);
}

// Vertices that are held stay to the bit; where the mesh fits already nothing moves.
TEST(FittedToSurface, LeavesWhatIsHeldAndWhatFits) {
  Random random(2);
  const FittedSurface fit = fitted(
      10, [&](double, double) { return 1e-3 * random.normal(); }, level, true);
  int held = 0, moved = 0;
  for (Eigen::Index v = 0; v < fit.shape.positions.rows(); ++v) {
    const double x = fit.shape.positions(v, 0), y = fit.shape.positions(v, 1);
    if (x == 0 || y == 0 || x == 1 || y == 1) {
      EXPECT_EQ(fit.result.positions.row(v), fit.shape.positions.row(v));
      ++held;
    } else {
      moved += fit.result.positions.row(v) != fit.shape.positions.row(v) ? 1 : 0;
    }
  }
  EXPECT_EQ(held, 40);
  EXPECT_EQ(moved, 81);
  const FittedSurface same = fitted(6, level, level, false);
  EXPECT_LT((same.result.positions - same.shape.positions).cwiseAbs().maxCoeff(), 1e-12);
}

// A mesh with its vertices on a bowl lies above it throughout; fitted, the error is on both sides: the mean
// height over the bowl falls to a small part.
TEST(FittedToSurface, SpreadsTheErrorOverBothSides) {
  const auto bowl = [](double u, double v) { return 0.3 * ((u - 0.5) * (u - 0.5) + (v - 0.5) * (v - 0.5)); };
  const FittedSurface fit = fitted(8, bowl, bowl, false, {.normals = 0});
  const auto mean_height = [&](const Points& positions) {
    double sum = 0;
    for (Eigen::Index f = 0; f < fit.shape.triangles.rows(); ++f) {
      // The mean of a quadratic function over a triangle is that of the middles of its sides.
      for (int k = 0; k < 3; ++k) {
        const Eigen::RowVector3d p = 0.5 * (positions.row(fit.shape.triangles(f, k)) +
                                            positions.row(fit.shape.triangles(f, (k + 1) % 3)));
        sum += p(2) - bowl(p(0), p(1));
      }
    }
    return sum / static_cast<double>(3 * fit.shape.triangles.rows());
  };
  EXPECT_GT(mean_height(fit.shape.positions), 0);
  EXPECT_LT(std::abs(mean_height(fit.result.positions)), 0.1 * mean_height(fit.shape.positions));
}

// However far away the reference, no vertex moves by more than the share of its shortest edge.
TEST(FittedToSurface, MovesNoFurtherThanItMay) {
  const auto above = [](double, double) { return 0.2; };
  for (const double most : {0.05, 0.25}) {
    const FittedSurface fit = fitted(8, level, above, false, {.most = most});
    const double furthest = (fit.result.positions - fit.shape.positions).rowwise().norm().maxCoeff();
    EXPECT_NEAR(furthest, most / 8, 1e-9);
  }
}

TEST(FittedToSurface, CanBeCancelled) {
  const Shape shape =
      fixtures::grid(2, 2, false, false, [](double u, double v) { return Eigen::Vector3d(u, v, 0); });
  const Progress stop([](std::string_view, double) { return false; });
  EXPECT_THROW(
      fitted_to_surface(shape.positions, shape.triangles, std::vector<char>(9, 0),
                        sample_reference(shape.positions, shape.triangles, shape.positions, shape.triangles),
                        {}, stop),
      Cancelled);
}

}  // namespace
}  // namespace batten
