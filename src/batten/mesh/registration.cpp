#include "batten/mesh/registration.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Points SimilarityTransform::operator()(const Points& points) const {
  return ((scale * points) * rotation.transpose()).rowwise() + translation.transpose();
}

SimilarityTransform SimilarityTransform::inverse() const {
  SimilarityTransform inverse;
  inverse.scale = 1 / scale;
  inverse.rotation = rotation.transpose();
  inverse.translation = -inverse.scale * (inverse.rotation * translation);
  return inverse;
}

SimilarityTransform SimilarityTransform::operator*(const SimilarityTransform& other) const {
  return {scale * other.scale, rotation * other.rotation, (*this)(other.translation)};
}

double SimilarityTransform::angle() const {
  return Eigen::AngleAxisd(rotation).angle();
}

namespace {

/// The second largest variance over the largest, below which points count as lying on one line.
constexpr double kLineRatio = 1e-14;

void refuse_line(const Eigen::Vector3d& variances_increasing) {
  if (!(variances_increasing[1] > kLineRatio * variances_increasing[2]))
    throw InvalidInput(
        "the points to register lie on one line, so the rotation about it cannot be found; compare without "
        "registration or give more of the shape");
}

/// Steps that lower the mean square by less than this fraction change no figure that anybody reads: near a
/// minimum with noise, iterated closest points creep on for hundreds of steps.
constexpr double kIdle = 1e-7;
constexpr int kIdleSteps = 5;

struct Moments {
  Vector3d centroid;
  Matrix3d covariance;
};

Moments moments(const Points& points) {
  const Vector3d centroid = points.colwise().mean();
  const Points centred = points.rowwise() - centroid.transpose();
  return {centroid, centred.transpose() * centred / static_cast<double>(points.rows())};
}

/// Per element of a shape: do its corners and edges lie on the border, so that a point beyond is held by
/// them?
class TangentSpaces {
 public:
  explicit TangentSpaces(const Shape& shape) : shape_(shape) {
    if (!shape.is_surface()) {
      degree_.assign(shape.positions.rows(), 0);
      for (Eigen::Index i = 0; i < shape.segments.size(); ++i) ++degree_[shape.segments.data()[i]];
      return;
    }
    struct Side {
      int low, high;
      Eigen::Index corner;  // 3 t + k for the edge opposite to corner k of triangle t
    };
    std::vector<Side> sides;
    sides.reserve(shape.triangles.size());
    for (Eigen::Index t = 0; t < shape.triangles.rows(); ++t)
      for (int k = 0; k < 3; ++k) {
        const int i = shape.triangles(t, (k + 1) % 3), j = shape.triangles(t, (k + 2) % 3);
        sides.push_back({std::min(i, j), std::max(i, j), 3 * t + k});
      }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
      return std::pair(a.low, a.high) < std::pair(b.low, b.high);
    });
    border_side_.assign(shape.triangles.size(), 0);
    border_vertex_.assign(shape.positions.rows(), 0);
    for (std::size_t i = 0; i < sides.size();) {
      std::size_t end = i + 1;
      while (end < sides.size() && sides[end].low == sides[i].low && sides[end].high == sides[i].high) ++end;
      if (end == i + 1) {
        border_side_[sides[i].corner] = 1;
        border_vertex_[sides[i].low] = border_vertex_[sides[i].high] = 1;
      }
      i = end;
    }
  }

  /// The projection on the directions in which the distance grows to first order: the normal of a surface,
  /// the plane across a curve, everything at an end. Residual of the Gauss–Newton step.
  Matrix3d normal_space(const ClosestPoint& at) const {
    const Eigen::Index e = at.element;
    if (!shape_.is_surface()) {
      for (int k = 0; k < 2; ++k)
        if (at.weights[k] == 1 && degree_[shape_.segments(e, k)] == 1) return Matrix3d::Identity();
      return across(shape_.segments(e, 0), shape_.segments(e, 1));
    }
    for (int k = 0; k < 3; ++k)
      if (at.weights[k] == 1)
        return border_vertex_[shape_.triangles(e, k)] != 0 ? Matrix3d::Identity() : along_normal(e);
    for (int k = 0; k < 3; ++k)
      if (at.weights[k] == 0 && border_side_[3 * e + k] != 0)
        return across(shape_.triangles(e, (k + 1) % 3), shape_.triangles(e, (k + 2) % 3));
    return along_normal(e);
  }

 private:
  Matrix3d across(int i, int j) const {
    const Vector3d d = (shape_.positions.row(j) - shape_.positions.row(i)).transpose();
    const double length2 = d.squaredNorm();
    if (!(length2 > 0)) return Matrix3d::Identity();
    return Matrix3d::Identity() - d * d.transpose() / length2;
  }
  Matrix3d along_normal(Eigen::Index t) const {
    const Vector3d a = shape_.positions.row(shape_.triangles(t, 0)),
                   b = shape_.positions.row(shape_.triangles(t, 1)),
                   c = shape_.positions.row(shape_.triangles(t, 2));
    const Vector3d n = (b - a).cross(c - a);
    const double norm2 = n.squaredNorm();
    if (!(norm2 > 0)) return Matrix3d::Identity();
    return n * n.transpose() / norm2;
  }

  const Shape& shape_;
  std::vector<int> degree_;
  std::vector<char> border_side_, border_vertex_;
};

