#include "batten/deformation/deformer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include <Eigen/Dense>

#include "batten/core/disjoint_sets.hpp"
#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/deformation/dual_laplacian.hpp"
#include "batten/deformation/local_rotations.hpp"
#include "batten/linalg/sparse_cholesky.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/operators/curvature.hpp"
#include "batten/operators/laplacian.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Per vertex the lowest vertex of its connected part.
std::vector<int> parts(const Triangles& triangles, Eigen::Index n) {
  DisjointSets sets(static_cast<int>(n));
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 2; ++k) sets.unite(triangles(f, k), triangles(f, k + 1));
  std::vector<int> lowest(n);
  for (Eigen::Index v = 0; v < n; ++v) lowest[v] = sets.root(static_cast<int>(v));
  return lowest;
}

/// Lengthens all edges by one small amount, such that no triangle is flatter than a hundredth of the mean
/// edge [sharp2020]: weights of degenerate triangles stay finite, those of good ones hardly change.
EdgeLengths mollified(EdgeLengths lengths) {
  if (lengths.rows() == 0) return lengths;
  const double least = 1e-2 * lengths.mean();
  double add = 0;
  for (Eigen::Index f = 0; f < lengths.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      add = std::max(add, least + lengths(f, k) - lengths(f, (k + 1) % 3) - lengths(f, (k + 2) % 3));
  lengths.array() += add;
  return lengths;
}

/// Negative weights of obtuse pairs of triangles become 0; rows keep their sum of zero.
void clamp_weights(SparseMatrix& K) {
  for (Eigen::Index i = 0; i < K.cols(); ++i) {
    double sum = 0;
    double* diagonal = nullptr;
    for (SparseMatrix::InnerIterator entry(K, i); entry; ++entry) {
      if (entry.row() == i) {
        diagonal = &entry.valueRef();
        continue;
      }
      entry.valueRef() = std::min(entry.value(), 0.0);
      sum += entry.value();
    }
    if (diagonal != nullptr) *diagonal = -sum;
  }
}

/// The stiffness matrix of ∇·(g ∇·): every edge weight of K times the mean of g at its ends.
SparseMatrix weighted_stiffness(const SparseMatrix& K, const Eigen::VectorXd& g) {
  SparseMatrix weighted = K;  // NOLINT(performance-unnecessary-copy-initialization): iterators write into it
  for (Eigen::Index i = 0; i < K.cols(); ++i) {
    double sum = 0;
    double* diagonal = nullptr;
    for (SparseMatrix::InnerIterator entry(weighted, i); entry; ++entry) {
      if (entry.row() == i) {
        diagonal = &entry.valueRef();
        continue;
      }
      entry.valueRef() *= 0.5 * (g[i] + g[entry.row()]);
      sum += entry.value();
    }
    if (diagonal != nullptr) *diagonal = -sum;
  }
  return weighted;
}

/// Rows and columns of a full symmetric matrix, lower triangle only where both are unknowns.
SparseMatrix part_of(const SparseMatrix& T, const std::vector<int>& row_of, const std::vector<int>& column_of,
                     Eigen::Index n_rows, Eigen::Index n_columns, bool lower) {
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index i = 0; i < T.cols(); ++i)
    for (SparseMatrix::InnerIterator entry(T, i); entry; ++entry) {
      const int row = row_of[entry.row()], column = column_of[i];
      if (row >= 0 && column >= 0 && (!lower || row >= column))
        entries.emplace_back(row, column, entry.value());
    }
  SparseMatrix part(n_rows, n_columns);
  part.setFromTriplets(entries.begin(), entries.end());
  return part;
}

/// Iterations of shape matching that Anderson's acceleration looks back on, and after which it begins.
constexpr int kAccelerationDepth = 6, kPlainIterations = 5;
/// Its damping (Walker, Ni's β). On cow and cheburashka with a turn of 40°, 2 of 6 runs converge within 100
/// iterations, and the others end after 200 at steps 1.4 to 150 times smaller than plain ones, of which none
/// converges.
constexpr double kMixing = 0.5;

