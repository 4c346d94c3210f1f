#include "batten/implicit/hermite_field.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

/// ∂/∂y_k φ(x − y) along w: −3 r d·w, d = x − y.
double slope_kernel(const Eigen::Vector3d& d, double r, const Eigen::Vector3d& w) {
  return -3 * r * d.dot(w);
}

/// Second derivative of φ(x − y), along v in x and w in y: −3 (r v·w + (d·v)(d·w)/r).
double curvature_kernel(const Eigen::Vector3d& d, double r, const Eigen::Vector3d& v,
                        const Eigen::Vector3d& w) {
  return r > 0 ? -3 * (r * v.dot(w) + d.dot(v) * d.dot(w) / r) : 0;
}

Eigen::Vector3d slope_direction(const FieldConditions& conditions, Eigen::Index k) {
  return (k % 2 == 0 ? conditions.across : conditions.aside).row(k / 2);
}

/// Sites whose distances are taken at a time: enough for vector instructions, few enough for the stack.
constexpr Eigen::Index kBlock = 128;
using Block = Eigen::Array<double, kBlock, 1>;

constexpr double kUnit = 1e-6;  // how far from 1 the length of a unit vector may be

}  // namespace

HermiteField::HermiteField(const Points& sites, const Eigen::VectorXd& values, const Points& slopes,
                           const Eigen::Vector4d& affine)
    : sites_(sites.array()), slopes_(slopes.array()), values_(values.array()), affine_(affine) {}

double HermiteField::value(const Eigen::Vector3d& x) const {
  const Eigen::Index m = sites_.rows(), n = slopes_.rows();
  double f = affine_.head<3>().dot(x) + affine_[3];
  Block r, along;
  for (Eigen::Index i = 0; i < m; i += kBlock) {
    const Eigen::Index count = std::min(kBlock, m - i);
    const auto dx = x[0] - sites_.col(0).segment(i, count);
    const auto dy = x[1] - sites_.col(1).segment(i, count);
    const auto dz = x[2] - sites_.col(2).segment(i, count);
    r.head(count) = (dx.square() + dy.square() + dz.square()).sqrt();
    const auto r_i = r.head(count);
    f += (values_.segment(i, count) * r_i * r_i * r_i).sum();
    const Eigen::Index sloped = std::min(count, n - i);
    if (sloped <= 0) continue;
    along.head(sloped) = dx.head(sloped) * slopes_.col(0).segment(i, sloped) +
                         dy.head(sloped) * slopes_.col(1).segment(i, sloped) +
                         dz.head(sloped) * slopes_.col(2).segment(i, sloped);
    f -= 3 * (r.head(sloped) * along.head(sloped)).sum();
  }
  return f;
}

double HermiteField::value(const Eigen::Vector3d& x, Eigen::Vector3d& gradient) const {
  const Eigen::Index m = sites_.rows(), n = slopes_.rows();
  double f = affine_.head<3>().dot(x) + affine_[3];
  gradient = affine_.head<3>();
  for (Eigen::Index i = 0; i < m; ++i) {
    const Eigen::Vector3d d = x - sites_.row(i).matrix().transpose();
    const double r = d.norm();
    f += values_[i] * r * r * r;
    gradient += 3 * r * values_[i] * d;
    if (i >= n || r == 0) continue;
    const Eigen::Vector3d b = slopes_.row(i).matrix().transpose();
    const double db = d.dot(b);
    f -= 3 * r * db;
    gradient -= 3 * (db / r * d + r * b);
  }
  return f;
}

