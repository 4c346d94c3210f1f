#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

#include <Eigen/Dense>

#include "batten/core/index.hpp"
#include "batten/surfacing/surface_move_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;

std::vector<int> united(const std::vector<int>& a, const std::vector<int>& b) {
  std::vector<int> both;
  std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  return both;
}

std::vector<int> numbers_to(Index n) {
  std::vector<int> numbers(at(n));
  std::iota(numbers.begin(), numbers.end(), 0);
  return numbers;
}

}  // namespace

void append(std::vector<VertexRange>& ranges, Index vertex) {
  if (!ranges.empty() && ranges.back().end == vertex)
    ++ranges.back().end;
  else
    ranges.push_back({vertex, vertex + 1});
}

SurfaceMover::SurfaceMover(FairingSystems& systems, const Triangles& triangles, bool metric_from_layout,
                           SurfaceMethod method, const Points& positions, const Points& normals,
                           const ScaledNetwork& network)
    : systems_(systems),
      triangles_(triangles),
      metric_from_layout_(metric_from_layout),
      method_(method),
      given_positions_(network.positions),
      given_normals_(network.normals),
      built_positions_(positions),
      built_normals_(normals),
      built_target_(curvature_target(systems, triangles, metric_from_layout, positions, normals)),
      positions_(positions),
      normals_(normals) {
  find_parts();
  judge(numbers_to(static_cast<Index>(parts_.size())));
}

void SurfaceMover::find_parts() {
  std::vector<int> part_of(at(positions_.rows()), -1);
  if (const PatchSystems* const patches = systems_.patches()) {
    parts_.resize(at(patches->n_patches()));
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      parts_[p].vertices = patches->vertices(static_cast<int>(p));
      parts_[p].rim = patches->rim(static_cast<int>(p));
      for (const int v : parts_[p].vertices) part_of[at(v)] = static_cast<int>(p);
    }
  } else {
    parts_.resize(1);
    parts_[0].rim = numbers_to(given_positions_.rows());
    for (Index v = given_positions_.rows(); v < positions_.rows(); ++v)
      parts_[0].vertices.push_back(static_cast<int>(v));
    part_of.assign(part_of.size(), 0);
  }
  for (Index f = 0; f < triangles_.rows(); ++f) {
    int part = -1;
    for (int k = 0; k < 3; ++k) part = std::max(part, part_of[at(triangles_(f, k))]);
    (part < 0 ? loose_triangles_ : parts_[at(part)].triangles).push_back(static_cast<int>(f));
  }
}

MatrixXd SurfaceMover::displacement_of(const Points& network_positions, const Points& network_normals,
                                       bool positions_only) const {
  const Index n_network = given_positions_.rows();
  const bool turned = !positions_only && network_normals != given_normals_;
  MatrixXd displacement = MatrixXd::Zero(positions_.rows(), turned ? 6 : 3);
  displacement.topLeftCorner(n_network, 3) = network_positions - given_positions_;
  if (turned) displacement.topRightCorner(n_network, 3) = network_normals - given_normals_;
  return displacement;
}

std::vector<int> SurfaceMover::parts_to_solve(const MatrixXd& displacement, SurfaceReach reach) const {
  const bool is_local = method_ == SurfaceMethod::Curvature || method_ == SurfaceMethod::Biharmonic;
  if (reach == SurfaceReach::All || !is_local) return numbers_to(static_cast<Index>(parts_.size()));
  std::vector<char> touched(at(given_positions_.rows()), 0);
  for (std::size_t v = 0; v < touched.size(); ++v)
    touched[v] = (displacement.row(static_cast<Index>(v)).array() != 0).any();
  std::vector<int> parts;
  for (std::size_t p = 0; p < parts_.size(); ++p)
    if (std::any_of(parts_[p].rim.begin(), parts_[p].rim.end(), [&](int v) { return touched[at(v)]; }))
      parts.push_back(static_cast<int>(p));
  return parts;
}

void SurfaceMover::spread(const std::vector<int>& parts, MatrixXd& displacement) {
  const int order = method_ == SurfaceMethod::Harmonic ? 1 : method_ == SurfaceMethod::Triharmonic ? 3 : 2;
  if (PatchSystems* const patches = systems_.patches(); patches != nullptr && order == 2)
    patches->displace(parts, nullptr, displacement);
  else
    displacement = systems_.polyharmonic(order, displacement);
}

