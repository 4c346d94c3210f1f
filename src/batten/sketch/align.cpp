#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/sketch/tools_detail.hpp"

namespace batten {

namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kSamples = 120;

struct PrincipalFrame {
  Vector3d centre;
  Matrix3d axes;     ///< columns by decreasing spread, determinant +1
  Vector3d spreads;  ///< standard deviations
};

PrincipalFrame principal_frame(const Points& samples) {
  PrincipalFrame frame;
  frame.centre = samples.colwise().mean();
  const Points centred = samples.rowwise() - frame.centre.transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(centred.transpose() * centred /
                                                       static_cast<double>(samples.rows()));
  frame.axes = solver.eigenvectors().rowwise().reverse();
  if (frame.axes.determinant() < 0) frame.axes.col(2) *= -1;
  frame.spreads = solver.eigenvalues().reverse().cwiseMax(0).cwiseSqrt();
  return frame;
}

SegmentTree tree_of(const Points& points) {
  Segments segments(points.rows() - 1, 2);
  for (Index i = 0; i + 1 < points.rows(); ++i)
    segments.row(i) << static_cast<int>(i), static_cast<int>(i) + 1;
  return {points, segments};
}

/// Root mean square distance of moved samples, both ways, so that a short curve does not hide in a long one.
double misfit(const Isometry3d& pose, const Points& reference, const SegmentTree& reference_tree,
              const Points& objective, const SegmentTree& objective_tree) {
  double sum = 0;
  const Isometry3d back = pose.inverse();
  for (Index i = 0; i < reference.rows(); ++i)
    sum += objective_tree.closest(pose * Vector3d(reference.row(i))).squared_distance;
  for (Index i = 0; i < objective.rows(); ++i)
    sum += reference_tree.closest(back * Vector3d(objective.row(i))).squared_distance;
  return std::sqrt(sum / static_cast<double>(reference.rows() + objective.rows()));
}

/// Iterated closest points with steps of Gauss and Newton: the distance to the line through the closest
/// segment counts, so that the curve may slide along itself; at the ends of an open curve the distance to the
/// end counts in full, which holds it.
Isometry3d refined(Isometry3d pose, const Points& reference, const Points& target, const SegmentTree& tree,
                   int iterations) {
  const Index n = target.rows();
  for (int step = 0; step < iterations; ++step) {
    Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
    const Vector3d centre = pose * Vector3d(reference.colwise().mean());
    double size = 0;
    for (Index i = 0; i < reference.rows(); ++i) {
      const Vector3d p = pose * Vector3d(reference.row(i));
      const ClosestPoint closest = tree.closest(p);
      const Index a = closest.element, b = closest.element + 1;
      const Vector3d along = (target.row(b) - target.row(a)).stableNormalized();
      const bool at_end = (a == 0 && closest.weights(1) == 0) || (b == n - 1 && closest.weights(0) == 0);
      Matrix3d weight = Matrix3d::Identity();
      if (!at_end) weight -= 0.999 * along * along.transpose();  // a trace keeps the system regular
      Eigen::Matrix<double, 3, 6> jacobian;
      const Vector3d r = p - centre;
      jacobian.leftCols<3>() << 0, r.z(), -r.y(), -r.z(), 0, r.x(), r.y(), -r.x(), 0;
      jacobian.rightCols<3>() = Matrix3d::Identity();
      normal += jacobian.transpose() * weight * jacobian;
      right += jacobian.transpose() * weight * (closest.point - p);
      size = std::max(size, r.norm());
    }
    normal.diagonal().array() += 1e-12 * normal.trace();
    const Eigen::Matrix<double, 6, 1> move = normal.ldlt().solve(right);
    const double angle = std::min(move.head<3>().norm(), 0.5);
    Isometry3d change = Isometry3d::Identity();
    if (angle > 0)
      change = Eigen::Translation3d(centre) * Eigen::AngleAxisd(angle, move.head<3>().normalized()) *
               Eigen::Translation3d(-centre);
    pose = Eigen::Translation3d(move.tail<3>()) * change * pose;
    if (angle * size + move.tail<3>().norm() < 1e-12 * size) break;
  }
  return pose;
}

/// Directions spread evenly over the sphere (Fibonacci), for shapes whose three axes are alike.
std::vector<Matrix3d> rotations_everywhere() {
  std::vector<Matrix3d> rotations;
  constexpr int kDirections = 24, kTurns = 8;
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1 - (2 * i + 1.0) / kDirections, phi = i * kPi * (3 - std::sqrt(5.0));
    const double rho = std::sqrt(1 - z * z);
    const Eigen::Quaterniond tilt = Eigen::Quaterniond::FromTwoVectors(
        Vector3d::UnitZ(), Vector3d(rho * std::cos(phi), rho * std::sin(phi), z));
    for (int k = 0; k < kTurns; ++k)
      rotations.push_back(
          (tilt * Eigen::AngleAxisd(2 * kPi * k / kTurns, Vector3d::UnitZ())).toRotationMatrix());
  }
  return rotations;
}

}  // namespace

