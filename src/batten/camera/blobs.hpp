#pragma once
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/camera/pen.hpp"

namespace batten {

/// A bright spot in an image.
struct Blob {
  Eigen::Vector2d pixel;       ///< its centre
  Eigen::Matrix2d covariance;  ///< of the centre, pixels²
};

/// What one camera saw at one time.
struct BlobFrame {
  double time = 0;  ///< middle of the exposure, seconds
  CameraSide camera = CameraSide::Left;
  std::vector<Blob> blobs;
  std::string image{};  ///< file that the blobs are still to be found in, beside the recording; else empty
};

/// A reading of the inertial sensor in the pen, in its own axes.
struct PenInertialReading {
  double time = 0;                ///< seconds
  Eigen::Vector3d gyroscope;      ///< rad/s
  Eigen::Vector3d accelerometer;  ///< specific force, m/s²
};

/// A button of the pen that goes down or up.
struct ButtonEvent {
  double time = 0;
  std::string button;  ///< "draw", "node", "mode"
  bool down = false;
};

/// What two cameras saw of a pen, each frame at its own time; frames, readings and events are in order of
/// time.
struct BlobRecording {
  std::vector<BlobFrame> frames;
  std::vector<PenInertialReading> inertial;
  std::vector<ButtonEvent> buttons;
  int width = 0, height = 0;  ///< of the images, pixels; 0: not known
};

/// A pose of a pen and when it had it.
struct TimedPose {
  double time = 0;
  PenPose pose;
  bool drawing = false;  ///< with the button held down
};

}  // namespace batten
