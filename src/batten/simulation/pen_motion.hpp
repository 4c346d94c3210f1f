#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "batten/camera/blobs.hpp"
#include "batten/core/arrays.hpp"
#include "batten/core/choices.hpp"

namespace batten {

/// Paths that a simulated hand draws.
enum class PenPath {
  Circle,   ///< radius 40 mm
  Line,     ///< 120 mm
  Spiral,   ///< from 15 to 45 mm, two and a half turns
  Letters,  ///< H, E, N, 30 mm high, with the pen up between strokes
};

constexpr auto choices_of(PenPath) {
  return choices<PenPath>("path", {{PenPath::Circle, "circle"},
                                   {PenPath::Line, "line"},
                                   {PenPath::Spiral, "spiral"},
                                   {PenPath::Letters, "letters"}});
}

/// The strokes of a path, n × 3 each, metres, about the origin in the plane z = 0.
std::vector<Points> strokes_of(PenPath path);

/// How a hand moves a pen along strokes.
struct PenMotionOptions {
  std::uint64_t seed = 0;
  double distance = 0.6;      ///< of the middle of the LEDs from the middle between the cameras, metres
  double speed = 0.1;         ///< along strokes, m/s
  double tremor = 0.1e-3;     ///< at about 9 Hz: root mean square per axis, metres
  double duration = 12;       ///< seconds at least, strokes are drawn again until then; 0: once
  double largest_tilt = 1.0;  ///< of the pen against the vertical, radians, below π/3 + 0.01
  /// The tip rests in a dimple and draws nothing, the pen turns about it to all sides (calibrate_pivot()).
  bool pivot = false;
  /// Turn the strokes at random; else x and y stay those of the cameras.
  bool turn = true;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A pen that moves: poses at a fixed step, between which it is interpolated by cubics.
class PenMotion {
 public:
  /// The strokes one after the other with 0.4 s in the air between, corners rounded by a hand that follows
  /// with a Gaussian of 12 ms; the pen leans by up to `largest_tilt` and sways by some degrees.
  /// @param middle  where the middle of the LEDs is to be, on average, left camera coordinates
  /// @throws InvalidInput on bad options or a stroke of fewer than two points.
  PenMotion(const std::vector<Points>& strokes, const Pen& pen, const Eigen::Vector3d& middle,
            const PenMotionOptions& options);

  double duration() const { return step_ * static_cast<double>(poses_.size() - 1); }
  /// The pose at a time, 0 … duration().
  PenPose at(double time) const;
  /// When the button is held down: pairs of times.
  const std::vector<std::pair<double, double>>& drawing() const { return drawing_; }
  bool is_drawing(double time) const;

 private:
  void follow(const std::vector<Eigen::Vector3d>& tips, const Pen& pen, const PenMotionOptions& options);

  double step_ = 1e-3;
  std::vector<PenPose> poses_;
  std::vector<std::pair<double, double>> drawing_;
};

}  // namespace batten
