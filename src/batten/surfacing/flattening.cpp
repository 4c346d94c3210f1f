#include "batten/surfacing/flattening.hpp"

#include <algorithm>
#include <utility>

#include <Eigen/Dense>

#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/linalg/held_unknowns.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/operators/laplacian.hpp"
#include "batten/surfacing/fairing_detail.hpp"

namespace batten {

namespace {

using Eigen::Index;

/// More pairs than this are not told apart.
constexpr std::size_t kMostPairs = 100000;
/// A patch counts as folded as in surface_network(): fewer folds are slivers that no other shape mends.
constexpr double kFoldedArea = 1e-3;
/// Solves of the membrane: the first with equal weights, then with those of the last shape.
constexpr int kMembranePasses = 3;

class Flattener {
 public:
  explicit Flattener(const SurfaceResult& surface)
      : surface_(surface), triangles_(surface.mesh.triangles), n_(surface.mesh.n_vertices()) {
    for (const int p : surface.patch_of_triangle) n_patches_ = std::max(n_patches_, p + 1);
  }

  int patch_of(Index triangle) const { return surface_.patch_of_triangle[at(triangle)]; }

  /// Marks the patches that cross anything or are folded.
  /// @return the number of crossing pairs.
  std::size_t find_bad(const Points& X, const Points& N, std::vector<char>& bad) const {
    bad.assign(static_cast<size_t>(n_patches_), 0);
    const auto pairs = self_intersections(X, triangles_, kMostPairs);
    for (const auto& [a, b] : pairs)
      bad[static_cast<size_t>(patch_of(a))] = bad[static_cast<size_t>(patch_of(b))] = 1;
    std::vector<double> area(bad.size(), 0), folded(bad.size(), 0);
    for (Index f = 0; f < triangles_.rows(); ++f) {
      const Eigen::RowVector3d cross = twice_area(X, f);
      const auto p = static_cast<size_t>(patch_of(f));
      area[p] += cross.norm();
      if (is_folded(X, N, f)) folded[p] += cross.norm();
    }
    for (size_t p = 0; p < bad.size(); ++p)
      if (folded[p] > kFoldedArea * area[p]) bad[p] = 1;
    return pairs.size();
  }

  bool is_folded(const Points& X, const Points& N, Index f) const {
    return detail::is_folded(X, N, triangles_, f);
  }

  /// The positions with the inner vertices of the marked patches on the membrane over their curves.
  Points membrane(const Points& X, const std::vector<char>& marked) const {
    std::vector<char> inner(at(n_), 0);
    for (Index f = 0; f < triangles_.rows(); ++f)
      for (int k = 0; k < 3 && marked[static_cast<size_t>(patch_of(f))]; ++k) {
        const int v = triangles_(f, k);
        if (!surface_.on_network[at(v)]) inner[at(v)] = 1;
      }
    const HeldUnknowns unknowns = HeldUnknowns::all_but(inner);
    Points result = X;
    if (unknowns.n_free() == 0) return result;
    HeldSolver solver("membrane of a patch", unknowns);
    for (int pass = 0; pass < kMembranePasses; ++pass) {
      const SparseMatrix K = cotangent_stiffness(result, triangles_);
      std::vector<Eigen::Triplet<double>> entries;
      for (const int v : unknowns.free())
        for (SparseMatrix::InnerIterator entry(K, v); entry; ++entry) {
          if (entry.row() == v) continue;
          // Equal weights know no shape, so they fold nothing that is flat; those of obtuse triangles have
          // the wrong sign and are left small.
          const double weight = pass == 0 ? 1 : std::clamp(-entry.value(), 0.05, 20.0);
          entries.emplace_back(v, v, weight);
          entries.emplace_back(v, static_cast<int>(entry.row()), -weight);
        }
      SparseMatrix A(n_, n_);
      A.setFromTriplets(entries.begin(), entries.end());
      solver.factorize(A);
      result = solver.solve_homogeneous(X);
    }
    return result;
  }

  int n_patches() const { return n_patches_; }

