#pragma once
#include "command.hpp"

#include <string>
#include <vector>

#include "batten/network/curve_network.hpp"

namespace batten::cli {

/// The way from a network to a surface, as `surface` and `reconstruct` share it.
struct SurfaceArguments {
  std::string output, rebuilds = "auto", method = "curvature", constraints = "hard", map = "plane";
  std::string edge_length = "auto";
  std::string crossings = "flatten";  ///< or keep; of sketches alone
  double soft_weight = 1;
  int base_order = 2;
};

/// Adds the output and every option, but not the network.
void add_surface_options(CLI::App& command, SurfaceArguments& arguments);

/// Fails where the output cannot be written as a mesh, before any work is done.
void check_surface_output(const SurfaceArguments& arguments);

/// Fills the network, checks the mesh and writes it. Figures, lines, warnings, times and the exhibit go to
/// `outcome`.
/// @param cycles the patches where they are known; empty: they are found from the normals.
void run_surface_stage(const SurfaceArguments& arguments, const CurveNetwork& network, const Context& context,
                       Outcome& outcome, const std::vector<NetworkCycle>& cycles = {});

}  // namespace batten::cli
