#include "batten/scan/uncertainty.hpp"

#include "scan/joint_fixtures.hpp"

#include <cmath>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/scan/joint_model_detail.hpp"
#include "batten/scan/prefilter.hpp"

namespace batten {
namespace {

// Half the radii that hold 95.45 % of a normal vector: of one direction 1, of two √(−2 log 0.0455)/2, of
// three √8.0249/2 (chi-squared of three).
TEST(DeviationOf, IsHalfTheRadiusOf954PerCent) {
  const auto of = [](double a, double b, double c) {
    return deviation_of(Eigen::Vector3d(a, b, c).asDiagonal().toDenseMatrix());
  };
  EXPECT_NEAR(of(1, 0, 0), 1, 0.02);
  EXPECT_NEAR(of(1, 1, 0), 0.5 * std::sqrt(-2 * std::log(0.0455)), 0.01);
  EXPECT_NEAR(of(1, 1, 1), 0.5 * std::sqrt(8.0249), 0.01);
  EXPECT_DOUBLE_EQ(of(4, 4, 4), 2 * of(1, 1, 1));
  EXPECT_EQ(of(0, 0, 0), 0);
}

// The covariance of the draws is the inverse of the system, which the selected inverse tells by other means.
TEST(JointModel, DrawsHaveThePosteriorAsTheirCovariance) {
  const SampledScan scan = test::coarse_samples(AnalyticShape::Sphere, 2);
  const JointOptions options = test::coarse_options(AnalyticShape::Sphere);
  JointModel model(scan, options);
  const JointLayout& layout = model.layout();
  for (int c = 0; c < layout.n_curves; ++c)
    for (int k = 0; k < scan.curves[c].n_samples(); ++k)
      model.state().X[layout.frames.frames[c][k]] = scan.curves[c].frames[k];
  model.set_normal_deviation(options.reading_noise);
  model.linearize({});
  const NoiseModel noise = model.prior().centre();
  model.evaluate(noise, true, {});
  Eigen::VectorXd expected(layout.n_frames + layout.n_samples);
  for (int f = 0; f < layout.n_frames; ++f) expected[f] = layout.system.inverse(layout.frame_slot[f]).trace();
  for (int i = 0; i < layout.n_samples; ++i)
    expected[layout.n_frames + i] = layout.system.inverse(layout.drift_slot[i]).trace();
  constexpr int kDraws = 600;
  Eigen::VectorXd found = Eigen::VectorXd::Zero(expected.size());
  for (int i = 0; i < kDraws; ++i) {
    Random random(11, static_cast<std::uint64_t>(i));
    const Eigen::VectorXd draw = model.draw(noise, random);
    for (Eigen::Index block = 0; block < found.size(); ++block)
      found[block] += draw.segment<3>(3 * block).squaredNorm() / kDraws;
  }
  const Eigen::ArrayXd ratio = found.array() / expected.array();
  EXPECT_NEAR(ratio.mean(), 1, 0.03);
  EXPECT_GT(ratio.minCoeff(), 0.75);
  EXPECT_LT(ratio.maxCoeff(), 1.3);
}

// Place and direction of the whole do not count: no draw moves it or turns it. And the deviations are what
// they say: of the true points some 95 % lie within two of them, and they are no larger than they must be.
TEST(NetworkUncertainty, HoldsTheErrorsOfSimulatedScans) {
  const TracedNetwork traced = trace_shape(AnalyticShape::Dish);
  double errors = 0, deviations = 0, within = 0, n = 0;
  for (int seed = 31; seed < 34; ++seed) {
    ScanOptions options;
    options.uncertainty = true;
    options.step = Length{0.04, Length::Kind::Relative};
    const ScanNetwork result =
        network_from_scan(simulate_scan(traced, test::noisy_device(seed)).scan, options);
    ASSERT_TRUE(result.uncertainty.has_value());
    ASSERT_EQ(result.uncertainty->draws.size(), static_cast<size_t>(kUncertaintyDraws));
    for (const NetworkVariation& draw : result.uncertainty->draws) {
      const Points& x = result.network.positions;
      Eigen::Vector3d moved = Eigen::Vector3d::Zero(), turned = Eigen::Vector3d::Zero();
      for (Eigen::Index v = 0; v < x.rows(); ++v) {
        const Eigen::Vector3d arm = x.row(v), move = draw.moves.row(v);
        moved += move;
        turned += arm.cross(move);
      }
      const double size = draw.moves.norm() * std::sqrt(static_cast<double>(x.rows()));
      EXPECT_LT(moved.norm(), 1e-6 * size);
      EXPECT_LT(turned.norm(), 0.01 * size * traced.diameter);
    }
    const Points truth = test::true_points(traced, result);
    const Points off = test::aligned(result.network.positions, truth) - truth;
    for (Eigen::Index v = 0; v < off.rows(); ++v, ++n) {
      const double deviation = result.uncertainty->deviations[v];
      errors += off.row(v).norm();
      deviations += deviation;
      within += off.row(v).norm() < 2 * deviation ? 1 : 0;
    }
  }
  EXPECT_GT(within / n, 0.85);
  EXPECT_GT(errors / deviations, 0.6);  // normal errors in one to three directions: 0.8 to 1.13
  EXPECT_LT(errors / deviations, 1.6);
}

TEST(NetworkUncertainty, IsNotToldWhereNothingTellsTheNoise) {
  ScanOptions options;
  options.uncertainty = true;
  options.weights = WeightChoice::Thesis;
  EXPECT_TRUE(options.problem().has_value());
  EXPECT_THROW(network_uncertainty({}), InvalidInput);
  JointOptions joint;
  joint.n_draws = -1;
  EXPECT_EQ(joint.problem().value_or(""), "n_draws must be >= 0, got -1");
}

}  // namespace
}  // namespace batten
