#pragma once
#include <array>

#include <Eigen/Core>

#include "batten/scan/joint.hpp"

namespace batten {

/// What is thought of one figure of NoiseModel beforehand.
struct NoiseFigure {
  double NoiseModel::*figure;
  double centre;     ///< where the search starts, and the median of the prior
  double factor;     ///< two thirds lie within this factor of the centre
  double low, high;  ///< beyond, a model would explain noise as shape, or shape as noise
};

/// The figures of a noise model as coordinates of a search: uᵢ = log(figure / centre) / log(factor). The only
/// place where limits and priors of the figures stand.
class NoisePrior {
 public:
  static constexpr int kFigures = 7;
  enum Place { kWhite, kDrift, kDriftLength, kScale, kStretch, kBending, kJerk };
  using Coordinates = Eigen::Matrix<double, kFigures, 1>;

  /// No device is better (0.006°); below, the error of the steps between samples would pass for noise.
  static constexpr double kLeastNoise = 1e-4;

  /// @param options reading noise and scale deviation are taken from here.
  explicit NoisePrior(const JointOptions& options);

  const NoiseFigure& operator[](int i) const { return figures_[i]; }
  NoiseModel centre() const { return at(Coordinates::Zero()); }
  NoiseModel at(const Coordinates& u) const;
  Coordinates coordinates(const NoiseModel& noise) const;
  Coordinates low() const { return low_; }    ///< coordinates of the limits
  Coordinates high() const { return high_; }  ///< equal to low() where a figure is known
  /// d log(figure) / du.
  double scale(int i) const { return scale_[i]; }
  /// −2 log of the prior density, up to a constant: normal in u.
  double operator()(const Coordinates& u) const { return u.squaredNorm(); }

 private:
  std::array<NoiseFigure, kFigures> figures_;
  Coordinates low_, high_, scale_;
};

}  // namespace batten
