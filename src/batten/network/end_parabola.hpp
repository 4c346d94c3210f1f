#pragma once
#include <Eigen/Core>

namespace batten::detail {

/// The parabola x(s) = x₀ + a s + b s² that starts at the end x₀ of a curve and fits its next samples in the
/// sense of least squares; s is the length along the samples.
class EndParabola {
 public:
  explicit EndParabola(const Eigen::Vector3d& end) : end_(end), previous_(end) {}

  /// Takes in the next sample along the curve.
  void add(const Eigen::Vector3d& x) {
    length_ += (x - previous_).norm();
    previous_ = x;
    const double s = length_, s2 = s * s;
    s2_ += s2;
    s3_ += s2 * s;
    s4_ += s2 * s2;
    p1_ += s * (x - end_);
    p2_ += s2 * (x - end_);
    ++n_;
  }

  /// Length along the samples so far.
  double length() const { return length_; }
  /// The slope of the straight line that fits the samples. Needs one sample.
  Eigen::Vector3d chord() const { return p1_ / s2_; }
  /// The derivative a at the end; with a single sample the chord.
  Eigen::Vector3d tangent() const {
    return n_ < 2 ? chord() : Eigen::Vector3d((s4_ * p1_ - s3_ * p2_) / (s2_ * s4_ - s3_ * s3_));
  }

 private:
  Eigen::Vector3d end_, previous_, p1_ = Eigen::Vector3d::Zero(), p2_ = Eigen::Vector3d::Zero();
  double length_ = 0, s2_ = 0, s3_ = 0, s4_ = 0;
  int n_ = 0;
};

}  // namespace batten::detail
