// Where the flow of H 6.4 begins: thin plates and Coons patches instead of the straight lines of 6.4.2.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>

#include "batten/core/index.hpp"
#include "batten/core/units.hpp"
#include "batten/linalg/held_unknowns.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/modelling/curvature_flow_detail.hpp"
#include "batten/operators/laplacian.hpp"

namespace batten::detail {

namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Begin = FlowPatch::Begin;

/// Coons patches are given up where plates have less than this share of their bending energy, and kept where
/// these have so many times more.
constexpr double kClearlyLess = 0.75, kMuchMore = 2;
/// Edges that bend by more than this count as sharp.
constexpr double kSharpBend = kPi / 4;
/// Plates are made so many times at most while more and more Coons patches turn out to be better.
constexpr int kMostTrials = 5;

/// The vertices that start_flow() places.
std::vector<char> fresh_vertices(const FlowMesh& mesh) {
  std::vector<char> fresh(at(mesh.positions.rows()), 0);
  for (const Begin kind : {Begin::Plate, Begin::Coons})
    for (Index t = 0; t < mesh.triangles.rows(); ++t)
      if (mesh.patches[at(mesh.patch[at(t)])].begin == kind)
        for (int k = 0; k < 3; ++k) fresh[at(mesh.triangles(t, k))] = kind == Begin::Plate;
  for (size_t v = 0; v < fresh.size(); ++v)
    if (mesh.fixed[v] || mesh.soft[v]) fresh[v] = 0;
  return fresh;
}

/// Minimises over the fresh vertices, the others held: the membrane energy (K), or the bending energy
/// (K diag(d) K).
class Filling {
 public:
  Filling(FlowMesh& mesh, const std::vector<char>& fresh)
      : mesh_(mesh), unknowns_(HeldUnknowns::all_but(fresh)) {
    Eigen::RowVector3d middle = Eigen::RowVector3d::Zero();
    for (const int v : unknowns_.held()) middle += mesh.positions.row(v);
    middle /= static_cast<double>(std::max<Index>(unknowns_.n_held(), 1));
    for (const int v : unknowns_.free()) mesh.positions.row(v) = middle;
  }

  bool is_empty() const { return unknowns_.n_free() == 0; }

  void membrane(const EdgeLengths& lengths) {
    const SparseMatrix K = cotangent_stiffness(mesh_.triangles, lengths, mesh_.positions.rows());
    solve(unknowns_.free_block(K, true), -(K * mesh_.positions), "membrane through the curves");
  }

  void plate(const EdgeLengths& lengths) {
    const Index n = mesh_.positions.rows();
    const SparseMatrix K = cotangent_stiffness(mesh_.triangles, lengths, n);
    const Eigen::VectorXd M = bounded_mass(lumped_mass(mesh_.triangles, lengths, n));
    Eigen::VectorXd d(n);
    for (Index v = 0; v < n; ++v)
      d(v) = mesh_.without_row[at(v)] || mesh_.sharpness[at(v)] > 0 ? 0 : 1 / M(v);
    const std::vector<int> none(at(n), -1);
    solve(squared_stiffness(K, d, unknowns_.free_index(), none).lower,
          -(K.transpose() * (d.asDiagonal() * (K * mesh_.positions))), "thin plate through the curves");
  }

 private:
  void solve(SparseMatrix A, const Points& right, const char* name) {
    const double anchor = 1e-2 * kAnchor * A.diagonal().mean();
    for (Index u = 0; u < A.rows(); ++u) A.coeffRef(u, u) += anchor;
    SparseCholesky solver(name);
    solver.factorize(A);
    unknowns_.add_to_free_rows(solver.solve(unknowns_.free_rows(right)), mesh_.positions);
  }

