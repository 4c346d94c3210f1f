#include <algorithm>
#include <numeric>
#include <utility>

#include <Eigen/Dense>

#include "batten/core/parallel.hpp"
#include "batten/surfacing/patch_systems_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd rows_of(const MatrixXd& X, const std::vector<int>& rows) {
  MatrixXd taken(static_cast<Index>(rows.size()), X.cols());
  for (Index c = 0; c < X.cols(); ++c)
    for (std::size_t i = 0; i < rows.size(); ++i) taken(static_cast<Index>(i), c) = X(rows[i], c);
  return taken;
}

void set_rows(const MatrixXd& values, const std::vector<int>& rows, MatrixXd& X) {
  for (Index c = 0; c < X.cols(); ++c)
    for (std::size_t i = 0; i < rows.size(); ++i) X(rows[i], c) = values(static_cast<Index>(i), c);
}

}  // namespace

PatchSystems::PatchSystems(const SparseMatrix& stiffness, HeldUnknowns unknowns)
    : unknowns_(std::move(unknowns)) {
  find_patches(stiffness);
  all_.patches.resize(patches_.size());
  std::iota(all_.patches.begin(), all_.patches.end(), 0);
}

void PatchSystems::find_patches(const SparseMatrix& stiffness) {
  std::vector<char> seen(static_cast<std::size_t>(unknowns_.size()), 0);
  std::vector<int> rim_of(seen.size(), -1);  // the last patch that has the held vertex on its rim
  for (const int seed : unknowns_.free()) {
    if (seen[at(seed)]) continue;
    Patch patch;
    patch.vertices = {seed};
    seen[at(seed)] = 1;
    for (std::size_t next = 0; next < patch.vertices.size(); ++next)
      for (SparseMatrix::InnerIterator entry(stiffness, patch.vertices[next]); entry; ++entry) {
        const auto v = static_cast<int>(entry.row());
        if (unknowns_.held_index()[at(v)] >= 0) {
          if (std::exchange(rim_of[at(v)], n_patches()) != n_patches()) patch.rim.push_back(v);
        } else if (!std::exchange(seen[at(v)], 1)) {
          patch.vertices.push_back(v);
        }
      }
    std::sort(patch.vertices.begin(), patch.vertices.end());
    std::sort(patch.rim.begin(), patch.rim.end());
    patches_.push_back(std::move(patch));
  }
}

double PatchSystems::cost() const {
  // A column of Z is a solve, some 40 multiplications per vertex for both triangles of the factor, and half
  // of the products of columns are needed.
  double sum = 0;
  for (const Patch& patch : patches_) {
    const auto rim = static_cast<double>(patch.rim.size());
    sum += static_cast<double>(patch.vertices.size()) * rim * (0.5 * rim + 40);
  }
  return sum;
}

void PatchSystems::factorize(const SparseMatrix& stiffness, const Eigen::VectorXd& mass,
                             const Eigen::VectorXd& row_weights) {
  all_.ready = some_.ready = false;
  row_weights_ = row_weights;
  held_stiffness_ = unknowns_.held_block(stiffness);
  // Of a vertex in its patch; no two patches share one.
  std::vector<int> place(static_cast<std::size_t>(unknowns_.size()), -1);
  for (const Patch& patch : patches_)
    for (std::size_t i = 0; i < patch.vertices.size(); ++i)
      place[at(patch.vertices[i])] = static_cast<int>(i);
  parallel_for(n_patches(), 1, [&](Index begin, Index end) {
    for (Index p = begin; p < end; ++p) {
      Patch& patch = patches_[at(p)];
      const auto n = static_cast<Index>(patch.vertices.size());
      std::vector<Eigen::Triplet<double>> inner, outer;
      for (Index i = 0; i < n; ++i)
        for (SparseMatrix::InnerIterator entry(stiffness, patch.vertices[at(i)]); entry; ++entry) {
          const auto v = static_cast<int>(entry.row());
          if (unknowns_.held_index()[at(v)] >= 0) {
            const auto r = std::lower_bound(patch.rim.begin(), patch.rim.end(), v) - patch.rim.begin();
            outer.emplace_back(static_cast<int>(i), static_cast<int>(r), entry.value());
          } else if (place[at(v)] >= i) {
            inner.emplace_back(place[at(v)], static_cast<int>(i), entry.value());
          }
        }
      SparseMatrix lower(n, n);
      lower.setFromTriplets(inner.begin(), inner.end());
      patch.factor.factorize(lower);
      patch.to_rim.resize(n, static_cast<Index>(patch.rim.size()));
      patch.to_rim.setFromTriplets(outer.begin(), outer.end());
      patch.mass.resize(n);
      for (Index i = 0; i < n; ++i) patch.mass[i] = mass[patch.vertices[at(i)]];
      patch.rim_mass.resize(0, 0);
    }
  });
}

