#include <algorithm>
#include <cmath>

#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/scan/noise_model_detail.hpp"

namespace batten {

std::optional<std::string> NoiseModel::problem() const {
  const struct {
    const char* name;
    double value;
  } figures[] = {{"white", white}, {"drift", drift},     {"drift_length", drift_length},
                 {"scale", scale}, {"stretch", stretch}, {"bending", bending},
                 {"jerk", jerk}};
  for (const auto& [name, value] : figures)
    if (!(value > 0) || !std::isfinite(value)) return concat(name, " must be > 0, got ", value);
  return std::nullopt;
}

std::optional<std::string> JointOptions::problem() const {
  const auto negative = [](double value) { return !(value >= 0) || !std::isfinite(value); };
  if (!(size > 0) || !std::isfinite(size)) return concat("size must be > 0, got ", size);
  if (negative(reading_noise)) return concat("reading_noise must be >= 0, got ", reading_noise);
  if (negative(scale_deviation)) return concat("scale_deviation must be >= 0, got ", scale_deviation);
  if (negative(speed_deviation)) return concat("speed_deviation must be >= 0, got ", speed_deviation);
  if (speed_deviation > 0 && !(scale_deviation > 0))
    return concat("speed_deviation needs a scale_deviation, got ", scale_deviation);
  if (negative(xi)) return concat("xi must be >= 0, got ", xi);
  if (n_draws < 0) return concat("n_draws must be >= 0, got ", n_draws);
  if (noise)
    if (const auto wrong = noise->problem()) return "noise." + *wrong;
  return std::nullopt;
}

NoisePrior::NoisePrior(const JointOptions& options) {
  const double white =
      std::max(options.reading_noise, kLeastNoise);  // from neighbours: right within a factor
  const bool known_scale = options.scale_deviation > 0;
  const double scale = known_scale ? options.scale_deviation : 0.003;
  figures_ = {{
      // figure                    centre       factor  low                               high
      {&NoiseModel::white, white, 1.5, std::max(kLeastNoise, white / 3), 3 * white},
      // No device drifts by tens of degrees.
      {&NoiseModel::drift, 0.5 * white, 2, 0.1 * kLeastNoise, std::max(radians(3), 4 * white)},
      {&NoiseModel::drift_length, 0.2, 2, 0.01, 2},
      // No odometer is wrong by a tenth.
      {&NoiseModel::scale, scale, 3, known_scale ? scale : 1e-6, known_scale ? scale : 0.02},
      {&NoiseModel::stretch, 100, 100, 1e-3, 1e6},
      {&NoiseModel::bending, 10, 100, 1e-5, 1e8},
      {&NoiseModel::jerk, 1e4, 1000, 1e-3, 1e10},
  }};
  for (int i = 0; i < kFigures; ++i) {
    const NoiseFigure& f = figures_[i];
    scale_[i] = std::log(f.factor);
    low_[i] = std::log(f.low / f.centre) / scale_[i];
    high_[i] = std::log(f.high / f.centre) / scale_[i];
  }
}

NoiseModel NoisePrior::at(const Coordinates& u) const {
  NoiseModel noise;
  for (int i = 0; i < kFigures; ++i)
    noise.*figures_[i].figure = figures_[i].centre * std::exp(u[i] * scale_[i]);
  return noise;
}

NoisePrior::Coordinates NoisePrior::coordinates(const NoiseModel& noise) const {
  Coordinates u;
  for (int i = 0; i < kFigures; ++i)
    u[i] = std::log(noise.*figures_[i].figure / figures_[i].centre) / scale_[i];
  return u;
}

}  // namespace batten
