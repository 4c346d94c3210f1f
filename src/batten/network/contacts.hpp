#pragma once
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "batten/mesh/box_tree.hpp"
#include "batten/network/curve_network.hpp"

// Where curves come near each other: for the diagnosis and welding of networks and the cleaning of strokes.
namespace batten::detail {

/// A place on a curve: on the edge from its vertex `edge` to the next, at `fraction` of it.
struct CurvePlace {
  int curve = -1;
  int edge = 0;
  double fraction = 0;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
};

/// Two curves, or two parts of one, within the tolerance of each other.
struct Contact {
  CurvePlace first, second;  ///< the closest pair
  double distance = 0;
  /// Length along the first curve over which they stay that near.
  double length = 0;
  /// They share a vertex there: no contact to be mended, only its length tells of an overlap.
  bool joined = false;
};

/// Polylines with their arc lengths, thinned to edges of about the tolerance so that dense sampling costs
/// nothing.
class CurveIndex {
 public:
  /// @param tolerance in the unit of the network, more than 0.
  CurveIndex(const CurveNetwork& network, double tolerance);
  CurveIndex(const CurveIndex&) = delete;
  CurveIndex& operator=(const CurveIndex&) = delete;

  /// All contacts, each once (first.curve <= second.curve), in a fixed order.
  std::vector<Contact> contacts() const;

  /// The place nearest to the end of a curve (its first or last vertex) on another curve or further along the
  /// same one, not counting what shares the end's vertex. Nothing when there is none within `reach`.
  std::optional<CurvePlace> nearest_other(int curve, bool at_last, double reach) const;

  /// Arc length from the first vertex of a curve to its vertex k.
  double arc(int curve, int k) const { return arcs_[static_cast<size_t>(curve)][static_cast<size_t>(k)]; }
  double length(int curve) const { return arcs_[static_cast<size_t>(curve)].back(); }

 private:
  struct Edge {
    int curve;
    int begin, end;  // places in the curve's vertex list
  };
  /// Two pieces within the tolerance of each other, or with a vertex in common; e < f.
  struct NearPair {
    int e, f;
    double distance, s, t;  ///< of the closest points, and where they are on each
    bool share;
  };
  /// A part of a piece, between two fractions of it.
  struct Span {
    int edge;
    double from, to;
  };
  /// Pairs that continue each other along both curves.
  struct PairGroup {
    int best = -1;  ///< the closest pair without a common vertex
    bool share = false;
    std::vector<Span> spans;  ///< what is within the tolerance, of the first piece of every pair
  };
  Eigen::Vector3d point(int curve, int k) const;
  std::vector<NearPair> near_pairs() const;
  std::array<int, 3> around(int e) const;  ///< the piece, and those before and after it on its curve
  std::vector<PairGroup> grouped(const std::vector<NearPair>& pairs) const;
  Span near_part(const NearPair& pair) const;
  Contact contact_of(PairGroup group, const NearPair& best) const;
  CurvePlace nearest_on(const Edge& edge, const Eigen::Vector3d& q) const;
  bool neighbours(int e, int f) const;

  const CurveNetwork& network_;
  double tolerance_;
  std::vector<std::vector<double>> arcs_;
  std::vector<Edge> edges_;
  std::vector<int> first_edge_;  // per curve, and the total at the end
  std::vector<Box> boxes_;       // per edge
  std::unique_ptr<BoxTree> tree_;
  double size_ = 0;  // diagonal of the box around everything
};

}  // namespace batten::detail
