#include "batten/pipeline/stroke_surface.hpp"

#include <exception>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/distance.hpp"

namespace batten {

namespace {

/// Samples of strokes that tell whether the surface follows them, in diameters; those farther than kOff from
/// it are off it. A closed surface is worth more than strokes that lead nowhere.
constexpr double kStep = 0.01, kOff = 0.015;
constexpr double kMostOffClosed = 0.25, kMostOffOpen = 0.1;
/// Fewer strokes do not go around a body.
constexpr std::size_t kFewestStrokes = 3;

/// The plane that is asked for, through the origin.
std::optional<MirrorPlane> given_plane(StrokeSymmetry symmetry) {
  if (symmetry == StrokeSymmetry::Auto || symmetry == StrokeSymmetry::Off) return std::nullopt;
  return MirrorPlane{symmetry == StrokeSymmetry::X ? 0 : symmetry == StrokeSymmetry::Y ? 1 : 2, 0};
}

/// @param mirror takes the plane in which the strokes are completed, where they are.
ImplicitSurface made_implicit(const CurveNetwork& given, const StrokeSurfaceOptions& options,
                              std::optional<MirrorPlane>& mirror, const Progress& progress) {
  CurveNetwork strokes = given;
  if (options.symmetry == StrokeSymmetry::Auto && !given.curves.empty() &&
      bounding_box_diagonal(given.positions) > 0)
    if ((mirror = find_mirror_plane(given))) strokes = with_mirrored_strokes(given, *mirror);
  ImplicitSurfaceOptions implicit;
  implicit.field = options.field;
  implicit.field.closed = true;
  implicit.edge_length = options.surface.edge_length;
  implicit.max_triangles = options.surface.surface.max_triangles;
  return implicit_surface(strokes, implicit, progress);
}

void take_implicit(ImplicitSurface made, StrokeSurface& result) {
  StageTimes times = result.surface.times;
  times.add(made.surface.times);
  result.surface = std::move(made.surface);
  result.surface.times = std::move(times);
  made.surface = {};
  result.implicit = std::move(made);
}

}  // namespace

std::optional<std::string> StrokeSurfaceOptions::problem() const {
  if (topology == StrokeTopology::Implicit && closed == StrokeClosure::No)
    return std::string("an implicit surface is closed: topology implicit does not go with closed no");
  if (const auto found = strokes.problem()) return found;
  if (const auto found = surface.problem()) return found;
  return field.problem();
}

std::string doubt_of_cycles(const CurveNetwork& strokes, const NetworkSurface& surface,
                            StrokeClosure closed) {
  if (!surface.is_sound()) return surface.flaws.front();
  if (closed == StrokeClosure::Yes && surface.topology.n_boundary_loops > 0)
    return concat("patches leave ", surface.topology.n_boundary_loops, " openings");
  const StrokeSamples samples = stroke_samples(strokes, kStep * surface.diameter);
  const Eigen::VectorXd distance =
      distances(TriangleTree(surface.mesh.positions, surface.mesh.triangles).closest(samples.positions));
  const double off = static_cast<double>((distance.array() > kOff * surface.diameter).count()) /
                     static_cast<double>(distance.size());
  if (off > (surface.topology.is_watertight() ? kMostOffClosed : kMostOffOpen))
    return concat(100 * off, " % of the strokes lie off the patches");
  return {};
}

StrokeSurface stroke_surface(const CurveNetwork& given, const StrokeSurfaceOptions& options,
                             const Progress& progress,
                             const std::function<void(const StrokeNetwork&)>& network_made) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  StrokeSurface result;
  result.mirror = given_plane(options.symmetry);
  const CurveNetwork strokes = result.mirror ? with_mirrored_strokes(given, *result.mirror) : given;
  if (options.topology == StrokeTopology::Implicit) {
    take_implicit(made_implicit(strokes, options, result.mirror, progress), result);
    return result;
  }
  const bool may_be_implicit = options.topology == StrokeTopology::Auto &&
                               options.closed != StrokeClosure::No && strokes.curves.size() >= kFewestStrokes;
  std::exception_ptr failure;  // of the cycles
  try {
    result.strokes = stroke_network(strokes, options.strokes, progress);
    if (network_made) network_made(*result.strokes);
    result.surface =
        network_surface(result.strokes->network, result.strokes->estimate.cycles, options.surface, progress);
    result.doubt = doubt_of_cycles(strokes, result.surface, options.closed);
  } catch (const Cancelled&) {
    throw;
  } catch (const Error& error) {
    if (!may_be_implicit) throw;
    failure = std::current_exception();
    result.doubt = error.what();
  }
  if (result.doubt.empty() || !may_be_implicit) return result;
  try {
    std::optional<MirrorPlane> mirror = result.mirror;
    ImplicitSurface made = made_implicit(strokes, options, mirror, progress);
    if (failure || made.surface.is_sound()) {
      take_implicit(std::move(made), result);
      result.mirror = mirror;
      return result;
    }
  } catch (const Cancelled&) {
    throw;
  } catch (const Error&) {
    if (failure) std::rethrow_exception(failure);  // what is wrong with the cycles says more of the strokes
  }
  // Neither is a surface of these strokes.
  if (result.surface.is_sound()) result.surface.flaws.push_back(result.doubt);
  return result;
}

}  // namespace batten
