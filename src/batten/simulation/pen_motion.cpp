#include "batten/simulation/pen_motion.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"

namespace batten {

namespace {

constexpr double kHover = 0.5;      // seconds before the first and after the last stroke
constexpr double kInTheAir = 0.4;   // seconds between strokes
constexpr double kLift = 0.01;      // metres, at the top between strokes
constexpr double kHand = 0.012;     // seconds: Gaussian with which a hand follows its intention
constexpr double kPlaneTilt = 0.6;  // radians, of the plane of the strokes at most

constexpr double kPivotTime = 12;    // seconds, of a pen in a dimple
constexpr double kPivotSwing = 0.4;  // radians rms about either axis

// Streams of random numbers.
constexpr std::uint64_t kPlane = 101, kLean = 102, kSway = 103, kTremor = 104;

Points polyline(std::initializer_list<Eigen::Vector2d> corners) {
  Points points(static_cast<Eigen::Index>(corners.size()), 3);
  Eigen::Index row = 0;
  for (const Eigen::Vector2d& corner : corners) points.row(row++) << corner.x(), corner.y(), 0;
  return points;
}

/// A sum of sinusoids with random frequencies between two, phases and amplitudes: smooth, and the same
/// whatever the step at which it is asked for.
class Sway {
 public:
  Sway(Random& random, double low, double high, double rms) {
    double power = 0;
    for (Wave& wave : waves_) {
      wave = {2 * kPi * random.uniform(low, high), random.uniform(0, 2 * kPi), random.uniform(0.3, 1.0)};
      power += wave.amplitude * wave.amplitude / 2;
    }
    for (Wave& wave : waves_) wave.amplitude *= rms / std::sqrt(power);
  }
  double at(double time) const {
    double sum = 0;
    for (const Wave& wave : waves_) sum += wave.amplitude * std::sin(wave.frequency * time + wave.phase);
    return sum;
  }

 private:
  struct Wave {
    double frequency, phase, amplitude;
  };
  Wave waves_[8];
};

/// Positions along a polyline at equal steps of length, the ends included.
std::vector<Eigen::Vector3d> along(const Points& points, double step) {
  std::vector<Eigen::Vector3d> result = {points.row(0)};
  double rest = step;
  for (Eigen::Index i = 0; i + 1 < points.rows(); ++i) {
    const Eigen::Vector3d from = points.row(i), to = points.row(i + 1);
    const double length = (to - from).norm();
    double at = rest;
    for (; at < length; at += step) result.push_back(from + at / length * (to - from));
    rest = at - length;
  }
  result.push_back(points.row(points.rows() - 1));
  return result;
}

void smooth(std::vector<Eigen::Vector3d>& path, double sigma) {
  const int radius = static_cast<int>(std::ceil(4 * sigma));
  std::vector<double> weights;
  for (int k = -radius; k <= radius; ++k) weights.push_back(std::exp(-k * k / (2 * sigma * sigma)));
  const std::vector<Eigen::Vector3d> raw = path;
  const int last = static_cast<int>(raw.size()) - 1;
  for (int i = 0; i <= last; ++i) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double total = 0;
    for (int k = -radius; k <= radius; ++k) {
      const double w = weights[static_cast<std::size_t>(k + radius)];
      sum += w * raw[static_cast<std::size_t>(std::clamp(i + k, 0, last))];
      total += w;
    }
    path[static_cast<std::size_t>(i)] = sum / total;
  }
}

/// The way of the tip that is meant, at equal steps of time about the origin: strokes at their speed, a pause
/// before and after, and arcs through the air between.
std::vector<Eigen::Vector3d> intended_path(const std::vector<Points>& strokes, const Eigen::Matrix3d& turn,
                                           double seconds, const PenMotionOptions& options,
                                           std::vector<std::pair<double, double>>& drawing) {
  if (strokes.empty()) throw InvalidInput("there is no stroke to draw");
  std::vector<Eigen::Vector3d> tips;
  const auto hold = [&] { tips.insert(tips.end(), static_cast<std::size_t>(kHover / seconds), tips.back()); };
  std::size_t next = 0;
  do {
    const Points& stroke = strokes[next % strokes.size()];
    if (stroke.rows() < 2) throw InvalidInput(concat("stroke ", next + 1, " has fewer than two points"));
    const std::vector<Eigen::Vector3d> path = along(stroke * turn.transpose(), options.speed * seconds);
    if (tips.empty()) {
      tips.push_back(path.front());
      hold();
    } else {
      const Eigen::Vector3d from = tips.back(), to = path.front();
      const int n = static_cast<int>(kInTheAir / seconds);
      for (int i = 1; i <= n; ++i) {
        const double t = static_cast<double>(i) / n, s = t * t * t * (10 - t * (15 - 6 * t));
        tips.push_back(from + s * (to - from) + kLift * 16 * t * t * (1 - t) * (1 - t) * turn.col(2));
      }
    }
    const double start = seconds * static_cast<double>(tips.size() - 1);
    tips.insert(tips.end(), path.begin() + 1, path.end());
    drawing.emplace_back(start, seconds * static_cast<double>(tips.size() - 1));
    ++next;
  } while (next < strokes.size() || drawing.back().second < options.duration);
  hold();
  return tips;
}

}  // namespace

