#include "batten/linalg/sparse_cholesky.hpp"

#include <algorithm>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/SparseCholesky>

#include "batten/core/error.hpp"

#ifdef BATTEN_HAS_CHOLMOD
#include <cholmod.h>

#include "batten/linalg/background_detail.hpp"
#include "batten/linalg/serial_blas_detail.hpp"
#endif

namespace batten {

namespace {

/// The pattern of the matrix last analysed, to know whether its ordering can be used again.
struct Pattern {
  std::vector<int> outer, inner;
  bool matches(const SparseMatrix& A) const {
    return static_cast<Eigen::Index>(outer.size()) == A.outerSize() + 1 &&
           static_cast<Eigen::Index>(inner.size()) == A.nonZeros() &&
           std::equal(outer.begin(), outer.end(), A.outerIndexPtr()) &&
           std::equal(inner.begin(), inner.end(), A.innerIndexPtr());
  }
  void take(const SparseMatrix& A) {
    outer.assign(A.outerIndexPtr(), A.outerIndexPtr() + A.outerSize() + 1);
    inner.assign(A.innerIndexPtr(), A.innerIndexPtr() + A.nonZeros());
  }
};

class Factor {
 public:
  virtual ~Factor() = default;
  virtual bool factorize(const SparseMatrix& A, bool same_pattern) = 0;
  virtual bool solve(const Eigen::MatrixXd& B, Eigen::MatrixXd& X) const = 0;
};

/// Backward and forward substitution with a unit lower triangular L in column-major storage, `Columns`
/// columns of right-hand sides at a time: row by row they lie side by side, so that the factor is read once
/// for all of them. Every column sees the same operations in the same order as if it were alone.
template <int Columns>
void substitute(const SparseMatrix& L, const Eigen::VectorXd& diagonal, const Eigen::VectorXi& place_of,
                const Eigen::MatrixXd& B, Eigen::Index first, Eigen::MatrixXd& X,
                std::vector<double>& buffer) {
  using Row = Eigen::Map<Eigen::Matrix<double, 1, Columns>>;
  const Eigen::Index n = L.rows();
  const int* const outer = L.outerIndexPtr();
  const int* const inner = L.innerIndexPtr();
  const int* const counts = L.innerNonZeroPtr();
  const double* const value = L.valuePtr();
  const auto end_of = [&](Eigen::Index j) { return counts != nullptr ? outer[j] + counts[j] : outer[j + 1]; };
  buffer.resize(static_cast<std::size_t>(n) * Columns);
  double* const work = buffer.data();
  for (int c = 0; c < Columns; ++c)
    for (Eigen::Index i = 0; i < n; ++i) work[place_of[i] * Columns + c] = B(i, first + c);
  for (Eigen::Index j = 0; j < n; ++j) {
    const Eigen::Matrix<double, 1, Columns> solved = Row(work + j * Columns);
    if ((solved.array() == 0).all()) continue;
    for (int e = outer[j]; e < end_of(j); ++e)
      Row(work + Eigen::Index{inner[e]} * Columns) -= value[e] * solved;
  }
  for (Eigen::Index j = 0; j < n; ++j) Row(work + j * Columns) *= 1 / diagonal[j];
  for (Eigen::Index j = n; j-- > 0;) {
    Eigen::Matrix<double, 1, Columns> sum = Row(work + j * Columns);
    for (int e = outer[j]; e < end_of(j); ++e) sum -= value[e] * Row(work + Eigen::Index{inner[e]} * Columns);
    Row(work + j * Columns) = sum;
  }
  for (int c = 0; c < Columns; ++c)
    for (Eigen::Index i = 0; i < n; ++i) X(i, first + c) = work[place_of[i] * Columns + c];
}

class EigenFactor : public Factor {
 public:
  bool factorize(const SparseMatrix& A, bool same_pattern) override {
    if (!same_pattern) ldlt_.analyzePattern(A);
    ldlt_.factorize(A);
    // An indefinite matrix passes LDLᵀ; a positive definite one has a positive diagonal.
    return ldlt_.info() == Eigen::Success && (A.rows() == 0 || ldlt_.vectorD().minCoeff() > 0);
  }
  bool solve(const Eigen::MatrixXd& B, Eigen::MatrixXd& X) const override {
    if (ldlt_.info() != Eigen::Success) return false;
    X.resize(B.rows(), B.cols());
    std::vector<double> buffer;
    for (Eigen::Index first = 0; first < B.cols();) first += substitute_next(B, first, X, buffer);
    return true;
  }