/// Fixed points x = g(x) from the last few steps: the combination of them whose residuals g(x) − x cancel
/// best [anderson1965] [walker2011]. Where plain steps creep or swing this converges like a quasi-Newton
/// method.
class AndersonAcceleration {
 public:
  explicit AndersonAcceleration(int depth) : depth_(depth) {}

  void forget() { past_.clear(); }

  /// Moves x to where g is to be evaluated next. @param g what g(x) was. @param damping of the step, (0, 1].
  void advance(Points& x, const Points& g, double damping) {
    const Points residual = g - x;
    if (!past_.empty()) {
      past_.back().x = x - past_.back().x;
      past_.back().residual = residual - past_.back().residual;
    }
    const auto m = static_cast<Eigen::Index>(past_.size());
    Points step = damping * residual;
    if (m > 0) {
      Eigen::MatrixXd gram(m, m);
      Eigen::VectorXd right(m);
      for (Eigen::Index i = 0; i < m; ++i) {
        for (Eigen::Index j = 0; j <= i; ++j)
          gram(i, j) = gram(j, i) = past_[i].residual.cwiseProduct(past_[j].residual).sum();
        right[i] = past_[i].residual.cwiseProduct(residual).sum();
      }
      // Steps that have become parallel must not blow up the combination.
      gram.diagonal().array() *= 1 + 1e-10;
      const Eigen::VectorXd share = gram.ldlt().solve(right);
      if (share.allFinite())
        for (Eigen::Index i = 0; i < m; ++i) step -= share[i] * (past_[i].x + damping * past_[i].residual);
    }
    if (m == depth_) past_.erase(past_.begin());
    past_.push_back({x, residual});
    x += step;
  }

 private:
  /// Differences of one step and of the residuals at its ends; for the last entry, where it began.
  struct Step {
    Points x, residual;
  };
  int depth_;
  std::vector<Step> past_;
};

}  // namespace

std::optional<std::string> DeformOptions::problem() const {
  const auto positive = [](double value) { return value > 0 && std::isfinite(value); };
  if (!(soft_weight >= 0) || !std::isfinite(soft_weight))
    return concat("soft_weight must be at least 0, got ", soft_weight);
  if (!positive(bending_length)) return concat("bending_length must be positive, got ", bending_length);
  if (!(curvature_term >= 0 && curvature_term <= 1))
    return concat("curvature_term must lie in [0, 1], got ", curvature_term);
  if (!positive(detail_weight)) return concat("detail_weight must be positive, got ", detail_weight);
  if (!(membrane_length >= 0) || !std::isfinite(membrane_length))
    return concat("membrane_length must be at least 0, got ", membrane_length);
  if (max_iterations < 1) return concat("max_iterations must be at least 1, got ", max_iterations);
  if (!positive(tolerance)) return concat("tolerance must be positive, got ", tolerance);
  return std::nullopt;
}

struct Deformer::Implementation {
  DeformOptions options;
  Points rest;
  std::vector<int> constrained;
  double diameter = 0;

  SparseMatrix K;
  Eigen::VectorXd inverse_mass;
  double bending = 0;         ///< factor of K M⁻¹ K in the displacement energy
  SparseMatrix second_order;  ///< the rest of it: K / ℓ², −2 c K_G or K; n × n, maybe empty
  double curvature_term = 0;
  SparseMatrix membrane;  ///< GaussNewton: λ_2 K / ℓ², whose edges turn with the one-rings; maybe empty

  std::vector<int> unknowns;       ///< vertices to solve for; constrained ones too where they are soft
  std::vector<int> soft_unknowns;  ///< soft constraints: the unknown of each constrained vertex
  SparseMatrix known;              ///< u × c: moves hard targets to the right-hand side
  // Dragging lives on back-substitutions, and CHOLMOD's take all three coordinates in one pass over the
  // factor.
  SparseCholesky cholesky{"deformation", CholeskyBackend::Cholmod};
  double pull = 0;  ///< the soft weight as an entry of the matrix

