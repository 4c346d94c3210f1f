#include "batten/mesh/handles.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/text.hpp"

namespace batten {

std::vector<int> Handles::vertices() const {
  std::vector<int> all = fixed;
  for (const HandleMotion& motion : moved)
    all.insert(all.end(), motion.vertices.begin(), motion.vertices.end());
  return all;
}

Points Handles::targets(const Points& positions, double share) const {
  Points result(static_cast<Eigen::Index>(vertices().size()), 3);
  Eigen::Index row = 0;
  for (const int v : fixed) result.row(row++) = positions.row(v);
  for (const HandleMotion& motion : moved) {
    const Eigen::Matrix3d R = Eigen::AngleAxisd(share * motion.angle, motion.axis).toRotationMatrix();
    for (std::size_t i = 0; i < motion.vertices.size(); ++i) {
      const Eigen::Vector3d p = positions.row(motion.vertices[i]);
      Eigen::Vector3d target = R * (p - motion.about) + motion.about + share * motion.translation;
      if (motion.targets.rows() > 0)
        target = (1 - share) * p + share * Eigen::Vector3d(motion.targets.row(static_cast<Eigen::Index>(i)));
      result.row(row++) = target;
    }
  }
  return result;
}

double Handles::largest_angle() const {
  double angle = 0;
  for (const HandleMotion& motion : moved) angle = std::max(angle, std::abs(motion.angle));
  return angle;
}

std::optional<std::string> Handles::problem(Eigen::Index n_vertices) const {
  std::vector<char> is_named(static_cast<std::size_t>(n_vertices), 0);
  for (const int v : vertices()) {
    if (v < 0 || v >= n_vertices)
      return concat("handles name vertex ", v, "; there are 0 to ", n_vertices - 1);
    if (std::exchange(is_named[static_cast<std::size_t>(v)], 1) != 0)
      return concat("handles name vertex ", v, " twice");
  }
  for (std::size_t i = 0; i < moved.size(); ++i) {
    const HandleMotion& motion = moved[i];
    if (motion.targets.rows() > 0 &&
        motion.targets.rows() != static_cast<Eigen::Index>(motion.vertices.size()))
      return concat("handle ", i, " has ", motion.targets.rows(), " targets for ", motion.vertices.size(),
                    " vertices");
    if (!(std::abs(motion.axis.norm() - 1) < 1e-6))
      return concat("handle ", i, " turns about an axis of length ", motion.axis.norm(), ", which must be 1");
    if (!motion.targets.allFinite() || !motion.translation.allFinite() || !motion.about.allFinite() ||
        !std::isfinite(motion.angle))
      return concat("handle ", i, " has a number that is not finite");
  }
  return std::nullopt;
}

}  // namespace batten