/// One alignment of fixed samples with a target, improved step by step.
class Alignment {
 public:
  Alignment(const ShapeTree& tree, const TangentSpaces& tangents, Points samples, RegistrationKind kind,
            double trim)
      : tree_(tree), tangents_(tangents), samples_(std::move(samples)), kind_(kind), trim_(trim) {}

  struct State {
    SimilarityTransform transform;
    Points moved;
    std::vector<ClosestPoint> closest;
    Eigen::VectorXd weights;  ///< 1, or 0 for pairs left out
    double mean_square = std::numeric_limits<double>::infinity();
  };

  State evaluate(const SimilarityTransform& transform) const {
    State state;
    state.transform = transform;
    state.moved = transform(samples_);
    state.closest = tree_.closest(state.moved);
    const Eigen::Index n = samples_.rows();
    state.weights = Eigen::VectorXd::Ones(n);
    const auto left_out = static_cast<Eigen::Index>(trim_ * static_cast<double>(n));
    if (left_out > 0) {
      std::vector<Eigen::Index> order(n);
      std::iota(order.begin(), order.end(), 0);
      std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
        return std::pair(-state.closest[a].squared_distance, a) <
               std::pair(-state.closest[b].squared_distance, b);
      });
      for (Eigen::Index i = 0; i < left_out; ++i) state.weights[order[i]] = 0;
    }
    double sum = 0;
    for (Eigen::Index i = 0; i < n; ++i) sum += state.weights[i] * state.closest[i].squared_distance;
    state.mean_square = sum / state.weights.sum();
    return state;
  }

  /// Iterates until no sample moves by more than `tolerance`, or until the mean square falls by less than
  /// rounding for several steps. @return iterations, negative when it never got so far.
  int improve(State& state, int max_iterations, double tolerance) const {
    int idle = 0;
    for (int iteration = 1; iteration <= max_iterations; ++iteration) {
      State next = evaluate(tangent_step(state));
      // Where the linearisation promised too much, the closed form for fixed pairs never does worse.
      if (!(next.mean_square <= state.mean_square)) next = evaluate(pair_step(state));
      if (!(next.mean_square <= state.mean_square)) return iteration;  // stuck at rounding
      const double move = (next.moved - state.moved).rowwise().norm().maxCoeff();
      idle = next.mean_square > (1 - kIdle) * state.mean_square ? idle + 1 : 0;
      state = std::move(next);
      if (move <= tolerance || idle == kIdleSteps) return iteration;
    }
    return -max_iterations;
  }

 private:
  SimilarityTransform pair_step(const State& state) const {
    Points to(samples_.rows(), 3);
    for (Eigen::Index i = 0; i < to.rows(); ++i) to.row(i) = state.closest[i].point;
    return fit_transform(samples_, to, kind_, state.weights);
  }

  /// Gauss–Newton over a rotation and a scaling about the centroid and a translation, lengths in units of the
  /// samples' radius so that one threshold serves all parameters.
  SimilarityTransform tangent_step(const State& state) const {
    const Vector3d centre = state.moved.colwise().mean();
    const double radius =
        std::sqrt((state.moved.rowwise() - centre.transpose()).rowwise().squaredNorm().mean());
    const int unknowns = kind_ == RegistrationKind::Similarity ? 7 : 6;
    Eigen::Matrix<double, 7, 7> normal = Eigen::Matrix<double, 7, 7>::Zero();
    Eigen::Matrix<double, 7, 1> right = Eigen::Matrix<double, 7, 1>::Zero();
    for (Eigen::Index i = 0; i < state.moved.rows(); ++i) {
      if (state.weights[i] == 0) continue;
      const Vector3d x = (state.moved.row(i).transpose() - centre) / radius;
      const Vector3d d = (state.moved.row(i).transpose() - state.closest[i].point) / radius;
      Eigen::Matrix<double, 3, 7> jacobian;
      jacobian << 0, x.z(), -x.y(), 1, 0, 0, x.x(),  //
          -x.z(), 0, x.x(), 0, 1, 0, x.y(),          //
          x.y(), -x.x(), 0, 0, 0, 1, x.z();
      const Eigen::Matrix<double, 3, 7> projected = tangents_.normal_space(state.closest[i]) * jacobian;
      normal += projected.transpose() * projected;
      right -= projected.transpose() * d;
    }
    // Directions in which the shape slides upon itself (a sphere's rotations) take no step.
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(normal.topLeftCorner(unknowns, unknowns));
    const Eigen::VectorXd& values = solver.eigenvalues();
    Eigen::VectorXd coefficients = solver.eigenvectors().transpose() * right.head(unknowns);
    for (int k = 0; k < unknowns; ++k)
      coefficients[k] = values[k] > 1e-10 * values[unknowns - 1] ? coefficients[k] / values[k] : 0.0;
    const Eigen::VectorXd step = solver.eigenvectors() * coefficients;
    const Vector3d turn = step.head<3>();
    SimilarityTransform change;
    if (turn.norm() > 0)
      change.rotation = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    if (unknowns == 7) change.scale = std::exp(std::clamp(step[6], -0.2, 0.2));
    change.translation = centre + radius * step.segment<3>(3) - change.scale * (change.rotation * centre);
    SimilarityTransform next = change * state.transform;
    // Products of rotations drift off orthogonality by rounding; a unit quaternion does not.
    next.rotation = Eigen::Quaterniond(next.rotation).normalized().toRotationMatrix();
    return next;
  }

  const ShapeTree& tree_;
  const TangentSpaces& tangents_;
  Points samples_;
  RegistrationKind kind_;
  double trim_;
};

