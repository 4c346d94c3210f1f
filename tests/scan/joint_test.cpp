#include "batten/scan/joint.hpp"

#include "scan/joint_fixtures.hpp"
#include "threads.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/scan/integration.hpp"
#include "batten/scan/joint_model_detail.hpp"
#include "batten/scan/prefilter.hpp"

namespace batten {
namespace {

/// A model linearised at the frames of the readings.
JointModel model_at_readings(const SampledScan& scan, const JointOptions& options) {
  JointModel model(scan, options);
  const JointLayout& layout = model.layout();
  for (int c = 0; c < layout.n_curves; ++c)
    for (int k = 0; k < scan.curves[c].n_samples(); ++k)
      model.state().X[layout.frames.frames[c][k]] = scan.curves[c].frames[k];
  model.set_normal_deviation(options.reading_noise);
  model.linearize({});
  return model;
}

TEST(JointModel, SlopesAreTheDerivativesOfTheEvidence) {
  for (const AnalyticShape shape : {AnalyticShape::Sphere, AnalyticShape::Dish}) {
    for (const bool wrap : {false, true}) {
      const SampledScan scan = test::coarse_samples(shape, 2, wrap);
      JointModel model = model_at_readings(scan, test::coarse_options(shape));
      NoisePrior::Coordinates u = NoisePrior::Coordinates::Zero();
      u[NoisePrior::kScale] = 0.3;
      u[NoisePrior::kDrift] = -0.2;
      const auto evidence = [&](const NoisePrior::Coordinates& at) {
        return model.evaluate(model.prior().at(at), false, {}).evidence;
      };
      const NoiseEvaluation here = model.evaluate(model.prior().at(u), true, {});
      EXPECT_DOUBLE_EQ(here.evidence, evidence(u));
      for (int i = 0; i < NoisePrior::kFigures; ++i) {
        constexpr double h = 1e-3;
        NoisePrior::Coordinates more = u, less = u;
        more[i] += h;
        less[i] -= h;
        const double slope = (evidence(more) - evidence(less)) / (2 * h);
        EXPECT_NEAR(here.slope[i], slope, 1e-4 * (10 + std::abs(slope))) << "figure " << i;
      }
    }
  }
}

// The speeds of two segments change by 30 % and −30 %: their factors are found although no curve's is wrong.
TEST(EstimateJointly, FindsASpeedThatChangesAlongCurves) {
  SampledScan scan = test::coarse_samples(AnalyticShape::Dish, 2);
  JointOptions options = test::coarse_options(AnalyticShape::Dish);
  options.scale_deviation = 0.15;
  const double steady = estimate_jointly(scan, options).cost;
  SampledCurve& curve = scan.curves.front();
  const double length = curve.length();
  for (int k = 0; k < curve.n_samples(); ++k) {
    double& s = curve.parameters[k];
    s += 0.25 * length / (2 * kPi) * std::sin(2 * kPi * s / length);  // speed 1 / (1 + 0.25 cos)
  }
  const double uneven = estimate_jointly(scan, options).cost;
  options.speed_deviation = 0.4;
  const JointEstimate estimate = estimate_jointly(scan, options);
  EXPECT_GT(uneven, steady + 50);
  EXPECT_LT(estimate.cost, uneven - 50);
  EXPECT_NEAR(estimate.speed_spread[0], 0.25 / std::sqrt(2.0), 0.04);
  for (size_t c = 1; c < scan.curves.size(); ++c)
    EXPECT_LT(estimate.speed_spread[static_cast<Eigen::Index>(c)], 0.06) << c;
  EXPECT_NEAR(estimate.scan.length() / scan.length(), 1, 1e-3);
  options.scale_deviation = 0;
  EXPECT_EQ(options.problem(), "speed_deviation needs a scale_deviation, got 0");
}

TEST(JointModel, SegmentsMeetTheirNodesAfterAFewSteps) {
  // The multipliers stand for the positions between the nodes: what is left open is the slip, 1e-4 √L sizes
  // times the force that holds it.
  const SampledScan scan = test::coarse_samples(AnalyticShape::Sphere, 2);
  const JointOptions options = test::coarse_options(AnalyticShape::Sphere);
  JointModel model = model_at_readings(scan, options);
  const NoiseModel noise = model.prior().centre();
  double turn = 1;
  for (int i = 0; i < 20 && turn > 1e-8; ++i) {
    turn = model.apply(model.evaluate(noise, false, {}).step);
    model.linearize({});
  }
  EXPECT_LT(turn, 1e-6);
  const JointState& state = model.state();
  const JointLayout& layout = model.layout();
  SampledScan frames = scan;
  for (int c = 0; c < layout.n_curves; ++c) {
    SampledCurve& curve = frames.curves[c];
    for (int k = 0; k < curve.n_samples(); ++k)
      curve.frames[k] = state.X[layout.frame_of_sample[layout.first_sample[c] + k]];
    curve.parameters *= std::exp(state.log_factors[c]) / options.size;
  }
  const std::vector<Points> steps = fourth_order_steps(frames);
  for (const JointSegment& segment : layout.segments) {
    const Eigen::Vector3d sum = steps[segment.curve]
                                    .middleRows(segment.first_step - layout.first_step[segment.curve],
                                                segment.end_step - segment.first_step)
                                    .colwise()
                                    .sum();
    EXPECT_LT((state.nodes.row(segment.to) - state.nodes.row(segment.from) - sum.transpose()).norm(), 2e-5);
  }
}

TEST(NoisePrior, HasItsCentreWithinItsLimits) {
  for (const double deviation : {0.0, 0.15}) {
    for (const double noise : {0.0, 1e-5, 0.02, 0.3}) {
      JointOptions options;
      options.reading_noise = noise;
      options.scale_deviation = deviation;
      const NoisePrior prior(options);
      for (int i = 0; i < NoisePrior::kFigures; ++i) {
        EXPECT_LE(prior.low()[i], 0);
        EXPECT_GE(prior.high()[i], 0);
      }
      const NoisePrior::Coordinates u = NoisePrior::Coordinates::LinSpaced(-1, 2);
      EXPECT_LT((prior.coordinates(prior.at(u)) - u).norm(), 1e-12);
    }
  }
}

TEST(EstimateJointly, FindsTheNoiseOfTheDevice) {
  // Simulated: 2° white, 1° drift. The mean of the readings of a sample follows them a little.
  const JointOptions options = test::coarse_options(AnalyticShape::Torus);
  const JointEstimate estimate = estimate_jointly(test::coarse_samples(AnalyticShape::Torus, 2), options);
  EXPECT_TRUE(estimate.converged);
  EXPECT_GT(estimate.noise.white, radians(2) / 2);
  EXPECT_LT(estimate.noise.white, radians(2) * 2);
  EXPECT_GT(estimate.noise.drift, radians(1) / 2);
  EXPECT_LT(estimate.noise.drift, radians(1) * 2);
  // Thirteen kinds, two searches, their steps.
  EXPECT_LE(estimate.evaluations, 80);
}

TEST(EstimateJointly, NoNeighbouringNoiseModelIsBetter) {
  const SampledScan scan = test::coarse_samples(AnalyticShape::Dish, 2);
  JointOptions options = test::coarse_options(AnalyticShape::Dish);
  options.robust = false;  // else every noise model trusts other samples
  const JointEstimate best = estimate_jointly(scan, options);
  const NoisePrior prior(options);
  // The normals are held by the noise that a run starts with, so the same start is needed: the centre.
  JointModel model = model_at_readings(scan, options);
  const JointLayout& layout = model.layout();
  for (int c = 0; c < layout.n_curves; ++c)
    for (int k = 0; k < scan.curves[c].n_samples(); ++k)
      model.state().X[layout.frames.frames[c][k]] = best.scan.curves[c].frames[k];
  model.set_normal_deviation(prior.centre().white);
  model.linearize({});
  for (int i = 0; i < 10; ++i) {
    model.apply(model.evaluate(best.noise, false, {}).step);
    model.linearize({});
  }
  const double least = model.evaluate(best.noise, false, {}).evidence;
  for (int i = 0; i < NoisePrior::kFigures; ++i) {
    for (const double change : {0.8, 1.25}) {
      NoiseModel other = best.noise;
      other.*prior[i].figure *= change;
      EXPECT_GT(model.evaluate(other, false, {}).evidence, least - 0.5) << "figure " << i;
    }
  }
}

TEST(EstimateJointly, GivesTheSameBitsForEveryNumberOfThreads) {
  const SampledScan scan = test::coarse_samples(AnalyticShape::Waves, 2);
  const auto estimated = [&](int threads) {
    const test::Threads here(threads);
    return estimate_jointly(scan, test::coarse_options(AnalyticShape::Waves));
  };
  const JointEstimate one = estimated(1);
  for (const int threads : {2, 3}) {
    const JointEstimate other = estimated(threads);
    EXPECT_EQ(other.evidence, one.evidence);
    EXPECT_EQ(other.factor_deviation, one.factor_deviation);
    for (size_t c = 0; c < one.scan.curves.size(); ++c)
      EXPECT_EQ(other.scan.curves[c].frames, one.scan.curves[c].frames);
  }
}

TEST(EstimateJointly, CanBeCancelledAtEveryReport) {
  const SampledScan scan = test::coarse_samples(AnalyticShape::Sphere, 2);
  const JointOptions options = test::coarse_options(AnalyticShape::Sphere);
  const test::Threads one_thread(1);  // on several the number of reports varies
  long reports = 0;
  const Progress counted([&](std::string_view, double fraction) {
    EXPECT_GE(fraction, 0);
    EXPECT_LE(fraction, 1);
    ++reports;
    return true;
  });
  estimate_jointly(scan, options, counted);
  EXPECT_GT(reports, 100);
  for (const double share : {0.0, 0.3, 0.9}) {
    long left = static_cast<long>(share * static_cast<double>(reports));
    EXPECT_THROW(
        estimate_jointly(scan, options, Progress([&](std::string_view, double) { return left-- > 0; })),
        Cancelled);
  }
}

}  // namespace
}  // namespace batten