  /// Normals with those of the triangles inside the marked patches.
  Points normals(const Points& X, const std::vector<char>& marked) const {
    Points result = surface_.mesh.normals;
    const Points own = vertex_normals(X, triangles_);
    for (Index f = 0; f < triangles_.rows(); ++f)
      for (int k = 0; k < 3 && marked[static_cast<size_t>(patch_of(f))]; ++k)
        if (!surface_.on_network[at(triangles_(f, k))])
          result.row(triangles_(f, k)) = own.row(triangles_(f, k));
    return result;
  }

 private:
  Eigen::RowVector3d twice_area(const Points& X, Index f) const {
    const Eigen::RowVector3d a = X.row(triangles_(f, 0));
    return (X.row(triangles_(f, 1)) - a).cross(X.row(triangles_(f, 2)) - a);
  }

  const SurfaceResult& surface_;
  const Triangles& triangles_;
  Index n_;
  int n_patches_ = 0;
};

}  // namespace

FlatteningReport flatten_crossing_patches(SurfaceResult& surface, const Progress& progress) {
  FlatteningReport report;
  const ScopedStage stage(surface.times, "flattening");
  progress.report("flattening", 0);
  const Flattener flattener(surface);
  std::vector<char> bad;
  report.crossings_before = report.crossings_after =
      flattener.find_bad(surface.mesh.positions, surface.mesh.normals, bad);
  const Points &curved = surface.mesh.positions, &propagated = surface.mesh.normals;
  Points X = curved, N = propagated;
  std::vector<char> marked(bad.size(), 0);
  std::vector<double> share(bad.size(), 0);
  std::size_t n_crossings = report.crossings_before;
  for (int round = 0; round < 2; ++round) {
    if (std::count(bad.begin(), bad.end(), 1) == 0) break;
    progress.report("flattening", 0.3 * (round + 1));
    for (size_t p = 0; p < bad.size(); ++p)
      if (bad[p]) {
        marked[p] = 1;
        share[p] = round == 0 ? 0.5 : 1;
      }
    const Points flat = flattener.membrane(curved, marked);
    std::vector<double> share_of_vertex(static_cast<size_t>(curved.rows()), 0);
    for (Index f = 0; f < surface.mesh.triangles.rows(); ++f)
      for (int k = 0; k < 3; ++k) {
        const auto v = static_cast<size_t>(surface.mesh.triangles(f, k));
        if (!surface.on_network[v]) share_of_vertex[v] = share[static_cast<size_t>(flattener.patch_of(f))];
      }
    for (Index v = 0; v < curved.rows(); ++v) {
      const double t = share_of_vertex[at(v)];
      if (t > 0) X.row(v) = (1 - t) * curved.row(v) + t * flat.row(v);
    }
    N = flattener.normals(X, marked);
    n_crossings = flattener.find_bad(X, N, bad);
  }
  std::vector<int> turned = detail::all_folded(X, N, surface.mesh.triangles);
  const auto folded = static_cast<int>(turned.size());
  const bool gained = n_crossings + static_cast<std::size_t>(folded) <
                      report.crossings_before + static_cast<std::size_t>(surface.folded_triangles);
  if (!gained) return report;
  report.crossings_after = n_crossings;
  std::string names;
  for (size_t p = 0; p < marked.size(); ++p)
    if (marked[p]) {
      report.patches.push_back(static_cast<int>(p));
      names += concat(names.empty() ? "" : ", ", p);
    }
  surface.mesh.positions = X;
  surface.mesh.normals = N;
  surface.folded_triangles = folded;
  surface.folded = std::move(turned);
  const auto counts_folds = [](const std::string& warning) {
    return warning.find("triangles are turned away") != std::string::npos;
  };
  surface.warnings.erase(std::remove_if(surface.warnings.begin(), surface.warnings.end(), counts_folds),
                         surface.warnings.end());
  if (folded > 0)
    surface.warnings.push_back(concat(folded, " triangles are still turned away from their neighbours"));
  surface.warnings.push_back(concat(
      "the patches ", names,
      " would have crossed others or folded and were filled flatter; a curve across them gives them shape"));
  return report;
}

}  // namespace batten