void PatchSystems::fill_rim_mass(Patch& patch) const {
  // A row of weight 0 has no multiplier: its column of Z is not asked for.
  std::vector<int> columns;
  for (std::size_t r = 0; r < patch.rim.size(); ++r)
    if (row_weights_[patch.rim[r]] > 0) columns.push_back(static_cast<int>(r));
  const auto rim = static_cast<Index>(patch.rim.size());
  patch.rim_mass = MatrixXd::Zero(rim, rim);
  // Eigen's update by a product reads the address of the first entry even where there is none.
  if (columns.empty() || patch.vertices.empty()) return;
  MatrixXd right = MatrixXd::Zero(patch.to_rim.rows(), static_cast<Index>(columns.size()));
  for (std::size_t c = 0; c < columns.size(); ++c)
    for (SparseMatrix::InnerIterator entry(patch.to_rim, columns[c]); entry; ++entry)
      right(entry.row(), static_cast<Index>(c)) = entry.value();
  const MatrixXd weighted = patch.mass.cwiseSqrt().asDiagonal() * patch.factor.solve(right);
  MatrixXd product = MatrixXd::Zero(weighted.cols(), weighted.cols());
  product.selfadjointView<Eigen::Lower>().rankUpdate(weighted.transpose());
  for (std::size_t j = 0; j < columns.size(); ++j)
    for (std::size_t i = j; i < columns.size(); ++i)
      patch.rim_mass(columns[i], columns[j]) = product(static_cast<Index>(i), static_cast<Index>(j));
}

void PatchSystems::prepare(Coupling& coupling) {
  if (coupling.ready) return;
  parallel_for(static_cast<Index>(coupling.patches.size()), 1, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      Patch& patch = patches_[at(coupling.patches[at(i)])];
      if (patch.rim_mass.rows() != static_cast<Index>(patch.rim.size())) fill_rim_mass(patch);
    }
  });
  // Rows in the order of the vertices.
  coupling.row_of_vertex.assign(static_cast<std::size_t>(unknowns_.size()), -1);
  coupling.vertex_of_row.clear();
  for (const int p : coupling.patches)
    for (const int v : patches_[at(p)].rim)
      if (row_weights_[v] > 0) coupling.vertex_of_row.push_back(v);
  std::sort(coupling.vertex_of_row.begin(), coupling.vertex_of_row.end());
  coupling.vertex_of_row.erase(std::unique(coupling.vertex_of_row.begin(), coupling.vertex_of_row.end()),
                               coupling.vertex_of_row.end());
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t row = 0; row < coupling.vertex_of_row.size(); ++row) {
    const int v = coupling.vertex_of_row[row];
    coupling.row_of_vertex[at(v)] = static_cast<int>(row);
    entries.emplace_back(static_cast<int>(row), static_cast<int>(row), 1 / row_weights_[v]);
  }
  for (const int p : coupling.patches) {
    const Patch& patch = patches_[at(p)];
    // Rims and rows increase with the vertex, so that lower triangles stay lower.
    for (std::size_t j = 0; j < patch.rim.size(); ++j)
      for (std::size_t i = j; i < patch.rim.size(); ++i) {
        const int row = coupling.row_of_vertex[at(patch.rim[i])],
                  column = coupling.row_of_vertex[at(patch.rim[j])];
        if (row >= 0 && column >= 0)
          entries.emplace_back(row, column, patch.rim_mass(static_cast<Index>(i), static_cast<Index>(j)));
      }
  }
  const auto n = static_cast<Index>(coupling.vertex_of_row.size());
  SparseMatrix lower(n, n);
  lower.setFromTriplets(entries.begin(), entries.end());
  coupling.factor.factorize(lower);
  coupling.ready = true;
}

