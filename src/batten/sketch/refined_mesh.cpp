#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/IterativeLinearSolvers>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/sketch/cage_fit_detail.hpp"
#include "batten/sketch/face_split_detail.hpp"
#include "batten/sketch/refined_mesh_detail.hpp"
#include "batten/subdivision/limit_stencils.hpp"

namespace batten::detail {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Share of the size by which drawn curves may move. With fidelity 0, the default, they do not move at all;
/// with 1 they move by per mille.
constexpr double kFarthestFromCurves = 0.05;

/// μ of fit_limit(). A surface through every vertex of uneven quads overshoots between them; with 1 it passes
/// them by a hundredth of a percent of the size on a sphere of 16 n quads, and does not wrinkle beside
/// concave corners.
constexpr double kEvenness = 1;

size_t at(int i) {
  return static_cast<size_t>(i);
}

}  // namespace

Triangles cut_quads(const PolygonMesh& mesh) {
  Triangles triangles(2 * mesh.n_faces(), 3);
  for (Index f = 0; f < mesh.n_faces(); ++f) {
    const int* c = &mesh.corners[at(mesh.offsets[static_cast<size_t>(f)])];
    const auto both = cut_along_corners({c[0], c[1], c[2], c[3]});
    for (size_t k = 0; k < 2; ++k)
      triangles.row(2 * f + static_cast<Index>(k)) << both[k][0], both[k][1], both[k][2];
  }
  return triangles;
}

double crease_sharpness(double drawn) {
  return drawn >= 1 ? kInfinitelySharp : 4 * drawn;
}

void fit_limit(ControlCage& cage, const Points& target) {
  const std::vector<char> all(static_cast<size_t>(target.rows()), 1);
  fit_limit(cage, target, all, all);
}

namespace {

/// Rows of μ U U for the vertices that are not exact, with U the umbrella: how uneven the difference of cage
/// and target is. Sharp edges have none, as the differences on their sides have nothing in common, and
/// neither has the rim of a part.
SparseMatrix unevenness(const ControlCage& cage, const std::vector<char>& free,
                        const std::vector<char>& exact) {
  const auto n = static_cast<Index>(exact.size());
  std::vector<char> left_out(exact.size(), 0);
  for (size_t v = 0; v < free.size(); ++v) left_out[v] = !free[v];
  for (const SharpEdge& edge : cage.sharp_edges) left_out[at(edge.from)] = left_out[at(edge.to)] = 1;
  std::vector<double> valence(exact.size(), 0);
  std::vector<Index> first_less_last(exact.size(),
                                     0);  // of the neighbours around a vertex: 0 where they close
  for (size_t first = 0; first < cage.mesh.corners.size(); first += 4)
    for (size_t k = 0; k < 4; ++k) {
      const size_t v = at(cage.mesh.corners[first + k]);
      valence[v] += 2;
      first_less_last[v] += cage.mesh.corners[first + (k + 1) % 4] - cage.mesh.corners[first + (k + 3) % 4];
    }
  for (size_t v = 0; v < left_out.size(); ++v)
    if (first_less_last[v] != 0) left_out[v] = 1;
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(4 * cage.mesh.corners.size());
  for (size_t first = 0; first < cage.mesh.corners.size(); first += 4)
    for (size_t k = 0; k < 4; ++k) {
      const int v = cage.mesh.corners[first + k];
      if (left_out[at(v)]) continue;
      entries.emplace_back(v, v, 2 / valence[at(v)]);
      for (const size_t next : {(k + 1) % 4, (k + 3) % 4})
        entries.emplace_back(v, cage.mesh.corners[first + next], -1 / valence[at(v)]);
    }
  SparseMatrix umbrella(n, n);
  umbrella.setFromTriplets(entries.begin(), entries.end());
  Eigen::VectorXd weight(n);
  for (Index v = 0; v < n; ++v) weight(v) = exact[static_cast<size_t>(v)] ? 0 : kEvenness;
  return weight.asDiagonal() * (umbrella * umbrella);
}

}  // namespace

