#pragma once
#include <array>
#include <optional>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "batten/sketch/polyline_mesh.hpp"
#include "batten/sketch/tools.hpp"

namespace batten {

// The edits of a model, one for each tool of sketch/tools.hpp. Lengths in the unit of the model; a snap of 0
// takes default_snap().

/// Draws a curve: insert_curve().
struct InsertEdit {
  DrawnStroke stroke;
  InsertOptions options;
};
/// Takes a curve away.
struct DeleteEdit {
  int curve = 0;
};
/// Makes a curve sharp or smooth, 0 … 1.
struct SharpnessEdit {
  int curve = 0;
  double value = 0;
  std::optional<std::array<int, 2>> between;  ///< two vertices of the curve: only the part between them
};
/// Of a curve of the model, or, with curve −1, of a stroke that becomes a closed curve with its image.
struct MirrorEdit {
  int curve = -1;
  DrawnStroke stroke;
  std::optional<Points> axis;  ///< 2 × 3
  InsertOptions options;
};
/// Cuts a hole along a stroke: cut_hole().
struct HoleEdit {
  DrawnStroke stroke;
  InsertOptions options;
};
/// Joins two borders: glue_borders().
struct GlueEdit {
  DrawnStroke first, second;
  std::optional<std::array<int, 2>> halves;
  InsertOptions options;
};
/// Covers profiles along two spines: skin_profiles().
struct SkinEdit {
  std::vector<DrawnStroke> profiles;
  std::array<DrawnStroke, 2> spines;
  InsertOptions options;
};
/// Moves the model so that a curve of it comes to lie on a stroke: align_curves().
struct AlignEdit {
  int reference = 0;
  DrawnStroke stroke;
};
/// Moves the whole model, by a matrix of homogeneous coordinates.
struct TransformEdit {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
};

using SketchEdit = std::variant<InsertEdit, DeleteEdit, SharpnessEdit, MirrorEdit, HoleEdit, GlueEdit,
                                SkinEdit, AlignEdit, TransformEdit>;

/// Carries out one edit within the caller's begin() and commit(), and checks what it has touched.
/// @throws RefusedEdit; std::logic_error when a tool has broken an invariant of the model.
EditReport run_tool(PolylineMesh& model, const SketchEdit& edit);

/// run_tool(), again with more patience where an edit that names no snapping distance is refused: its strokes
/// reach for what they begin and end at, up to 6 % of the diameter away, and meet curves within 1.5, 2.2
/// and 3.2 times default_snap(). What the edit gives is kept of the first that succeeds.
/// @param model within begin(), which is begun anew for every try.
/// @throws as run_tool(): the refusal of the first try.
EditReport run_patiently(PolylineMesh& model, const SketchEdit& edit);

/// Whether two edits set the same thing, so that within one drag the second takes the place of the first: the
/// sharpness of the same part of a curve, or a motion of the whole model.
bool sets_the_same(const SketchEdit& first, const SketchEdit& second);

}  // namespace batten
