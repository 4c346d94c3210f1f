#pragma once
#include <optional>
#include <string>
#include <vector>

#include "batten/network/curve_network.hpp"
#include "batten/strokes/snapping.hpp"

namespace batten {

/// Options of mended_network().
struct NetworkMendingOptions {
  /// Curves this near meet, as a fraction of the diameter; 0 tries several from 0.01 to 0.5 % and takes the
  /// least with which patches are found, fewest pieces are left out and fewest crossings missed.
  double weld_tolerance = 0;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// A network with normals whose curves meet where they touch.
struct MendedNetwork {
  CurveNetwork network;
  bool changed = false;       ///< false: nothing was wrong, `network` is what came
  WeldReport weld;            ///< vertices at one place, and all that was welded
  int n_doubled = 0;          ///< pieces left out because another has the same vertices
  int n_sharp = 0;            ///< of these, pieces whose two normals make them sharp (more than 20° apart)
  int n_left_out = 0;         ///< pieces that end in nothing, or are the only way between two parts
  double weld_tolerance = 0;  ///< the one used, a fraction of the diameter
  std::vector<std::string> warnings;  ///< all of that in words
};

/// Mends networks with normals as other programs export them: vertices at the same place become one; of
/// pieces drawn twice one is left, sharp where the two had different normals; curves that touch or cross
/// without a vertex in common are welded; what ends in nothing is left out. Normals are kept, those of merged
/// vertices are averaged. A network in which every curve ends at a node and none touches another elsewhere
/// comes back as it is, bit for bit.
/// @throws InvalidInput without normals, for options out of range, or as network_topology().
MendedNetwork mended_network(const CurveNetwork& network, const NetworkMendingOptions& options = {});

}  // namespace batten
