#pragma once
#include <string>

#include "batten/core/progress.hpp"
#include "batten/scan/joint.hpp"

namespace batten {

/// Curves whose lengths are only estimated: the deviation of the logarithm of their factors.
constexpr double kEstimatedLengths = 0.15;

/// What lengths from time stamps are worth, and the noise that goes with it.
struct LengthModel {
  double scale_deviation = kEstimatedLengths;  ///< JointOptions::scale_deviation
  double speed_deviation = 0;                  ///< JointOptions::speed_deviation
  JointEstimate estimate;                      ///< of the scan by which it was chosen
  std::string words;                           ///< for reports
};

/// The model of least cost of a scan whose lengths are only estimated: one factor per curve, lengths as good
/// as those of an odometer, or a speed that wanders along each curve, a little to much. Whatever is not one
/// factor per curve must be clearly better: without loops nothing is.
/// @param options of all; the deviations are replaced. Five searches for the noise.
LengthModel choose_length_model(const SampledScan& scan, JointOptions options, const Progress& progress = {});

}  // namespace batten