  Points rest_vectors;  ///< K X: integrated Laplacian coordinates
  std::unique_ptr<DualLaplacian> dual;
  std::vector<int> not_followed;  ///< vertices whose vectors turn with a rotation of their ring

  bool has_second_order() const { return second_order.nonZeros() > 0; }
  bool is_soft() const { return options.soft_weight > 0; }

  /// Factorises c_b K M⁻¹ K + T (+ soft weights) for the unknowns.
  void factorize(double bending_factor, const SparseMatrix& T, const std::vector<int>& index_of_unknown,
                 const std::vector<int>& index_of_known, const Progress& progress) {
    progress.report("factorising", 0.1);
    const auto u = static_cast<Eigen::Index>(unknowns.size());
    const auto c = is_soft() ? Eigen::Index{0} : static_cast<Eigen::Index>(constrained.size());
    SparseMatrix lower(u, u);
    known = SparseMatrix(u, c);
    if (bending_factor > 0) {
      SquaredStiffness squared =
          squared_stiffness(K, bending_factor * inverse_mass, index_of_unknown, index_of_known);
      lower.swap(squared.lower);
      if (c > 0) known.swap(squared.known);
    }
    if (T.nonZeros() > 0) {
      lower += part_of(T, index_of_unknown, index_of_unknown, u, u, true);
      if (c > 0) known += part_of(T, index_of_unknown, index_of_known, u, c, false);
    }
    if (is_soft()) {
      soft_unknowns.clear();
      pull = options.soft_weight * lower.diagonal().mean();
      SparseMatrix weights(u, u);
      std::vector<Eigen::Triplet<double>> entries;
      for (const int v : constrained) soft_unknowns.push_back(index_of_unknown[v]);
      for (const int u_v : soft_unknowns) entries.emplace_back(u_v, u_v, pull);
      weights.setFromTriplets(entries.begin(), entries.end());
      lower += weights;
    }
    lower.makeCompressed();
    progress.report("factorising", 0.3);
    cholesky.factorize(lower, progress.part("factorising", 0.3, 1));
  }

  /// Constrained vertices that hang together along edges and, as parts of one handle, mostly move as one.
  struct Region {
    std::vector<Eigen::Index> rows;  ///< of the constraints
    Eigen::MatrixXd basis;  ///< rows × r: orthonormal affine functions of the rest positions, r ≤ 4
    std::once_flag once;
    RowMajor response;  ///< n × r: how all vertices answer to the basis; computed when first asked for
  };
  std::vector<std::unique_ptr<Region>> regions;  ///< empty where there are too many

  /// Solves A X = B + (what the constraints add) and fills in the constrained rows.
  /// @param B n × k. @param values c × k: targets, or target displacements.
  /// @param outside n × k: what vertices without triangles get.
  template <typename Rows>
  Rows solve(const Rows& B, const Rows& values, const Rows& outside) const {
    Eigen::MatrixXd right(unknowns.size(), B.cols());
    for (std::size_t u = 0; u < unknowns.size(); ++u) right.row(u) = B.row(unknowns[u]);
    if (is_soft())
      for (std::size_t c = 0; c < constrained.size(); ++c)
        right.row(soft_unknowns[c]) += pull * values.row(static_cast<Eigen::Index>(c));
    else
      right -= known * values;
    const Eigen::MatrixXd solution = cholesky.solve(right);
    Rows X = outside;
    for (std::size_t u = 0; u < unknowns.size(); ++u) X.row(unknowns[u]) = solution.row(u);
    if (!is_soft())
      for (std::size_t c = 0; c < constrained.size(); ++c)
        X.row(constrained[c]) = values.row(static_cast<Eigen::Index>(c));
    return X;
  }

