#include "batten/deformation/deformer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/deformation/anderson_acceleration_detail.hpp"
#include "batten/deformation/constrained_system_detail.hpp"
#include "batten/deformation/deformation_matrices_detail.hpp"
#include "batten/deformation/deformation_model_detail.hpp"
#include "batten/deformation/handle_responses_detail.hpp"
#include "batten/deformation/local_rotations.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;

/// Iterations of shape matching that Anderson's acceleration looks back on, and after which it begins.
constexpr int kAccelerationDepth = 6, kPlainIterations = 5;
/// Its damping (Walker, Ni's β). On cow and cheburashka with a turn of 40°, 2 of 6 runs converge within 100
/// iterations, and the others end after 200 at steps 1.4 to 150 times smaller than plain ones, of which none
/// converges.
constexpr double kMixing = 0.5;

/// How far to go towards what an iteration found.
class StepControl {
 public:
  explicit StepControl(bool gauss_newton) : gauss_newton_(gauss_newton) {}

  /// @param iteration from 1. @param move the largest distance of a vertex from `next`.
  void advance(Points& positions, Points next, int iteration, double move) {
    if (gauss_newton_)
      shorten(positions, std::move(next), move);
    else
      accelerate(positions, next, iteration, move);
    last_move_ = move;
  }

 private:
  /// Gauss–Newton is not bound to descend: on irregular triangles the steps may begin to swing. Then they are
  /// shortened, which leaves the solution, where the step is zero, in its place. (Acceleration by past steps
  /// was tried and swings as well.)
  void shorten(Points& positions, Points next, double move) {
    damping_ = move < 0.95 * last_move_ ? std::min(1.0, 1.05 * damping_) : std::max(0.05, 0.7 * damping_);
    if (damping_ < 1)
      positions += damping_ * (next - positions);
    else
      positions = std::move(next);
  }

  void accelerate(Points& positions, const Points& next, int iteration, double move) {
    // Far from the solution, and where it has led astray, the past says nothing.
    const bool accelerate = iteration > kPlainIterations;
    if (!accelerate || move > 1.1 * last_move_) acceleration_.forget();
    acceleration_.advance(positions, next, accelerate ? kMixing : 1);
  }

  bool gauss_newton_;
  double damping_ = 1, last_move_ = std::numeric_limits<double>::infinity();
  detail::AndersonAcceleration acceleration_{kAccelerationDepth};
};

}  // namespace

std::optional<std::string> DeformOptions::problem() const {
  const auto positive = [](double value) { return value > 0 && std::isfinite(value); };
  if (!(soft_weight >= 0) || !std::isfinite(soft_weight))
    return concat("soft_weight must be at least 0, got ", soft_weight);
  if (!positive(bending_length)) return concat("bending_length must be positive, got ", bending_length);
  if (!(curvature_term >= 0 && curvature_term <= 1))
    return concat("curvature_term must lie in [0, 1], got ", curvature_term);
  if (!positive(detail_weight)) return concat("detail_weight must be positive, got ", detail_weight);
  if (!(membrane_length >= 0) || !std::isfinite(membrane_length))
    return concat("membrane_length must be at least 0, got ", membrane_length);
  if (max_iterations < 1) return concat("max_iterations must be at least 1, got ", max_iterations);
  if (!positive(tolerance)) return concat("tolerance must be positive, got ", tolerance);
  return std::nullopt;
}

struct Deformer::Implementation {
  DeformOptions options;
  Points rest;
  double diameter = 0;
  detail::ConstrainedSystem system;
  std::optional<detail::DeformationModel> model;
  std::unique_ptr<detail::HandleResponses> responses;  ///< without detail preservation
  double curvature_term = 0;

  Implementation(const Points& positions, std::vector<int> constrained, const DeformOptions& wanted)
      : options(wanted),
        rest(positions),
        diameter(bounding_box_diagonal(positions)),
        system(std::move(constrained), positions.rows(), wanted.soft_weight) {}

  bool gauss_newton() const { return options.detail == DetailPreservation::GaussNewton; }

  /// @throws InvalidInput where a part of the mesh has no constrained vertex.
  void check_parts(const Triangles& triangles, const std::vector<char>& used) const {
    const std::vector<int> part = detail::connected_parts(triangles, rest.rows());
    std::vector<char> held(rest.rows(), 0);
    for (const int v : system.constrained()) held[part[v]] = 1;
    for (Eigen::Index v = 0; v < rest.rows(); ++v)
      if (used[v] && !held[part[v]])
        throw InvalidInput(
            concat("the part of the mesh around vertex ", v,
                   " has no fixed vertex and no handle, so its place is open; select some of it"));
  }

  void factorize(const Progress& progress) {
    system.factorize(model->stiffness(), model->inverse_mass(), model->bending(), model->second_order(),
                     progress);
  }