/// The 24 rotations that map the coordinate axes onto each other.
std::vector<Matrix3d> axis_rotations() {
  std::vector<Matrix3d> rotations;
  int axes[3] = {0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Matrix3d R = Matrix3d::Zero();
      for (int k = 0; k < 3; ++k) R(k, axes[k]) = (signs >> k & 1) != 0 ? -1 : 1;
      if (R.determinant() > 0) rotations.push_back(R);
    }
  } while (std::next_permutation(axes, axes + 3));
  return rotations;
}

Matrix3d principal_axes(const Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(covariance);
  refuse_line(solver.eigenvalues());
  Matrix3d axes = solver.eigenvectors();
  if (axes.determinant() < 0) axes.col(0) *= -1;
  return axes;
}

std::vector<SimilarityTransform> starts(const Points& from, const Points& to, RegistrationKind kind) {
  const Moments a = moments(from), b = moments(to);
  const double scale =
      kind == RegistrationKind::Similarity ? std::sqrt(b.covariance.trace() / a.covariance.trace()) : 1.0;
  const auto start = [&](const Matrix3d& R) {
    return SimilarityTransform{scale, R, b.centroid - scale * (R * a.centroid)};
  };
  const Matrix3d axes_a = principal_axes(a.covariance), axes_b = principal_axes(b.covariance);
  std::vector<SimilarityTransform> list{start(Matrix3d::Identity())};
  for (const Matrix3d& R : axis_rotations()) list.push_back(start(axes_b * R * axes_a.transpose()));
  return list;
}

}  // namespace

SimilarityTransform fit_transform(const Points& from, const Points& to, RegistrationKind kind,
                                  const Eigen::VectorXd& weights) {
  const Eigen::Index n = from.rows();
  if (to.rows() != n) throw InvalidInput(concat("pairs of points: ", n, " are to be mapped to ", to.rows()));
  if (weights.size() != 0 && (weights.size() != n || !(weights.minCoeff() >= 0)))
    throw InvalidInput("pairs of points need one weight each, none negative");
  if (!from.allFinite() || !to.allFinite()) throw InvalidInput("pairs of points must be finite");
  SimilarityTransform result;
  if (kind == RegistrationKind::None) return result;
  const Eigen::VectorXd w = weights.size() == 0 ? Eigen::VectorXd::Ones(n) : weights;
  const double total = n > 0 ? w.sum() : 0;
  if (n < 3 || !(total > 0)) throw InvalidInput("a registration needs at least three pairs of points");
  const Vector3d mean_from = from.transpose() * w / total, mean_to = to.transpose() * w / total;
  const Points a = from.rowwise() - mean_from.transpose(), b = to.rowwise() - mean_to.transpose();
  const Matrix3d covariance = b.transpose() * w.asDiagonal() * a / total;
  const Matrix3d spread = a.transpose() * w.asDiagonal() * a / total;
  refuse_line(Eigen::SelfAdjointEigenSolver<Matrix3d>(spread, Eigen::EigenvaluesOnly).eigenvalues());
  const Eigen::JacobiSVD<Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (!(svd.singularValues()[1] > 1e-9 * svd.singularValues()[0]))
    throw InvalidInput(
        "the points to register onto lie on one line, so the rotation about it cannot be found");
  Vector3d signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1.0 : 1.0);
  result.rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  if (kind == RegistrationKind::Similarity) result.scale = svd.singularValues().dot(signs) / spread.trace();
  result.translation = mean_to - result.scale * (result.rotation * mean_from);
  return result;
}