 private:
  /// As many of the columns from `first` on as go at a time. @return how many.
  int substitute_next(const Eigen::MatrixXd& B, Eigen::Index first, Eigen::MatrixXd& X,
                      std::vector<double>& buffer) const {
    const auto with = [&](auto columns) {
      substitute<columns()>(ldlt_.matrixL().nestedExpression(), ldlt_.vectorD(),
                            ldlt_.permutationP().indices(), B, first, X, buffer);
      return columns();
    };
    const Eigen::Index left = B.cols() - first;
    if (left >= 8) return with(std::integral_constant<int, 8>());
    if (left >= 6) return with(std::integral_constant<int, 6>());
    if (left >= 3) return with(std::integral_constant<int, 3>());
    if (left >= 2) return with(std::integral_constant<int, 2>());
    return with(std::integral_constant<int, 1>());
  }

  Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower> ldlt_;
};

#ifdef BATTEN_HAS_CHOLMOD
class CholmodFactor : public Factor {
 public:
  CholmodFactor() {
    cholmod_start(&common_);
    common_.print = 0;
    common_.nmethods = 1;  // the ordering is chosen in analyze()
    common_.postorder = 1;
    common_.supernodal = CHOLMOD_SUPERNODAL;
  }
  ~CholmodFactor() override {
    cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }
  CholmodFactor(const CholmodFactor&) = delete;
  CholmodFactor& operator=(const CholmodFactor&) = delete;

  bool factorize(const SparseMatrix& A, bool same_pattern) override {
    const linalg_detail::SerialBlas serial;
    cholmod_sparse view = sparse_view(A);
    if (!same_pattern || factor_ == nullptr) {
      cholmod_free_factor(&factor_, &common_);
      factor_ = analyze(view);
      if (factor_ == nullptr) return false;
    }
    cholmod_factorize(&view, factor_, &common_);
    return common_.status == CHOLMOD_OK && factor_->minor == factor_->n;
  }

  bool solve(const Eigen::MatrixXd& B, Eigen::MatrixXd& X) const override {
    const linalg_detail::SerialBlas serial;
    cholmod_dense right{};
    right.nrow = B.rows();
    right.ncol = B.cols();
    right.nzmax = B.size();
    right.d = B.rows();
    right.x = const_cast<double*>(B.data());
    right.xtype = CHOLMOD_REAL;
    right.dtype = CHOLMOD_DOUBLE;
    cholmod_dense* solution = cholmod_solve(CHOLMOD_A, factor_, &right, &common_);
    if (solution == nullptr) return false;
    X = Eigen::Map<const Eigen::MatrixXd>(static_cast<const double*>(solution->x), B.rows(), B.cols());
    cholmod_free_dense(&solution, &common_);
    return true;
  }

 private:
  /// Minimum degree, and nested dissection where that leaves much to do: it takes longer to find than minimum
  /// degree but keeps the work of a plane grid of n unknowns at n^1.5. Depends on nothing but the pattern.
  cholmod_factor* analyze(cholmod_sparse& view) {
    // Operations of a factorisation per entry of the matrix from which nested dissection pays for itself at
    // once; seen on the bi-Laplacian of surfaces and on the frames of large networks, where it saved half and
    // 99 % of them.
    constexpr double kMuchWork = 15000;
    common_.method[0].ordering = CHOLMOD_AMD;
    cholmod_factor* factor = cholmod_analyze(&view, &common_);
    if (factor == nullptr || common_.fl < kMuchWork * common_.anz) return factor;
    const double work = common_.fl;
    common_.method[0].ordering = CHOLMOD_METIS;
    cholmod_factor* dissected = cholmod_analyze(&view, &common_);
    if (dissected != nullptr && common_.fl < work) std::swap(factor, dissected);
    cholmod_free_factor(&dissected, &common_);
    common_.status = CHOLMOD_OK;  // a failed second trial is no failure
    return factor;
  }