std::vector<Points> strokes_of(PenPath path) {
  switch (path) {
    case PenPath::Circle: {
      Points points(361, 3);
      for (int i = 0; i <= 360; ++i)
        points.row(i) << 0.04 * std::cos(radians(i)), 0.04 * std::sin(radians(i)), 0;
      return {points};
    }
    case PenPath::Line:
      return {polyline({{-0.06, 0}, {0.06, 0}})};
    case PenPath::Spiral: {
      Points points(901, 3);
      for (int i = 0; i <= 900; ++i) {
        const double radius = 0.015 + 0.03 * i / 900;
        points.row(i) << radius * std::cos(radians(i)), radius * std::sin(radians(i)), 0;
      }
      return {points};
    }
    case PenPath::Letters: {
      const double a = 0.015;
      return {polyline({{-0.05, -a}, {-0.05, a}}), polyline({{-0.03, -a}, {-0.03, a}}),
              polyline({{-0.05, 0}, {-0.03, 0}}),  polyline({{0.01, -a}, {-0.01, -a}, {-0.01, a}, {0.01, a}}),
              polyline({{-0.01, 0}, {0.005, 0}}),  polyline({{0.03, a}, {0.03, -a}, {0.05, a}, {0.05, -a}})};
    }
  }
  return {};
}

std::optional<std::string> PenMotionOptions::problem() const {
  const auto range = [](const char* field, double value, const char* expected) {
    return concat(field, " is ", value, "; expected ", expected);
  };
  if (!(distance >= 0.15 && distance <= 5)) return range("distance", distance, "0.15 to 5 m");
  if (!(speed >= 0.001 && speed <= 2)) return range("speed", speed, "0.001 to 2 m/s");
  if (!(tremor >= 0 && tremor <= 0.01)) return range("tremor", tremor, "0 to 10 mm");
  if (!(duration >= 0 && duration <= 3600)) return range("duration", duration, "0 to 3600 s");
  if (!(largest_tilt >= 0 && largest_tilt <= 1.06))
    return range("largest_tilt", largest_tilt, "0 to 1.06 rad");
  return {};
}

