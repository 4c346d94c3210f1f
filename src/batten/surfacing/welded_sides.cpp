#include "batten/core/index.hpp"
#include "batten/surfacing/welded_sides_detail.hpp"

namespace batten::detail {

using Eigen::Index;
using Eigen::RowVector3d;

WeldedSides::WeldedSides(const SharpSplit& split, Index n_given)
    : n_split_(static_cast<int>(split.place.size())),
      n_copies_(n_split_ - static_cast<int>(n_given)),
      n_given_(static_cast<int>(n_given)),
      place_(split.place),
      sides_(at(n_given_)) {
  for (int v = n_given_; v < n_split_; ++v) sides_[at(place_[at(v)])].push_back(v);
}

RowVector3d WeldedSides::normal(int row, const Points& normals) const {
  if (row >= n_given_) return normals.row(row + n_copies_);
  RowVector3d sum = normals.row(row);
  if (sides_[at(row)].empty()) return sum;
  for (const int v : sides_[at(row)]) sum += normals.row(v);
  return sum.norm() > 1e-6 ? RowVector3d(sum.normalized()) : RowVector3d(normals.row(row));
}

void WeldedSides::weld(SurfaceResult& result) const {
  if (!any()) return;
  const TriangleMesh split = std::move(result.mesh);
  const auto n = static_cast<Index>(split.n_vertices()) - n_copies_;
  result.mesh = TriangleMesh();
  result.mesh.positions.resize(n, 3);
  result.mesh.normals.resize(n, 3);
  std::vector<char> on_network(at(static_cast<int>(n)), 0);
  for (Index v = 0; v < split.positions.rows(); ++v) {
    const int r = row(static_cast<int>(v));
    result.mesh.positions.row(r) = split.positions.row(v);
    if (result.on_network[at(v)]) on_network[at(r)] = 1;
  }
  for (Index r = 0; r < n; ++r) result.mesh.normals.row(r) = normal(static_cast<int>(r), split.normals);
  result.on_network = std::move(on_network);
  result.mesh.triangles = split.triangles.unaryExpr([&](int v) { return row(v); });
}

}  // namespace batten::detail
