#pragma once
#include <cstdint>
#include <string>

#include "batten/mesh/shape.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/scan/scan.hpp"
#include "batten/simulation/traced_curve.hpp"

namespace batten::experiments {

/// The length in which λ and μ of S are taken, metres: S does not state it, in metres the lobes of lilium
/// vanish (docs/errata.md#s-3-units).
inline constexpr double kThesisUnit = 0.01;

/// The three ways in which S 3.7.4 takes a scan.
enum class Acquisition {
  Device,          ///< the Morphorider: an odometer, wrong by 0.3 % for each curve
  PhoneMeasured,   ///< time stamps, with the length of every segment measured
  PhoneEstimated,  ///< time stamps alone
};

/// What something made is measured against, with the places of the nodes (n × 3) in it.
struct Truth {
  Truth(Shape shape, Points nodes);

  Shape shape;  ///< a surface or curves
  Points nodes;
  ShapeTree tree;
  double diameter;
};

/// An object whose surface is known, with the curves that are drawn on it. Lengths in metres.
struct ScannedObject {
  ScannedObject(std::string name, TracedNetwork traced, Shape surface);

  std::string name;
  TracedNetwork traced;
  Truth truth;
};

/// Length of all curves, in the unit of the object.
double total_length(const TracedNetwork& traced);

/// The cone of S 5.1: base radius 0.5 m, height 2 m, of which the part between 0.1 and 1.7 m is scanned.
ScannedObject scanned_cone();
/// lilium.obj as wide as in S table 5.2 (1 m), with sections by `planes` planes per horizontal axis and its
/// border: 2 for five curves, 3 for seven.
ScannedObject scanned_lilium(const TriangleMesh& lilium, int planes);

/// What a hand-held device makes of it: frames off by 2° of noise and 1° of drift per axis, and the lengths
/// of the acquisition; time stamps come from a hand whose speed varies by 20 % along each curve and, where
/// lengths are estimated, by 10 % between curves.
/// @param readings about how many, without those at nodes.
Scan acquired_scan(const ScannedObject& object, Acquisition acquisition, int readings, std::uint64_t seed);

/// Distances of points from the truth, in per cent of its diameter.
struct TruthDistances {
  double mean = 0, rms = 0, max = 0, min = 0;
};
/// As S 3.7.3 and (5.1) measure, over the vertices of what was made, after a rigid motion: that of the nodes
/// onto the true ones, then, onto a surface, the one that makes the squared distances least (iterated closest
/// points with tangent planes).
/// @param made  a network or a surface. @param nodes  where its nodes are: as many rows as the truth has.
TruthDistances distances_from_truth(const Shape& made, const Points& nodes, const Truth& truth);
/// The same where the nodes are the first vertices, as in every network of a scan and the surface on it.
TruthDistances distances_from_truth(const Shape& made, const Truth& truth);

}  // namespace batten::experiments
