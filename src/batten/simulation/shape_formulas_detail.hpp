#pragma once
#include <Eigen/Core>

#include "batten/simulation/shapes.hpp"

// The formulas of the shapes, shared by their functions, sections and meshes. Private to the room.
namespace batten::detail {

inline const Eigen::Vector3d kEllipsoidAxes(1.5, 1, 0.7);
inline constexpr double kTorusRadius = 4;
inline constexpr double kTubeRadius = 2;
inline constexpr double kConeSlope = 0.25;  ///< radius kConeSlope · (kConeTip − z)
inline constexpr double kConeTip = 2;
inline constexpr double kConeBottom = 0.1;
inline constexpr double kConeTop = 1.7;

double cone_radius(double z);

/// Height and its derivatives of the height fields.
struct ShapeHeight {
  double z, dx, dy;
};
using HeightField = ShapeHeight (*)(double x, double y);

ShapeHeight saddle_height(double x, double y);
ShapeHeight waves_height(double x, double y);
ShapeHeight dish_height(double x, double y);
/// @pre the shape is one of these three.
HeightField height_field(AnalyticShape shape);

/// As shape_function() of the bumpy cube.
double bumpy_cube(const Eigen::Vector3d& x, Eigen::Vector3d& gradient);
/// The point of the bumpy cube in a unit direction; it is star-shaped about the origin.
Eigen::Vector3d on_bumpy_cube(const Eigen::Vector3d& direction);

}  // namespace batten::detail
