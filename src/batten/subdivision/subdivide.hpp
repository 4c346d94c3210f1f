#pragma once
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/choices.hpp"
#include "batten/core/progress.hpp"
#include "batten/mesh/control_cage.hpp"

namespace batten {

/// How a cage is refined. The rules, with the source of each, are in docs/subdivide.md.
enum class SubdivisionScheme {
  CatmullClark,  ///< approximating, curvature-continuous but for extraordinary vertices: the usual choice
  Nuliss,        ///< goes through the vertices; knots of its own for every edge (H 6.3.1)
  NulissMod,     ///< Nuliss that also goes along the polylines of the edges; not smooth everywhere (H 6.3.1)
  Linear,        ///< splits faces at centroids and edges halfway, moves nothing (H 6.4.2)
};

constexpr auto choices_of(SubdivisionScheme) {
  return choices<SubdivisionScheme>("scheme", {{SubdivisionScheme::CatmullClark, "catmull-clark"},
                                               {SubdivisionScheme::Nuliss, "nuliss"},
                                               {SubdivisionScheme::NulissMod, "nulissmod"},
                                               {SubdivisionScheme::Linear, "linear"}});
}

/// Options of subdivide().
struct SubdivisionOptions {
  SubdivisionScheme scheme = SubdivisionScheme::CatmullClark;
  /// Levels of refinement, 0 to 12; each level has four times as many faces.
  int levels = 3;
  /// Also give the points and normals of the limit surface at the vertices.
  bool limit = false;
  /// Round off the corners of the border (vertices of one face alone). Off: they stay where they are.
  bool smooth_corners = false;
  /// Schemes Nuliss and NulissMod: a knot interval is the length of an edge to this power. 0 uniform, 0.5
  /// centripetal [lee1989], 1 by chord length; 0.5 follows edges of very different lengths best.
  double knot_exponent = 0.5;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A refined cage and where its parts come from.
struct SubdividedSurface {
  /// The refined mesh, all quads from level 1 on; the first vertices are those of the cage in their order.
  /// What is still sharp at this level, and the pieces of polylines that the next level would follow.
  ControlCage cage;
  /// n × 3 points and unit normals of the limit surface, with option `limit`; else 0 × 3. At creases and
  /// corners, where there is no one normal, the mean of those of the faces around by area.
  Points limit_positions, limit_normals;
  std::vector<int> face_parent;  ///< per face the face of the cage in which it lies
  /// The edges of the cage, e × 2, the first vertex as its first face runs along it.
  std::vector<std::array<int, 2>> cage_edges;
  /// e × (2^levels + 1): the vertices into which each edge of the cage was refined, from end to end.
  Eigen::Matrix<int, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> edge_chains;
};

/// Refines a cage. Borders become curves of their border vertices alone. Sharp edges and vertices hold for
/// as many levels as they are sharp; with the schemes other than Catmull–Clark, for that many rounded up.
/// Where one sharp edge ends it is a dart, two make a crease, more a corner (H 6.4). Time and memory are
/// linear in the number of faces that come out.
/// @pre Every vertex belongs to faces that form one fan, every edge to one or two faces of like orientation.
/// @throws InvalidInput naming face, edge or vertex and the remedy; Cancelled.
SubdividedSurface subdivide(const ControlCage& cage, const SubdivisionOptions& options = {},
                            const Progress& progress = {});

/// The same, kept for further positions of the vertices of the same cage.
class Subdivision {
 public:
  /// Does what subdivide() does and keeps what does not depend on positions.
  Subdivision(const ControlCage& cage, const SubdivisionOptions& options = {}, const Progress& progress = {});
  ~Subdivision();
  Subdivision(Subdivision&&) noexcept;
  Subdivision& operator=(Subdivision&&) noexcept;

  /// The surface for the positions given last.
  const SubdividedSurface& surface() const;
  /// Gives the surface away; nothing else may be asked afterwards.
  SubdividedSurface release();

  /// Refines again. With Catmull–Clark only positions are computed, in a fifth of the time or less; the other
  /// schemes, whose rules depend on the lengths of edges, begin anew.
  /// @param positions n × 3, as in the cage. @throws InvalidInput on other sizes, numbers that are not finite
  /// and polylines that no longer begin at their vertices; Cancelled. The surface is then as before.
  const SubdividedSurface& move(const Points& positions, const Progress& progress = {});

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace batten
