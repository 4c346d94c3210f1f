#pragma once
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "batten/network/curve_network.hpp"

// One side of a sharp curve, and the normals along it.
namespace batten::detail {

/// Samples of a sharp curve along which one side of it is smooth, in the order of the curve.
struct SharpChain {
  std::vector<int> corners;         ///< of the patches on that side
  std::vector<std::size_t> places;  ///< in NetworkCurve::vertices
  bool left = false;
  bool periodic = false;  ///< all around a closed curve; the last sample is the first again
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d> references;  ///< the normal given on the curve
  std::vector<char> is_node;
  std::vector<Eigen::Vector3d> normals;  ///< unit; 0 where they are unknown

  /// The unit tangent of the curve at a sample: of the parabola through it and its neighbours.
  Eigen::Vector3d tangent(std::size_t k) const;
};

/// Joins the last chain of a closed curve with the first where they are one part there.
/// @param part of a corner.
void close_chains(const NetworkCurve& curve, std::vector<SharpChain>& chains,
                  const std::function<int(int)>& part);

/// Gives unknown normals of a chain the angle about the curve, against the reference, that is interpolated
/// from those that are known: one at least.
void interpolate_normals(SharpChain& chain);

}  // namespace batten::detail
