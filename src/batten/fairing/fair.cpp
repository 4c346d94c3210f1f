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
  FairingResult result;
  const auto iterations = [&](int standard) {
    return result.iterations = options.iterations > 0 ? options.iterations : standard;
  };
  if (options.method == FairingMethod::Automatic) {
    AutomaticFairingReport report;
    result.positions = fair_automatically(
        positions, triangles, {options.noise, options.iterations, options.keep_boundary}, &report, progress);
    result.noise = report.noise;
    result.strategy = report.strategy;
    result.iterations = report.iterations;
    result.largest_move = report.largest_move;
    result.solves = report.solves;
    return result;
  }
  result.noise = options.noise >= 0 ? options.noise : estimate_noise(positions, triangles).level;

  const auto flow = [&](auto function, auto flow_options, int steps) {
    flow_options.steps = iterations(steps);
    flow_options.keep_boundary = options.keep_boundary;
    FlowReport report;
    result.positions = function(positions, triangles, flow_options, &report, progress);
    result.iterations = report.steps;
    result.time_step = report.time_step;
  };
  const auto diffusion = [&](bool nonlocal) {
    SurfaceDiffusionOptions diffusion_options;
    diffusion_options.nonlocal = nonlocal;
    diffusion_options.steps = iterations(10);
    diffusion_options.keep_boundary = options.keep_boundary;
    SurfaceDiffusionReport report;
    result.positions = surface_diffusion(positions, triangles, diffusion_options, &report, progress);
    result.time_step = report.time_step;
  };
  NormalFilterOptions filter;
  filter.keep_boundary = options.keep_boundary;
  switch (options.method) {
    case FairingMethod::Automatic:
      break;
    case FairingMethod::NonlocalSurfaceDiffusion:
      diffusion(true);
      break;
    case FairingMethod::SurfaceDiffusion:
      diffusion(false);
      break;
    case FairingMethod::MeanCurvature:
      flow(mean_curvature_flow, FlowOptions{}, 3);
      break;
    case FairingMethod::BiLaplacian:
      flow(bilaplacian_flow, FlowOptions{}, 10);
      break;
    case FairingMethod::Anisotropic:
      flow(anisotropic_flow, AnisotropicFlowOptions{}, 3);
      break;
    case FairingMethod::AnisotropicTensor:
      flow(anisotropic_tensor_flow, AnisotropicFlowOptions{}, 3);
      break;
    case FairingMethod::Elastica:
      flow(elastica_flow, FlowOptions{}, 5);
      break;
    case FairingMethod::Nonlocal:
      flow(nonlocal_flow, NonlocalFlowOptions{}, 3);
      break;
    case FairingMethod::TotalVariation:
      result.positions = fair_by_total_variation(positions, triangles, result.noise, iterations(200),
                                                 options.keep_boundary, progress);
      break;
    case FairingMethod::Taubin:
      result.positions = taubin_smoothing(positions, triangles,
                                          {0.5, -0.53, iterations(10), options.keep_boundary}, progress);
      break;
    case FairingMethod::BilateralNormal:
    case FairingMethod::GuidedNormal: {
      filter.iterations = iterations(20);
      const auto filter_normals =
          options.method == FairingMethod::BilateralNormal ? bilateral_normals : guided_normals;
      result.positions =
          move_to_normals(positions, triangles, filter_normals(positions, triangles, filter, progress),
                          filter.vertex_iterations, options.keep_boundary);
      break;
    }
  }
  result.largest_move = positions.rows() > 0 ? (result.positions - positions).rowwise().norm().maxCoeff() : 0;
  return result;
}

}  // namespace batten
