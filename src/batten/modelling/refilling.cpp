#include <algorithm>
#include <array>
#include <cmath>

#include "batten/core/index.hpp"
#include "batten/linalg/held_unknowns.hpp"
#include "batten/linalg/sparse_cholesky.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/modelling/curvature_flow_detail.hpp"
#include "batten/modelling/refilling_detail.hpp"
#include "batten/operators/laplacian.hpp"

namespace batten::detail {

namespace {

using Eigen::Index;

/// Steps towards the least area; after so many a patch moves no more that anyone would see.
constexpr int kStepsOfMembrane = 8;

/// The faces to be filled and the triangles around them, with vertices of their own.
struct Region {
  std::vector<int> vertices;  // of the mesh, per vertex here
  Triangles triangles;        // those to be filled first
  Index n_filled = 0;
  std::vector<char> is_free;    // per vertex: inside a face that is filled
  std::vector<char> is_smooth;  // per vertex: its curvature counts
  Points positions;
};

Region region_of(const TriangleMesh& mesh, const std::vector<int>& face_of_triangle,
                 const std::vector<int>& faces, const std::vector<char>& on_crease) {
  const Index n = mesh.positions.rows(), m = mesh.triangles.rows();
  constexpr int kNone = -1, kSeveral = -2;
  std::vector<char> is_filled_face;
  for (const int face : faces) {
    if (at(face) >= is_filled_face.size()) is_filled_face.resize(at(face) + 1, 0);
    is_filled_face[at(face)] = 1;
  }
  const auto is_filled = [&](Index t) {
    const int face = face_of_triangle[at(t)];
    return at(face) < is_filled_face.size() && is_filled_face[at(face)] != 0;
  };
  std::vector<int> face_of_vertex(at(n), kNone), n_sides(at(n), 0), n_boundary(at(n), 0);
  std::vector<char> touched(at(n), 0);
  for (Index t = 0; t < m; ++t)
    for (int k = 0; k < 3; ++k) {
      int& face = face_of_vertex[at(mesh.triangles(t, k))];
      face = face == kNone || face == face_of_triangle[at(t)] ? face_of_triangle[at(t)] : kSeveral;
      if (is_filled(t)) touched[at(mesh.triangles(t, k))] = 1;
    }
  // A vertex at the border has one triangle less than edges: seen from the sums of directed edges.
  std::vector<long> balance(at(n), 0);
  for (Index t = 0; t < m; ++t)
    for (int k = 0; k < 3; ++k) {
      const int v = mesh.triangles(t, k);
      balance[at(v)] += mesh.triangles(t, (k + 1) % 3);
      balance[at(v)] -= mesh.triangles(t, (k + 2) % 3);
    }
  Region region;
  std::vector<int> number(at(n), -1);
  std::vector<std::array<int, 3>> triangles;
  const auto add = [&](Index t) {
    std::array<int, 3> own{};
    for (size_t k = 0; k < 3; ++k) {
      const int v = mesh.triangles(t, static_cast<Index>(k));
      int& there = number[at(v)];
      if (there < 0) {
        there = static_cast<int>(region.vertices.size());
        region.vertices.push_back(v);
      }
      own[k] = there;
    }
    triangles.push_back(own);
  };
  for (Index t = 0; t < m; ++t)
    if (is_filled(t)) add(t);
  region.n_filled = static_cast<Index>(triangles.size());
  for (Index t = 0; t < m; ++t)
    if (!is_filled(t) && (touched[at(mesh.triangles(t, 0))] || touched[at(mesh.triangles(t, 1))] ||
                          touched[at(mesh.triangles(t, 2))]))
      add(t);
  region.triangles.resize(static_cast<Index>(triangles.size()), 3);
  for (size_t t = 0; t < triangles.size(); ++t)
    for (size_t k = 0; k < 3; ++k)
      region.triangles(static_cast<Index>(t), static_cast<Index>(k)) = triangles[t][k];
  region.positions.resize(static_cast<Index>(region.vertices.size()), 3);
  for (size_t v = 0; v < region.vertices.size(); ++v) {
    const int global = region.vertices[v];
    region.positions.row(static_cast<Index>(v)) = mesh.positions.row(global);
    const int face = face_of_vertex[at(global)];
    const bool at_border = balance[at(global)] != 0;
    region.is_free.push_back(!at_border && face >= 0 && at(face) < is_filled_face.size() &&
                             is_filled_face[at(face)]);
    region.is_smooth.push_back(touched[at(global)] && !at_border && !on_crease[at(global)]);
  }
  return region;
}

/// Minimises the Dirichlet energy of the filled triangles, all edges alike at first, then in the metric of
/// what came out, again and again.
void make_membrane(Region& region, const HeldUnknowns& unknowns) {
  const Index n = region.positions.rows();
  const Triangles filled = region.triangles.topRows(region.n_filled);
  SparseCholesky solver("membrane over a face");  // every step has the same pattern
  for (int step = 0; step <= kStepsOfMembrane; ++step) {
    std::vector<Eigen::Triplet<double>> entries;
    const auto add = [&](int v, int w, double weight) {
      entries.emplace_back(v, v, weight);
      entries.emplace_back(w, w, weight);
      entries.emplace_back(v, w, -weight);
      entries.emplace_back(w, v, -weight);
    };
    if (step == 0) {
      for (Index t = 0; t < filled.rows(); ++t)
        for (int k = 0; k < 3; ++k) add(filled(t, k), filled(t, (k + 1) % 3), 0.5);
    } else {
      const SparseMatrix K = cotangent_stiffness(region.positions, filled);
      double mean = 0;
      for (Index v = 0; v < n; ++v) mean += K.coeff(v, v) / static_cast<double>(n);
      for (Index j = 0; j < K.outerSize(); ++j)
        for (SparseMatrix::InnerIterator entry(K, j); entry; ++entry)
          if (entry.row() < j)  // no edge pushes, and none lets go
            add(static_cast<int>(entry.row()), static_cast<int>(j),
                std::clamp(-entry.value(), 1e-2 * mean, 1e2 * mean));
    }
    SparseMatrix K(n, n);
    K.setFromTriplets(entries.begin(), entries.end());
    solver.factorize(unknowns.free_block(K, true));
    const Points right = -(K * region.positions);
    unknowns.add_to_free_rows(solver.solve(unknowns.free_rows(right)), region.positions);
  }
}

/// Minimises the bending energy in the metric of the membrane.
void make_plate(Region& region, const HeldUnknowns& unknowns) {
  const Index n = region.positions.rows();
  const SparseMatrix K = cotangent_stiffness(region.positions, region.triangles);
  const Eigen::VectorXd M = bounded_mass(lumped_mass(region.positions, region.triangles));
  Eigen::VectorXd d(n);
  for (Index v = 0; v < n; ++v) d(v) = region.is_smooth[at(v)] ? 1 / M(v) : 0;
  const std::vector<int> none(at(n), -1);
  SparseMatrix A = squared_stiffness(K, d, unknowns.free_index(), none).lower;
  const double anchor = 1e-2 * kAnchor * A.diagonal().mean();
  for (Index u = 0; u < A.rows(); ++u) A.coeffRef(u, u) += anchor;
  SparseCholesky solver("thin plate over a face");
  solver.factorize(A);
  const Points right = -(K.transpose() * (d.asDiagonal() * (K * region.positions)));
  unknowns.add_to_free_rows(solver.solve(unknowns.free_rows(right)), region.positions);
}

}  // namespace

void refill_faces(TriangleMesh& mesh, const std::vector<int>& face_of_triangle, const std::vector<int>& faces,
                  const std::vector<char>& on_crease, Refill how) {
  Region region = region_of(mesh, face_of_triangle, faces, on_crease);
  const HeldUnknowns unknowns = HeldUnknowns::all_but(region.is_free);
  if (unknowns.n_free() == 0) return;
  make_membrane(region, unknowns);
  if (how == Refill::Plate) make_plate(region, unknowns);
  for (size_t v = 0; v < region.vertices.size(); ++v)
    mesh.positions.row(region.vertices[v]) = region.positions.row(static_cast<Index>(v));
  const Points normals = vertex_normals(region.positions, region.triangles);
  for (size_t v = 0; v < region.vertices.size(); ++v)
    if (region.is_free[v] || region.is_smooth[v])
      mesh.normals.row(region.vertices[v]) = normals.row(static_cast<Index>(v));
}

}  // namespace batten::detail
