#pragma once
#include "command.hpp"
#include "commands/surface.hpp"
#include "step_output.hpp"

#include <string>

#include "batten/network/curve_network.hpp"
#include "batten/pipeline/network_surface.hpp"

namespace batten::cli {

/// The way from a network to a surface, as `surface` and `reconstruct` share it.
struct SurfaceArguments : commands::SurfaceArguments {
  std::string output;
  std::string unit;  ///< for CAD; else that of the network, else m
  StepArguments step;
};

/// Adds the output and every option, but not the network.
void add_surface_options(CLI::App& command, SurfaceArguments& arguments);

/// Fails where the output cannot be written as a mesh, before any work is done.
void check_surface_output(const SurfaceArguments& arguments);

/// Writes the surface of `network`, unless it is unsound and that is not accepted, and adds figures, lines,
/// warnings, times, the failure and the exhibit.
void report_surface(const SurfaceArguments& arguments, NetworkSurface surface, const CurveNetwork& network,
                    const Context& context, Outcome& outcome);

}  // namespace batten::cli
