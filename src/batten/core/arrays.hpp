#pragma once
#include <Eigen/Core>

namespace batten {

/// Points or vectors, one per row: n × 3, row-major, so that the same memory goes to files and to other
/// languages.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
/// Triangles, one per row: m × 3 vertex indices, counter-clockwise seen from outside.
using Triangles = Eigen::Matrix<int, Eigen::Dynamic, 3, Eigen::RowMajor>;

}  // namespace batten
