#include <algorithm>

#include <Eigen/Geometry>

#include "batten/linalg/sparse_cholesky.hpp"
#include "batten/mesh/predicates.hpp"
#include "batten/modelling/face_splitter_detail.hpp"
#include "batten/modelling/plane_detail.hpp"

namespace batten::detail {

using Eigen::Index;
using Eigen::Vector2d;

namespace {

/// A vertex so near to the wanted direction of a cut will do.
constexpr double kNearCut = 0.14 * kPi;

}  // namespace

FaceSplit FaceSplitter::run(double widest) {
  begin();
  widest_ = widest;
  divide_piece(whole_face());
  return result();
}

std::vector<int> FaceSplitter::parts_at_concave_corners() {
  begin();
  const std::vector<Chain> whole = whole_face();
  const size_t n = whole.size();
  std::vector<std::vector<double>> feet(n);  // per side: along it, 0 to 1
  for (size_t c = 0; c < n; ++c) {
    if (!concave_[c] || n < 4) continue;
    const Vector2d here = p(whole[c][0]), next = p(whole[c][1]) - here;
    const double angle = angle_at(whole, c);
    const auto turned = [&](double by) -> Vector2d { return Eigen::Rotation2Dd(by) * next.normalized(); };
    std::vector<double> cuts;  // that are there, as angles from the next side
    for (size_t k = 0; k < n; ++k)
      if (k != c && (k + 1) % n != c && (c + 1) % n != k && is_inside(whole, c, k))
        cuts.push_back(angle_between(next, p(whole[k][0]) - here));
    const auto has = [&](double low, double high) {
      return std::any_of(cuts.begin(), cuts.end(), [&](double cut) { return cut > low && cut < high; });
    };
    if (has(angle - kWideFrom, kWideFrom)) continue;
    for (const double wanted : {angle - kPi, kPi}) {
      if (has(wanted - kNearCut, wanted + kNearCut)) continue;
      if (const auto [side, along] = first_hit(here, turned(wanted)); side >= 0)
        feet[at(side)].push_back(along);
    }
  }
  std::vector<int> parts(n, 1);
  for (size_t k = 0; k < n; ++k)
    if (!feet[k].empty()) parts[k] = parts_through(feet[k]);
  return parts;
}

FaceSplit FaceSplitter::run_grid(const std::vector<size_t>& corners) {
  begin();
  fill_grid(corners);
  FaceSplit split = result();
  split.is_grid = true;
  return split;
}

double FaceSplitter::shape() const {
  double sum = 0, area = 0;
  for (const std::array<int, 4>& quad : quads_)
    for (const std::array<int, 3>& t : cut_along_corners(quad)) {
      const Vector2d a = p(t[1]) - p(t[0]), b = p(t[2]) - p(t[1]), c = p(t[0]) - p(t[2]);
      const double own = cross_in_plane(a, b) / 2;
      sum += own * 4 * std::sqrt(3.0) * own / (a.squaredNorm() + b.squaredNorm() + c.squaredNorm());
      area += own;
    }
  return sum / area;
}

void FaceSplitter::begin() {
  positions_.clear();
  for (Index i = 0; i < boundary_.rows(); ++i) positions_.push_back(boundary_.row(i));
  quads_.clear();
  cuts_.clear();
  n_pieces_ = 0;
}

std::vector<FaceSplitter::Chain> FaceSplitter::whole_face() {
  std::vector<Chain> whole;
  for (int k = 0; k < n_sides_; ++k) {
    Chain chain;
    for (int i = 0; i <= m_; ++i) chain.push_back((k * m_ + i) % static_cast<int>(boundary_.rows()));
    whole.push_back(std::move(chain));
  }
  concave_.assign(whole.size(), 0);
  for (size_t k = 0; k < whole.size(); ++k) concave_[k] = angle_at(whole, k) > kReflexFrom;
  return whole;
}

std::pair<int, double> FaceSplitter::first_hit(const Vector2d& from, const Vector2d& direction) const {
  std::pair<int, double> hit(-1, 0);
  double nearest = std::numeric_limits<double>::infinity();
  const Index n = boundary_.rows();
  for (Index i = 0; i < n; ++i) {
    const Vector2d a = boundary_.row(i), b = boundary_.row((i + 1) % n);
    const double det = cross_in_plane(direction, b - a);
    if (std::abs(det) <= 1e-12 * (b - a).norm()) continue;
    const double distance = cross_in_plane(a - from, b - a) / det,
                 share = cross_in_plane(a - from, direction) / det;
    if (share < 0 || share > 1 || distance < 1e-6 * (b - a).norm() || distance >= nearest) continue;
    nearest = distance;
    hit = {static_cast<int>(i) / m_, (static_cast<double>(i % m_) + share) / m_};
  }
  return hit;
}

int FaceSplitter::parts_through(std::vector<double> feet) {
  std::sort(feet.begin(), feet.end());
  feet.erase(std::unique(feet.begin(), feet.end(), [](double a, double b) { return b - a < 0.1; }),
             feet.end());
  const int fewest = std::min(static_cast<int>(feet.size()) + 1, 4);
  int best = fewest;
  double least = 1;
  for (int parts = fewest; parts <= 4; ++parts) {
    double worst = 0;
    for (const double foot : feet)
      worst =
          std::max(worst, std::abs(foot - std::clamp(std::round(foot * parts), 1.0, parts - 1.0) / parts));
    if (worst < 0.6 * least) least = worst, best = parts;
  }
  return best;
}

FaceSplit FaceSplitter::result() const {
  FaceSplit split;
  split.domain.resize(static_cast<Index>(positions_.size()), 2);
  for (size_t v = 0; v < positions_.size(); ++v)
    split.domain.row(static_cast<Index>(v)) = positions_[v].transpose();
  split.n_boundary = static_cast<int>(boundary_.rows());
  split.quads = quads_;
  split.n_pieces = n_pieces_;
  split.cuts = cuts_;
  return split;
}

int FaceSplitter::add(const Vector2d& position) {
  positions_.push_back(position);
  return static_cast<int>(positions_.size()) - 1;
}

double FaceSplitter::angle_at(const std::vector<Chain>& piece, size_t k) const {
  const Chain& next = piece[k];
  const Chain& last = piece[(k + piece.size() - 1) % piece.size()];
  const auto reach = static_cast<size_t>(reach_);
  return angle_between(p(next[reach]) - p(next[0]), p(last[last.size() - 1 - reach]) - p(next[0]));
}

double FaceSplitter::angle_between(const Vector2d& a, const Vector2d& b) {
  const double angle = std::atan2(cross_in_plane(a, b), a.dot(b));
  return angle < 0 ? angle + 2 * kPi : angle;
}

bool FaceSplitter::is_inside(const std::vector<Chain>& piece, size_t a, size_t b) const {
  const Vector2d from = p(piece[a][0]), to = p(piece[b][0]);
  const Chain& last = piece[(a + piece.size() - 1) % piece.size()];
  const double start = angle_between(p(piece[a][1]) - from, to - from),
               whole = angle_between(p(piece[a][1]) - from, p(last[last.size() - 2]) - from);
  if (!(start > 0.1) || !(start < whole - 0.1)) return false;
  for (const Chain& chain : piece)
    for (size_t i = 0; i + 1 < chain.size(); ++i) {
      const int v = chain[i], w = chain[i + 1];
      if (v == piece[a][0] || v == piece[b][0] || w == piece[a][0] || w == piece[b][0]) continue;
      // On the line itself lie sides that end where it begins: they only meet it if they overlap it.
      const int side_v = orient2d(from, to, p(v)), side_w = orient2d(from, to, p(w));
      if (side_v == 0 && side_w == 0) {
        const auto along = [&](int end) { return (p(end) - from).dot(to - from); };
        if (std::max(along(v), along(w)) > 0 && std::min(along(v), along(w)) < (to - from).squaredNorm())
          return false;
      } else if (side_v * side_w <= 0 && orient2d(p(v), p(w), from) * orient2d(p(v), p(w), to) <= 0) {
        return false;
      }
    }
  return true;
}

void FaceSplitter::divide_piece(std::vector<Chain> piece) {
  const size_t n = piece.size();
  double worst = 0;
  size_t reflex = n;
  for (size_t k = 0; std::isfinite(widest_) && n > 3 && k < n; ++k) {
    const double angle = angle_at(piece, k), from = is_concave(piece[k][0]) ? widest_ : kReflexFrom;
    if (angle > std::max(from, worst) + 1e-6) worst = angle, reflex = k;
  }
  size_t to = n;
  double best = std::numeric_limits<double>::infinity();
  for (size_t k = 0; reflex < n && k < n; ++k) {
    if (k == reflex || (k + 1) % n == reflex || (reflex + 1) % n == k) continue;
    if (!is_inside(piece, reflex, k)) continue;
    // The line should halve the concave corner, leave no concave corners at its other end, and be short.
    const Vector2d line = p(piece[k][0]) - p(piece[reflex][0]);
    const double first = angle_between(p(piece[reflex][1]) - p(piece[reflex][0]), line), rest = worst - first;
    const double other = angle_at(piece, k), before = angle_between(p(piece[k][1]) - p(piece[k][0]), -line),
                 after = other - before;
    const auto excess = [](double angle) { return std::max(0.0, angle - 1.02 * kPi); };
    const auto lack = [](double angle) { return std::max(0.0, kPi / 4 - angle); };
    double concave = 0;
    for (const double angle : {first, rest, before, after}) concave += excess(angle) + 0.5 * lack(angle);
    const double cost = line.norm() * (1 + 4 * concave);
    if (cost < best * (1 - 1e-6)) best = cost, to = k;
  }
  if (to == n) {
    fill_piece(piece);
    return;
  }
  Chain line{piece[reflex][0]};
  for (int i = 1; i < m_; ++i) {
    const double t = static_cast<double>(i) / m_;
    line.push_back(add((1 - t) * p(piece[reflex][0]) + t * p(piece[to][0])));
  }
  line.push_back(piece[to][0]);
  const bool both_concave = is_concave(piece[to][0]);
  Chain back(line.rbegin(), line.rend());
  cuts_.push_back({line[0], line[1]});
  if (both_concave) cuts_.push_back({back[0], back[1]});
  std::vector<Chain> first{line}, second{back};
  for (size_t k = to; k != reflex; k = (k + 1) % n) first.push_back(piece[k]);
  for (size_t k = reflex; k != to; k = (k + 1) % n) second.push_back(piece[k]);
  divide_piece(std::move(first));
  divide_piece(std::move(second));
}

void FaceSplitter::fill_piece(const std::vector<Chain>& piece) {
  const size_t n = piece.size();
  const int half = m_ / 2, first_inner = static_cast<int>(positions_.size());
  const size_t first_quad = quads_.size();
  Vector2d sum = Vector2d::Zero();
  double length = 0;
  for (const Chain& chain : piece)
    for (size_t i = 0; i + 1 < chain.size(); ++i) {
      const double step = (p(chain[i + 1]) - p(chain[i])).norm();
      sum += step * (p(chain[i]) + p(chain[i + 1])) / 2;
      length += step;
    }
  const int centre = add(sum / length);
  std::vector<Chain> spokes(n);  // from the middle of each side to the centroid
  for (size_t k = 0; k < n; ++k) {
    const int middle = piece[k][at(half)];
    spokes[k].push_back(middle);
    for (int i = 1; i < half; ++i) {
      const double t = static_cast<double>(i) / half;
      spokes[k].push_back(add((1 - t) * p(middle) + t * p(centre)));
    }
    spokes[k].push_back(centre);
  }
  for (size_t k = 0; k < n; ++k) {  // the quad at the start of side k
    const size_t before = (k + n - 1) % n;
    Eigen::MatrixXi grid(half + 1, half + 1);  // i along side k, j along the side before, backwards
    for (int i = 0; i <= half; ++i) {
      grid(i, 0) = piece[k][at(i)];
      grid(0, i) = piece[before][piece[before].size() - 1 - at(i)];
      grid(half, i) = spokes[k][at(i)];
      grid(i, half) = spokes[before][at(i)];
    }
    const auto q = [&](int i, int j) -> const Vector2d& { return p(grid(i, j)); };
    for (int j = 1; j < half; ++j)
      for (int i = 1; i < half; ++i) {
        const double u = static_cast<double>(i) / half, v = static_cast<double>(j) / half;
        const Vector2d position = (1 - v) * q(i, 0) + v * q(i, half) + (1 - u) * q(0, j) + u * q(half, j) -
                                  (1 - u) * (1 - v) * q(0, 0) - u * (1 - v) * q(half, 0) -
                                  (1 - u) * v * q(0, half) - u * v * q(half, half);
        grid(i, j) = add(position);
      }
    for (int j = 0; j < half; ++j)
      for (int i = 0; i < half; ++i)
        quads_.push_back({grid(i, j), grid(i + 1, j), grid(i + 1, j + 1), grid(i, j + 1)});
  }
  ++n_pieces_;
  if (folded(first_quad)) relax(first_quad, first_inner);
}

void FaceSplitter::fill_grid(const std::vector<size_t>& corners) {
  const int n = static_cast<int>(boundary_.rows()), first_inner = n;
  const auto vertex = [&](size_t corner) { return static_cast<int>(corners[corner]) * m_; };
  const int columns = vertex(1) - vertex(0), rows = vertex(2) - vertex(1);
  Eigen::MatrixXi grid(columns + 1, rows + 1);
  for (int i = 0; i <= columns; ++i) {
    grid(i, 0) = vertex(0) + i;
    grid(i, rows) = vertex(3) - i;
  }
  for (int j = 0; j <= rows; ++j) {
    grid(columns, j) = vertex(1) + j;
    grid(0, j) = (vertex(3) + rows - j) % n;
  }
  const auto q = [&](int i, int j) -> const Vector2d& { return p(grid(i, j)); };
  for (int j = 1; j < rows; ++j)
    for (int i = 1; i < columns; ++i) {
      const double u = static_cast<double>(i) / columns, v = static_cast<double>(j) / rows;
      grid(i, j) = add((1 - v) * q(i, 0) + v * q(i, rows) + (1 - u) * q(0, j) + u * q(columns, j) -
                       (1 - u) * (1 - v) * q(0, 0) - u * (1 - v) * q(columns, 0) - (1 - u) * v * q(0, rows) -
                       u * v * q(columns, rows));
    }
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      std::array<int, 4> quad{grid(i, j), grid(i + 1, j), grid(i + 1, j + 1), grid(i, j + 1)};
      const bool right = i % m_ >= m_ / 2, upper = j % m_ >= m_ / 2;
      std::rotate(quad.begin(), quad.begin() + (right ? (upper ? 2 : 1) : (upper ? 3 : 0)), quad.end());
      quads_.push_back(quad);
    }
  n_pieces_ = 1;
  if (folded(0)) relax(0, first_inner);
}

