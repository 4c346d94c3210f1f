#pragma once
#include <map>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "batten/core/progress.hpp"
#include "batten/mesh/halfedge_mesh.hpp"
#include "batten/remeshing/feature_chains.hpp"

namespace batten {

/// 0 to π.
double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

/// A surface under remeshing: the triangles, and for every vertex where on the features it lies and how long
/// its edges should be. STEP 0 of H 2.2.2 works on it.
class RemeshState {
 public:
  /// @param sizes wanted edge length per vertex of `mesh`, above 0.
  RemeshState(HalfedgeMesh mesh, const FeatureChains& features, const Eigen::VectorXd& sizes);

  HalfedgeMesh mesh;
  std::vector<double> size;   ///< per vertex: the wanted edge length
  std::vector<int> chain;     ///< per vertex: its feature chain, or kNone
  std::vector<double> place;  ///< per vertex on a chain: its arc length
  std::vector<int> corner;    ///< per vertex: the corner it is (a vertex of the input), never moved, or kNone
  bool hold_border = false;   ///< edges on the border stay, see RemeshOptions

  bool is_free(int v) const { return chain[v] < 0 && corner[v] < 0; }
  double edge_length(int h) const { return (mesh.position(mesh.from(h)) - mesh.position(mesh.to(h))).norm(); }
  double wanted_length(int h) const { return 0.5 * (size[mesh.from(h)] + size[mesh.to(h)]); }
  /// The chain that the marked edge h lies on.
  int chain_of_edge(int h) const;
  /// Arc length of v, a vertex inside the chain or one of its corners.
  double place_on(int chain_number, int v) const;
  /// Moves every vertex inside a chain along it, towards the place where its two edges have the same length
  /// relative to the wanted ones, by `share` of the way.
  void relax_chains(double share);

  /// Splits edges longer than `ratio` times the wanted length, longest first. @return how many.
  int split_long_edges(double ratio, const Progress& progress = {});
  /// The same until no such edge is left: always the longest next, those across included, which ends because
  /// every new edge is shorter than that. Beside a border that is held, longer edges stay: those that are not
  /// the longest of their faces. The surface stays where it is.
  /// @param lines_only features and edges between faces that turn by more than `turn` radians alone.
  /// @return how many.
  int refine(double ratio, bool lines_only, double turn, const Progress& progress = {});
  /// Splits the longest edge of each face that may be, unless that was done for a face before it. @return the
  /// new vertices.
  std::vector<int> split_longest_edges(const std::vector<int>& faces);
  /// Collapses edges shorter than `ratio` times the wanted length, shortest first, where that makes no edge
  /// longer than `longest` times its wanted length, turns no face over and leaves features on their curves.
  int collapse_short_edges(double ratio, double longest, const Progress& progress = {});
  /// Turns edges that bring valences nearer to 6 (what the angle around asks for, on features and borders).
  /// Refused where a face would turn by more than `turn` radians or an angle become smaller than `angle`.
  int flip_for_valence(double turn, double angle);
  /// Turns edges that raise the smallest angle of their two faces.
  int flip_for_angles(double turn);
  /// Turns edges between faces in one plane, up to `turn` radians, where the angles opposite to them sum to
  /// more than π, until there are none: Delaunay triangulations of flat pieces. The surface stays where it
  /// is.
  int flip_flat_pieces(double turn);

 private:
  /// A border that is held is not split, nor what is shorter beside it: that would make flatter and flatter
  /// triangles on the same edge without end.
  bool can_split(int h) const;
  bool is_longest_of_its_faces(int h) const;
  /// Puts a vertex in the middle of h (of its part of the chain).
  int split_in_the_middle(int h);
  /// Collapses h so that its start goes (its end, where `reversed`), if that is allowed and sound.
  bool collapse_towards(int h, bool reversed, double longest);
  bool collapse_is_sound(int h, const Eigen::Vector3d& place, double longest) const;
  /// Sines of the smallest angle of the two faces at h before and after a turn of the edge.
  struct FlipSines {
    double before, after;
  };
  FlipSines flip_sines(int h) const;
  /// Whether h can be turned without bending the surface by more than `turn` radians.
  bool flip_is_sound(int h, double turn) const;
  void add_vertex(int v, double size_there, int chain_there, double place_there);

  const FeatureChains* features_;
  std::vector<int> inner_vertices_;  ///< per chain: its vertices besides the two corners
  std::map<std::pair<int, int>, std::vector<int>> chains_between_;
};

}  // namespace batten
