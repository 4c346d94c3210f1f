#pragma once
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/core/choices.hpp"
#include "batten/core/progress.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/network/curve_network.hpp"
#include "batten/render/camera.hpp"
#include "batten/render/image.hpp"

namespace batten {

/// What a picture shows.
enum class Shading {
  Shaded,     ///< a matt material under three soft lights
  Wireframe,  ///< the same in pale, with the edges of the triangles
  Isophotes,  ///< stripes of equal angle between normal and light: kinks in them are kinks of the normal
  ReflectionLines,    ///< a row of parallel lamps mirrored in the surface: kinks show breaks of curvature
  NormalMap,          ///< the hemisphere of normals as red and blue circles about the viewer (S fig. 4.24)
  MeanCurvature,      ///< H, positive on a sphere with outward normals
  GaussianCurvature,  ///< K
  GaussMap,           ///< the normals as points of the unit sphere (S fig. 2.2, 3.4)
  Porcupine,          ///< normals of the network scaled by its curvature (S fig. 3.12)
  Error,              ///< distance to a truth, given per vertex
  Uncertainty,        ///< standard deviations per vertex: the value `uncertainty` of a mesh, or given
};

constexpr auto choices_of(Shading) {
  return choices<Shading>("shading", {{Shading::Shaded, "shaded"},
                                      {Shading::Wireframe, "wireframe"},
                                      {Shading::Isophotes, "isophotes"},
                                      {Shading::ReflectionLines, "reflection-lines"},
                                      {Shading::NormalMap, "normal-map"},
                                      {Shading::MeanCurvature, "mean-curvature"},
                                      {Shading::GaussianCurvature, "gaussian-curvature"},
                                      {Shading::GaussMap, "gauss-map"},
                                      {Shading::Porcupine, "porcupine"},
                                      {Shading::Error, "error"},
                                      {Shading::Uncertainty, "uncertainty"}});
}

/// What is drawn. A mesh, a network, or a network upon a mesh.
struct Subject {
  const TriangleMesh* mesh = nullptr;
  const CurveNetwork* network = nullptr;
  /// For Shading::Error: distances per vertex of the mesh, or of the network where there is no mesh; values
  /// that are not finite are drawn grey.
  Eigen::VectorXd errors = {};
  /// Divides the errors for the colour bar, with its unit: 100 / diameter and "% of the diameter".
  double error_scale = 1;
  std::string error_unit = "distance";
  /// For Shading::Uncertainty, per vertex as the errors; empty: the value `uncertainty` of the mesh.
  Eigen::VectorXd uncertainty = {};

  /// The values per vertex behind Shading::Error or Shading::Uncertainty; empty where there are none.
  const Eigen::VectorXd& amounts(Shading shading) const;
};

/// What a picture shows, and how large it is.
struct RenderOptions {
  Shading shading = Shading::Shaded;
  int width = 1200, height = 900;  ///< pixels
  View view;
  int samples = 3;  ///< samples per pixel and direction, 1 … 8
  /// Use the normals given with the mesh. Off: those of its triangles, so that the picture shows the surface
  /// as it is, not as it is meant to be.
  bool given_normals = false;
  /// Edges with a larger angle between their triangles are drawn sharp; degrees. Ignored with given normals.
  double crease_angle_deg = 50;
  int stripes = 28;  ///< isophotes and reflection lines over half a turn
  /// Upper end of the colour bar of errors, or of the absolute curvature, in shown units; 0 takes it from the
  /// values so that the extreme percent is cut.
  double range = 0;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Draws one picture. Deterministic.
/// @throws InvalidInput when the subject lacks what the shading needs (a mesh, a network, normals, errors),
/// or an option is out of range; Cancelled.
Image render(const Subject& subject, const RenderOptions& options = {}, const Progress& progress = {});

/// The numbers behind a picture whose colours are values per vertex, and the ends of its colour bar.
struct ShownValues {
  Eigen::VectorXd values;    ///< per vertex of the mesh, or of the network; NaN: drawn grey
  double low = 0, high = 1;  ///< what lies beyond is drawn as the end
  std::string title;         ///< "mean curvature", or the unit of the errors
};

/// For whoever colours vertices without drawing: curvatures (on borders, where the operators say nothing, the
/// mean of the neighbours inside) and errors, exactly as render() shows them. Nothing for the other shadings.
/// @throws InvalidInput as render().
std::optional<ShownValues> shown_values(const Subject& subject, const RenderOptions& options);

/// One picture per shading side by side, each with its name below, on a sheet of options.width × height.
Image contact_sheet(const Subject& subject, const std::vector<Shading>& shadings,
                    const RenderOptions& options = {}, const Progress& progress = {});

}  // namespace batten