  void find_regions(const Triangles& triangles, const std::vector<int>& index_of_known) {
    constexpr std::size_t kMostRegions = 8;
    const auto c = static_cast<Eigen::Index>(constrained.size());
    Triangles inside(triangles.rows(), 3);  // edges between constraints, as triangles that repeat a corner
    Eigen::Index count = 0;
    for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
      Eigen::RowVector3i known_corners;
      int held = 0;
      for (int k = 0; k < 3; ++k)
        if (const int row = index_of_known[triangles(f, k)]; row >= 0) known_corners[held++] = row;
      if (held < 2) continue;
      if (held == 2) known_corners[2] = known_corners[1];
      inside.row(count++) = known_corners;
    }
    const std::vector<int> part = parts(inside.topRows(count), c);
    std::vector<int> region_of(constrained.size(), -1);
    for (std::size_t row = 0; row < constrained.size(); ++row) {
      int& region = region_of[part[row]];
      if (region < 0) {
        region = static_cast<int>(regions.size());
        if (regions.size() == kMostRegions) {
          regions.clear();
          return;
        }
        regions.push_back(std::make_unique<Region>());
      }
      regions[region]->rows.push_back(static_cast<Eigen::Index>(row));
    }
    for (const auto& region : regions) {
      const auto m = static_cast<Eigen::Index>(region->rows.size());
      Eigen::MatrixXd affine(m, 4);
      for (Eigen::Index i = 0; i < m; ++i) affine.row(i) << 1, rest.row(constrained[region->rows[i]]);
      affine.rightCols(3).rowwise() -= affine.rightCols(3).colwise().mean().eval();
      if (diameter > 0) affine.rightCols(3) /= diameter;
      Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(affine);
      qr.setThreshold(1e-9);  // flat and straight regions, and single vertices, span less than four
      region->basis = qr.householderQ() * Eigen::MatrixXd::Identity(m, qr.rank());
    }
  }

  /// Adds to the rest shape the answer to displacements (c × 3) that are affine on every region: translations
  /// and turns of handles are. It is linear in the few numbers that describe them, so that no system is left
  /// to solve [botsch2004framework]. @return false, with X undefined, where some
  /// region moves otherwise.
  bool respond(const Points& displacements, Points& X) const {
    if (regions.empty()) return false;
    const double rounding = 1e-13 * (rest.cwiseAbs().maxCoeff() + displacements.cwiseAbs().maxCoeff());
    X = rest;
    for (const auto& region : regions) {
      const auto m = static_cast<Eigen::Index>(region->rows.size());
      Eigen::MatrixXd moves(m, 3);
      for (Eigen::Index i = 0; i < m; ++i) moves.row(i) = displacements.row(region->rows[i]);
      if (moves.isZero(0)) continue;
      const Eigen::MatrixXd coefficients = region->basis.transpose() * moves;
      if ((moves - region->basis * coefficients).cwiseAbs().maxCoeff() > rounding) return false;
      std::call_once(region->once, [&] {
        const Eigen::Index r = region->basis.cols();
        RowMajor values = RowMajor::Zero(displacements.rows(), r);
        for (Eigen::Index i = 0; i < m; ++i) values.row(region->rows[i]) = region->basis.row(i);
        const RowMajor zero = RowMajor::Zero(rest.rows(), r);
        region->response = solve(zero, values, zero);
      });
      X.noalias() += region->response * coefficients;
    }
    return true;
  }

  Points apply_bending(const Points& vectors) const {
    return K * (inverse_mass.asDiagonal() * vectors).eval();
  }

  /// T X with every edge of the rest shape turned by the mean of the rotations at its ends.
  Points turned_edges(const SparseMatrix& T, const std::vector<Matrix3d>& rotations) const {
    Points B(rest.rows(), 3);
    for (Eigen::Index i = 0; i < rest.rows(); ++i) {
      Vector3d sum = Vector3d::Zero();
      for (SparseMatrix::InnerIterator entry(T, i); entry; ++entry) {
        const Eigen::Index j = entry.row();
        const Vector3d edge = rest.row(i) - rest.row(j);
        sum -= 0.5 * entry.value() * ((rotations[i] + rotations[j]) * edge);
      }
      B.row(i) = sum;
    }
    return B;
  }

  /// Right-hand side of the alternating method: the differentials of the rest shape, turned.
  Points turned_rest(const std::vector<Matrix3d>& rotations) const {
    Points B = Points::Zero(rest.rows(), 3);
    if (bending > 0) {
      Points turned(rest.rows(), 3);
      for (Eigen::Index i = 0; i < rest.rows(); ++i)
        turned.row(i) = rest_vectors.row(i) * rotations[i].transpose();
      B = bending * apply_bending(turned);
    }
    if (has_second_order()) B += turned_edges(second_order, rotations);
    return B;
  }

  /// The detail part of the right-hand side of (2.79): λ_2 K M⁻¹ δ̂, and the membrane's.
  Points detail_forces(const Points& deformed, std::vector<Matrix3d>& rotations) const {
    Points vectors;
    dual->evaluate(deformed, vectors);
    if (membrane.nonZeros() > 0) fit_local_rotations(K, rest, deformed, rotations);
    if (rotations.empty()) rotations.assign(rest.rows(), Matrix3d::Identity());
    for (const int i : not_followed) {
      // Vectors that the face normals cannot carry (in the surface, on borders) turn with their one-ring.
      if (membrane.nonZeros() == 0)
        rotations[i] = nearest_rotation(one_ring_covariance(K, rest, deformed, i), rotations[i]);
      vectors.row(i) = rest_vectors.row(i) * rotations[i].transpose();
    }
    Points B = options.detail_weight * apply_bending(vectors);
    if (membrane.nonZeros() > 0) B += turned_edges(membrane, rotations);
    return B;
  }

  Points displacement_forces() const {
    Points B = Points::Zero(rest.rows(), 3);
    if (bending > 0) B = bending * apply_bending(rest_vectors);
    if (has_second_order()) B += second_order * rest;
    return B;
  }
};