  FlowMesh& mesh_;
  HeldUnknowns unknowns_;
};

/// Places what is to begin on a plate.
void fill(FlowMesh& mesh) {
  const std::vector<char> fresh = fresh_vertices(mesh);
  Filling filling(mesh, fresh);
  if (filling.is_empty()) return;
  EdgeLengths lengths = mesh.domain;
  const auto measure = [&](Index t) {
    const auto p = [&](int k) { return mesh.positions.row(mesh.triangles(t, k % 3)); };
    for (int k = 0; k < 3; ++k) lengths(t, k) = (p(k + 1) - p(k + 2)).norm();
  };
  const auto patch_of = [&](Index t) -> const FlowPatch& { return mesh.patches[at(mesh.patch[at(t)])]; };
  bool with_membrane = false;
  for (Index t = 0; t < mesh.triangles.rows(); ++t) {
    if (patch_of(t).begin == Begin::Coons) measure(t);
    with_membrane = with_membrane || (patch_of(t).begin == Begin::Plate && !patch_of(t).is_projection);
  }
  if (with_membrane) {
    filling.membrane(lengths);
    for (Index t = 0; t < mesh.triangles.rows(); ++t)
      if (!patch_of(t).is_projection) measure(t);
  }
  filling.plate(lengths);
}

/// The other triangle at side k of a triangle, or −1.
int across(const MeshEdges& edges, int triangle, int k) {
  const size_t edge = at(edges.of_triangle(triangle, k));
  for (int s = edges.offsets[edge]; s < edges.offsets[edge + 1]; ++s)
    if (const int other = edges.sides[at(s)] / 3; other != triangle) return other;
  return -1;
}

/// Side k of a triangle is sharp.
bool is_crease(const FlowMesh& mesh, int triangle, int k) {
  return mesh.sharpness[at(mesh.triangles(triangle, k))] > 0 &&
         mesh.sharpness[at(mesh.triangles(triangle, (k + 1) % 3))] > 0;
}

/// Σ θ² l² / A over the edges of some triangles, with θ the angle between the normals on both sides and A the
/// area of both: the bending energy of a polyhedron, for two ways to place the vertices. Creases are free to
/// bend, and so are edges that bend sharply either way: what lies beyond them does not tell which is better.
std::array<double, 2> bending(const FlowMesh& mesh, const std::array<const Points*, 2>& positions,
                              const std::vector<int>& triangles, const MeshEdges& edges) {
  std::array<double, 2> sum{};
  for (const int t : triangles)
    for (int k = 0; k < 3; ++k) {
      const int from = mesh.triangles(t, k), to = mesh.triangles(t, (k + 1) % 3);
      const int other = across(edges, t, k);
      if (other < 0 || is_crease(mesh, t, k)) continue;
      std::array<double, 2> angle{}, energy{};
      for (size_t way = 0; way < 2; ++way) {
        const Points& X = *positions[way];
        const auto normal = [&](int f) -> Vector3d {
          const Vector3d p = X.row(mesh.triangles(f, 0)), q = X.row(mesh.triangles(f, 1)),
                         r = X.row(mesh.triangles(f, 2));
          return (q - p).cross(r - p);
        };
        const Vector3d one = normal(t), two = normal(other);
        const double area = (one.norm() + two.norm()) / 2;
        angle[way] = std::atan2(one.cross(two).norm(), one.dot(two));
        if (area > 0) energy[way] = angle[way] * angle[way] * (X.row(to) - X.row(from)).squaredNorm() / area;
      }
      if (std::min(angle[0], angle[1]) > kSharpBend) continue;
      const double share = mesh.patch[at(other)] == mesh.patch[at(t)] ? 0.5 : 1;
      for (size_t way = 0; way < 2; ++way) sum[way] += share * energy[way];
    }
  return sum;
}

/// Gives up Coons patches that bulge.
void choose_beginnings(FlowMesh& mesh) {
  const size_t n = mesh.patches.size();
  std::vector<std::vector<int>> triangles_of(n);
  for (Index t = 0; t < mesh.triangles.rows(); ++t)
    triangles_of[at(mesh.patch[at(t)])].push_back(static_cast<int>(t));
  const MeshEdges edges = mesh_edges(mesh.triangles, mesh.positions.rows());
  std::vector<char> open(n);
  for (size_t p = 0; p < n; ++p) open[p] = mesh.patches[p].begin == Begin::Coons;
  std::vector<std::array<double, 2>> energy(n);
  // Plates for all but those that turn out to want none: tubes collapse, and spoil their neighbours.
  bool again = true;
  for (int trial = 0; again && trial < kMostTrials; ++trial) {
    again = false;
    FlowMesh plates = mesh;
    for (size_t p = 0; p < n; ++p)
      if (open[p]) plates.patches[p].begin = Begin::Plate;
    fill(plates);
    for (size_t p = 0; p < n; ++p) {
      if (!open[p]) continue;
      energy[p] = bending(mesh, {&mesh.positions, &plates.positions}, triangles_of[p], edges);
      if (energy[p][1] > kMuchMore * energy[p][0]) {
        open[p] = 0;
        again = true;
      }
    }
  }
  // Neighbours decide together: beside a patch that bulges a plate sways.
  for (size_t p = 0; p < n; ++p) {
    if (!open[p]) continue;
    std::vector<size_t> cluster{p};
    open[p] = 0;
    std::array<double, 2> sum{};
    for (size_t k = 0; k < cluster.size(); ++k) {
      for (size_t way = 0; way < 2; ++way) sum[way] += energy[cluster[k]][way];
      for (const int t : triangles_of[cluster[k]])
        for (int side = 0; side < 3; ++side) {
          const int other = across(edges, t, side);
          if (other < 0 || !open[at(mesh.patch[at(other)])] || is_crease(mesh, t, side)) continue;
          open[at(mesh.patch[at(other)])] = 0;
          cluster.push_back(at(mesh.patch[at(other)]));
        }
    }
    if (sum[1] < kClearlyLess * sum[0])
      for (const size_t patch : cluster) mesh.patches[patch].begin = Begin::Plate;
  }
}

}  // namespace

void start_flow(FlowMesh& mesh) {
  if (std::any_of(mesh.patches.begin(), mesh.patches.end(),
                  [](const FlowPatch& patch) { return patch.begin == Begin::Coons; }))
    choose_beginnings(mesh);
  fill(mesh);
}

}  // namespace batten::detail