std::optional<std::string> RegistrationOptions::problem() const {
  if (samples < 10) return concat("samples must be at least 10, got ", samples);
  if (!(trim >= 0 && trim <= 0.9)) return concat("trim must lie between 0 and 0.9, got ", trim);
  return std::nullopt;
}

Registration register_shapes(const Shape& moving, const Shape& fixed, const RegistrationOptions& options,
                             const Progress& progress) {
  Registration result;
  if (options.kind == RegistrationKind::None) {
    result.converged = true;
    return result;
  }
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  if (moving.is_surface() && !fixed.is_surface()) {
    result = register_shapes(fixed, moving, options, progress);
    result.transform = result.transform.inverse();
    result.rms *= result.transform.scale;
    return result;
  }
  const ShapeTree tree(fixed);
  { const ShapeTree check(moving); }  // the same refusals for the moving shape
  const TangentSpaces tangents(fixed);
  Random random(options.seed, 1), random_fixed(options.seed, 2);
  const Points samples = sample_uniformly(moving, options.samples, random);
  const Points targets = sample_uniformly(fixed, options.samples, random_fixed);
  const double tolerance = options.tolerance * diameter(fixed);

  // All starts with few samples, then the promising ones with more, and at last with all.
  constexpr Eigen::Index kCoarseSamples = 300, kMediumSamples = 2000;
  constexpr int kFirstIterations = 5, kFurtherIterations = 25;
  constexpr std::size_t kKept = 5;  // starts that are followed further, besides "as it lies"
  const Alignment coarse(tree, tangents, samples.topRows(std::min(kCoarseSamples, samples.rows())),
                         options.kind, options.trim);
  const std::vector<SimilarityTransform> tried = starts(samples, targets, options.kind);
  const double coarse_tolerance = 1e-6 * diameter(fixed);
  std::vector<Alignment::State> states;
  for (std::size_t i = 0; i < tried.size(); ++i) {
    progress.report("register", 0.3 * static_cast<double>(i) / static_cast<double>(tried.size()));
    states.push_back(coarse.evaluate(tried[i]));
    coarse.improve(states.back(), kFirstIterations, coarse_tolerance);
  }
  std::vector<std::size_t> ranking(states.size());
  std::iota(ranking.begin(), ranking.end(), 0);
  std::stable_sort(ranking.begin(), ranking.end(), [&](std::size_t a, std::size_t b) {
    return states[a].mean_square < states[b].mean_square;
  });
  for (std::size_t rank = 0; rank < ranking.size(); ++rank)
    if (rank < kKept || ranking[rank] == 0)
      coarse.improve(states[ranking[rank]], kFurtherIterations, coarse_tolerance);
  std::size_t best = 0;
  for (std::size_t i = 1; i < states.size(); ++i)
    if (states[i].mean_square < states[best].mean_square) best = i;
  const Alignment medium(tree, tangents, samples.topRows(std::min(kMediumSamples, samples.rows())),
                         options.kind, options.trim);
  const Alignment fine(tree, tangents, samples, options.kind, options.trim);
  const auto refine = [&](std::size_t start, double done) {
    progress.report("register", done);
    Alignment::State rough = medium.evaluate(states[start].transform);
    medium.improve(rough, options.max_iterations, tolerance);
    Alignment::State state = fine.evaluate(rough.transform);
    const int iterations = fine.improve(state, options.max_iterations, tolerance);
    return std::pair(std::move(state), iterations);
  };
  auto [state, iterations] = refine(best, 0.3);
  // A few samples cannot tell near equals apart: let "as it lies" compete on all.
  if (best != 0 && states[0].mean_square < 16 * states[best].mean_square + tolerance * tolerance) {
    auto [as_it_lies, its_iterations] = refine(0, 0.6);
    const double rms = std::sqrt(as_it_lies.mean_square);
    if (rms <= 1.001 * std::sqrt(state.mean_square) + tolerance) {
      state = std::move(as_it_lies);
      iterations = its_iterations;
    }
  }
  const double scale_change = state.transform.scale / tried[0].scale;
  if (!(scale_change > 0.1 && scale_change < 10))
    throw InvalidInput(
        "the scale of the registration runs away, because the shapes are too different; register rigidly");
  result.transform = state.transform;
  result.rms = std::sqrt(state.mean_square);
  result.iterations = std::abs(iterations);
  result.converged = iterations > 0;
  return result;
}

}  // namespace batten
