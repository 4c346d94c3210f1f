#pragma once
#include <Eigen/Core>

namespace batten {

// Signs of determinants, exact for every finite input whose products neither overflow nor underflow: a
// floating filter, then expansions [shewchuk1997].

/// +1 when a, b, c turn counter-clockwise, −1 clockwise, 0 when they lie on a line.
int orient2d(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c);

/// The sign of (b − a) × (c − a) · (d − a): +1 when d lies on the side to which the counter-clockwise normal
/// of the triangle a b c points, 0 when all four lie in a plane.
int orient3d(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
             const Eigen::Vector3d& d);

/// True when the closed triangle a b c and the closed segment p q share a point. Exact.
/// @pre the triangle has area.
bool segment_meets_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& a,
                            const Eigen::Vector3d& b, const Eigen::Vector3d& c);

/// True when the three points lie on a line (exactly): the triangle has no area.
bool are_collinear(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

}  // namespace batten
