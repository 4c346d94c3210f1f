#include "batten/curves/clamped_spline.hpp"

namespace batten {

ClampedSpline::ClampedSpline(const Points& points, const Eigen::VectorXd& knots)
    : points_(points), h_(knots.tail(knots.size() - 1) - knots.head(knots.size() - 1)) {
  const Eigen::Index n = points.rows() - 2;  // inner points
  slopes_.resize(n + 1, 3);
  for (Eigen::Index i = 0; i <= n; ++i) slopes_.row(i) = (points.row(i + 1) - points.row(i)) / h_(i);
  // Rows of (C.5) for uneven knots: h_i t_{i−1} + 2 (h_{i−1} + h_i) t_i + h_{i−1} t_{i+1} = 3 (h_i s_{i−1}
  // + h_{i−1} s_i). Elimination from the front: t_i = data_i + from_a_i a − ratio_i t_{i+1}. The ratios
  // stay between 0 and 1, whatever n (the c_k of (C.15) overflow).
  ratio_.resize(n);
  from_a_.resize(n);
  data_.resize(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double before = h_(i), after = h_(i + 1);
    const Eigen::RowVector3d right = 3 * (after * slopes_.row(i) + before * slopes_.row(i + 1));
    double pivot = 2 * (before + after);
    Eigen::RowVector3d data = right;
    double from_a = i == 0 ? -after : 0;
    if (i > 0) {
      pivot -= after * ratio_(i - 1);
      data -= after * data_.row(i - 1);
      from_a -= after * from_a_(i - 1);
    }
    ratio_(i) = before / pivot;
    from_a_(i) = from_a / pivot;
    data_.row(i) = data / pivot;
  }
  // The tangents next to the ends as affine functions of a and b.
  double a_part = 0, b_part = 1;  // of t_{i+1}, walking back from b
  Eigen::RowVector3d constant = Eigen::RowVector3d::Zero();
  first_ = last_ = {constant, a_part, b_part};
  if (n == 0) first_ = {constant, 0, 1}, last_ = {constant, 1, 0};  // the other end itself
  for (Eigen::Index i = n; i-- > 0;) {
    constant = data_.row(i) - ratio_(i) * constant;
    a_part = from_a_(i) - ratio_(i) * a_part;
    b_part = -ratio_(i) * b_part;
    if (i == n - 1) last_ = {constant, a_part, b_part};
    if (i == 0) first_ = {constant, a_part, b_part};
  }
  // x''(0) = (6 s_0 − 4 a − 2 t_1)/h_0 and x''(L) = (−6 s_n + 2 t_n + 4 b)/h_n
  const double h0 = h_(0), hn = h_(n);
  energy_aa_ = (4 + 2 * first_.a) / h0;
  energy_ab_ = 2 * first_.b / h0;
  energy_bb_ = (4 + 2 * last_.b) / hn;
  pull_a_ = (6 * slopes_.row(0) - 2 * first_.constant) / h0;
  pull_b_ = (6 * slopes_.row(n) - 2 * last_.constant) / hn;
}

Points ClampedSpline::tangents(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const {
  const Eigen::Index n = points_.rows() - 2;
  Points t(n + 2, 3);
  t.row(0) = a.transpose();
  t.row(n + 1) = b.transpose();
  for (Eigen::Index i = n; i-- > 0;)
    t.row(i + 1) = data_.row(i) + from_a_(i) * a.transpose() - ratio_(i) * t.row(i + 2);
  return t;
}

}  // namespace batten