Alignment align_curves(const Polyline& reference, const Polyline& stroke) {
  if (!(reference.length() > 0) || !(stroke.length() > 0))
    throw RefusedEdit("a curve without length cannot be aligned", "draw the whole reference curve again");
  const Points from = reference.sampled(kSamples), to = stroke.sampled(kSamples);
  const PrincipalFrame a = principal_frame(from), b = principal_frame(to);
  const Points coarse_from = reference.sampled(40), coarse_to = stroke.sampled(40);
  const SegmentTree from_tree = tree_of(reference.points()), to_tree = tree_of(stroke.points());
  const double size = b.spreads.norm();

  // Starts: turns T with pose = F_b T F_a⁻¹. Signs with determinant +1 are half turns about the axes.
  std::vector<Matrix3d> turns;
  const auto alike = [&](int i, int j) { return b.spreads(i) - b.spreads(j) < 0.15 * b.spreads(i); };
  if (alike(0, 2)) {
    turns = rotations_everywhere();
  } else {
    std::vector<Matrix3d> signs{Matrix3d::Identity()};
    for (int axis = 0; axis < 3; ++axis)
      signs.emplace_back(Eigen::AngleAxisd(kPi, Vector3d::Unit(axis)).toRotationMatrix());
    // Two axes alike leave the turn about the third free, to be tried in steps of 15°.
    const int about = alike(0, 1) ? 2 : alike(1, 2) ? 0 : -1;
    const int steps = about < 0 ? 1 : 24;
    for (const Matrix3d& sign : signs)
      for (int k = 0; k < steps; ++k)
        turns.push_back(
            about < 0
                ? sign
                : Matrix3d(sign *
                           Eigen::AngleAxisd(2 * kPi * k / steps, Vector3d::Unit(about)).toRotationMatrix()));
  }
  struct Candidate {
    double misfit;
    Isometry3d pose;
  };
  std::vector<Candidate> candidates;
  for (const Matrix3d& turn : turns) {
    Isometry3d pose = Isometry3d::Identity();
    pose.linear() = b.axes * turn * a.axes.transpose();
    pose.translation() = b.centre - pose.linear() * a.centre;
    candidates.push_back({misfit(pose, coarse_from, from_tree, coarse_to, to_tree), pose});
  }
  const auto by_misfit = [](const Candidate& x, const Candidate& y) { return x.misfit < y.misfit; };
  std::stable_sort(candidates.begin(), candidates.end(), by_misfit);
  if (candidates.size() > 16) candidates.resize(16);
  for (Candidate& candidate : candidates) {
    candidate.pose = refined(candidate.pose, coarse_from, stroke.points(), to_tree, 8);
    candidate.misfit = misfit(candidate.pose, coarse_from, from_tree, coarse_to, to_tree);
  }
  std::stable_sort(candidates.begin(), candidates.end(), by_misfit);
  Isometry3d best = refined(candidates.front().pose, from, stroke.points(), to_tree, 40);
  // Rotations from many products are brought back to exact orthogonality.
  best.linear() = Eigen::Quaterniond(best.linear()).normalized().toRotationMatrix();
  Alignment alignment;
  alignment.matrix = best.matrix();
  alignment.rms = misfit(best, from, from_tree, to, to_tree);
  for (const Candidate& other : candidates) {
    const double turned = Eigen::AngleAxisd(best.linear().transpose() * other.pose.linear()).angle();
    if (turned > 0.1 && other.misfit < std::max(1.2 * candidates.front().misfit, 1e-3 * size))
      alignment.ambiguous = true;
  }
  if (alignment.rms > 0.2 * size)
    throw RefusedEdit(concat("the stroke does not have the shape of the curve: the best pose leaves ",
                             detail::text_of_length(alignment.rms)),
                      "draw the whole reference curve, from end to end, on the moved object");
  return alignment;
}

