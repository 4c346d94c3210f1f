#include "batten/camera/wand.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "batten/camera/triangulation.hpp"
#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"
#include "batten/rotation/so3.hpp"

namespace batten {

namespace {

constexpr int kRig = 6;   // rotation and translation
constexpr int kWand = 5;  // first light, and two turns of the direction

/// A frame whose blobs are in the order of the lights, and where the wand is.
struct Placed {
  double time = 0;
  std::vector<Eigen::Vector2d> left, right;
  Eigen::Vector3d place, direction;  ///< of the first light; towards the others
};

/// Points on a line in their order along it.
std::vector<Eigen::Vector2d> along_line(std::vector<Eigen::Vector2d> points) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& p : points) spread += (p - mean) * (p - mean).transpose();
  const Eigen::Vector2d axis = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread).eigenvectors().col(1);
  std::sort(points.begin(), points.end(),
            [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return axis.dot(a - b) < 0; });
  return points;
}

/// Sum of squared epipolar distances; infinite where a blob belongs to no ray.
double epipolar_squares(const StereoRig& rig, const Placed& frame) {
  double sum = 0;
  for (std::size_t i = 0; i < frame.left.size(); ++i) {
    const auto distance = epipolar_distance(rig, frame.left[i], frame.right[i]);
    if (!distance) return std::numeric_limits<double>::infinity();
    sum += *distance * *distance;
  }
  return sum;
}

/// Triangulated lights, or nothing where one has no place.
std::optional<std::vector<Eigen::Vector3d>> lights_of(const StereoRig& rig, const Placed& frame) {
  std::vector<Eigen::Vector3d> lights;
  for (std::size_t i = 0; i < frame.left.size(); ++i) {
    const auto point = triangulate(rig, frame.left[i], frame.right[i]);
    if (!point) return {};
    lights.push_back(point->position);
  }
  return lights;
}

/// Squared misfit of triangulated lights to those of a wand in the given sense, whose place is set.
double laid_upon(const std::vector<Eigen::Vector3d>& points, const std::vector<double>& lights,
                 Placed& frame) {
  const double n = static_cast<double>(points.size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), moment = Eigen::Vector3d::Zero();
  double middle = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    mean += points[i] / n;
    middle += lights[i] / n;
  }
  for (std::size_t i = 0; i < points.size(); ++i) moment += (lights[i] - middle) * (points[i] - mean);
  frame.direction = moment.normalized();
  frame.place = mean - middle * frame.direction;
  double misfit = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    misfit += (frame.place + lights[i] * frame.direction - points[i]).squaredNorm();
  return misfit;
}

/// The blobs of a frame in the order of the lights, and where the wand is; nothing where there are others
/// than lights, or they meet nowhere.
std::optional<Placed> placed(const StereoRig& rig, const WandFrame& given,
                             const std::vector<double>& lights) {
  if (given.left.size() != lights.size() || given.right.size() != lights.size()) return {};
  Placed frame;
  frame.time = given.time;
  frame.left = along_line(given.left);
  frame.right = along_line(given.right);
  const double same = epipolar_squares(rig, frame);
  std::reverse(frame.right.begin(), frame.right.end());
  if (same <= epipolar_squares(rig, frame)) std::reverse(frame.right.begin(), frame.right.end());
  const auto points = lights_of(rig, frame);
  if (!points) return {};
  Placed turned = frame;
  std::reverse(turned.left.begin(), turned.left.end());
  std::reverse(turned.right.begin(), turned.right.end());
  const double misfit = laid_upon(*points, lights, frame);
  const double other = laid_upon({points->rbegin(), points->rend()}, lights, turned);
  Placed& best = other < misfit ? turned : frame;
  return best.direction.allFinite() ? std::optional(best) : std::nullopt;
}

std::vector<Placed> all_placed(const StereoRig& rig, const std::vector<WandFrame>& frames,
                               const WandOptions& options) {
  std::vector<Placed> result;
  for (const WandFrame& frame : frames)
    if (auto found = placed(rig, frame, options.lights)) result.push_back(std::move(*found));
  return result;
}

