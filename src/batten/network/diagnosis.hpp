#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "batten/network/curve_network.hpp"

namespace batten {

/// What can be wrong with a network.
enum class NetworkDefect {
  DanglingEnd,         ///< an end of a curve that meets nothing
  NearMiss,            ///< an end that stops short of another curve
  TJunction,           ///< an end that lies on another curve without sharing a vertex with it
  Crossing,            ///< two curves that cross without sharing a vertex
  SelfCrossing,        ///< a curve that crosses itself, or a cycle that passes a vertex twice
  Overlap,             ///< two curves that run along each other for a while
  DuplicateCurve,      ///< two curves that run along each other altogether
  FlippedNormals,      ///< normals on the other side than their neighbours'
  TiltedNormal,        ///< a normal far from perpendicular to its curve
  OpenBoundary,        ///< curves tagged as border that do not close
  UntraceablePatches,  ///< the patches cannot be traced (an untagged border among other reasons)
  SeparateParts,       ///< a part of the network that is not connected to the first
};

/// The defect in two or three words: "dangling end".
std::string_view defect_name(NetworkDefect defect);

/// One defect: where, how far, and what to do.
struct NetworkFinding {
  NetworkDefect defect = NetworkDefect::DanglingEnd;
  int curve = -1;        ///< the curve concerned, or −1
  int other_curve = -1;  ///< the second one, or −1
  int vertex = -1;       ///< the vertex of the network nearest to it, or −1
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  /// The gap in the unit of the network (DanglingEnd, NearMiss, TJunction, Crossing, SeparateParts), the
  /// length of an overlap, or the angle off in radians (TiltedNormal); else 0.
  double distance = 0;
  std::string sentence;  ///< all of it in words, with the remedy
};

/// How many findings are of one kind.
int count_findings(const std::vector<NetworkFinding>& findings, NetworkDefect defect);

/// Options of diagnose_network(). All are relative or angles, so that the unit does not matter.
struct DiagnosisOptions {
  /// Curves this near to each other meet, as a fraction of the diameter: twice what a hand-drawn crossing
  /// misses.
  double meeting_distance = 0.003;
  /// An end this near to a curve was meant to meet it, as a fraction of the diameter.
  double near_miss_distance = 0.03;
  /// A normal may be this far from perpendicular to its curve, in radians; scans come within 0.2.
  double max_normal_tilt = 0.35;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Looks for everything that keeps a network from being surfaced, and says it in words. Findings are sorted
/// by kind, then by curve; a sound network gives none. Time grows in proportion to the samples and the
/// findings.
/// @throws InvalidInput as network_topology(), or when an option is out of range.
std::vector<NetworkFinding> diagnose_network(const CurveNetwork& network,
                                             const DiagnosisOptions& options = {});

}  // namespace batten
