#pragma once
#include <functional>
#include <optional>
#include <string>

#include "batten/core/choices.hpp"
#include "batten/pipeline/implicit_surface.hpp"
#include "batten/pipeline/network_surface.hpp"
#include "batten/strokes/stroke_symmetry.hpp"

namespace batten {

/// Where the surface of strokes comes from.
enum class StrokeTopology {
  Auto,      ///< cycles where they are sure, else an implicit surface
  Cycles,    ///< patches between strokes that meet
  Implicit,  ///< the zero of a field through all strokes
};
constexpr auto choices_of(StrokeTopology) {
  return choices<StrokeTopology>("topology", {{StrokeTopology::Auto, "auto"},
                                              {StrokeTopology::Cycles, "cycles"},
                                              {StrokeTopology::Implicit, "implicit"}});
}

/// Whether the surface of strokes is closed.
enum class StrokeClosure {
  Auto,  ///< as the cycles have it where they are sure; an implicit surface is closed
  Yes,   ///< cycles that leave it open are not sure
  No,    ///< it may be open: by cycles alone
};
constexpr auto choices_of(StrokeClosure) {
  return choices<StrokeClosure>(
      "closed", {{StrokeClosure::Auto, "auto"}, {StrokeClosure::Yes, "yes"}, {StrokeClosure::No, "no"}});
}

/// Whether the strokes are completed by their image in a mirror.
enum class StrokeSymmetry {
  Auto,  ///< an implicit surface of strokes that are nearly their own image is made of both
         ///< (find_mirror_plane())
  X,     ///< in the plane x = 0, before anything else; half a sketch becomes a whole one
  Y,
  Z,
  Off,
};
constexpr auto choices_of(StrokeSymmetry) {
  return choices<StrokeSymmetry>("symmetry", {{StrokeSymmetry::Auto, "auto"},
                                              {StrokeSymmetry::X, "x"},
                                              {StrokeSymmetry::Y, "y"},
                                              {StrokeSymmetry::Z, "z"},
                                              {StrokeSymmetry::Off, "off"}});
}

/// Options of stroke_surface().
struct StrokeSurfaceOptions {
  StrokeTopology topology = StrokeTopology::Auto;
  StrokeClosure closed = StrokeClosure::Auto;
  StrokeSymmetry symmetry = StrokeSymmetry::Auto;
  StrokeNetworkOptions strokes;   ///< of the way by cycles
  NetworkSurfaceOptions surface;  ///< of the way by cycles; edge length and limit of both
  StrokeFieldOptions field;       ///< of the implicit way

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// The surface of a set of strokes and which way it came.
struct StrokeSurface {
  NetworkSurface surface;
  std::optional<StrokeNetwork> strokes;  ///< the network of the cycles, where there was one
  /// What the implicit surface was found to be, without its mesh; where it is the result.
  std::optional<ImplicitSurface> implicit;
  /// Why the cycles are not sure, in words; empty where they are the result and sure.
  std::string doubt;
  std::optional<MirrorPlane> mirror;  ///< in which the strokes were completed
};

/// Why a surface by cycles may not be what its strokes mean; nothing where it is sure: it is sound, it is
/// closed where it must be, and no stroke lies off it.
std::string doubt_of_cycles(const CurveNetwork& strokes, const NetworkSurface& surface, StrokeClosure closed);

/// The surface of strokes without normals. Cycles of strokes that meet are filled (stroke_network(),
/// network_surface()); where that is in doubt or fails, the implicit surface of all strokes takes its place
/// (implicit_surface()), if it is sound or there is no other; a drawing of one or two strokes, or in a plane,
/// has none. Where that one is no good either, the doubt is a flaw of the surface by cycles.
/// @param network_made called with the network of the cycles before it is filled.
/// @throws InvalidInput, SolverFailure, Cancelled; where both ways fail, what the cycles failed of.
StrokeSurface stroke_surface(const CurveNetwork& strokes, const StrokeSurfaceOptions& options = {},
                             const Progress& progress = {},
                             const std::function<void(const StrokeNetwork&)>& network_made = {});

}  // namespace batten
