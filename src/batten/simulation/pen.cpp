#include "batten/simulation/pen.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"

namespace batten {

namespace {

constexpr double kBaseline = 0.25;       // metres
constexpr double kCrossing = 0.6;        // metres, where the axes meet
constexpr double kLedRadius = 2.5e-3;    // metres
constexpr double kReference = 0.6;       // metres, where an LED has `kReferencePeak`
constexpr double kReferencePeak = 200;   // grey levels
constexpr double kRateError = 50e-6;     // of free-running clocks
constexpr double kTruthStep = 2e-3;      // seconds
constexpr double kLampRadius = 15e-3;    // metres
constexpr double kLampPeak = 400;        // grey levels before clipping
constexpr double kSunRadius = 0.03;      // of the width of the image
constexpr int kMotionSamples = 5;        // per exposure
constexpr double kWiimoteSigma = 0.075;  // pixels, of a centroid above a threshold
constexpr double kWiimoteStep = 1.0 / 8;
constexpr std::size_t kWiimoteBlobs = 4;
constexpr double kInertialRate = 200;         // Hz
constexpr double kGyroscopeDensity = 8.7e-4;  // rad/s/√Hz: 0.05 °/s/√Hz
constexpr double kGyroscopeBias = 8.7e-3;     // rad/s: 0.5 °/s
constexpr double kGyroscopeScale = 0.01;
constexpr double kAccelerometerNoise = 0.02;  // m/s² per reading

// Streams of random numbers.
constexpr std::uint64_t kClock = 201, kNoise = 202, kHandStream = 203, kFalse = 204, kSun = 205, kOrder = 206,
                        kCalibration = 207, kInertial = 208;

struct CameraKind {
  double rate, blur, exposure;
};

CameraKind kind_of(PenRig rig) {
  switch (rig) {
    case PenRig::Wiimote:
      return {100, 0.55, 2e-3};
    case PenRig::Vga:
      return {60, 0.8, 4e-3};
    case PenRig::Global:
      break;
  }
  return {120, 0.9, 2e-3};
}

Camera nominal_camera(PenRig kind) {
  Camera camera;
  const bool global = kind == PenRig::Global;
  camera.width = kind == PenRig::Wiimote ? 128 : global ? 1280 : 640;
  camera.height = kind == PenRig::Wiimote ? 96 : global ? 1024 : 480;
  camera.fx = camera.fy = camera.width / 2.0 / std::tan(radians(global ? 30 : 22.5));
  camera.cx = camera.width / 2.0;
  camera.cy = camera.height / 2.0;
  return camera;
}

/// Times during which a hand covers some of the LEDs.
struct Cover {
  double from, to;
  std::array<bool, kPenLeds> leds;
};

std::vector<Cover> covers_of(const SimulatePenOptions& options, double duration) {
  std::vector<Cover> covers;
  if (!(options.hand > 0)) return covers;
  Random random(options.motion.seed, kHandStream);
  for (double time = random.uniform(0.5, 1.5); time < duration;) {
    Cover cover{time, time + random.uniform(std::min(0.1, options.hand), options.hand), {}};
    const std::uint64_t n = 1 + random.below(3), first = random.below(kPenLeds - n + 1);
    for (std::uint64_t i = first; i < first + n; ++i) cover.leds[i] = true;
    covers.push_back(cover);
    time = cover.to + random.uniform(0.5, 1.5);
  }
  return covers;
}

/// Spots of the sun that wander over the images.
struct SunSpot {
  double from, to;
  bool left, right;
  Eigen::Vector2d start, speed;  // in widths of the image
};

std::vector<SunSpot> sun_of(const SimulatePenOptions& options, double duration) {
  std::vector<SunSpot> spots;
  if (!options.sun) return spots;
  Random random(options.motion.seed, kSun);
  for (double time = random.uniform(0, 1); time < duration; time += random.uniform(1, 4)) {
    const std::uint64_t where = random.below(3);
    const double length = random.uniform(0.5, 3);
    const double u = random.uniform(0.1, 0.9), v = random.uniform(0.1, 0.7);
    const double du = random.uniform(-0.05, 0.05), dv = random.uniform(-0.05, 0.05);
    spots.push_back({time, time + length, where != 1, where != 0, {u, v}, {du, dv}});
  }
  return spots;
}

/// Everything that stands still while frames are taken.
struct Scene {
  const SimulatePenOptions& options;
  const PenMotion& motion;
  const StereoRig& rig;
  CameraKind kind;
  std::vector<Cover> covers;
  std::vector<SunSpot> suns;
  /// Of the plane that mirrors: points x with normal · x = offset.
  Eigen::Vector3d mirror_normal;
  double mirror_offset = 0;
  std::vector<Eigen::Vector3d> lamps;
};

/// Image of an LED at rest.
Spot spot_of(const Scene& scene, const Camera& camera, const Eigen::Vector2d& pixel, double depth,
             double cosine) {
  const auto variance = [&](double z) {
    const double disc = camera.fx * kLedRadius / z;
    return scene.kind.blur * scene.kind.blur + disc * disc / 4;
  };
  const double light = kReferencePeak * variance(kReference) * std::pow(kReference / depth, 2) * cosine;
  return {pixel, std::sqrt(variance(depth)), light / variance(depth)};
}

/// Where a point that moves is seen during the exposure, and the mean of that.
struct ExposedWay {
  std::vector<Eigen::Vector2d> way;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
};

/// A frame and what it is made of.
struct TakenFrame {
  BlobFrame frame;
  std::vector<SeenLight> lights;
};

/// Two normal numbers, one after the other: compilers draw the arguments of one call in orders of their own.
Eigen::Vector2d drawn2(Random& noise) {
  const double y = noise.normal(), x = noise.normal();
  return {x, y};
}

/// Adds the image of a light with its noise.
void add_light(const Scene& scene, const ExposedWay& exposed, double depth, double cosine, Random& noise,
               TakenFrame& taken) {
  const Camera& camera = taken.frame.camera == CameraSide::Left ? scene.rig.left : scene.rig.right;
  const Spot spot = spot_of(scene, camera, exposed.mean, depth, cosine);
  if (scene.options.images)
    taken.lights.push_back({SeenLight::Kind::Led, exposed.way, spot.sigma, spot.peak});
  if (!is_inside(camera, exposed.mean)) return;
  Blob blob;
  const Eigen::Vector2d draw = drawn2(noise);
  if (scene.options.rig == PenRig::Wiimote) {
    blob.pixel = exposed.mean + kWiimoteSigma * draw;
    for (double& value : blob.pixel) value = std::round(value / kWiimoteStep) * kWiimoteStep;
    blob.covariance =
        (kWiimoteSigma * kWiimoteSigma + kWiimoteStep * kWiimoteStep / 12) * Eigen::Matrix2d::Identity();
  } else {
    if (spot.peak < 6 * SensorNoise().read) return;  // lost in the noise
    blob.covariance = centre_bound(spot, {});
    blob.pixel = exposed.mean + blob.covariance.llt().matrixL() * draw;
  }
  taken.frame.blobs.push_back(blob);
}

/// The image of a point that moves during the exposure; nothing where it is behind the camera.
template <typename PointAt>
std::optional<ExposedWay> exposed(const Scene& scene, CameraSide side, double time, const PointAt& point) {
  ExposedWay result;
  for (int k = 0; k < kMotionSamples; ++k) {
    const double t = time + scene.kind.exposure * ((k + 0.5) / kMotionSamples - 0.5);
    const auto pixel = image_in(scene.rig, side, point(t));
    if (!pixel) return {};
    result.way.push_back(*pixel);
    result.mean += *pixel;
  }
  result.mean /= kMotionSamples;
  return result;
}

double depth_in(const StereoRig& rig, CameraSide side, const Eigen::Vector3d& point) {
  return side == CameraSide::Left ? point.z() : (rig.rotation * point + rig.translation).z();
}

/// Cosine of the angle between an LED's axis, across the pen and towards the cameras, and the camera.
double lobe(const StereoRig& rig, CameraSide side, const PenPose& pose, const Eigen::Vector3d& led) {
  const Eigen::Vector3d centre = side == CameraSide::Left ? Eigen::Vector3d::Zero() : rig.right_centre();
  const Eigen::Vector3d to_rig = rig.right_centre() / 2 - led;
  const Eigen::Vector3d axis = (to_rig - to_rig.dot(pose.direction) * pose.direction).normalized();
  return std::max(0.0, axis.dot((centre - led).normalized()));
}

long add_leds(const Scene& scene, TakenFrame& taken, Random& noise) {
  const BlobFrame& frame = taken.frame;
  std::array<bool, kPenLeds> hidden = scene.options.hidden;
  for (const Cover& cover : scene.covers)
    if (frame.time >= cover.from && frame.time <= cover.to)
      for (std::size_t i = 0; i < kPenLeds; ++i) hidden[i] = hidden[i] || cover.leds[i];
  const std::size_t before = frame.blobs.size();
  const PenPose pose = scene.motion.at(frame.time);
  for (int i = 0; i < kPenLeds; ++i) {
    if (hidden[static_cast<std::size_t>(i)]) continue;
    const auto way = exposed(scene, frame.camera, frame.time, [&](double t) {
      return led_position(scene.options.pen, scene.motion.at(t), i);
    });
    const Eigen::Vector3d led = led_position(scene.options.pen, pose, i);
    if (way)
      add_light(scene, *way, depth_in(scene.rig, frame.camera, led), lobe(scene.rig, frame.camera, pose, led),
                noise, taken);
  }
  return static_cast<long>(frame.blobs.size() - before);
}

void add_disturbances(const Scene& scene, TakenFrame& taken, Random& noise) {
  BlobFrame& frame = taken.frame;
  const Camera& camera = frame.camera == CameraSide::Left ? scene.rig.left : scene.rig.right;
  const Eigen::Vector3d& n = scene.mirror_normal;
  for (int k = 0; k < scene.options.false_blobs; ++k) {
    const auto point = [&](double t) -> Eigen::Vector3d {
      if (k % 2 == 1) return scene.lamps[static_cast<std::size_t>(k / 2)];
      const Eigen::Vector3d led = led_position(scene.options.pen, scene.motion.at(t), (k / 2) % kPenLeds);
      return led - 2 * (n.dot(led) - scene.mirror_offset) * n;
    };
    const auto way = exposed(scene, frame.camera, frame.time, point);
    if (!way) continue;
    const double depth = depth_in(scene.rig, frame.camera, point(frame.time));
    add_light(scene, *way, depth, 0.7, noise, taken);
    if (!scene.options.images || k % 2 == 0) continue;
    taken.lights.back() = {SeenLight::Kind::Lamp,
                           {way->mean},
                           std::hypot(scene.kind.blur, camera.fx * kLampRadius / depth / 2),
                           kLampPeak};
  }
  for (const SunSpot& spot : scene.suns) {
    const bool seen = frame.camera == CameraSide::Left ? spot.left : spot.right;
    if (!seen || frame.time < spot.from || frame.time > spot.to) continue;
    const Eigen::Vector2d pixel = camera.width * (spot.start + (frame.time - spot.from) * spot.speed);
    const double sigma = 0.004 * camera.width;  // of a ragged edge
    if (scene.options.images)
      taken.lights.push_back({SeenLight::Kind::Sun, {pixel}, kSunRadius * camera.width, 0});
    if (is_inside(camera, pixel))
      frame.blobs.push_back({pixel + sigma * drawn2(noise), sigma * sigma * Eigen::Matrix2d::Identity()});
  }
}

void take_frames(const Scene& scene, SimulatedPen& result) {
  const SimulatePenOptions& options = scene.options;
  const std::uint64_t seed = options.motion.seed;
  Random clock(seed, kClock), order(seed, kOrder);
  const bool free = options.unsynchronised || options.rig == PenRig::Wiimote;
  const double duration = scene.motion.duration();
  std::vector<TakenFrame> all;
  for (const CameraSide side : {CameraSide::Left, CameraSide::Right}) {
    const auto stream = static_cast<std::uint64_t>(side);
    Random noise(seed, kNoise + 100 * (1 + stream)), disturbance(seed, kFalse + 100 * (1 + stream));
    const double phase = clock.uniform(), rate = clock.uniform(-1, 1);
    const double period = (1 + (free ? kRateError * rate : 0)) / scene.kind.rate;
    for (double time = (free ? phase : 0.5) * period; time < duration; time += period) {
      TakenFrame taken{{time, side, {}}, {}};
      result.images_of_leds += add_leds(scene, taken, noise);
      add_disturbances(scene, taken, disturbance);
      BlobFrame& frame = taken.frame;
      for (std::size_t i = frame.blobs.size(); i > 1; --i)
        std::swap(frame.blobs[i - 1], frame.blobs[static_cast<std::size_t>(order.below(i))]);
      if (options.rig == PenRig::Wiimote && frame.blobs.size() > kWiimoteBlobs)
        frame.blobs.resize(kWiimoteBlobs);
      all.push_back(std::move(taken));
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const TakenFrame& a, const TakenFrame& b) { return a.frame.time < b.frame.time; });
  for (TakenFrame& taken : all) {
    result.recording.frames.push_back(std::move(taken.frame));
    if (options.images) result.lights.push_back(std::move(taken.lights));
  }
}

/// Axes of the pen's sensor: z along the pen, x where the swing turns it least (no roll of its own).
Eigen::Matrix3d body_axes(const Eigen::Vector3d& direction) {
  return Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), direction).toRotationMatrix();
}