PenMotion::PenMotion(const std::vector<Points>& strokes, const Pen& pen, const Eigen::Vector3d& middle,
                     const PenMotionOptions& options) {
  if (const auto found = options.problem()) throw InvalidInput(*found);
  std::vector<Eigen::Vector3d> tips;
  if (options.pivot) {
    const double seconds = options.duration > 0 ? options.duration : kPivotTime;
    tips.assign(static_cast<std::size_t>(seconds / step_) + 2, Eigen::Vector3d::Zero());
  } else {
    Random plane(options.seed, kPlane);
    const double heading = plane.uniform(0, 2 * kPi), tilt = plane.uniform(-kPlaneTilt, kPlaneTilt);
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    if (options.turn) turn = so3_exp(Eigen::Vector3d(tilt, 0, 0)) * so3_exp(Eigen::Vector3d(0, 0, heading));
    tips = intended_path(strokes, turn, step_, options, drawing_);
    smooth(tips, kHand / step_);
  }
  follow(tips, pen, options);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const PenPose& pose : poses_)
    mean += (led_position(pen, pose, 0) + led_position(pen, pose, kPenLeds - 1)) / 2;
  mean /= static_cast<double>(poses_.size());
  for (PenPose& pose : poses_) pose.tip += middle - mean;
}

void PenMotion::follow(const std::vector<Eigen::Vector3d>& tips, const Pen& pen,
                       const PenMotionOptions& options) {
  Random lean(options.seed, kLean), sway(options.seed, kSway), shake(options.seed, kTremor);
  // The pen leans to one side and sways; y points down, so the other end of an upright pen is at −y.
  double leaning = options.largest_tilt * 0.7 * std::sqrt(lean.uniform());
  const double side = lean.uniform(0, 2 * kPi);
  double swing = 0.12 * options.largest_tilt, tremor = options.tremor;
  if (options.pivot) {  // upright, to all sides, and the tip cannot tremble
    leaning = 0;
    swing = kPivotSwing;
    tremor = 0;
  }
  const Sway swing_x(sway, 0.1, 0.8, swing), swing_z(sway, 0.1, 0.8, swing);
  const double turning = options.tremor / pen.led_distance(kPenLeds - 1);
  const Sway shakes[5] = {{shake, 8, 10, tremor},
                          {shake, 8, 10, tremor},
                          {shake, 8, 10, tremor},
                          {shake, 8, 10, turning},
                          {shake, 8, 10, turning}};
  poses_.resize(tips.size());
  for (std::size_t i = 0; i < tips.size(); ++i) {
    const double t = step_ * static_cast<double>(i);
    const Eigen::Vector2d across(leaning * std::cos(side) + swing_x.at(t) + shakes[3].at(t),
                                 leaning * std::sin(side) + swing_z.at(t) + shakes[4].at(t));
    PenPose& pose = poses_[i];
    // Near its largest tilt the hand gives way smoothly.
    const double wanted = across.norm();
    const double angle =
        options.largest_tilt > 0 ? options.largest_tilt * std::tanh(wanted / options.largest_tilt) : 0;
    const double share = wanted > 0 ? std::sin(angle) / wanted : 0;
    pose.direction = Eigen::Vector3d(share * across.x(), -std::cos(angle), share * across.y());
    pose.tip = tips[i] + Eigen::Vector3d(shakes[0].at(t), shakes[1].at(t), shakes[2].at(t));
  }
}

PenPose PenMotion::at(double time) const {
  const int last = static_cast<int>(poses_.size()) - 1;
  const double place = std::clamp(time / step_, 0.0, static_cast<double>(last));
  const int i = std::min(static_cast<int>(place), last - 1);
  const double t = place - i;
  // The cubic through four neighbours (Catmull and Rom).
  const double weights[4] = {t * (-0.5 + t * (1 - 0.5 * t)), 1 + t * t * (-2.5 + 1.5 * t),
                             t * (0.5 + t * (2 - 1.5 * t)), t * t * (-0.5 + 0.5 * t)};
  PenPose pose{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  for (int k = 0; k < 4; ++k) {
    const PenPose& near = poses_[static_cast<std::size_t>(std::clamp(i - 1 + k, 0, last))];
    pose.tip += weights[k] * near.tip;
    pose.direction += weights[k] * near.direction;
  }
  pose.direction.normalize();
  return pose;
}

bool PenMotion::is_drawing(double time) const {
  for (const auto& [down, up] : drawing_)
    if (time >= down && time <= up) return true;
  return false;
}

}  // namespace batten
