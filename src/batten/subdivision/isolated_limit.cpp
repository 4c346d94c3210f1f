#include <algorithm>
#include <cmath>

#include "batten/subdivision/bspline_surface.hpp"
#include "batten/subdivision/isolated_limit_detail.hpp"

namespace batten::detail {

using Row = Eigen::RowVector3d;
using Weights = Eigen::RowVector4d;

Weights polar_weights(const PolarArguments& t) {
  Eigen::Matrix4d points = Eigen::Matrix4d::Identity();
  for (int step = 0; step < 3; ++step)
    for (int i = 0; i + step < 3; ++i) {
      const int begin = i - 2 + step, width = 3 - step;
      const double w = (t[at(step)] - begin) / width;
      points.row(i) = (1 - w) * points.row(i) + w * points.row(i + 1);
    }
  return points.row(0);
}

Row polar_form(const LimitCell& cell, const PolarArguments& u, const PolarArguments& v) {
  const double scale = std::ldexp(1.0, cell.depth);
  const auto local = [scale](const PolarArguments& t, int offset) {
    return PolarArguments{t[0] * scale - offset, t[1] * scale - offset, t[2] * scale - offset};
  };
  const Weights wu = polar_weights(local(u, cell.u)), wv = polar_weights(local(v, cell.v));
  Row sum = Row::Zero();
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) sum += wu(i) * wv(j) * cell.control_points.row(4 * j + i);
  return sum;
}

FaceCells::FaceCells(const LimitCells& cells, Eigen::Index n_faces) : of_face_(static_cast<size_t>(n_faces)) {
  for (const LimitCell& cell : cells.cells) of_face_[at(cell.face)].push_back(&cell);
}

const LimitCell* FaceCells::covering(int face, double u, double v, int depth) const {
  for (const LimitCell* cell : of_face_[at(face)]) {
    if (cell->depth > depth) continue;
    const double scale = std::ldexp(1.0, cell->depth), x = u * scale - cell->u, y = v * scale - cell->v;
    if (x >= 0 && x <= 1 && y >= 0 && y <= 1) return cell;
  }
  return nullptr;
}

std::array<bool, 4> FaceCells::irregular_corners(int face) const {
  std::array<bool, 4> irregular{true, true, true, true};
  for (const LimitCell* cell : of_face_[at(face)]) {
    if (cell->depth > kLeastIsolation) continue;
    const int last = (1 << cell->depth) - 1;
    const bool left = cell->u == 0, right = cell->u == last, low = cell->v == 0, high = cell->v == last;
    if (left && low) irregular[0] = false;
    if (right && low) irregular[1] = false;
    if (right && high) irregular[2] = false;
    if (left && high) irregular[3] = false;
  }
  return irregular;
}

IsolatedLimit::IsolatedLimit(const ControlCage& cage, const CageTopology& topology, const LimitCells& limit,
                             const std::vector<double>& sharpness, int isolation)
    : cage_(cage),
      topology_(topology),
      limit_(limit),
      sharpness_(sharpness),
      isolation_(isolation),
      cells_(limit, cage.mesh.n_faces()) {
  const int n_faces = static_cast<int>(cage.mesh.n_faces());
  irregular_.resize(at(n_faces));
  for (int f = 0; f < n_faces; ++f) irregular_[at(f)] = cells_.irregular_corners(f);
  find_tangent_planes();
}

double IsolatedLimit::cell_side() const {
  return std::ldexp(1.0, -isolation_);
}

void IsolatedLimit::find_tangent_planes() {
  const size_t n = static_cast<size_t>(cage_.mesh.positions.rows());
  std::vector<int> n_sharp(n, 0);
  for (int e = 0; e < static_cast<int>(topology_.edges.size()); ++e)
    if (is_sharp(e))
      for (const int v : topology_.edges[at(e)]) ++n_sharp[at(v)];
  has_plane_.assign(n, 0);
  for (size_t v = 0; v < n; ++v) has_plane_[v] = topology_.is_border[v] == 0 && n_sharp[v] < 2;
  for (const SharpVertex& sharp : cage_.sharp_vertices)
    if (sharp.sharpness > 0) has_plane_[at(sharp.vertex)] = 0;
}

Row IsolatedLimit::exact(int face, double u, double v) const {
  const LimitCell* cell = cells_.covering(face, u, v, isolation_ + kSampledHalvings);
  return polar_form(*cell, {u, u, u}, {v, v, v});
}

bool IsolatedLimit::side_polar(int face, int k, const PolarArguments& t, double inside, Row& point) const {
  const auto middle = on_patch_side(k, inside);
  const LimitCell* cell = cells_.covering(face, middle[0], middle[1], isolation_);
  if (cell == nullptr) return false;
  PolarArguments u, v;
  for (size_t i = 0; i < 3; ++i) {
    const auto uv = on_patch_side(k, t[i]);
    u[i] = uv[0];
    v[i] = uv[1];
  }
  point = polar_form(*cell, u, v);
  return true;
}

IsolatedLimit::SideOf IsolatedLimit::side_of(int edge, int which) const {
  const int c = topology_.sides[at(edge)][at(which)];
  if (c < 0) return {};
  const int face = topology_.face_of_corner[at(c)];
  const int k = c - cage_.mesh.offsets[at(face)];
  return {face, k, cage_.mesh.corners[at(c)] == topology_.edges[at(edge)][0]};
}
bool IsolatedLimit::irregular_end(const SideOf& side, int end) const {
  const int k = (end == 0) == side.forward ? side.side : (side.side + 1) & 3;
  return irregular_[at(side.face)][at(k)];
}

std::array<double, 2> IsolatedLimit::in_corner(int k, double x, double y) const {
  const double s = x * cell_side(), t = y * cell_side();
  return {k == 1 || k == 2 ? 1 - s : s, k >= 2 ? 1 - t : t};
}

}  // namespace batten::detail
