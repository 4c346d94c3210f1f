#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/sketch/polyline_mesh.hpp"
#include "batten/sketch/stroke.hpp"

// The tools of H 5.1 and 5.2. Each changes the model within begin() … commit() of the caller, or throws
// RefusedEdit; the caller then rolls back (see session/document.hpp, which does both).
namespace batten {

/// A drawn stroke as tools take it.
struct DrawnStroke {
  Points points;        ///< in the unit of the model
  bool closed = false;  ///< also recognised by its ends
};

/// What a tool has done.
struct EditReport {
  /// Change of the Euler characteristic that the steps of the tool amount to, counted as they are done and
  /// not from the result.
  int euler_change = 0;
  std::vector<int> curves;           ///< new curves
  std::vector<std::string> remarks;  ///< worth telling, in words
};

/// Which side of a border a stroke goes to where both are possible.
enum class Into {
  Auto,     ///< by the directions in which it leaves its ends; a face where they do not tell
  Face,     ///< divides a face
  Opening,  ///< closes an opening with two faces, on either side of the stroke
};

/// The snapping distance for strokes that give none: 1.5 % of the diameter of model and stroke.
double default_snap(const PolylineMesh& mesh, const Points& stroke);

/// Inserts a curve (H 5.2.1): the first boundary of a component, or a curve that starts and ends on the
/// network, crosses any number of curves within `snap` of them, and divides the faces on its way; a closed
/// one crosses at least one curve. Its pieces over an opening close it.
struct InsertOptions {
  double snap = 0;  ///< snapping distance to curves and vertices, in the unit of the model; 0: default_snap()
  double snap_factor = 1;   ///< times default_snap(), where `snap` is 0; above 0
  double reach_factor = 0;  ///< times default_snap(): how far ends of strokes look for a curve; at least 0
  double sharpness = 0;     ///< 0 … 1
  Into into = Into::Auto;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};
/// Carries it out. @throws RefusedEdit with reason and remedy; the model is as it was.
EditReport insert_curve(PolylineMesh& mesh, const DrawnStroke& stroke, const InsertOptions& options = {});

/// Takes a curve away: faces on both sides become one; a face at the border goes with its border.
EditReport delete_curve(PolylineMesh& mesh, int curve);

/// Mirrors a curve at an axis in its own least-squares plane (H 5.1.1) and inserts the image.
/// @param axis 2 × 3, two points of the axis, or nothing for the line through the ends of the curve.
EditReport mirror_curve(PolylineMesh& mesh, int curve, const std::optional<Points>& axis,
                        const InsertOptions& options = {});
/// The same for a stroke that is not part of the model: with its image it becomes a closed curve.
EditReport mirror_stroke(PolylineMesh& mesh, const DrawnStroke& stroke, const std::optional<Points>& axis,
                         const InsertOptions& options = {});

/// Cuts a hole (H 5.2.2). A stroke that meets no curve lies within a face and is tied to every corner of it
/// by a straight curve (6.4.2); one that crosses curves takes away what lies inside it.
EditReport cut_hole(PolylineMesh& mesh, const DrawnStroke& stroke, const InsertOptions& options = {});

/// Joins two borders by a tube of two faces (H 5.2.3). The two strokes run from the one border to the other.
/// @param halves two curves (one on each border) that bound the same face of the tube; nothing: chosen as
/// skin_profiles() does.
EditReport glue_borders(PolylineMesh& mesh, const DrawnStroke& first, const DrawnStroke& second,
                        const std::optional<std::array<int, 2>>& halves, const InsertOptions& options = {});

/// A tube through closed profiles along two spines that cross all of them in the same order (H 5.2.4).
EditReport skin_profiles(PolylineMesh& mesh, const std::vector<DrawnStroke>& profiles,
                         const std::array<DrawnStroke, 2>& spines, const InsertOptions& options = {});

/// Tags a curve as smooth (0), sharp (1) or between.
/// @param between two vertices of the curve: only its part from the one to the other, over the fewest edges.
EditReport set_curve_sharpness(PolylineMesh& mesh, int curve, double sharpness,
                               const std::optional<std::array<int, 2>>& between = std::nullopt);

/// Moves everything. @param matrix 4 × 4, affine and not singular. One that mirrors also turns the faces.
EditReport transform_model(PolylineMesh& mesh, const Eigen::Matrix4d& matrix);

/// How well a curve was laid on a stroke.
struct Alignment {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();  ///< rigid; takes the reference onto the stroke
  double rms = 0;          ///< distance of the reference from the stroke, in the unit of the model
  bool ambiguous = false;  ///< another pose, not near this one, fits as well: the curve is symmetric
};
/// The rigid motion that takes a curve onto a stroke of the same object in another place (H 5.3): principal
/// axes with the four choices of signs that do not mirror, more starts where axes are (nearly) equal, each
/// refined by iterated closest points.
/// @throws RefusedEdit when either has no length or the best pose leaves more than 20 % of its size.
Alignment align_curves(const Polyline& reference, const Polyline& stroke);
/// The whole curve, in order; the longest run where it was cut into several.
SharedPolyline polyline_of_curve(const PolylineMesh& mesh, int curve);
/// align_curves() and the motion of the whole model (H 5.3, step 3).
EditReport align_model(PolylineMesh& mesh, int reference, const DrawnStroke& stroke);

}  // namespace batten
