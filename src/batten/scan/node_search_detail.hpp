#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/core/progress.hpp"

namespace batten {

/// A stay on a curve that is known up to a translation.
struct CurveStay {
  Eigen::Vector3d place;   ///< along the curve from its start, in sizes
  Eigen::Vector3d normal;  ///< unit
  double distance = 0;     ///< along the curve, in sizes
  int number = -1;         ///< of its node where it is known
  int same_as = -1;        ///< an earlier stay of the curve that is the same point: where a closed one begins
};

/// How far stays of one node may differ.
struct StayNoise {
  double normal = 0;  ///< deviation of a normal, per axis, radians
  double floor = 0;   ///< deviation of a place, per axis, in sizes
  double walk = 0;    ///< variance of a place per size along the curve
  double part = 0;    ///< deviation of lengths, as a part
};

/// Places of curves and nodes that explain stays.
struct StayNumbering {
  std::vector<std::vector<int>> node_of;         ///< per curve and stay; −1 on curves that were not reached
  std::vector<Eigen::Vector3d> shifts;           ///< per curve
  std::vector<Eigen::Vector3d> places, normals;  ///< per node
  double gain = 0;                               ///< log odds against chance, doubled
  bool is_complete = false;                      ///< all curves are placed
};

/// The best numberings of the stays of some curves, best first, all different: a beam search.
/// @param curves per curve its stays, at least one curve with at least one.
std::vector<StayNumbering> search_numberings(const std::vector<std::vector<CurveStay>>& curves,
                                             const StayNoise& noise, const Progress& progress);

/// χ² of a visit to a node. @param along the distance on the curve from where its place is known.
double stay_misfit(const CurveStay& stay, const Eigen::Vector3d& shift, const Eigen::Vector3d& place,
                   const Eigen::Vector3d& normal, double along, const StayNoise& noise);

/// Visits of a greater χ² are to another node: five degrees of freedom, one in a thousand.
constexpr double kMostStayMisfit = 20.5;

}  // namespace batten
