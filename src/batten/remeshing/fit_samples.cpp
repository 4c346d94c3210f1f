#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "batten/remeshing/fit_ring_detail.hpp"
#include "batten/remeshing/fit_samples_detail.hpp"

namespace batten::remeshing {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kSamplesPerReport = 1 << 17;  ///< some 20 ms

}  // namespace

std::vector<std::array<char, 3>> crease_corners(const Points& X, const Triangles& T, double angle) {
  struct Side {
    int low, high, triangle, corner;
    bool operator<(const Side& other) const {
      return std::tie(low, high, triangle) < std::tie(other.low, other.high, other.triangle);
    }
  };
  std::vector<Side> sides;
  sides.reserve(3 * T.rows());
  std::vector<Vector3d> normals(T.rows());
  for (Eigen::Index f = 0; f < T.rows(); ++f) {
    normals[f] = cross(X.row(T(f, 1)) - X.row(T(f, 0)), X.row(T(f, 2)) - X.row(T(f, 0))).normalized();
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(T(f, k), T(f, (k + 1) % 3));
      sides.push_back({low, high, static_cast<int>(f), k});
    }
  }
  std::sort(sides.begin(), sides.end());
  std::vector<std::array<char, 3>> result(T.rows(), {0, 0, 0});
  const double cosine = std::cos(angle);
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    const Side &a = sides[i], &b = sides[i + 1];
    if (a.low == b.low && a.high == b.high && normals[a.triangle].dot(normals[b.triangle]) < cosine)
      result[a.triangle][a.corner] = result[b.triangle][b.corner] = 1;
  }
  return result;
}

void FitSamples::take(ReferenceSamples reference, const HalfedgeMesh& mesh,
                      const HalfedgeMesh::Compact& compact, const std::vector<int>& faces,
                      const Progress& progress) {
  pieces_ = std::move(reference.pieces);
  std::vector<int> first(mesh.face_capacity() + 1, 0);
  for (const int nearest : reference.nearest) ++first[compact.faces[nearest]];
  int total = 0;
  for (const int f : faces) total += std::exchange(first[f], total);
  points_.resize(reference.points.size());
  of_face_.resize(mesh.face_capacity());
  for (std::size_t s = 0; s < points_.size(); ++s) {
    if (s % kSamplesPerReport == 0)
      progress.report("samples", static_cast<double>(s) / static_cast<double>(points_.size()));
    const int f = compact.faces[reference.nearest[s]];
    points_[first[f]] = reference.points[s];
    const Vector3d n = mesh.area_normal(f);
    if (n.dot(pieces_[points_[first[f]].triangle].normal) > kSameSide * n.norm())
      of_face_[f].push_back(first[f]);
    ++first[f];
  }
}

}  // namespace batten::remeshing