WandCheck checked(const StereoRig& rig, const std::vector<Placed>& frames) {
  WandCheck check;
  std::vector<double> lengths;
  double sum = 0, squares = 0, mean_time = 0;
  int n = 0;
  for (const Placed& frame : frames) {
    const auto lights = lights_of(rig, frame);
    if (!lights) continue;
    ++check.frames;
    lengths.push_back((lights->front() - lights->back()).norm());
    mean_time += frame.time / static_cast<double>(frames.size());
    for (std::size_t i = 0; i < frame.left.size(); ++i) {
      const double distance = epipolar_distance(rig, frame.left[i], frame.right[i]).value_or(0);
      sum += distance;
      squares += distance * distance;
      ++n;
    }
  }
  if (n == 0) return check;
  check.epipolar = sum / n;
  check.epipolar_rms = std::sqrt(squares / n);
  std::vector<double> ordered = lengths;
  check.length = median(ordered);
  ordered = lengths;
  check.length_std = deviation_by_median(ordered, check.length);
  double moment = 0, inertia = 0;
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    const double t = frames[i].time - mean_time;
    // A frame that is far off would tip the line.
    moment += t * std::clamp(lengths[i] - check.length, -3 * check.length_std, 3 * check.length_std);
    inertia += t * t;
  }
  if (inertia > 0) check.trend = moment / inertia * (frames.back().time - frames.front().time);
  return check;
}

/// Two directions orthogonal to d and to each other.
Eigen::Matrix<double, 3, 2> tangents(const Eigen::Vector3d& d) {
  Eigen::Matrix<double, 3, 2> E;
  E.col(0) = d.unitOrthogonal();
  E.col(1) = d.cross(E.col(0));
  return E;
}

struct WandState {
  StereoRig rig;
  std::vector<Placed> frames;
};

/// Residuals of one frame, two per blob and camera; infinite where a light is behind a camera.
Eigen::VectorXd residuals_of(const StereoRig& rig, const Placed& frame, const std::vector<double>& lights) {
  Eigen::VectorXd r(4 * static_cast<Eigen::Index>(lights.size()));
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const Eigen::Vector3d left = frame.place + lights[i] * frame.direction;
    const Eigen::Vector3d right = rig.rotation * left + rig.translation;
    if (!(left.z() > 0) || !(right.z() > 0)) {
      r.setConstant(std::numeric_limits<double>::infinity());
      return r;
    }
    const auto row = 4 * static_cast<Eigen::Index>(i);
    r.segment<2>(row) = project(rig.left, left) - frame.left[i];
    r.segment<2>(row + 2) = project(rig.right, right) - frame.right[i];
  }
  return r;
}

double huber_cost(double distance, double huber) {
  return distance <= huber ? distance * distance : huber * (2 * distance - huber);
}

double cost_of(const WandState& state, const WandOptions& options) {
  double cost = 0;
  for (const Placed& frame : state.frames) {
    const Eigen::VectorXd r = residuals_of(state.rig, frame, options.lights);
    for (Eigen::Index k = 0; k < r.size(); k += 2) cost += huber_cost(r.segment<2>(k).norm(), options.huber);
  }
  return cost;
}

/// Normal equations of the rig, and of one frame with what couples them.
struct FrameNormal {
  Eigen::Matrix<double, kWand, kWand> B = Eigen::Matrix<double, kWand, kWand>::Zero();
  Eigen::Matrix<double, kWand, 1> b = Eigen::Matrix<double, kWand, 1>::Zero();
  Eigen::Matrix<double, kRig, kWand> C = Eigen::Matrix<double, kRig, kWand>::Zero();
};
struct WandNormal {
  Eigen::Matrix<double, kRig, kRig> A = Eigen::Matrix<double, kRig, kRig>::Zero();
  Eigen::Matrix<double, kRig, 1> a = Eigen::Matrix<double, kRig, 1>::Zero();
  std::vector<FrameNormal> frames;
  double weights = 0, squares = 0;
};

