#pragma once
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/scan/scan.hpp"

namespace batten {

/// A stay of the device that was taken for a visit to a node.
struct NodeVisit {
  int curve = 0, reading = 0;  ///< 0-based; the first reading of the stay
  double distance = 0;         ///< along the curve, as in the scan
  double normal_angle = 0;     ///< between its normal and that of the node, radians
  double misfit = 0;           ///< from the place of the node, in parts of the size
  /// By how much −2 log likelihood would grow if the visit were one to the next best node, or to none.
  double margin = 0;
};

/// A node with its evidence.
struct InferredNode {
  int number = 0;
  std::vector<NodeVisit> visits;
  bool is_sure = false;
  std::string doubt;  ///< in words, where it is not
};

/// Numbers for the nodes of a scan.
struct NodeInference {
  Scan scan;                        ///< the one given, with numbers from 0 in the order of the visits
  std::vector<InferredNode> nodes;  ///< by number
  std::vector<std::string> doubts;  ///< what a user should look at; empty: all is sure
  double margin = 0;                ///< by which −2 log likelihood of the next best numbering is worse
  int n_stays = 0;

  bool is_sure() const { return doubts.empty(); }
};

/// Finds which stays of a scan lie at the same node: the nodes without numbers of S 6.2.
///
/// Stays are the marked nodes that have no number (kNoNodeNumber); on curves without marks the places where
/// at least two readings share a distance. Numbers that are given are kept and held for right. As
/// orientations are those of one world, each curve is known up to a translation; a stay of one curve and a
/// node of another with the same normal give a hypothesis of it, which every further stay confirms or not, by
/// its place and normal. Curves are added one by one, and the best hypotheses are kept (beam search); the
/// closure of the whole decides. A numbering is sure when the next best is clearly worse (odds of twenty to
/// one), every visit is far from every other node, and no stay within a curve is alone.
/// Some seconds for fifty curves and five hundred stays. Deterministic.
/// @throws InvalidInput where a scan has no stays, or as check_scan() without numbers; Cancelled.
NodeInference infer_nodes(const Scan& scan, const Progress& progress = {});

}  // namespace batten
