#include "batten/scan/integration.hpp"

#include "scan/scan_fixtures.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/scan/prefilter.hpp"

namespace batten {
namespace {

SampledScan exact_samples(AnalyticShape shape, double step) {
  SimulateOptions device;
  device.step = 0.004;
  const TracedNetwork traced = trace_shape(shape);
  const Scan scan = simulate_scan(traced, device).scan;
  std::vector<std::string> warnings;
  PrefilterOptions options;
  options.step = step * traced.diameter;
  return resample(scan, clean_readings(scan, {}, warnings), options);
}

TEST(Integration, StepOfAConstantTurnIsExactOnAHelix) {
  // x(s) = (cos s, sin s, s)/√2 has unit speed and a frame that turns at a constant rate.
  const auto frame = [](double s) {
    const double r = std::sqrt(0.5);
    return darboux_frame(r * Eigen::Vector3d(-std::sin(s), std::cos(s), 1), {std::cos(s), std::sin(s), 0});
  };
  const auto x = [](double s) {
    return Eigen::Vector3d(std::sqrt(0.5) * Eigen::Vector3d(std::cos(s), std::sin(s), s));
  };
  for (const double h : {1e-4, 0.1, 1.0}) {
    const Eigen::Vector3d d = frame_step(frame(0.3), frame(0.3 + h), h, StepRule::ConstantRate);
    EXPECT_LT((d - (x(0.3 + h) - x(0.3))).norm(), 1e-14);
  }
}

TEST(Integration, BothFormsRecoverStepsThatClose) {
  // Steps taken from positions close exactly, so both forms give the positions back.
  const SampledScan scan = exact_samples(AnalyticShape::Torus, 0.03);
  const VertexNumbering numbering = number_vertices(scan);
  Random random(5);
  Points truth = Points::NullaryExpr(numbering.n_vertices, 3, [&] { return random.normal(); });
  truth.rowwise() -= Eigen::RowVector3d(truth.row(0));
  std::vector<Points> steps;
  for (size_t c = 0; c < scan.curves.size(); ++c) {
    Points d(scan.curves[c].n_samples() - 1, 3);
    for (Eigen::Index k = 0; k < d.rows(); ++k)
      d.row(k) = truth.row(numbering.vertices[c][k + 1]) - truth.row(numbering.vertices[c][k]);
    steps.push_back(d);
  }
  for (const ClosureForm form : {ClosureForm::FirstDifference, ClosureForm::SecondDifference}) {
    const IntegrationResult result = integrate_steps(scan, steps, form);
    EXPECT_LT((result.positions - truth).norm(), 1e-9);
    EXPECT_LT(result.closure_misfit, 1e-10);
  }
}

/// Σ over rows of both forms, for the check that the condensed solution is the minimum.
double energy_of(const SampledScan& scan, const std::vector<Points>& steps, const Points& x,
                 ClosureForm form) {
  const VertexNumbering numbering = number_vertices(scan);
  double energy = 0;
  for (size_t c = 0; c < scan.curves.size(); ++c) {
    const int n = scan.curves[c].n_samples() - 1;
    Points e(n, 3);
    for (int k = 0; k < n; ++k)
      e.row(k) = (x.row(numbering.vertices[c][k + 1]) - x.row(numbering.vertices[c][k]) - steps[c].row(k)) /
                 scan.curves[c].step(k);
    if (form == ClosureForm::FirstDifference) {
      for (int k = 0; k < n; ++k) energy += e.row(k).squaredNorm() * scan.curves[c].step(k);
      continue;
    }
    for (int k = 1; k < n; ++k) energy += (e.row(k) - e.row(k - 1)).squaredNorm();
    energy += scan.curves[c].closed ? (e.row(0) - e.row(n - 1)).squaredNorm()
                                    : e.row(0).squaredNorm() + e.row(n - 1).squaredNorm();
  }
  return energy;
}

TEST(Integration, CondensedSolutionsMinimiseTheWholeLeastSquaresProblem) {
  for (const AnalyticShape shape : {AnalyticShape::Sphere, AnalyticShape::Cone, AnalyticShape::Waves}) {
    const SampledScan scan = exact_samples(shape, 0.06);
    std::vector<Points> steps = frame_steps(scan, StepRule::Tangent);
    Random random(6);
    for (Points& d : steps)
      for (Eigen::Index i = 0; i < d.size(); ++i) d.data()[i] *= 1 + 0.05 * random.normal();
    for (const ClosureForm form : {ClosureForm::FirstDifference, ClosureForm::SecondDifference}) {
      const Points x = integrate_steps(scan, steps, form).positions;
      const double least = energy_of(scan, steps, x, form);
      for (int i = 0; i < 20; ++i) {
        const Points noise = Points::NullaryExpr(x.rows(), 3, [&] { return random.normal(); });
        const double up = energy_of(scan, steps, x + 1e-3 * noise, form);
        const double down = energy_of(scan, steps, x - 1e-3 * noise, form);
        // At a minimum of a quadratic the two sides rise alike.
        EXPECT_NEAR(up - least, down - least, 1e-6 * (up - least) + 1e-12);
        EXPECT_GT(up, least);
      }
    }
  }
}

TEST(Integration, RefusesPartsThatAreNotConnected) {
  SampledScan scan = exact_samples(AnalyticShape::Sphere, 0.06);
  for (int& id : scan.curves[0].node_ids) id += 100;
  EXPECT_THROW(integrate_steps(scan, frame_steps(scan, StepRule::Tangent), ClosureForm::FirstDifference),
               InvalidInput);
}

TEST(Integration, PreviewFollowsTheStepsFromTheFirstCommonNode) {
  const SampledScan scan = exact_samples(AnalyticShape::Sphere, 0.01);
  const std::vector<Points> lines = integrate_preview(scan);
  const Points x =
      integrate_steps(scan, frame_steps(scan, StepRule::ConstantRate), ClosureForm::FirstDifference)
          .positions;
  const VertexNumbering numbering = number_vertices(scan);
  for (size_t c = 0; c < lines.size(); ++c)
    for (Eigen::Index k = 0; k < lines[c].rows(); ++k)
      EXPECT_LT((lines[c].row(k) - lines[0].row(0) -
                 (x.row(numbering.vertices[c][k]) - x.row(numbering.vertices[0][0])))
                    .norm(),
                1e-6);
}

}  // namespace
}  // namespace batten
