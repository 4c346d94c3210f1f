#pragma once
#include "command.hpp"
#include "step_output.hpp"

#include <string>

#include "batten/network/curve_network.hpp"
#include "batten/pipeline/network_surface.hpp"

namespace batten::cli {

/// The way from a network to a surface, as `surface` and `reconstruct` share it.
struct SurfaceArguments {
  std::string output, rebuilds = "auto", method = "curvature", constraints = "hard", map = "plane";
  std::string edge_length = "auto";
  std::string crossings = "flatten";  ///< or keep; of stroke sets alone
  std::string unit;                   ///< for CAD; else that of the network, else m
  StepArguments step;
  double soft_weight = 1, max_triangles = 20e6;
  int base_order = 2;
  bool accept_flaws = false;
};

/// Adds the output and every option, but not the network.
void add_surface_options(CLI::App& command, SurfaceArguments& arguments);

/// Fails where the output cannot be written as a mesh, before any work is done.
void check_surface_output(const SurfaceArguments& arguments);

/// @throws InvalidInput on values that do not parse.
NetworkSurfaceOptions surface_options(const SurfaceArguments& arguments);

/// Writes the surface of `network`, unless it is unsound and that is not accepted, and adds figures, lines,
/// warnings, times, the failure and the exhibit.
void report_surface(const SurfaceArguments& arguments, NetworkSurface surface, const CurveNetwork& network,
                    const Context& context, Outcome& outcome);

}  // namespace batten::cli