WandNormal normal_equations(const WandState& state, const WandOptions& options) {
  WandNormal normal;
  for (const Placed& frame : state.frames) {
    FrameNormal of_frame;
    const Eigen::Matrix<double, 3, 2> E = tangents(frame.direction);
    for (std::size_t i = 0; i < options.lights.size(); ++i) {
      const Eigen::Vector3d left = frame.place + options.lights[i] * frame.direction;
      Eigen::Matrix<double, 3, kWand> by_wand;
      by_wand << Eigen::Matrix3d::Identity(), options.lights[i] * E;
      for (const bool is_right : {false, true}) {
        const Eigen::Vector3d turned = state.rig.rotation * left;
        Eigen::Matrix<double, 2, 3> by_point;
        const Eigen::Vector2d r =
            is_right ? Eigen::Vector2d(project(state.rig.right, turned + state.rig.translation, &by_point) -
                                       frame.right[i])
                     : Eigen::Vector2d(project(state.rig.left, left, &by_point) - frame.left[i]);
        const double distance = r.norm(), w = distance <= options.huber ? 1 : options.huber / distance;
        normal.weights += 2 * w;
        normal.squares += w * distance * distance;
        Eigen::Matrix<double, 2, kWand> P = by_point * by_wand;
        if (is_right) {
          P = by_point * state.rig.rotation * by_wand;
          Eigen::Matrix<double, 2, kRig> J;
          J << -by_point * hat(turned), by_point;
          normal.A += w * J.transpose() * J;
          normal.a += w * J.transpose() * r;
          of_frame.C += w * J.transpose() * P;
        }
        of_frame.B += w * P.transpose() * P;
        of_frame.b += w * P.transpose() * r;
      }
    }
    normal.frames.push_back(of_frame);
  }
  return normal;
}

WandState stepped(const WandState& state, const WandNormal& normal, double damping) {
  Eigen::Matrix<double, kRig, kRig> S = normal.A;
  S.diagonal() *= 1 + damping;
  Eigen::Matrix<double, kRig, 1> s = normal.a;
  std::vector<Eigen::LDLT<Eigen::Matrix<double, kWand, kWand>>> factors;
  for (const FrameNormal& frame : normal.frames) {
    Eigen::Matrix<double, kWand, kWand> B = frame.B;
    B.diagonal() *= 1 + damping;
    factors.emplace_back(B);
    S -= frame.C * factors.back().solve(frame.C.transpose());
    s -= frame.C * factors.back().solve(frame.b);
  }
  const Eigen::Matrix<double, kRig, 1> step = -S.ldlt().solve(s);
  WandState next = state;
  next.rig.rotation = so3_exp(step.head<3>()) * state.rig.rotation;
  next.rig.translation += step.tail<3>();
  for (std::size_t k = 0; k < next.frames.size(); ++k) {
    const FrameNormal& frame = normal.frames[k];
    const Eigen::Matrix<double, kWand, 1> own = -factors[k].solve(frame.b + frame.C.transpose() * step);
    Placed& wand = next.frames[k];
    wand.place += own.head<3>();
    wand.direction = (wand.direction + tangents(wand.direction) * own.tail<2>()).normalized();
  }
  return next;
}

void adjust(WandState& state, const WandOptions& options, const Progress& progress) {
  constexpr int kMostSteps = 60;
  double cost = cost_of(state, options), damping = 1e-3;
  for (int step = 0; step < kMostSteps; ++step) {
    progress.report("adjust", step / static_cast<double>(kMostSteps));
    const WandNormal normal = normal_equations(state, options);
    bool is_better = false;
    double gain = 0;
    for (; damping < 1e12 && !is_better; damping *= 10) {
      WandState next = stepped(state, normal, damping);
      const double next_cost = cost_of(next, options);
      if (!(next_cost < cost)) continue;
      is_better = true;
      gain = (cost - next_cost) / cost;
      cost = next_cost;
      state = std::move(next);
    }
    damping = std::max(damping / 100, 1e-12);  // the loop has raised it once more
    if (!is_better || gain < 1e-12) return;
  }
}

void check_frames(const std::vector<Placed>& frames, const Camera& camera) {
  constexpr std::size_t kFewest = 20;
  constexpr double kLeastSpread = 0.1;
  if (frames.size() < kFewest)
    throw InvalidInput(concat(frames.size(), " frames show all lights in both images, at least ", kFewest,
                              " are needed; wave the wand for half a minute where both cameras see it"));
  Eigen::Vector2d low = frames[0].left[0], high = low;
  double near = frames[0].place.z(), far = near;
  for (const Placed& frame : frames) {
    near = std::min(near, frame.place.z());
    far = std::max(far, frame.place.z());
    for (const Eigen::Vector2d& blob : frame.left) {
      low = low.cwiseMin(blob);
      high = high.cwiseMax(blob);
    }
  }
  const Eigen::Vector2d extent = high - low;
  if (extent.x() < kLeastSpread * camera.width || extent.y() < kLeastSpread * camera.height ||
      far - near < kLeastSpread * near)
    throw InvalidInput(
        "the wand stayed nearly in one place; wave it through all of the volume, near and far, up and down");
}

}  // namespace

