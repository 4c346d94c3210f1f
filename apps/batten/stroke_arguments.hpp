#pragma once
#include "command.hpp"
#include "commands/surface.hpp"

#include <string>

#include "batten/network/curve_network.hpp"
#include "batten/strokes/stroke_network.hpp"

namespace batten::cli {

/// The way from curves without normals to a network with patches, as `surface` goes it.
struct StrokeArguments : commands::StrokeArguments {
  std::string network;  ///< where to write it, or empty
};

/// Adds the options; all but --weld apply to networks without normals only.
void add_stroke_options(CLI::App& command, StrokeArguments& arguments);

/// Adds what the strokes amount to: counts of strokes, dangling ends, near misses and of what was mended, a
/// line of them, warnings and times.
void report_strokes(const StrokeNetwork& strokes, Outcome& outcome);

/// Mends a network with normals and reports it: counts, warnings. `--weld 0` leaves it as it is.
CurveNetwork run_mending(const StrokeArguments& arguments, const CurveNetwork& curves, Outcome& outcome);

/// Makes a network of strokes, reports it with its diagnosis, and writes it where `network` is not empty.
StrokeNetwork run_strokes(const StrokeArguments& arguments, const CurveNetwork& strokes,
                          const Context& context, Outcome& outcome);

}  // namespace batten::cli
