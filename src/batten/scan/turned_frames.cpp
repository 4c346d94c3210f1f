#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/error.hpp"
#include "batten/core/statistics.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/joint_turns_detail.hpp"
#include "batten/scan/turned_frames_detail.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Errors of readings hang together along a curve: so many of them say no more than one.
constexpr double kReadingsPerError = 5;
/// Deviation of a sample at first and at least, radians; beyond so many deviations it loses its say.
constexpr double kFirstSpread = radians(3.0), kLeastSampleSpread = 1e-4, kTrusted = 3;
constexpr double kMedianOfSample = 1.538;  // of a normal 3-vector
constexpr int kMostTurnSteps = 20;
constexpr double kLeastTurnStep = 1e-6;  // radians

/// Frames and gyroscope of a scan, and the samples that speak of them.
class TurnedFrames {
 public:
  explicit TurnedFrames(const SampledScan& scan) : scan_(scan), frames_(number_frames(scan)) {
    int n = frames_.n_frames;
    layout_.find(scan, frames_, n);
    n_blocks_ = n;
    if (layout_.turns.empty()) return;
    std::vector<std::pair<int, int>> joined;
    layout_.join(joined);
    for (auto& [a, b] : joined)
      if (a < b) std::swap(a, b);
    std::sort(joined.begin(), joined.end());
    joined.erase(std::unique(joined.begin(), joined.end()), joined.end());
    system_ = FrameLdlt(n, joined);
    layout_.find_slots(system_);
    X_.assign(frames_.n_frames, Matrix3d::Identity());
    for (size_t c = 0; c < scan.curves.size(); ++c)
      for (int k = scan.curves[c].n_samples() - 1; k >= 0; --k)
        X_[frames_.frames[c][k]] = scan.curves[c].frames[k];
  }

  bool empty() const { return layout_.turns.empty(); }

  /// @return whether the turns fit the frames.
  bool solve(const Progress& progress) {
    JointTurns turns(layout_, kLeastTurnDensity);
    for (int i = 0; i < kMostTurnSteps; ++i) {
      progress.report("gyroscope", static_cast<double>(i) / kMostTurnSteps);
      turns.linearize(X_);
      // The second time the bias is known and the turns fit as well as they ever will.
      if (i == 1 && !choose_density(turns)) return false;
      evaluate(turns);
      double largest = 0;
      for (size_t f = 0; f < X_.size(); ++f) {
        const Vector3d d = step_.segment<3>(3 * static_cast<Eigen::Index>(f));
        largest = std::max(largest, d.norm());
        X_[f] = nearest_rotation(so3_exp(d) * X_[f]);
      }
      turns.apply(step_);
      spread_ = spread();
      if (i > 1 && largest < kLeastTurnStep) break;
    }
    return true;
  }

  SampledScan result() const {
    SampledScan result = scan_;
    for (size_t c = 0; c < result.curves.size(); ++c)
      for (int k = 0; k < result.curves[c].n_samples(); ++k)
        result.curves[c].frames[k] = X_[frames_.frames[c][k]];
    return result;
  }

 private:
  template <typename Body>
  void for_samples(const Body& body) const {
    for (size_t c = 0; c < scan_.curves.size(); ++c)
      for (int k = 0; k < scan_.curves[c].n_samples(); ++k) {
        const int f = frames_.frames[c][k];
        body(f, Vector3d(so3_log(scan_.curves[c].frames[k] * X_[f].transpose())), scan_.curves[c].weights[k]);
      }
  }

  /// Of one reading, about.
  double spread() const {
    std::vector<double> sizes;
    for_samples([&](int, const Vector3d& r, double readings) {
      if (readings > 0) sizes.push_back(r.norm() * std::sqrt(std::max(readings, 1.0)));
    });
    return sizes.empty() ? kFirstSpread : std::max(upper_median(sizes) / kMedianOfSample, kLeastSampleSpread);
  }

  /// The step from here. @return −2 log of the marginal likelihood, up to a constant.
  double evaluate(const JointTurns& turns) {
    system_.clear();
    Eigen::VectorXd right = Eigen::VectorXd::Zero(3L * n_blocks_);
    turns.assemble(system_, right);
    const auto weight = [&](const Vector3d& r, double readings) {
      const double n = std::max(readings, 0.0),
                   z = r.norm() * std::sqrt(std::max(n, 1.0)) / (kTrusted * spread_);
      return n / (kReadingsPerError * spread_ * spread_) * (z < 1 ? 1 : 1 / (z * z * z * z));
    };
    for_samples([&](int f, const Vector3d& r, double readings) {
      const double w = weight(r, readings);
      const Matrix3d J = so3_right_jacobian_inverse(r);  // log(A Xᵀ exp(−η)) ≈ r − J η
      system_.add(system_.slot(f, f), w * (J.transpose() * J));
      right.segment<3>(3L * f) += w * (J.transpose() * r);
    });
    if (!system_.factorize()) throw SolverFailure("frames with the turns of the gyroscope", 3L * n_blocks_);
    step_ = system_.solve(right);
    double energy = turns.energy(step_) + system_.log_determinant();
    for_samples([&](int f, const Vector3d& r, double readings) {
      const Matrix3d J = so3_right_jacobian_inverse(r);
      energy += weight(r, readings) * (r - J * step_.segment<3>(3L * f)).squaredNorm();
    });
    return energy;
  }

  bool choose_density(JointTurns& turns) {
    double least = std::numeric_limits<double>::infinity(), best = kMostTurnDensity;
    for (double density = kLeastTurnDensity; density <= kMostTurnDensity; density *= kTurnDensityFactor) {
      turns.set_density(density);
      const double evidence = evaluate(turns);
      if (evidence < least) least = evidence, best = density;
    }
    turns.set_density(best);
    return best <= kUselessTurnDensity;
  }

  const SampledScan& scan_;
  FrameNumbering frames_;
  TurnLayout layout_;
  int n_blocks_ = 0;
  FrameLdlt system_;
  std::vector<Matrix3d> X_;
  Eigen::VectorXd step_;
  double spread_ = kFirstSpread;
};

}  // namespace

SampledScan turned_frames(const SampledScan& scan, const Progress& progress) {
  TurnedFrames turned(scan);
  if (turned.empty() || !turned.solve(progress)) return scan;
  return turned.result();
}

}  // namespace batten