SharedPolyline polyline_of_curve(const PolylineMesh& mesh, int curve) {
  const std::vector<int> edges = mesh.edges_of_curve(curve);
  std::vector<char> is_used(edges.size(), 0);
  const auto used = [&](int e) -> char& {
    return is_used[static_cast<size_t>(std::lower_bound(edges.begin(), edges.end(), e) - edges.begin())];
  };
  SharedPolyline longest;
  const auto others = [&](int vertex) {
    int n = 0;
    for (const int e : mesh.vertex(vertex).edges) n += mesh.edge(e).curve == curve ? 1 : 0;
    return n;
  };
  // Runs that have an end are walked from there, closed ones from their lowest edge.
  for (const bool closed : {false, true})
    for (const int first : edges) {
      if (used(first)) continue;
      const auto& ends = mesh.edge(first).vertices;
      if (!closed && others(ends[0]) != 1 && others(ends[1]) != 1) continue;
      const bool backwards = !closed && others(ends[0]) != 1;
      SharedPolyline run = backwards ? reversed(*mesh.edge(first).polyline) : mesh.edge(first).polyline;
      used(first) = 1;
      int at = ends[backwards ? 0 : 1];
      for (bool more = true; more;) {
        more = false;
        for (const int e : mesh.vertex(at).edges) {
          if (mesh.edge(e).curve != curve || used(e)) continue;
          used(e) = 1;
          const bool turn = mesh.edge(e).vertices[0] != at;
          run = joined(*run, turn ? *reversed(*mesh.edge(e).polyline) : *mesh.edge(e).polyline);
          at = mesh.edge(e).vertices[turn ? 0 : 1];
          more = true;
          break;
        }
      }
      if (!longest || run->length() > longest->length()) longest = run;
    }
  return longest;
}

EditReport align_model(PolylineMesh& mesh, int reference, const DrawnStroke& drawn) {
  detail::require_curve(mesh, reference);
  const SharedPolyline curve = polyline_of_curve(mesh, reference);
  StrokeOptions options;
  options.closed = drawn.closed;
  options.snap = 1e-6 * curve->length();
  const Stroke stroke = prepare_stroke(drawn.points, options);
  Points points = stroke.points;
  if (stroke.closed) {
    points.conservativeResize(points.rows() + 1, 3);
    points.row(points.rows() - 1) = points.row(0).eval();
  }
  const Alignment alignment = align_curves(*curve, Polyline(std::move(points)));
  mesh.move_everything(alignment.matrix);
  EditReport report;
  report.remarks.push_back(
      concat("aligned c", reference, "; ", detail::text_of_length(alignment.rms), " left"));
  if (alignment.ambiguous)
    report.remarks.push_back(
        concat("c", reference, " fits in more than one way; align by a less regular curve"));
  return report;
}

}  // namespace batten
