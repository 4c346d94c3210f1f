#pragma once
#include "commands/json.hpp"

#include <string>
#include <vector>

#include "batten/pipeline/network_surface.hpp"
#include "batten/pipeline/stroke_surface.hpp"
#include "batten/strokes/stroke_network.hpp"

namespace batten::commands {

/// The way from a network to a surface, as `surface` and `reconstruct` share it: options in the words of
/// users, with their defaults (docs/surface.md).
struct SurfaceArguments {
  std::string rebuilds = "auto", method = "curvature", constraints = "hard", map = "plane";
  std::string edge_length = "auto";
  std::string crossings = "flatten";  ///< or keep; of stroke sets alone
  double soft_weight = 1, max_triangles = 20e6;
  int base_order = 2;
  bool accept_flaws = false;
};

/// The way from curves without normals to a network with patches, as `surface` goes it.
struct StrokeArguments {
  std::string weld = "auto", reach = "3%", step = "1.5%";
  std::string topology = "auto", closed = "auto", symmetry = "auto";
};

/// −1 for "auto". @throws InvalidInput on anything but auto and 0 to 20.
int parse_rebuilds(const std::string& text);

/// @throws InvalidInput on words that do not parse.
NetworkSurfaceOptions options_of(const SurfaceArguments& arguments);
/// Of the way by cycles; all words are checked. @param diameter of the strokes.
StrokeNetworkOptions options_of(const StrokeArguments& arguments, double diameter);

/// Mends a network with normals, and tells in figures and warnings what it did; `weld` "0" leaves it alone.
CurveNetwork mended(const StrokeArguments& arguments, const CurveNetwork& curves, Json& figures,
                    std::vector<std::string>& warnings);

/// @throws InvalidInput on words that do not parse or do not go together, and where `weld` is "0".
StrokeSurfaceOptions options_of(const StrokeArguments& arguments, const NetworkSurfaceOptions& surface,
                                double diameter);

/// What the strokes amount to.
Json figures_of(const StrokeNetwork& made);
/// The findings that need a person's eye.
Json diagnosis_json(const StrokeNetwork& made);

/// How sure the vertices of a mended network are: as the nearest points of the curves that were read.
/// @param deviations one for each vertex of `read`; none: its curves are taken as exact.
NetworkUncertainty carried_uncertainty(const Eigen::VectorXd& deviations, const CurveNetwork& read,
                                       const CurveNetwork& mended);

/// Which way the surface of strokes came, why, and how near it is to them.
Json figures_of(const StrokeSurface& made);
/// The same as a warning: what the cycles left in doubt. Empty where there is nothing to say.
std::string warning_of(const StrokeSurface& made);

/// All but what was written, and how sure it is.
Json figures_of(const SurfaceArguments& arguments, const NetworkSurface& surface);

}  // namespace batten::commands
