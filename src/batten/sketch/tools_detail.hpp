#pragma once
#include <functional>
#include <unordered_set>
#include <vector>

#include "batten/sketch/contacts_detail.hpp"
#include "batten/sketch/tools.hpp"

// Private to the room: what several tools share.
namespace batten::detail {

double snap_or_default(const PolylineMesh& mesh, const Points& stroke, const InsertOptions& options);
/// prepare_stroke() and neat_stroke(), and refuses strokes that cross themselves.
/// @param may_close whether a stroke that looks like a loop is one, where its ends are not on each other.
Stroke ready_stroke(const DrawnStroke& drawn, double snap, bool may_close = false);
/// An open stroke that reaches for what it begins and ends at: each end goes on straight, is cut off, and
/// moves aside, with a smooth share of that along the stroke, to the place on the network that is nearest to
/// the stroke and to its end (what lies along it counts half). Ends for which there is none stay.
/// @param reach how far from the end such a place may lie, in the unit of the model.
/// @param may_end whether the stroke may end on an edge; nothing: on any.
Stroke reaching_stroke(const PolylineMesh& mesh, const Stroke& stroke, double reach,
                       const std::function<bool(int)>& may_end = {});
/// How far the ends of a stroke reach: `factor` times the default snap, but no further than a quarter of it.
double reach_of(const PolylineMesh& mesh, const Stroke& stroke, double factor);
/// Whether a stroke begins and ends on the network, in two places: then it is open, whatever it looks like.
bool runs_between_curves(const PolylineMesh& mesh, const DrawnStroke& drawn, double snap);
/// @throws RefusedEdit unless the curve exists.
void require_curve(const PolylineMesh& mesh, int curve);

/// Refuses an end of a stroke that is on no curve, or on none of its own.
/// @param what as in "the stroke ends". @param course as in "curve to curve".
[[noreturn]] void refuse_end(const PolylineMesh& mesh, const Eigen::Vector3d& end, const std::string& what,
                             double snap, const std::string& course);

/// A closed stroke that meets nothing, as edges of a new curve: vertices at its corners, two seams where it
/// has fewer than two. @return the sides in the sense of the stroke.
std::vector<int> add_loop(PolylineMesh& mesh, const Stroke& stroke, double sharpness, int curve);

/// A curve and the walks of its pieces: walks[k] runs from vertex k to vertex k + 1 of the contacts.
struct DrawnCurve {
  int curve = -1;
  std::vector<std::vector<Points>> pieces;  ///< per piece its edges from corner to corner
  std::vector<int> vertices;
  bool closed = false;
};
/// Fits a stroke to held points that are vertices already (held k is vertex k).
DrawnCurve place_stroke(PolylineMesh& mesh, const Stroke& stroke, const std::vector<HeldPoint>& held,
                        std::vector<int> vertices);
/// Fits a stroke to its contacts and makes these vertices; adds no edges yet.
DrawnCurve place_stroke(PolylineMesh& mesh, const Stroke& stroke, const std::vector<StrokeContact>& contacts);
/// The edges of one piece. @return the sides from its first vertex to its last.
std::vector<int> add_piece(PolylineMesh& mesh, const DrawnCurve& curve, size_t piece, double sharpness,
                           bool drawn = true);

/// insert_curve() of a stroke made ready, with its contacts known.
EditReport insert_ready(PolylineMesh& mesh, const Stroke& stroke, const std::vector<StrokeContact>& contacts,
                        double snap, const InsertOptions& options, int* curve = nullptr);

/// Walked the other way.
Stroke reversed_stroke(const Stroke& stroke);
/// The part of an open stroke between two arc lengths.
Stroke part_of(const Stroke& stroke, double from, double to);
/// A chain of sides walked the other way.
std::vector<int> reversed_chain(const std::vector<int>& chain);
/// H 5.2.4: from the middle of a half of a profile to the middle between its ends, unit length.
Eigen::Vector3d half_direction(const PolylineMesh& mesh, const std::vector<int>& chain);
/// Whether the first half of one border faces the first (rather than the second) half of the other, by the
/// greatest scalar product of their directions (H 5.2.4).
bool first_faces_first(const PolylineMesh& mesh, const std::array<std::vector<int>, 2>& a,
                       const std::array<std::vector<int>, 2>& b);

/// The faces that can be reached from one of them, in the order of their distance, found step by step.
class Spread {
 public:
  Spread(const PolylineMesh& mesh, int start) : mesh_(mesh), faces_{start}, seen_{start} {}
  /// Goes on from one face. @param may_cross(side): whether the way leads over this side of the face.
  /// @return the faces that are new.
  template <typename MayCross>
  std::vector<int> step(MayCross may_cross) {
    std::vector<int> found;
    if (is_complete()) return found;
    for (const int side : mesh_.face(faces_[done_++]).sides) {
      const int next = mesh_.face_of(opposite_side(side));
      if (next >= 0 && may_cross(side) && seen_.insert(next).second) found.push_back(next);
    }
    faces_.insert(faces_.end(), found.begin(), found.end());
    return found;
  }
  bool is_complete() const { return done_ == faces_.size(); }
  bool has(int face) const { return seen_.count(face) > 0; }
  const std::vector<int>& faces() const { return faces_; }

 private:
  const PolylineMesh& mesh_;
  std::vector<int> faces_;
  size_t done_ = 0;
  std::unordered_set<int> seen_;
};

/// Seam vertices of the curves that meet at the given vertices.
std::vector<int> seams_near(const PolylineMesh& mesh, const std::vector<int>& vertices);

}  // namespace batten::detail