MatrixXd SurfaceMover::fitted(const std::vector<int>& parts, const std::vector<int>& vertices,
                              const Points& normals, const MatrixXd& displacement) {
  // Rows of the fit: the vertices of the parts and of their rims.
  std::vector<int> rows = vertices;
  for (const int p : parts) rows.insert(rows.end(), parts_[at(p)].rim.begin(), parts_[at(p)].rim.end());
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  Points base = built_positions_;
  for (const int v : vertices) base.row(v) += displacement.row(v).head<3>();
  Triangles around;
  if (metric_from_layout_) {
    std::vector<char> is_row(at(base.rows()), 0);
    for (const int v : rows) is_row[at(v)] = 1;
    std::vector<int> chosen;
    for (Index f = 0; f < triangles_.rows(); ++f)
      if (is_row[at(triangles_(f, 0))] || is_row[at(triangles_(f, 1))] || is_row[at(triangles_(f, 2))])
        chosen.push_back(static_cast<int>(f));
    around = triangles_(chosen, Eigen::all);
  }
  Points target(base.rows(), 3);
  curvature_target(systems_, around, metric_from_layout_, base, normals, rows, target);
  MatrixXd change = MatrixXd::Zero(base.rows(), 3);
  for (const int v : rows) change.row(v) = target.row(v) - built_target_.row(v);
  MatrixXd result = displacement.leftCols(3);
  if (method_ == SurfaceMethod::BiharmonicNormals)
    return systems_.biharmonic_with_curvature(systems_.inverse_mass().asDiagonal() * change, result);
  if (PatchSystems* const patches = systems_.patches()) {
    patches->displace(parts, &change, result);
    return result;
  }
  return systems_.fit_laplacian(change, result);
}

Points SurfaceMover::turned_normals(const std::vector<int>& vertices, const MatrixXd& displacement) const {
  Points normals = built_normals_;
  if (displacement.cols() < 6) return normals;
  std::vector<int> turned;
  for (const int v : vertices)
    if ((displacement.row(v).tail<3>().array() != 0).any()) {
      normals.row(v) += displacement.row(v).tail<3>();
      turned.push_back(v);
    }
  normalize_propagated(normals, systems_.stiffness(), turned);
  return normals;
}

MovedVertices SurfaceMover::move(const Points& network_positions, const Points& network_normals,
                                 const SurfaceMoveOptions& options) {
  MatrixXd displacement = displacement_of(network_positions, network_normals, options.positions_only);
  const std::vector<int> parts = parts_to_solve(displacement, options.reach);
  std::vector<int> vertices = numbers_to(given_positions_.rows());  // of the network and the parts
  for (const int p : parts)
    vertices.insert(vertices.end(), parts_[at(p)].vertices.begin(), parts_[at(p)].vertices.end());
  std::sort(vertices.begin(), vertices.end());
  if (!parts.empty()) spread(parts, displacement);
  Points normals;
  if (!options.positions_only) {
    normals = turned_normals(vertices, displacement);
    const bool has_fit = method_ == SurfaceMethod::Curvature || method_ == SurfaceMethod::BiharmonicNormals;
    if (has_fit && !parts.empty()) displacement = fitted(parts, vertices, normals, displacement);
  }
  // Nothing can fail from here on.
  MovedVertices result;
  result.parts_solved = static_cast<int>(parts.size());
  result.vertices = std::move(vertices);
  const std::vector<int> again =
      options.positions_only ? united(parts, moved_) : united(parts, united(moved_, turned_));
  std::vector<int> returning;  // vertices of parts that are no longer touched
  for (const int p : again)
    if (!std::binary_search(parts.begin(), parts.end(), p))
      returning.insert(returning.end(), parts_[at(p)].vertices.begin(), parts_[at(p)].vertices.end());
  for (const int v : returning) positions_.row(v) = built_positions_.row(v);
  for (const int v : result.vertices)
    positions_.row(v) = built_positions_.row(v) + displacement.row(v).head<3>();
  moved_ = parts;
  result.vertices.insert(result.vertices.end(), returning.begin(), returning.end());
  std::sort(result.vertices.begin(), result.vertices.end());
  if (!options.positions_only) {
    normals_ = std::move(normals);
    turned_ = parts;
    judge(again);
  }
  return result;
}

void SurfaceMover::judge(const std::vector<int>& parts) {
  for (const int p : parts)
    parts_[at(p)].soundness = soundness_of(positions_, normals_, triangles_, parts_[at(p)].triangles);
  loose_soundness_ = soundness_of(positions_, normals_, triangles_, loose_triangles_);
}

Soundness SurfaceMover::soundness() const {
  Soundness sum = loose_soundness_;
  for (const Part& part : parts_) {
    sum.folded += part.soundness.folded;
    sum.degenerate += part.soundness.degenerate;
  }
  return sum;
}

}  // namespace batten::detail
