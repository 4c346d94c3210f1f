#include "batten/pipeline/step_surface.hpp"

#include <array>
#include <cmath>
#include <map>
#include <set>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/distance.hpp"

namespace batten {

namespace {

/// Above, CAD programs take a smooth edge for a sharp one.
constexpr double kVisibleJump = radians(0.1);
/// Beyond these the faces are not the surface any more.
constexpr double kFoldedJump = radians(30.0), kLostDeviation = 0.01;
/// An edge is a curve's where its points are this near to it, of its own length.
constexpr double kOnCurve = 0.02;

/// Names edges after the curves that they follow, and faces after their patch and the curves around it.
void name_after_curves(const CurveNetwork& network, const BsplineSurface& faces, StepOptions& step) {
  std::vector<int> curve_of_segment;
  std::vector<std::array<int, 2>> ends;
  for (std::size_t c = 0; c < network.curves.size(); ++c)
    for (std::size_t k = 1; k < network.curves[c].vertices.size(); ++k) {
      ends.push_back({network.curves[c].vertices[k - 1], network.curves[c].vertices[k]});
      curve_of_segment.push_back(static_cast<int>(c));
    }
  if (ends.empty()) return;
  Segments segments(static_cast<Eigen::Index>(ends.size()), 2);
  for (std::size_t k = 0; k < ends.size(); ++k)
    segments.row(static_cast<Eigen::Index>(k)) << ends[k][0], ends[k][1];
  const SegmentTree tree(network.positions, segments);
  const auto curve_under = [&](const BsplineCurve& edge) {
    const double length = (evaluate(edge, 0.25) - evaluate(edge, 0)).norm() +
                          (evaluate(edge, 0.75) - evaluate(edge, 0.25)).norm() +
                          (evaluate(edge, 1) - evaluate(edge, 0.75)).norm();
    int curve = -1;
    for (const double t : {0.25, 0.5, 0.75}) {
      const ClosestPoint nearest = tree.closest(evaluate(edge, t));
      if (std::sqrt(nearest.squared_distance) > kOnCurve * length) return -1;
      const int here = curve_of_segment[static_cast<std::size_t>(nearest.element)];
      if (curve >= 0 && here != curve) return -1;
      curve = here;
    }
    return curve;
  };
  const auto name_of = [&](int curve) {
    const std::string& name = network.curves[static_cast<std::size_t>(curve)].name;
    return name.empty() ? concat("curve ", curve) : name;
  };
  std::map<int, std::set<int>> curves_of_face;
  step.edge_names.assign(faces.edges.size(), "");
  for (std::size_t e = 0; e < faces.edges.size(); ++e) {
    const int curve = curve_under(faces.edges[e].curve);
    if (curve < 0) continue;
    step.edge_names[e] = name_of(curve);
    for (const int p : faces.edges[e].patches)
      if (p >= 0) curves_of_face[faces.patches[static_cast<std::size_t>(p)].face].insert(curve);
  }
  for (const BsplinePatch& patch : faces.patches) {
    const auto face = static_cast<std::size_t>(patch.face);
    if (step.face_names.size() <= face) step.face_names.resize(face + 1);
    std::string name = concat("patch ", patch.face);
    for (const int curve : curves_of_face[patch.face]) {
      name += (curve == *curves_of_face[patch.face].begin() ? ": " : ", ") + name_of(curve);
    }
    step.face_names[face] = name;
  }
}

}  // namespace

std::optional<std::string> StepSurfaceOptions::problem() const {
  if (!(step.millimetres_per_unit > 0) || !std::isfinite(step.millimetres_per_unit))
    return concat("millimetres_per_unit must be above 0, got ", step.millimetres_per_unit);
  return faces.problem();
}

StepSurface step_surface(const TriangleMesh& mesh, const std::vector<int>& patch_of_triangle,
                         const StepSurfaceOptions& options, const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  require_step();
  StepSurface result;
  result.diameter = bounding_box_diagonal(mesh.positions);
  {
    const ScopedStage stage(result.times, "splines");
    result.faces = spline_faces(mesh, patch_of_triangle, options.faces, progress.part("splines", 0, 0.9));
  }
  {
    const ScopedStage stage(result.times, "step");
    progress.report("step", 0.9);
    StepOptions step = options.step;
    if (options.network != nullptr && options.format == CadFormat::Step)
      name_after_curves(*options.network, result.faces.surface, step);
    result.text = format_cad(options.format, result.faces.surface, step);
  }
  const double deviation = result.faces.surface.deviation / result.diameter,
               jump = result.faces.surface.normal_jump;
  if (jump > kFoldedJump)
    result.flaws.push_back(
        concat("B-spline faces fold where patches are too bent for few faces: normals differ by up to ",
               degrees(jump), " degrees along smooth curves; divide large patches by more curves"));
  if (deviation > kLostDeviation)
    result.flaws.push_back(concat("B-spline faces leave the surface by ", 100 * deviation,
                                  " % of the diameter; divide large patches by more curves"));
  if (!result.flaws.empty()) return result;
  if (deviation > options.faces.tolerance)
    result.warnings.push_back(concat("the B-spline faces leave the surface by ", 100 * deviation,
                                     " % of the diameter, `step_tolerance` ", 100 * options.faces.tolerance,
                                     " %: more triangles (a shorter `edge_length`) determine more knots"));
  if (jump > kVisibleJump)
    result.warnings.push_back(concat(
        "the normals of neighbouring faces differ by up to ", degrees(jump),
        " degrees along curves that are not sharp; a looser `step_tolerance` or more curves may help"));
  return result;
}

}  // namespace batten