Deformer::Deformer(const Points& positions, const Triangles& triangles, std::vector<int> constrained,
                   const DeformOptions& options, const Progress& progress)
    : implementation_(std::make_unique<Implementation>()) {
  Implementation& self = *implementation_;
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  progress.report("factorising", 0);
  const Eigen::Index n = positions.rows();
  self.options = options;
  self.rest = positions;
  self.constrained = std::move(constrained);
  self.diameter = bounding_box_diagonal(positions);

  std::vector<int> index_of_known(n, -1), index_of_unknown(n, -1);
  for (std::size_t c = 0; c < self.constrained.size(); ++c) {
    const int v = self.constrained[c];
    if (v < 0 || v >= n)
      throw InvalidInput(
          concat("constraint ", c, " names vertex ", v, ", but the mesh has the vertices 0 to ", n - 1));
    if (index_of_known[v] >= 0)
      throw InvalidInput(concat("vertex ", v, " is constrained twice; name it once"));
    index_of_known[v] = static_cast<int>(c);
  }
  progress.report("factorising", 0);
  const EdgeLengths lengths = mollified(edge_lengths(positions, triangles));
  self.K = cotangent_stiffness(triangles, lengths, n);
  // Rotations are fitted with weights of at least 0; the energies that follow them must have the same, or the
  // alternation need not descend.
  if (options.detail != DetailPreservation::None) clamp_weights(self.K);
  const Eigen::VectorXd mass = lumped_mass(triangles, lengths, n);
  progress.report("factorising", 0.05);
  const std::vector<int> part = parts(triangles, n);
  std::vector<char> held(n, 0), used(n, 0);
  for (const int v : self.constrained) held[part[v]] = 1;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) used[triangles(f, k)] = 1;
  for (Eigen::Index v = 0; v < n; ++v)
    if (used[v] && !held[part[v]])
      throw InvalidInput(
          concat("the part of the mesh around vertex ", v,
                 " has no fixed vertex and no handle, so its place is open; select some of it"));
  const bool soft = options.soft_weight > 0;
  for (Eigen::Index v = 0; v < n; ++v)
    // A vertex without triangles is nothing to the energy: it stays unless it is constrained.
    if (soft ? used[v] != 0 || index_of_known[v] >= 0 : index_of_known[v] < 0 && used[v] != 0) {
      index_of_unknown[v] = static_cast<int>(self.unknowns.size());
      self.unknowns.push_back(static_cast<int>(v));
    }
  // The mass of a vertex whose triangles have no area is bounded, so that its row stays finite.
  const double least = 1e-8 * mass.sum() / static_cast<double>(std::max<Eigen::Index>(n, 1));
  self.inverse_mass = mass.cwiseMax(least > 0 ? least : 1.0).cwiseInverse();
  self.rest_vectors = self.K * positions;

  const bool gauss_newton = options.detail == DetailPreservation::GaussNewton;
  self.bending = options.energy == DeformationEnergy::Stretch ? 0 : 1;
  // GaussNewton adds λ_2 times the bending energy (2.67) to the matrix; Stretch has none to compare it with
  // and takes it at the size of the mesh.
  const double detail = gauss_newton ? options.detail_weight : 0;
  if (options.energy == DeformationEnergy::Stretch) {
    self.second_order = self.K;
    if (gauss_newton) {
      const double length = options.bending_length * self.diameter;
      if (length > 0) self.second_order /= length * length;
    }
  }
  if (options.energy == DeformationEnergy::Combined) {
    const double length = options.bending_length * self.diameter;
    if (length > 0) self.second_order = self.K / (length * length);
  }
  if (gauss_newton && options.membrane_length > 0 && self.diameter > 0) {
    const double length = options.membrane_length * self.diameter;
    self.membrane = self.K * (detail / (length * length));
  }
  const auto factorize = [&] {
    SparseMatrix T = self.second_order;
    if (self.membrane.nonZeros() > 0) T = T.nonZeros() > 0 ? SparseMatrix(T + self.membrane) : self.membrane;
    self.factorize(self.bending + detail, T, index_of_unknown, index_of_known, progress);
  };
  if (options.energy == DeformationEnergy::TotalCurvature && options.curvature_term > 0) {
    const Curvatures curvatures = discrete_curvatures(positions, triangles);
    Eigen::VectorXd G = Eigen::VectorXd::Zero(n);
    for (Eigen::Index v = 0; v < n; ++v)
      if (!curvatures.on_border[v])
        G[v] = std::max(0.0, curvatures.mean[v] * curvatures.mean[v] - curvatures.gaussian[v]);
    const SparseMatrix K_G = weighted_stiffness(self.K, G);
    // The second variation of (2.60) is positive only where curved regions are small; halve the term until
    // the whole is. Seven halvings leave less than a hundredth: then it is dropped.
    self.curvature_term = options.curvature_term;
    for (int halving = 0;; ++halving) {
      if (halving == 7) self.curvature_term = 0;
      self.second_order = SparseMatrix(-2 * self.curvature_term * K_G);
      if (self.curvature_term == 0) self.second_order = SparseMatrix(n, n);
      try {
        factorize();
        break;
      } catch (const SolverFailure&) {
        if (self.curvature_term == 0) throw;
      }
      self.curvature_term /= 2;
    }
  } else {
    factorize();
  }
  if (options.detail == DetailPreservation::None) self.find_regions(triangles, index_of_known);
  if (gauss_newton) {
    self.dual = std::make_unique<DualLaplacian>(positions, triangles, self.rest_vectors);
    for (Eigen::Index v = 0; v < n; ++v)
      if (!self.dual->followed()[v] && used[v]) self.not_followed.push_back(static_cast<int>(v));
  }
}

