#include "batten/remeshing/size_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <queue>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

namespace batten {

namespace {

using Eigen::Vector3d;

double face_area(const HalfedgeMesh& mesh, int f) {
  return 0.5 * mesh.area_normal(f).norm();
}

/// Unit normals per corner 3f + k: the mean over the faces around the corner's vertex that are reached
/// without crossing a marked edge.
std::vector<Vector3d> corner_normals(const HalfedgeMesh& mesh) {
  std::vector<Vector3d> normals(mesh.halfedge_capacity(), Vector3d::Zero());
  std::vector<int> ring;
  for (int v = 0; v < mesh.vertex_capacity(); ++v) {
    if (!mesh.has_vertex(v)) continue;
    ring.clear();
    mesh.for_each_outgoing(v, [&](int h) { ring.push_back(h); });
    // A sector begins at a marked edge; rings without one are one sector.
    std::size_t first = 0;
    while (first < ring.size() && !mesh.is_marked(ring[first])) ++first;
    if (first < ring.size()) std::rotate(ring.begin(), ring.begin() + static_cast<long>(first), ring.end());
    for (std::size_t begin = 0; begin < ring.size();) {
      std::size_t end = begin + 1;
      while (end < ring.size() && !mesh.is_marked(ring[end])) ++end;
      Vector3d sum = Vector3d::Zero();
      for (std::size_t i = begin; i < end; ++i) {
        const int h = ring[i];
        const Vector3d a = mesh.position(mesh.to(h)) - mesh.position(v),
                       b = mesh.position(mesh.tip(h)) - mesh.position(v);
        const Vector3d cross = a.cross(b);
        const double sine = cross.norm();
        if (sine > 0) sum += std::atan2(sine, a.dot(b)) / sine * cross;
      }
      if (sum.norm() > 0) sum.normalize();
      for (std::size_t i = begin; i < end; ++i) normals[ring[i]] = sum;
      begin = end;
    }
  }
  return normals;
}

/// A third of the area of the faces around each vertex.
Eigen::VectorXd vertex_areas(const HalfedgeMesh& mesh) {
  Eigen::VectorXd areas = Eigen::VectorXd::Zero(mesh.vertex_capacity());
  for (int f = 0; f < mesh.face_capacity(); ++f) {
    if (!mesh.has_face(f)) continue;
    const double third = face_area(mesh, f) / 3;
    for (int k = 0; k < 3; ++k) areas[mesh.from(3 * f + k)] += third;
  }
  return areas;
}

/// ∫ 2 / (√3 h²) dA with 1/h² interpolated between the vertices.
double count_for_sizes(const Eigen::VectorXd& areas, const Eigen::VectorXd& sizes) {
  return 2 / std::sqrt(3.0) * (areas.array() / sizes.array().square()).sum();
}

}  // namespace

Eigen::VectorXd curvature_magnitude(const HalfedgeMesh& mesh, const FeatureChains& chains, int rings) {
  const std::vector<Vector3d> normals = corner_normals(mesh);
  const int n = mesh.vertex_capacity(), m = mesh.face_capacity();
  std::vector<double> area(m, 0.0), squared(m, 0.0);
  for (int f = 0; f < m; ++f) {
    if (!mesh.has_face(f)) continue;
    area[f] = face_area(mesh, f);
    if (!(area[f] > 0)) continue;
    // ∫ ‖∇n‖² of the normals interpolated over the face, by cotangents.
    double energy = 0;
    for (int k = 0; k < 3; ++k) {
      const int h = 3 * f + k;
      const Vector3d& x = mesh.position(mesh.tip(h));
      const Vector3d a = mesh.position(mesh.from(h)) - x, b = mesh.position(mesh.to(h)) - x;
      const double cotangent = std::clamp(a.dot(b) / (2 * area[f]), -5.0, 5.0);
      energy += 0.5 * cotangent * (normals[h] - normals[HalfedgeMesh::next(h)]).squaredNorm();
    }
    squared[f] = std::max(0.0, energy / area[f]);
  }
  Eigen::VectorXd result = Eigen::VectorXd::Zero(n), weight(n);
  for (int ring = 0; ring < std::max(rings, 1); ++ring) {
    result.setZero();
    weight.setZero();
    for (int f = 0; f < m; ++f) {
      if (!mesh.has_face(f)) continue;
      for (int k = 0; k < 3; ++k) {
        result[mesh.from(3 * f + k)] += area[f] * squared[f];
        weight[mesh.from(3 * f + k)] += area[f];
      }
    }
    for (int v = 0; v < n; ++v)
      if (weight[v] > 0) result[v] /= weight[v];
    for (int f = 0; f < m; ++f)
      if (mesh.has_face(f))
        squared[f] =
            (result[mesh.from(3 * f)] + result[mesh.from(3 * f + 1)] + result[mesh.from(3 * f + 2)]) / 3;
  }
  result = result.cwiseSqrt();
  for (const FeatureChain& chain : chains.chains)
    for (std::size_t i = 1; i + 1 < chain.vertices.size(); ++i) {
      const Vector3d a = chain.points[i] - chain.points[i - 1], b = chain.points[i + 1] - chain.points[i];
      const double length = chain.lengths[i + 1] - chain.lengths[i - 1];
      if (!(length > 0)) continue;
      double& value = result[chain.vertices[i]];
      value = std::max(value, std::atan2(a.cross(b).norm(), a.dot(b)) / (0.5 * length));
    }
  return result;
}

double vertices_for_sizes(const HalfedgeMesh& mesh, const Eigen::VectorXd& sizes) {
  return count_for_sizes(vertex_areas(mesh), sizes);
}

void limit_gradation(const HalfedgeMesh& mesh, double gradation, Eigen::VectorXd& sizes) {
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (int v = 0; v < mesh.vertex_capacity(); ++v)
    if (mesh.has_vertex(v)) queue.emplace(sizes[v], v);
  while (!queue.empty()) {
    const auto [size, v] = queue.top();
    queue.pop();
    if (size > sizes[v]) continue;
    mesh.for_each_neighbour(v, [&, size = size, v = v](int u) {
      const double limit = size + gradation * (mesh.position(u) - mesh.position(v)).norm();
      if (limit < sizes[u]) {
        sizes[u] = limit;
        queue.emplace(limit, u);
      }
    });
  }
}

Eigen::VectorXd adaptive_sizes(const HalfedgeMesh& mesh, const Eigen::VectorXd& curvature, double mean_length,
                               double adaptivity, double gradation) {
  const Eigen::Index n = curvature.size();
  Eigen::VectorXd even = Eigen::VectorXd::Constant(n, mean_length);
  const Eigen::VectorXd areas = vertex_areas(mesh);
  const double wanted = count_for_sizes(areas, even);
  if (adaptivity == 0 || n == 0 || !(wanted > 0)) return even;
  const double range = std::pow(4.0, adaptivity);
  Eigen::VectorXd shape(n);  // κ^(−adaptivity/2), without unit
  for (Eigen::Index v = 0; v < n; ++v)
    shape[v] = std::pow(std::max(curvature[v] * mean_length, 1e-9), -adaptivity / 2);
  const auto sizes_for = [&](double factor) -> Eigen::VectorXd {
    return mean_length * (factor * shape).cwiseMax(1 / range).cwiseMin(range);
  };
  // The count falls with the factor: bisect its logarithm.
  double low = -12, high = 12;
  for (int step = 0; step < 40; ++step) {
    const double middle = 0.5 * (low + high);
    (count_for_sizes(areas, sizes_for(std::exp(middle))) > wanted ? low : high) = middle;
  }
  Eigen::VectorXd sizes = sizes_for(std::exp(0.5 * (low + high)));
  limit_gradation(mesh, gradation, sizes);
  return sizes * std::sqrt(count_for_sizes(areas, sizes) / wanted);
}

}  // namespace batten
