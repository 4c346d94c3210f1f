#include <cmath>
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/fairing/flows.hpp"
#include "batten/fairing/normal_filters.hpp"
#include "batten/fairing/surface_diffusion.hpp"
#include "batten/fairing/total_variation.hpp"

// What is wrong with options is named with field and value, by problem() and by who uses them.

namespace batten {
namespace {

const Points kPositions = (Points(3, 3) << 0, 0, 0, 1, 0, 0, 0, 1, 0).finished();
const Triangles kTriangles = (Triangles(1, 3) << 0, 1, 2).finished();

/// The message with which a call refuses its options.
std::string refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "accepted";
}

template <typename Options, typename Call>
void expect_problem(const Options& options, const std::string& field, const std::string& value,
                    const Call& call) {
  const std::string problem = options.problem().value_or("none");
  EXPECT_EQ(problem.find(field + " "), 0U) << problem;
  EXPECT_NE(problem.find("got " + value), std::string::npos) << problem;
  EXPECT_EQ(refusal([&] { call(kPositions, kTriangles, options); }), problem);
}

TEST(FairingOptions, DefaultsHaveNoProblem) {
  EXPECT_FALSE(FlowOptions().problem());
  EXPECT_FALSE(AnisotropicFlowOptions().problem());
  EXPECT_FALSE(NonlocalFlowOptions().problem());
  EXPECT_FALSE(TaubinOptions().problem());
  EXPECT_FALSE(NormalFilterOptions().problem());
  EXPECT_FALSE(SurfaceDiffusionOptions().problem());
  EXPECT_FALSE(TotalVariationOptions().problem());
}

TEST(FairingOptions, FlowsNameWhatIsWrong) {
  const auto flow = [](const auto&... arguments) { mean_curvature_flow(arguments...); };
  FlowOptions options;
  options.time_step = -1;
  expect_problem(options, "time_step", "-1", flow);
  options = {};
  options.steps = -2;
  expect_problem(options, "steps", "-2", flow);
  options = {};
  options.fidelity = INFINITY;
  expect_problem(options, "fidelity", "inf", flow);
}

TEST(FairingOptions, FlowsWithMoreOptionsNameTheirOwnAndTheCommonOnes) {
  AnisotropicFlowOptions anisotropic;
  anisotropic.threshold = -0.5;
  expect_problem(anisotropic, "threshold", "-0.5",
                 [](const auto&... arguments) { anisotropic_flow(arguments...); });
  expect_problem(anisotropic, "threshold", "-0.5",
                 [](const auto&... arguments) { anisotropic_tensor_flow(arguments...); });
  anisotropic = {};
  anisotropic.steps = -1;
  expect_problem(anisotropic, "steps", "-1",
                 [](const auto&... arguments) { anisotropic_flow(arguments...); });
  NonlocalFlowOptions nonlocal;
  nonlocal.similarity = 0;
  expect_problem(nonlocal, "similarity", "0", [](const auto&... arguments) { nonlocal_flow(arguments...); });
  nonlocal = {};
  nonlocal.time_step = -3;
  expect_problem(nonlocal, "time_step", "-3", [](const auto&... arguments) { nonlocal_flow(arguments...); });
}

// A filter that does not shrink needs a growing half that is stronger than the shrinking one.
TEST(FairingOptions, TaubinNamesWhatIsWrong) {
  const auto smooth = [](const auto&... arguments) { taubin_smoothing(arguments...); };
  TaubinOptions options;
  options.lambda = 1.5;
  expect_problem(options, "lambda", "1.5", smooth);
  options = {};
  options.mu = -0.25;
  expect_problem(options, "mu", "-0.25", smooth);
  options = {};
  options.steps = -1;
  expect_problem(options, "steps", "-1", smooth);
}

TEST(FairingOptions, NormalFiltersNameWhatIsWrong) {
  const auto filter = [](const auto&... arguments) { bilateral_normals(arguments...); };
  NormalFilterOptions options;
  options.range = NAN;
  expect_problem(options, "range", "nan", filter);
  options = {};
  options.iterations = -3;
  expect_problem(options, "iterations", "-3", filter);
  options = {};
  options.vertex_iterations = -4;
  expect_problem(options, "vertex_iterations", "-4", filter);
  expect_problem(options, "vertex_iterations", "-4",
                 [](const auto&... arguments) { guided_normals(arguments...); });
}

TEST(FairingOptions, SurfaceDiffusionNamesWhatIsWrong) {
  const auto diffuse = [](const auto&... arguments) { surface_diffusion(arguments...); };
  SurfaceDiffusionOptions options;
  options.similarity = 0;
  expect_problem(options, "similarity", "0", diffuse);
  options = {};
  options.fidelity = 0;
  expect_problem(options, "fidelity", "0", diffuse);
  options = {};
  options.time_step = -1;
  expect_problem(options, "time_step", "-1", diffuse);
  options = {};
  options.steps = -1;
  expect_problem(options, "steps", "-1", diffuse);
}

TEST(FairingOptions, TotalVariationNamesWhatIsWrong) {
  const auto denoise = [](const Points& positions, const Triangles& triangles,
                          const TotalVariationOptions& options) {
    denoise_total_variation(positions, triangles, positions, options);
  };
  TotalVariationOptions options;
  options.fit_weight = 0;
  expect_problem(options, "fit_weight", "0", denoise);
  options = {};
  options.iterations = 0;
  expect_problem(options, "iterations", "0", denoise);
}

}  // namespace
}  // namespace batten
