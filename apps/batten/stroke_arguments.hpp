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

/// report_strokes(), with the diagnosis; writes the network where `network` is not empty.
void tell_strokes(const StrokeArguments& arguments, const StrokeNetwork& strokes, Outcome& outcome);

/// Makes the surface of strokes and reports which way it came. The network of its cycles is told
/// (tell_strokes()) even where filling it fails.
StrokeSurface run_strokes(const StrokeArguments& arguments, const NetworkSurfaceOptions& surface,
                          const CurveNetwork& strokes, const Context& context, Outcome& outcome);

}  // namespace batten::cli