void fit_limit(ControlCage& cage, const Points& target, const std::vector<char>& free,
               const std::vector<char>& exact) {
  const SparseMatrix uneven = unevenness(cage, free, exact), rows = limit_stencils(cage) + uneven;
  const Points wanted = target + uneven * target;
  const Index n = target.rows();
  std::vector<int> index(static_cast<size_t>(n), -1);
  int n_free = 0;
  for (Index v = 0; v < n; ++v)
    if (free[static_cast<size_t>(v)]) index[static_cast<size_t>(v)] = n_free++;
  if (n_free == 0) return;
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(static_cast<size_t>(rows.nonZeros()));
  for (Index j = 0; j < rows.outerSize(); ++j)
    for (SparseMatrix::InnerIterator entry(rows, j); entry; ++entry)
      if (index[static_cast<size_t>(entry.row())] >= 0 && index[static_cast<size_t>(j)] >= 0)
        entries.emplace_back(index[static_cast<size_t>(entry.row())], index[static_cast<size_t>(j)],
                             entry.value());
  Eigen::SparseMatrix<double, Eigen::RowMajor> A(n_free, n_free);
  A.setFromTriplets(entries.begin(), entries.end());
  Eigen::BiCGSTAB<Eigen::SparseMatrix<double, Eigen::RowMajor>> inverse(A);
  inverse.setTolerance(1e-8);  // of what is still lacking, which falls with every turn
  inverse.setMaxIterations(200);
  const double size = bounding_box_diagonal(target);
  Points& positions = cage.mesh.positions;
  for (int k = 0; k < 20; ++k) {
    const Points lack = wanted - rows * positions;
    Eigen::MatrixXd right(n_free, 3);
    for (Index v = 0; v < n; ++v)
      if (index[static_cast<size_t>(v)] >= 0) right.row(index[static_cast<size_t>(v)]) = lack.row(v);
    if (right.rowwise().norm().maxCoeff() < 1e-12 * size) break;
    for (int c = 0; c < 3; ++c) {
      const Eigen::VectorXd solved = inverse.solve(right.col(c));
      if (!solved.allFinite()) throw SolverFailure("cage of the limit surface", n_free);
      for (Index v = 0; v < n; ++v)
        if (index[static_cast<size_t>(v)] >= 0) positions(v, c) += solved(index[static_cast<size_t>(v)]);
    }
  }
}

// The flow has no bound on what the curves ask of it: what comes out folded is refused.
void require_sound(const PolygonMesh& mesh, const std::vector<int>& face_of_quad,
                   const std::vector<char>& on_curve, const Points& start) {
  const Points& positions = mesh.positions;
  const auto face_of = [&](int triangle) { return face_of_quad[at(triangle) / 2]; };
  for (size_t c = 0; c < mesh.corners.size(); ++c)
    if (!positions.row(mesh.corners[c]).allFinite())
      throw InvalidInput(concat("the surface leaves the finite numbers in the face f", face_of_quad[c / 4],
                                "; divide it by another curve, or draw its curves farther apart"));
  const auto crossing = self_intersections(positions, cut_quads(mesh), 1);
  if (!crossing.empty()) {
    const int first = face_of(crossing[0].first), second = face_of(crossing[0].second);
    throw InvalidInput(
        first == second
            ? concat("the surface folds or crosses itself in the face f", first,
                     "; divide it by another curve, best where it is not convex or is long and thin")
            : concat("the surface folds or crosses itself in the faces f", first, " and f", second,
                     "; divide them by another curve, best where they are not convex or are long and thin"));
  }
  const double size = bounding_box_diagonal(start);
  for (Index v = 0; v < positions.rows(); ++v)
    if (on_curve[static_cast<size_t>(v)] &&
        !((positions.row(v) - start.row(v)).norm() <= kFarthestFromCurves * size))
      throw InvalidInput(
          concat("the surface leaves its curves by more than ", 100 * kFarthestFromCurves,
                 " % of the size; divide the faces by another curve, best where they are not convex"));
}

void turn_outwards(const PolylineMesh& model, PolygonMesh& mesh, const std::vector<int>& face_of_quad) {
  std::vector<int> component(model.faces().size(), -1);
  std::vector<char> is_open;
  for (size_t f = 0; f < model.faces().size(); ++f) {
    if (!model.faces()[f].alive || component[f] >= 0) continue;
    const int own = static_cast<int>(is_open.size());
    is_open.push_back(0);
    std::vector<int> stack{static_cast<int>(f)};
    component[f] = own;
    while (!stack.empty()) {
      const int face = stack.back();
      stack.pop_back();
      for (const int side : model.face(face).sides) {
        const int next = model.face_of(opposite_side(side));
        if (next < 0) is_open.back() = 1;
        if (next < 0 || component[at(next)] >= 0) continue;
        component[at(next)] = own;
        stack.push_back(next);
      }
    }
  }
  std::vector<double> volume(is_open.size(), 0);
  const auto quad = [&](Index f) { return &mesh.corners[at(mesh.offsets[static_cast<size_t>(f)])]; };
  for (Index f = 0; f < mesh.n_faces(); ++f) {
    const int* c = quad(f);
    const auto p = [&](int k) -> Vector3d { return mesh.positions.row(c[k]); };
    const int own = component[at(face_of_quad[static_cast<size_t>(f)])];
    volume[at(own)] += p(0).cross(p(1)).dot(p(2)) + p(0).cross(p(2)).dot(p(3));
  }
  for (Index f = 0; f < mesh.n_faces(); ++f) {
    const int own = component[at(face_of_quad[static_cast<size_t>(f)])];
    if (is_open[at(own)] || volume[at(own)] >= 0) continue;
    int* c = quad(f);
    std::swap(c[1], c[3]);
  }
}

}  // namespace batten::detail