void read_inertial(const Scene& scene, BlobRecording& recording) {
  Random random(scene.options.motion.seed, kInertial);
  const Eigen::Vector3d bias = kGyroscopeBias * random.normal3();
  const Eigen::Vector3d scale = Eigen::Vector3d::Ones() + kGyroscopeScale * random.normal3();
  const double h = 1 / kInertialRate, e = 2e-3;
  for (double time = h / 2; time < scene.motion.duration(); time += h) {
    const PenPose pose = scene.motion.at(time);
    const Eigen::Matrix3d X = body_axes(pose.direction);
    const Eigen::Vector3d turn = so3_log(body_axes(scene.motion.at(time - e).direction).transpose() *
                                         body_axes(scene.motion.at(time + e).direction)) /
                                 (2 * e);
    const Eigen::Vector3d acceleration =
        (scene.motion.at(time - e).tip - 2 * pose.tip + scene.motion.at(time + e).tip) / (e * e);
    // Down is +y of an upright rig; at rest the sensor feels what holds it, upwards.
    const Eigen::Vector3d force = X.transpose() * (acceleration - Eigen::Vector3d(0, kUsualGravity, 0));
    PenInertialReading reading;
    reading.time = time;
    reading.gyroscope =
        scale.cwiseProduct(turn) + bias + kGyroscopeDensity * std::sqrt(kInertialRate) * random.normal3();
    reading.accelerometer = force + kAccelerometerNoise * random.normal3();
    recording.inertial.push_back(reading);
  }
}

