#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "batten/core/choices.hpp"
#include "batten/subdivision/bspline_surface.hpp"

namespace batten {

/// True where the library was built with Open Cascade; without it the functions below throw an InvalidInput
/// that says how to get it.
bool has_step();

/// For whoever would rather know before the work than after it.
/// @throws InvalidInput that says how to get Open Cascade, where has_step() is false.
void require_step();

/// What files for CAD are written as.
enum class CadFormat { Step, Iges };
constexpr auto choices_of(CadFormat) {
  return choices<CadFormat>("CAD format", {{CadFormat::Step, "step"}, {CadFormat::Iges, "iges"}});
}
/// By its extension: .step and .stp, .igs and .iges, in small letters; nothing where it is neither.
std::optional<CadFormat> cad_format(std::string_view extension);

/// Options of format_step() and format_iges().
struct StepOptions {
  /// STEP files declare millimetres; a cage in metres is written a thousand times larger. Above 0.
  double millimetres_per_unit = 1000;
  /// The name of the product in the file.
  std::string name = "surface";
  /// Names of faces by the `face` of their patches, and of edges by their number; empty or missing: none.
  /// Characters beyond ASCII become underscores. IGES has no place for them.
  std::vector<std::string> face_names{}, edge_names{};

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A B-spline surface as the text of a STEP file (ISO 10303-214): one solid per closed component, one shell
/// per open one; a face per patch, which shares its edges and vertices with its neighbours. The text is the
/// same for the same surface: the time stamp is fixed.
/// @throws InvalidInput without Open Cascade, on bad options, or naming an edge shorter than 1e-5 mm; Error
/// when Open Cascade cannot write.
std::string format_step(const BsplineSurface& surface, const StepOptions& options = {});

/// The same as the text of an IGES file (version 5.3): solids and shells as boundary representations.
/// @throws as format_step().
std::string format_iges(const BsplineSurface& surface, const StepOptions& options = {});

/// format_step() or format_iges(). @throws as these.
std::string format_cad(CadFormat format, const BsplineSurface& surface, const StepOptions& options = {});

/// What Open Cascade makes of a STEP or IGES file.
struct StepModel {
  int n_solids = 0, n_shells = 0, n_faces = 0, n_edges = 0, n_vertices = 0;
  bool is_valid = false;   ///< Open Cascade's own check of geometry and topology
  bool is_closed = false;  ///< every edge belongs to two faces
  double area = 0;         ///< mm²
  double volume = 0;       ///< mm³, of the solids
  double largest_gap =
      0;                ///< mm, between the curve of an edge and each of its faces, and its ends and vertices
  double diameter = 0;  ///< mm, of the box around the control points
  /// The faces that are bicubic B-splines, in their order in the file, in mm; vertices and edges not filled.
  std::vector<BsplinePatch> patches;
};

/// Reads a STEP file back. @throws InvalidInput without Open Cascade or when the text is no STEP file.
StepModel read_step(const std::string& text);

/// Reads an IGES file back. @throws InvalidInput without Open Cascade or when the file is none of IGES.
StepModel read_iges(const std::string& path);

}  // namespace batten