void PatchSystems::solve(const Coupling& coupling, const MatrixXd* target, MatrixXd& X) const {
  const Index columns = X.cols();
  const auto n_patches = static_cast<Index>(coupling.patches.size());
  std::vector<MatrixXd> first(coupling.patches.size()), at_rim(coupling.patches.size());
  parallel_for(n_patches, 1, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const auto slot = static_cast<std::size_t>(i);
      const Patch& patch = patches_[at(coupling.patches[slot])];
      MatrixXd right = -(patch.to_rim * rows_of(X, patch.rim));
      if (target != nullptr) right += rows_of(*target, patch.vertices);
      first[slot] = patch.factor.solve(right);
      at_rim[slot] = patch.to_rim.transpose() * first[slot];
    }
  });
  MatrixXd q = MatrixXd::Zero(static_cast<Index>(coupling.vertex_of_row.size()), columns);
  for (Index row = 0; row < q.rows(); ++row) {
    const int v = coupling.vertex_of_row[at(row)];
    for (SparseMatrix::InnerIterator entry(held_stiffness_, unknowns_.held_index()[at(v)]); entry; ++entry)
      q.row(row) += entry.value() * X.row(unknowns_.held()[at(entry.row())]);
    if (target != nullptr) q.row(row) -= target->row(v);
  }
  for (std::size_t slot = 0; slot < at_rim.size(); ++slot) {
    const std::vector<int>& rim = patches_[at(coupling.patches[slot])].rim;
    for (std::size_t r = 0; r < rim.size(); ++r)
      if (const int row = coupling.row_of_vertex[at(rim[r])]; row >= 0)
        q.row(row) += at_rim[slot].row(static_cast<Index>(r));
  }
  const MatrixXd multipliers = coupling.factor.solve(q);
  parallel_for(n_patches, 1, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const auto slot = static_cast<std::size_t>(i);
      const Patch& patch = patches_[at(coupling.patches[slot])];
      MatrixXd of_rim = MatrixXd::Zero(static_cast<Index>(patch.rim.size()), columns);
      for (std::size_t r = 0; r < patch.rim.size(); ++r)
        if (const int row = coupling.row_of_vertex[at(patch.rim[r])]; row >= 0)
          of_rim.row(static_cast<Index>(r)) = multipliers.row(row);
      const MatrixXd residual = patch.mass.asDiagonal() * patch.factor.solve(patch.to_rim * of_rim);
      set_rows(first[slot] - patch.factor.solve(residual), patch.vertices, X);
    }
  });
}

MatrixXd PatchSystems::harmonic(const MatrixXd& right, const MatrixXd& values) const {
  MatrixXd X = values;
  parallel_for(n_patches(), 1, [&](Index begin, Index end) {
    for (Index p = begin; p < end; ++p) {
      const Patch& patch = patches_[at(p)];
      set_rows(patch.factor.solve(rows_of(right, patch.vertices) - patch.to_rim * rows_of(X, patch.rim)),
               patch.vertices, X);
    }
  });
  return X;
}

MatrixXd PatchSystems::biharmonic(const MatrixXd& target, const MatrixXd& values) {
  prepare(all_);
  MatrixXd X = values;
  solve(all_, &target, X);
  return X;
}

void PatchSystems::displace(const std::vector<int>& patches, const MatrixXd* target,
                            MatrixXd& displacements) {
  if (patches == all_.patches) {
    prepare(all_);
    solve(all_, target, displacements);
    return;
  }
  if (some_.patches != patches) {
    some_.ready = false;
    some_.patches = patches;
  }
  prepare(some_);
  solve(some_, target, displacements);
}

}  // namespace batten::detail