bool FaceSplitter::folded(size_t from) const {
  for (size_t q = from; q < quads_.size(); ++q)
    for (const std::array<int, 3>& t : cut_along_corners(quads_[q]))
      if (orient2d(p(t[0]), p(t[1]), p(t[2])) <= 0) return true;
  return false;
}

void FaceSplitter::relax(size_t first_quad, int first_inner) {
  const int n = static_cast<int>(positions_.size()) - first_inner;
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(n, 2);
  for (size_t q = first_quad; q < quads_.size(); ++q)
    for (const std::array<int, 3>& t : cut_along_corners(quads_[q]))
      for (int k = 0; k < 3; ++k) {
        const int v = t[static_cast<size_t>(k)], w = t[static_cast<size_t>((k + 1) % 3)];
        for (const auto& [a, b] : {std::pair(v, w), std::pair(w, v)}) {
          if (a < first_inner) continue;
          entries.emplace_back(a - first_inner, a - first_inner, 1.0);
          if (b < first_inner)
            right.row(a - first_inner) += p(b).transpose();
          else
            entries.emplace_back(a - first_inner, b - first_inner, -1.0);
        }
      }
  SparseMatrix A(n, n);
  A.setFromTriplets(entries.begin(), entries.end());
  SparseCholesky solver("layout of a face", CholeskyBackend::Eigen);
  solver.factorize(A);
  const Eigen::MatrixXd solved = solver.solve(right);
  for (int v = 0; v < n; ++v) positions_[at(first_inner + v)] = solved.row(v);
}

}  // namespace batten::detail