  static cholmod_sparse sparse_view(const SparseMatrix& A) {
    cholmod_sparse view{};
    view.nrow = A.rows();
    view.ncol = A.cols();
    view.nzmax = A.nonZeros();
    view.p = const_cast<int*>(A.outerIndexPtr());
    view.i = const_cast<int*>(A.innerIndexPtr());
    view.x = const_cast<double*>(A.valuePtr());
    view.stype = -1;  // symmetric, lower triangle read
    view.itype = CHOLMOD_INT;
    view.xtype = CHOLMOD_REAL;
    view.dtype = CHOLMOD_DOUBLE;
    view.sorted = 1;
    view.packed = 1;
    return view;
  }

  mutable cholmod_common common_{};
  cholmod_factor* factor_ = nullptr;
};
#endif

/// Factorises here, or on another thread while this one reports (see SparseCholesky::factorize()).
bool run_factorization(const std::shared_ptr<Factor>& factor, const SparseMatrix& A, bool same_pattern,
                       CholeskyBackend backend, const Progress& progress) {
#ifdef BATTEN_HAS_CHOLMOD
  if (backend == CholeskyBackend::Cholmod && !progress.is_silent() &&
      A.rows() >= SparseCholesky::kCholmodFrom)
    return linalg_detail::run_in_background(
        [factor, A, same_pattern] { return factor->factorize(A, same_pattern); }, progress);
#else
  static_cast<void>(backend);
#endif
  progress.report("factorisation", 0);
  return factor->factorize(A, same_pattern);
}

}  // namespace

struct SparseCholesky::Implementation {
  std::string system;
  CholeskyBackend requested;
  CholeskyBackend used = CholeskyBackend::Eigen;
  std::shared_ptr<Factor> factor;  ///< shared with the thread that fills it
  Pattern pattern;
  Eigen::Index unknowns = 0;
  bool ready = false;
};

SparseCholesky::SparseCholesky(std::string system, CholeskyBackend backend)
    : implementation_(std::make_unique<Implementation>()) {
  implementation_->system = std::move(system);
  implementation_->requested = backend;
}

SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

bool SparseCholesky::has_cholmod() {
#ifdef BATTEN_HAS_CHOLMOD
  return true;
#else
  return false;
#endif
}

void SparseCholesky::factorize(const SparseMatrix& A, const Progress& progress) {
  if (!try_factorize(A, progress)) throw SolverFailure(implementation_->system, A.rows());
}

bool SparseCholesky::try_factorize(const SparseMatrix& A, const Progress& progress) {
  Implementation& self = *implementation_;
  self.ready = false;
  self.unknowns = A.rows();
  if (A.rows() != A.cols()) throw SolverFailure(self.system, A.rows());
  if (A.rows() == 0) return self.ready = true;
  if (!A.isCompressed()) {
    SparseMatrix compressed = A;
    compressed.makeCompressed();
    return try_factorize(compressed, progress);
  }
  const CholeskyBackend wanted =
      has_cholmod() && (self.requested == CholeskyBackend::Cholmod ||
                        (self.requested == CholeskyBackend::Auto && A.rows() >= kCholmodFrom))
          ? CholeskyBackend::Cholmod
          : CholeskyBackend::Eigen;
  const bool same_pattern = self.factor && wanted == self.used && self.pattern.matches(A);
  if (!self.factor || wanted != self.used) {
#ifdef BATTEN_HAS_CHOLMOD
    if (wanted == CholeskyBackend::Cholmod) self.factor = std::make_shared<CholmodFactor>();
#endif
    if (wanted == CholeskyBackend::Eigen) self.factor = std::make_shared<EigenFactor>();
    self.used = wanted;
  }
  if (!same_pattern) self.pattern.take(A);
  // Taken out until it is whole: what is cancelled belongs to the thread that still fills it.
  std::shared_ptr<Factor> factor = std::exchange(self.factor, nullptr);
  self.ready = run_factorization(factor, A, same_pattern, wanted, progress);
  self.factor = std::move(factor);
  return self.ready;
}

Eigen::MatrixXd SparseCholesky::solve(const Eigen::MatrixXd& B) const {
  const Implementation& self = *implementation_;
  Eigen::MatrixXd X;
  if (!self.ready || B.rows() != self.unknowns) throw SolverFailure(self.system, self.unknowns);
  if (B.rows() == 0) return B;
  if (!self.factor->solve(B, X) || !X.allFinite()) throw SolverFailure(self.system, self.unknowns);
  return X;
}

Eigen::Index SparseCholesky::unknowns() const {
  return implementation_->unknowns;
}
CholeskyBackend SparseCholesky::backend() const {
  return implementation_->used;
}

}  // namespace batten