StereoRig disturbed(StereoRig rig, const SimulatePenOptions& options) {
  Random random(options.motion.seed, kCalibration);
  const Eigen::Matrix3d turn = so3_exp(options.rotation_error * random.direction());
  rig.rotation = turn * rig.rotation;  // about the centre of the camera
  rig.translation = turn * rig.translation;
  const double factor = 1 + (random.uniform() < 0.5 ? -1 : 1) * options.focal_error;
  rig.right.fx *= factor;
  rig.right.fy *= factor;
  return rig;
}

}  // namespace

StereoRig nominal_rig(PenRig kind) {
  StereoRig rig;
  rig.left = rig.right = nominal_camera(kind);
  rig.rotation = so3_exp(Eigen::Vector3d(0, 2 * std::atan(kBaseline / 2 / kCrossing), 0));
  const double toe = std::atan(kBaseline / 2 / kCrossing);
  // The left axis leans towards the right camera: in its coordinates that stands aside and a little ahead.
  rig.translation = -(rig.rotation * (kBaseline * Eigen::Vector3d(std::cos(toe), 0, std::sin(toe))));
  return rig;
}

std::optional<std::string> SimulatePenOptions::problem() const {
  if (const auto found = motion.problem()) return "motion: " + *found;
  if (const std::string found = batten::problem(pen); !found.empty()) return "pen: " + found;
  const auto range = [](const char* field, double value, const char* expected) {
    return concat(field, " is ", value, "; expected ", expected);
  };
  if (!(hand >= 0 && hand <= 60)) return range("hand", hand, "0 to 60 s");
  if (false_blobs < 0 || false_blobs > 20) return range("false_blobs", false_blobs, "0 to 20");
  if (!(rotation_error >= 0 && rotation_error <= 0.1))
    return range("rotation_error", rotation_error, "0 to 0.1 rad");
  if (!(focal_error >= 0 && focal_error <= 0.1)) return range("focal_error", focal_error, "0 to 10 %");
  return {};
}

