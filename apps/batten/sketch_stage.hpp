#pragma once
#include "command.hpp"

#include <string>
#include <vector>

#include "batten/strokes/sketch_network.hpp"

namespace batten::cli {

/// The way from curves without normals to a network with patches, as `surface` goes it.
struct SketchArguments {
  std::string weld = "auto", reach = "3%", step = "1.5%", network;
};

/// Adds the options; they apply to networks without normals only.
void add_sketch_options(CLI::App& command, SketchArguments& arguments);

/// Reads a sketch as `surface` does: what its strokes amount to. Counts of strokes, dangling ends, near
/// misses and of what was mended, a line of them, warnings and times go to `outcome`; diagnosis and patches
/// do not.
/// @throws InvalidInput where no patch is left.
SketchNetwork read_sketch(const SketchArguments& arguments, const CurveNetwork& strokes,
                          const Context& context, Outcome& outcome);

/// Cleans the sketch, samples its curves evenly, finds the patches and estimates normals. The network is
/// replaced. Figures, lines, warnings and times go to `outcome`.
/// @return the patches.
std::vector<NetworkCycle> run_sketch_stage(const SketchArguments& arguments, CurveNetwork& network,
                                           const Context& context, Outcome& outcome);

}  // namespace batten::cli