  /// The second variation of (2.60) is positive only where curved regions are small; the term is halved until
  /// the whole is. Seven halvings leave less than a hundredth: then it is dropped.
  void factorize_total_curvature(const Triangles& triangles, const Progress& progress) {
    const SparseMatrix curvature = model->curvature_stiffness(triangles);
    curvature_term = options.curvature_term;
    for (int halving = 0;; ++halving) {
      if (halving == 7) curvature_term = 0;
      model->set_curvature_term(curvature_term, curvature);
      try {
        factorize(progress);
        return;
      } catch (const SolverFailure&) {
        if (curvature_term == 0) throw;
      }
      curvature_term /= 2;
    }
  }

  /// @throws InvalidInput as deform().
  void check(const Points& targets, const Points* start) const {
    const std::vector<int>& constrained = system.constrained();
    if (targets.rows() != static_cast<Eigen::Index>(constrained.size()))
      throw InvalidInput(concat("there are ", constrained.size(), " constrained vertices, but ",
                                targets.rows(), " targets"));
    for (Eigen::Index c = 0; c < targets.rows(); ++c)
      if (!targets.row(c).allFinite())
        throw InvalidInput(concat("the target of vertex ", constrained[c], " is not finite"));
    if (start != nullptr && start->rows() != rest.rows())
      throw InvalidInput(
          concat("the start has ", start->rows(), " positions, but the mesh ", rest.rows(), " vertices"));
  }

  /// The displacement of least energy.
  Points linear_solution(const Points& targets) const {
    Points displacements = targets;
    for (std::size_t c = 0; c < system.constrained().size(); ++c)
      displacements.row(static_cast<Eigen::Index>(c)) -= rest.row(system.constrained()[c]);
    Points positions;
    if (responses && responses->respond(displacements, positions)) return positions;
    const Points zero = Points::Zero(rest.rows(), 3);
    return rest + system.solve(zero, displacements, zero);
  }

  /// Alternates between the directions of detail and positions, from result.positions on.
  void preserve_detail(const Points& targets, Result& result, const Progress& progress) const {
    const Points constant = gauss_newton() ? model->displacement_forces() : Points();
    std::vector<Matrix3d> rotations;
    StepControl steps(gauss_newton());
    result.report.converged = false;
    const auto report = [&] {
      progress.report("deforming", static_cast<double>(result.report.iterations) / options.max_iterations);
    };
    while (!result.report.converged && result.report.iterations < options.max_iterations) {
      Points next;
      if (gauss_newton()) {
        next = system.solve(Points(constant + model->detail_forces(result.positions, rotations)), targets,
                            result.positions);
      } else {
        fit_local_rotations(model->stiffness(), rest, result.positions, rotations);
        report();
        next = system.solve(model->turned_rest(rotations), targets, result.positions);
      }
      const double move = (next - result.positions).rowwise().norm().maxCoeff();
      ++result.report.iterations;
      result.report.last_move = diameter > 0 ? move / diameter : 0;
      result.report.converged = result.report.last_move <= options.tolerance;
      if (result.report.converged)
        result.positions = std::move(next);
      else
        steps.advance(result.positions, std::move(next), result.report.iterations, move);
      report();
    }
  }
};

Deformer::Deformer(const Points& positions, const Triangles& triangles, std::vector<int> constrained,
                   const DeformOptions& options, const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  progress.report("factorising", 0);
  implementation_ = std::make_unique<Implementation>(positions, std::move(constrained), options);
  Implementation& self = *implementation_;
  progress.report("factorising", 0);
  self.model.emplace(self.rest, triangles, options, self.diameter);
  progress.report("factorising", 0.05);
  std::vector<char> used(positions.rows(), 0);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) used[triangles(f, k)] = 1;
  self.check_parts(triangles, used);
  self.system.choose_unknowns(used);
  if (options.energy == DeformationEnergy::TotalCurvature && options.curvature_term > 0)
    self.factorize_total_curvature(triangles, progress);
  else
    self.factorize(progress);
  if (options.detail == DetailPreservation::None)
    self.responses =
        std::make_unique<detail::HandleResponses>(self.system, self.rest, triangles, self.diameter);
  if (self.gauss_newton()) self.model->follow_normals(triangles, used);
}

Deformer::~Deformer() = default;
Deformer::Deformer(Deformer&&) noexcept = default;
Deformer& Deformer::operator=(Deformer&&) noexcept = default;

Deformer::Result Deformer::deform(const Points& targets, const Points* start,
                                  const Progress& progress) const {
  const Implementation& self = *implementation_;
  self.check(targets, start);
  progress.report("deforming", 0);
  const bool linear = self.options.detail == DetailPreservation::None;
  Result result;
  result.positions = start != nullptr && !linear ? *start : self.linear_solution(targets);
  if (!linear) self.preserve_detail(targets, result, progress);
  return result;
}

const std::vector<int>& Deformer::constrained() const {
  return implementation_->system.constrained();
}
double Deformer::curvature_term() const {
  return implementation_->curvature_term;
}

}  // namespace batten