std::optional<std::string> FieldConditions::problem() const {
  const Eigen::Index m = sites.rows(), n = across.rows();
  if (m < 4) return concat("a field needs 4 sites or more, got ", m);
  if (values.size() != m || smoothing.size() != m)
    return concat(m, " sites need as many values and weights of smoothing, got ", values.size(), " and ",
                  smoothing.size());
  if (n > m || aside.rows() != n)
    return concat("directions of slopes: ", n, " across and ", aside.rows(), " aside for ", m, " sites");
  if (!sites.allFinite() || !values.allFinite()) return std::string("sites and values must be finite");
  for (Eigen::Index i = 0; i < m; ++i)
    if (!(smoothing[i] >= 0) || !std::isfinite(smoothing[i]))
      return concat("smoothing of site ", i, " must be 0 or more, got ", smoothing[i]);
  for (Eigen::Index i = 0; i < n; ++i)
    if (!(std::abs(across.row(i).norm() - 1) < kUnit) || !(std::abs(aside.row(i).norm() - 1) < kUnit) ||
        !(std::abs(across.row(i).dot(aside.row(i))) < kUnit))
      return concat("directions of slopes at site ", i, " must be perpendicular unit vectors");
  return std::nullopt;
}

SlopeEnergy::SlopeEnergy(FieldConditions conditions, const Progress& progress)
    : conditions_(std::move(conditions)) {
  if (const auto problem = conditions_.problem()) throw InvalidInput(*problem);
  const Points& sites = conditions_.sites;
  const Eigen::Index m = sites.rows(), n = 2 * conditions_.across.rows();
  // Values and the linear polynomial; slopes; between them.
  Eigen::MatrixXd A11 = Eigen::MatrixXd::Zero(m + 4, m + 4), A12(m + 4, n), A22(n, n);
  for (Eigen::Index j = 0; j < m; ++j) {
    for (Eigen::Index i = 0; i < m; ++i) {
      const double r = (sites.row(i) - sites.row(j)).norm();
      A11(i, j) = r * r * r;
    }
    A11(j, j) = conditions_.smoothing[j];
    A11.block<3, 1>(m, j) = sites.row(j).transpose();
    A11(m + 3, j) = 1;
    A11.block<1, 4>(j, m) = A11.block<4, 1>(m, j).transpose();
  }
  progress.report("field", 0.05);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Vector3d w = slope_direction(conditions_, k);
    for (Eigen::Index i = 0; i < m; ++i) {
      const Eigen::Vector3d d = (sites.row(i) - sites.row(k / 2)).transpose();
      A12(i, k) = slope_kernel(d, d.norm(), w);
    }
    A12.block<3, 1>(m, k) = w;
    A12(m + 3, k) = 0;
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::Vector3d d = (sites.row(i / 2) - sites.row(k / 2)).transpose();
      A22(i, k) = curvature_kernel(d, d.norm(), slope_direction(conditions_, i), w);
    }
  }
  progress.report("field", 0.1);
  const Eigen::PartialPivLU<Eigen::MatrixXd> factor(A11);
  progress.report("field", 0.3);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(m + 4);
  right.head(m) = conditions_.values;
  value_weights_ = factor.solve(right);
  coupling_ = factor.solve(A12);
  progress.report("field", 0.6);
  inverse_ = A22;
  inverse_.noalias() -= A12.transpose() * coupling_;
  inverse_ = (0.5 * (inverse_ + inverse_.transpose())).eval();
  progress.report("field", 0.75);
  const Eigen::LLT<Eigen::MatrixXd> slopes(inverse_);
  if (!value_weights_.allFinite() || (n > 0 && slopes.info() != Eigen::Success))
    throw SolverFailure("the field through the strokes", m + n);
  hessian_ = slopes.solve(Eigen::MatrixXd::Identity(n, n));
  free_slopes_ = A12.transpose() * value_weights_;
  pull_ = -(hessian_ * free_slopes_);
  progress.report("field", 1);
}

HermiteField SlopeEnergy::field(const Eigen::VectorXd& slopes) const {
  const Eigen::Index m = conditions_.sites.rows(), n = conditions_.across.rows();
  const Eigen::VectorXd b = hessian_ * (slopes - free_slopes_);
  const Eigen::VectorXd a = value_weights_ - coupling_ * b;
  Points vectors(n, 3);
  for (Eigen::Index j = 0; j < n; ++j)
    vectors.row(j) = b[2 * j] * conditions_.across.row(j) + b[2 * j + 1] * conditions_.aside.row(j);
  return {conditions_.sites, a.head(m), vectors, a.tail<4>()};
}

}  // namespace batten
