#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

double bounding_box_diagonal(const Points& points) {
  if (points.rows() == 0) return 0;
  return (points.colwise().maxCoeff() - points.colwise().minCoeff()).norm();
}

}  // namespace batten
