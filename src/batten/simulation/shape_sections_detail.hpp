#pragma once
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/simulation/shapes.hpp"
#include "batten/simulation/traced_curve.hpp"

// Private to the room.
namespace batten::detail {

/// A curve of a shape that is to be traced.
struct ShapeSection {
  std::string name;
  bool boundary;
  ImplicitFunction cut;     ///< the plane or cylinder that it lies in
  Eigen::Vector3d start;    ///< near the curve; on it where the curve is open
  Eigen::Vector3d towards;  ///< the direction in which to leave the start
  bool closed = true;
  Eigen::Vector3d end{0, 0, 0};  ///< of open curves alone
};

/// The network of a shape: its borders, with the surface on their left, and plane sections.
std::vector<ShapeSection> sections_of(AnalyticShape shape);

}  // namespace batten::detail