std::optional<std::string> WandOptions::problem() const {
  if (lights.size() < 2 || lights[0] != 0) return "lights must be at least 2 places, the first of them 0";
  for (std::size_t i = 1; i < lights.size(); ++i)
    if (!(lights[i] > lights[i - 1] && lights[i] < 100))
      return concat("lights must increase and stay below 100 m, got ", lights[i], " after ", lights[i - 1]);
  if (!(huber >= 0.01)) return concat("huber must be at least 0.01 pixels, got ", huber);
  if (!(outliers >= 2)) return concat("outliers must be at least 2, got ", outliers);
  return {};
}

std::vector<double> wand_lights(const std::vector<WandFrame>& frames, double length) {
  constexpr std::size_t kLeastShare = 10;  // one frame in so many
  const auto count = [&](std::size_t n) {
    return static_cast<std::size_t>(std::count_if(frames.begin(), frames.end(), [n](const WandFrame& frame) {
      return frame.left.size() == n && frame.right.size() == n;
    }));
  };
  const std::vector<double> pen = WandOptions{}.lights;
  const std::size_t two = count(2), four = count(pen.size());
  if (kLeastShare * std::max(two, four) < std::max<std::size_t>(frames.size(), 1))
    throw InvalidInput(
        "less than a tenth of the frames show two lights, or the four of the pen, in both images; cover what "
        "else shines, and wave the wand where both cameras see all of it");
  if (two > four) return {0, length};
  std::vector<double> lights;
  for (const double light : pen) lights.push_back(light / pen.back() * length);
  return lights;
}

WandCheck check_wand(const StereoRig& rig, const std::vector<WandFrame>& frames, const WandOptions& options) {
  if (const std::string found = problem(rig); !found.empty()) throw InvalidInput(found);
  if (const auto found = options.problem()) throw InvalidInput(*found);
  WandCheck check = checked(rig, all_placed(rig, frames, options));
  if (check.frames == 0)
    throw InvalidInput(concat("no frame shows all ", options.lights.size(),
                              " lights in both images, and nothing else; check the wand and the exposure"));
  check.unused = static_cast<int>(frames.size()) - check.frames;
  return check;
}

WandCalibration calibrate_wand(const StereoRig& rig, const std::vector<WandFrame>& frames,
                               const WandOptions& options, const Progress& progress) {
  WandCalibration result;
  result.before = check_wand(rig, frames, options);
  WandState state{rig, all_placed(rig, frames, options)};
  check_frames(state.frames, rig.left);
  adjust(state, options, progress);
  // Matched and placed anew: with the rig as it was some frames may have been read in the wrong sense.
  state.frames = all_placed(state.rig, frames, options);
  adjust(state, options, progress);
  std::vector<double> sizes;
  for (const Placed& frame : state.frames)
    sizes.push_back(residuals_of(state.rig, frame, options.lights).norm());
  std::vector<double> ordered = sizes;
  constexpr double kExact = 1e-3;  // pixels: exact blobs differ by rounding alone
  const double limit = std::max(kExact, options.outliers * median(ordered));
  std::vector<Placed> kept;
  for (std::size_t k = 0; k < sizes.size(); ++k)
    if (sizes[k] <= limit) kept.push_back(state.frames[k]);
  result.left_out = static_cast<int>(state.frames.size() - kept.size());
  state.frames = std::move(kept);
  adjust(state, options, progress);
  result.rig = state.rig;
  result.after = check_wand(result.rig, frames, options);

  const WandNormal normal = normal_equations(state, options);
  Eigen::Matrix<double, kRig, kRig> S = normal.A;
  for (const FrameNormal& frame : normal.frames) S -= frame.C * frame.B.ldlt().solve(frame.C.transpose());
  const double unknowns = kRig + kWand * static_cast<double>(state.frames.size());
  const double variance = normal.squares / std::max(1.0, normal.weights - unknowns);
  const Eigen::Matrix<double, kRig, 1> deviations =
      (variance * S.ldlt().solve(Eigen::Matrix<double, kRig, kRig>::Identity()).diagonal())
          .cwiseMax(0)
          .cwiseSqrt();
  result.rotation_deviation = deviations.head<3>();
  result.translation_deviation = deviations.tail<3>();
  result.rms = std::sqrt(2 * normal.squares / normal.weights);
  return result;
}

}  // namespace batten
