#include "batten/fairing/fair.hpp"

#include <cmath>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/fairing/automatic.hpp"
#include "batten/fairing/flows.hpp"
#include "batten/fairing/implicit_detail.hpp"
#include "batten/fairing/noise.hpp"
#include "batten/fairing/normal_filters.hpp"
#include "batten/fairing/surface_diffusion.hpp"
#include "batten/fairing/total_variation.hpp"
#include "batten/mesh/normals.hpp"

namespace batten {

namespace {

/// Normals by total variation, then a refit.
Points fair_by_total_variation(const Points& positions, const Triangles& triangles, double noise,
                               int iterations, bool keep_boundary, const Progress& progress) {
  // Normals jump by about 2 σ/ē per edge: a fit that takes them for noise weighs 1/(4 σ) per mean edge.
  const double edge = mean_edge_length(positions, triangles);
  if (!(edge > 0)) return positions;
  TotalVariationOptions options;
  options.fit_weight = 1 / (edge * std::max(4 * noise, 1e-3));
  options.iterations = iterations;
  const Eigen::MatrixXd smooth = denoise_total_variation(
      positions, triangles, vertex_normals(positions, triangles), options, nullptr, progress);
  Points normals(triangles.rows(), 3);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const Eigen::RowVector3d sum =
        smooth.row(triangles(f, 0)) + smooth.row(triangles(f, 1)) + smooth.row(triangles(f, 2));
    const double length = sum.norm();
    normals.row(f) = length > 0 ? Eigen::RowVector3d(sum / length) : Eigen::RowVector3d::Zero();
  }
  return refit_to_normals(positions, triangles, normals, 0.1, keep_boundary, progress);
}

/// One run of fair() by a given method.
class SmoothingRun {
 public:
  SmoothingRun(const Points& positions, const Triangles& triangles, const FairingOptions& options,
               const Progress& progress)
      : positions_(positions), triangles_(triangles), options_(options), progress_(progress) {}

  FairingResult run() {
    if (options_.method == FairingMethod::Automatic) {
      run_automatically();
      return std::move(result_);
    }
    result_.noise = options_.noise >= 0 ? options_.noise : estimate_noise(positions_, triangles_).level;
    run_method();
    result_.largest_move =
        positions_.rows() > 0 ? (result_.positions - positions_).rowwise().norm().maxCoeff() : 0;
    return std::move(result_);
  }

 private:
  int iterations(int standard) {
    return result_.iterations = options_.iterations > 0 ? options_.iterations : standard;
  }

  void run_automatically() {
    AutomaticFairingReport report;
    result_.positions =
        fair_automatically(positions_, triangles_,
                           {options_.noise, options_.iterations, options_.keep_boundary}, &report, progress_);
    result_.noise = report.noise;
    result_.strategy = report.strategy;
    result_.iterations = report.iterations;
    result_.largest_move = report.largest_move;
    result_.solves = report.solves;
  }

  template <typename Function, typename Options>
  void run_flow(Function function, Options flow_options, int steps) {
    flow_options.steps = iterations(steps);
    flow_options.keep_boundary = options_.keep_boundary;
    FlowReport report;
    result_.positions = function(positions_, triangles_, flow_options, &report, progress_);
    result_.iterations = report.steps;
    result_.time_step = report.time_step;
  }

  void run_diffusion(bool nonlocal) {
    SurfaceDiffusionOptions diffusion_options;
    diffusion_options.nonlocal = nonlocal;
    diffusion_options.steps = iterations(10);
    diffusion_options.keep_boundary = options_.keep_boundary;
    SurfaceDiffusionReport report;
    result_.positions = surface_diffusion(positions_, triangles_, diffusion_options, &report, progress_);
    result_.time_step = report.time_step;
  }

  template <typename Function>
  void run_normal_filter(Function filter_normals) {
    NormalFilterOptions filter;
    filter.keep_boundary = options_.keep_boundary;
    filter.iterations = iterations(20);
    result_.positions =
        move_to_normals(positions_, triangles_, filter_normals(positions_, triangles_, filter, progress_),
                        filter.vertex_iterations, options_.keep_boundary);
  }

  void run_method() {
    switch (options_.method) {
      case FairingMethod::Automatic:
        break;
      case FairingMethod::NonlocalSurfaceDiffusion:
        return run_diffusion(true);
      case FairingMethod::SurfaceDiffusion:
        return run_diffusion(false);
      case FairingMethod::MeanCurvature:
        return run_flow(mean_curvature_flow, FlowOptions{}, 3);
      case FairingMethod::BiLaplacian:
        return run_flow(bilaplacian_flow, FlowOptions{}, 10);
      case FairingMethod::Anisotropic:
        return run_flow(anisotropic_flow, AnisotropicFlowOptions{}, 3);
      case FairingMethod::AnisotropicTensor:
        return run_flow(anisotropic_tensor_flow, AnisotropicFlowOptions{}, 3);
      case FairingMethod::Elastica:
        return run_flow(elastica_flow, FlowOptions{}, 5);
      case FairingMethod::Nonlocal:
        return run_flow(nonlocal_flow, NonlocalFlowOptions{}, 3);
      case FairingMethod::TotalVariation:
        result_.positions = fair_by_total_variation(positions_, triangles_, result_.noise, iterations(200),
                                                    options_.keep_boundary, progress_);
        return;
      case FairingMethod::Taubin:
        result_.positions = taubin_smoothing(positions_, triangles_,
                                             {0.5, -0.53, iterations(10), options_.keep_boundary}, progress_);
        return;
      case FairingMethod::BilateralNormal:
        return run_normal_filter(bilateral_normals);
      case FairingMethod::GuidedNormal:
        return run_normal_filter(guided_normals);
    }
  }

  const Points& positions_;
  const Triangles& triangles_;
  const FairingOptions& options_;
  const Progress& progress_;
  FairingResult result_;
};

}  // namespace

std::optional<std::string> FairingOptions::problem() const {
  if (!std::isfinite(noise)) return concat("noise must be finite, got ", noise);
  if (iterations < 0) return concat("iterations must be at least 0, got ", iterations);
  return std::nullopt;
}

FairingResult fair(const Points& positions, const Triangles& triangles, const FairingOptions& options,
                   const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  fairing_detail::fixed_vertices(positions, triangles, false);  // checks the mesh
  return SmoothingRun(positions, triangles, options, progress).run();
}

}  // namespace batten
