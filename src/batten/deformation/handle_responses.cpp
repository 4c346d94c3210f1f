#include <Eigen/Dense>

#include "batten/deformation/deformation_matrices_detail.hpp"
#include "batten/deformation/handle_responses_detail.hpp"

namespace batten::detail {

HandleResponses::HandleResponses(const ConstrainedSystem& system, const Points& rest,
                                 const Triangles& triangles, double diameter)
    : system_(system), rest_(rest) {
  find_regions(triangles);
  for (const auto& region : regions_) set_basis(*region, diameter);
}

void HandleResponses::find_regions(const Triangles& triangles) {
  constexpr std::size_t kMostRegions = 8;
  const std::size_t n_constrained = system_.constrained().size();
  Triangles inside(triangles.rows(), 3);  // edges between constraints, as triangles that repeat a corner
  Eigen::Index count = 0;
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    Eigen::RowVector3i known_corners;
    int held = 0;
    for (int k = 0; k < 3; ++k)
      if (const int row = system_.constraint_of()[triangles(f, k)]; row >= 0) known_corners[held++] = row;
    if (held < 2) continue;
    if (held == 2) known_corners[2] = known_corners[1];
    inside.row(count++) = known_corners;
  }
  const std::vector<int> part =
      connected_parts(inside.topRows(count), static_cast<Eigen::Index>(n_constrained));
  std::vector<int> region_of(n_constrained, -1);
  for (std::size_t row = 0; row < n_constrained; ++row) {
    int& region = region_of[part[row]];
    if (region < 0) {
      region = static_cast<int>(regions_.size());
      if (regions_.size() == kMostRegions) {
        regions_.clear();
        return;
      }
      regions_.push_back(std::make_unique<Region>());
    }
    regions_[region]->rows.push_back(static_cast<Eigen::Index>(row));
  }
}

void HandleResponses::set_basis(Region& region, double diameter) const {
  const auto m = static_cast<Eigen::Index>(region.rows.size());
  Eigen::MatrixXd affine(m, 4);
  for (Eigen::Index i = 0; i < m; ++i) affine.row(i) << 1, rest_.row(system_.constrained()[region.rows[i]]);
  affine.rightCols(3).rowwise() -= affine.rightCols(3).colwise().mean().eval();
  if (diameter > 0) affine.rightCols(3) /= diameter;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(affine);
  qr.setThreshold(1e-9);  // flat and straight regions, and single vertices, span less than four
  region.basis = qr.householderQ() * Eigen::MatrixXd::Identity(m, qr.rank());
}

bool HandleResponses::respond(const Points& displacements, Points& X) const {
  if (regions_.empty()) return false;
  const double rounding = 1e-13 * (rest_.cwiseAbs().maxCoeff() + displacements.cwiseAbs().maxCoeff());
  X = rest_;
  for (const auto& region : regions_) {
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
      const RowMajor zero = RowMajor::Zero(rest_.rows(), r);
      region->response = system_.solve(zero, values, zero);
    });
    X.noalias() += region->response * coefficients;
  }
  return true;
}

}  // namespace batten::detail