SimulatedPen simulate_pen(const std::vector<Points>& strokes, const SimulatePenOptions& options) {
  if (const auto found = options.problem()) throw InvalidInput(*found);
  SimulatedPen result;
  result.nominal = nominal_rig(options.rig);
  result.actual = disturbed(result.nominal, options);
  const double toe = std::atan(kBaseline / 2 / kCrossing);
  // From the middle between the cameras towards the point where their axes meet.
  const Eigen::Vector3d ahead(-std::sin(toe), 0, std::cos(toe));
  const Eigen::Vector3d middle = result.nominal.right_centre() / 2 + options.motion.distance * ahead;
  const PenMotion motion(strokes, options.pen, middle, options.motion);

  Random random(options.motion.seed, kFalse);
  Scene scene{options, motion, result.actual, kind_of(options.rig), {}, {}, {}, 0, {}};
  scene.covers = covers_of(options, motion.duration());
  scene.suns = sun_of(options, motion.duration());
  // A shiny wall beside the pen.
  scene.mirror_normal = (Eigen::Vector3d(1, 0, 0) + 0.3 * random.direction()).normalized();
  scene.mirror_offset = scene.mirror_normal.dot(middle) + 0.08 * options.motion.distance / 0.6;
  for (int k = 1; k < options.false_blobs; k += 2) {
    const double z = random.uniform(0.0, 0.3), y = random.uniform(-0.15, 0.15), x = random.uniform(-0.2, 0.2);
    scene.lamps.push_back(middle + options.motion.distance * Eigen::Vector3d(x, y, z));
  }
  result.recording.width = result.nominal.left.width;
  result.recording.height = result.nominal.left.height;
  take_frames(scene, result);
  if (options.inertial) read_inertial(scene, result.recording);
  for (const auto& [down, up] : motion.drawing()) {
    result.recording.buttons.push_back({down, "draw", true});
    result.recording.buttons.push_back({up, "draw", false});
  }
  for (long i = 0; static_cast<double>(i) * kTruthStep <= motion.duration(); ++i) {
    const double time = static_cast<double>(i) * kTruthStep;
    result.truth.push_back({time, motion.at(time), motion.is_drawing(time)});
  }
  return result;
}

}  // namespace batten
