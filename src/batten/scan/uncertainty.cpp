#include "batten/scan/uncertainty.hpp"

#include <cmath>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/parallel.hpp"
#include "batten/mesh/registration.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/integration.hpp"

namespace batten {

namespace {

Points placed(const SampledScan& scan) {
  return integrate_steps(scan, frame_steps(scan, StepRule::ConstantRate), ClosureForm::FirstDifference)
      .positions;
}

/// The network of a draw.
Points placed(SampledScan scan, const JointDraw& draw) {
  for (std::size_t c = 0; c < scan.curves.size(); ++c) {
    SampledCurve& curve = scan.curves[c];
    for (int k = 0; k < curve.n_samples(); ++k)
      curve.frames[static_cast<std::size_t>(k)] =
          so3_exp(draw.turns[c].row(k).transpose()) * curve.frames[static_cast<std::size_t>(k)];
    Eigen::VectorXd steps =
        curve.parameters.tail(curve.n_samples() - 1) - curve.parameters.head(curve.n_samples() - 1);
    steps.array() *= draw.log_factors[c].array().exp();
    for (Eigen::Index k = 0; k < steps.size(); ++k) curve.parameters[k + 1] = curve.parameters[k] + steps[k];
  }
  return placed(scan);
}

/// The difference that a draw makes, moved rigidly back onto the network.
NetworkVariation variation_of(const JointEstimate& estimate, const JointDraw& draw, const Points& base,
                              const VertexNumbering& numbering) {
  const Points moved = placed(estimate.scan, draw);
  const SimilarityTransform back = fit_transform(moved, base, RegistrationKind::Rigid);
  NetworkVariation variation;
  variation.moves = back(moved) - base;
  const Eigen::RowVector3d turned_back = so3_log(back.rotation).transpose();
  variation.turns = Points::Zero(base.rows(), 3);
  Eigen::VectorXd visits = Eigen::VectorXd::Zero(base.rows());
  for (std::size_t c = 0; c < draw.turns.size(); ++c)
    for (Eigen::Index k = 0; k < draw.turns[c].rows(); ++k) {
      const int v = numbering.vertices[c][static_cast<std::size_t>(k)];
      variation.turns.row(v) += draw.turns[c].row(k) + turned_back;
      ++visits[v];
    }
  variation.turns.array().colwise() /= visits.array().max(1);
  return variation;
}

}  // namespace

double deviation_of(const Eigen::Matrix3d& covariance) {
  // Σ λ_i z_i² has the mean t = tr C and the variance 2 tr C²: g χ²_h with g = tr C² / t, h = t² / tr C².
  const double trace = covariance.trace(), square = covariance.squaredNorm();
  if (!(trace > 0)) return 0;
  const double freedom = trace * trace / square, scale = square / trace;
  constexpr double kNormalQuantile = 1.6906;  // of 0.9545
  const double spread = 2 / (9 * freedom);
  const double root = 1 - spread + kNormalQuantile * std::sqrt(spread);
  return 0.5 * std::sqrt(scale * freedom * root * root * root);
}

NetworkUncertainty network_uncertainty(const JointEstimate& estimate, const Progress& progress) {
  const auto n_draws = static_cast<Eigen::Index>(estimate.draws.size());
  if (n_draws < 2) throw InvalidInput("the uncertainty of a network needs at least 2 draws");
  const Points base = placed(estimate.scan);
  const VertexNumbering numbering = number_vertices(estimate.scan);
  NetworkUncertainty result;
  result.draws.resize(estimate.draws.size());
  parallel_for(
      n_draws, 1,
      [&](Eigen::Index begin, Eigen::Index end) {
        for (Eigen::Index i = begin; i < end; ++i)
          result.draws[static_cast<std::size_t>(i)] =
              variation_of(estimate, estimate.draws[static_cast<std::size_t>(i)], base, numbering);
      },
      progress);
  result.deviations.resize(base.rows());
  for (Eigen::Index v = 0; v < base.rows(); ++v) {
    // About what was found, which is the mean.
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (const NetworkVariation& draw : result.draws)
      covariance += draw.moves.row(v).transpose() * draw.moves.row(v);
    result.deviations[v] = deviation_of(covariance / static_cast<double>(n_draws));
  }
  return result;
}

}  // namespace batten