Deformer::~Deformer() = default;
Deformer::Deformer(Deformer&&) noexcept = default;
Deformer& Deformer::operator=(Deformer&&) noexcept = default;

Deformer::Result Deformer::deform(const Points& targets, const Points* start,
                                  const Progress& progress) const {
  const Implementation& self = *implementation_;
  const Eigen::Index n = self.rest.rows();
  if (targets.rows() != static_cast<Eigen::Index>(self.constrained.size()))
    throw InvalidInput(concat("there are ", self.constrained.size(), " constrained vertices, but ",
                              targets.rows(), " targets"));
  for (Eigen::Index c = 0; c < targets.rows(); ++c)
    if (!targets.row(c).allFinite())
      throw InvalidInput(concat("the target of vertex ", self.constrained[c], " is not finite"));
  if (start != nullptr && start->rows() != n)
    throw InvalidInput(concat("the start has ", start->rows(), " positions, but the mesh ", n, " vertices"));

  progress.report("deforming", 0);
  Result result;
  if (start != nullptr) {
    result.positions = *start;
  } else {
    Points displacements = targets;
    for (std::size_t c = 0; c < self.constrained.size(); ++c)
      displacements.row(static_cast<Eigen::Index>(c)) -= self.rest.row(self.constrained[c]);
    if (!self.respond(displacements, result.positions)) {
      const Points zero = Points::Zero(n, 3);
      result.positions = self.rest + self.solve(zero, displacements, zero);
    }
  }
  if (self.options.detail == DetailPreservation::None) {
    if (start != nullptr) return deform(targets, nullptr, progress);
    return result;
  }

  const bool gauss_newton = self.options.detail == DetailPreservation::GaussNewton;
  const Points constant = gauss_newton ? self.displacement_forces() : Points();
  std::vector<Matrix3d> rotations;
  AndersonAcceleration acceleration(kAccelerationDepth);
  double damping = 1, last_move = std::numeric_limits<double>::infinity();
  result.report.converged = false;
  const auto report = [&] {
    progress.report("deforming", static_cast<double>(result.report.iterations) / self.options.max_iterations);
  };
  while (!result.report.converged && result.report.iterations < self.options.max_iterations) {
    Points next;
    if (gauss_newton) {
      next = self.solve(Points(constant + self.detail_forces(result.positions, rotations)), targets,
                        result.positions);
    } else {
      fit_local_rotations(self.K, self.rest, result.positions, rotations);
      report();
      next = self.solve(self.turned_rest(rotations), targets, result.positions);
    }
    const double move = (next - result.positions).rowwise().norm().maxCoeff();
    ++result.report.iterations;
    result.report.last_move = self.diameter > 0 ? move / self.diameter : 0;
    result.report.converged = result.report.last_move <= self.options.tolerance;
    if (result.report.converged) {
      result.positions = std::move(next);
    } else if (gauss_newton) {
      // This alternation is not bound to descend: on irregular triangles the steps may begin to swing. Then
      // they are shortened, which leaves the solution, where the step is zero, in its place. (Acceleration
      // by past steps was tried and swings as well.)
      damping = move < 0.95 * last_move ? std::min(1.0, 1.05 * damping) : std::max(0.05, 0.7 * damping);
      if (damping < 1)
        result.positions += damping * (next - result.positions);
      else
        result.positions = std::move(next);
    } else {
      // Far from the solution, and where it has led astray, the past says nothing.
      const bool accelerate = result.report.iterations > kPlainIterations;
      if (!accelerate || move > 1.1 * last_move) acceleration.forget();
      acceleration.advance(result.positions, next, accelerate ? kMixing : 1);
    }
    last_move = move;
    report();
  }
  return result;
}

const std::vector<int>& Deformer::constrained() const {
  return implementation_->constrained;
}
double Deformer::curvature_term() const {
  return implementation_->curvature_term;
}

}  // namespace batten
