#include "batten/scan/integration.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Dense>

#include "batten/core/error.hpp"
#include "batten/core/parallel.hpp"
#include "batten/linalg/sparse_cholesky.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/rate_change_detail.hpp"

namespace batten {

namespace {

/// A piece of one curve between two shared vertices.
struct Segment {
  int curve;
  int begin, end;  ///< steps [begin, end)
  int from, to;    ///< vertices; to may be no node where the curve ends freely
  double length;
  Eigen::Vector3d sum;  ///< of its steps
};

std::vector<Segment> segments_of(const SampledScan& scan, const VertexNumbering& numbering,
                                 const std::vector<Points>& steps) {
  std::vector<Segment> segments;
  for (int c = 0; c < static_cast<int>(scan.curves.size()); ++c) {
    const SampledCurve& curve = scan.curves[c];
    const int n = curve.n_samples();
    int begin = 0;
    for (int k = 1; k < n; ++k) {
      if (numbering.vertices[c][k] >= numbering.n_nodes && k < n - 1) continue;
      Segment segment;
      segment.curve = c;
      segment.begin = begin;
      segment.end = k;
      segment.from = numbering.vertices[c][begin];
      segment.to = numbering.vertices[c][k];
      segment.length = curve.parameters[k] - curve.parameters[begin];
      segment.sum = steps[c].middleRows(begin, k - begin).colwise().sum().transpose();
      segments.push_back(segment);
      begin = k;
    }
  }
  return segments;
}

/// The second-difference form of one curve, condensed: with e_k = (x_{k+1} − x_k − d_k)/h_k the least value
/// of eᵀTe under Σ_{segment} h_k e_k = m_s. T is the path (or ring) Laplacian over the steps, with one more
/// on the diagonal at the free ends of an open curve. Time and memory are linear in the steps; besides they
/// grow as the third and second power of the segments of one curve, which all depend on each other.
///
/// On a ring T is singular: step 0 is taken out and its value becomes the unknown c, added to all. What is
/// left is, open or closed, the second-difference matrix with fixed ends, whose inverse is known:
/// T⁻¹_ij = (i + 1)(n − j)/(n + 1) for i ≤ j.
class CurveBending {
 public:
  CurveBending(const SampledCurve& curve, const std::vector<Segment>& segments, size_t first, size_t last)
      : curve_(curve),
        first_step_(curve.closed ? 1 : 0),
        n_(curve.n_samples() - 1 - first_step_),
        n_segments_(static_cast<int>(last - first)) {
    // G = LᵀT⁻¹L for the loads L, whose column s holds the steps h_k of segment s. T⁻¹ is a product on each
    // side of its diagonal, so two sums per segment give the couplings of different segments.
    Eigen::VectorXd rising = Eigen::VectorXd::Zero(n_segments_), falling = rising, own = rising,
                    lengths = rising;
    for (int s = 0; s < n_segments_; ++s) {
      const Segment& segment = segments[first + s];
      begins_.push_back(segment.begin);
      lengths[s] = segment.length;
      for (int k = std::max(segment.begin, first_step_); k < segment.end; ++k) {
        const double h = curve.step(k), up = k - first_step_ + 1.0, down = n_ + 1.0 - up;
        own[s] += h * down * (2 * rising[s] + h * up);
        rising[s] += h * up;
        falling[s] += h * down;
      }
    }
    begins_.push_back(curve.n_samples() - 1);
    const int n_multipliers = n_segments_ + first_step_;
    Eigen::MatrixXd system = Eigen::MatrixXd::Zero(n_multipliers, n_multipliers);
    for (int s = 0; s < n_segments_; ++s) {
      system(s, s) = own[s] / (n_ + 1);
      for (int t = s + 1; t < n_segments_; ++t)
        system(s, t) = system(t, s) = rising[s] * falling[t] / (n_ + 1);
    }
    if (curve.closed) {
      system.col(n_segments_).head(n_segments_) = lengths;
      system.row(n_segments_).head(n_segments_) = lengths.transpose();
    }
    const Eigen::MatrixXd inverse = system.completeOrthogonalDecomposition().pseudoInverse();
    multipliers_ = inverse.leftCols(n_segments_);
  }

  /// K with energy mᵀ K m, n_segments × n_segments.
  Eigen::MatrixXd stiffness() const { return multipliers_.topRows(n_segments_); }

  /// e = T⁻¹ L ν + c for the misfits m (n_segments × 3): n_steps × 3.
  Points strain(const Eigen::MatrixXd& misfits) const {
    const Eigen::MatrixXd nu = multipliers_ * misfits;
    Points e = Points::Zero(first_step_ + n_, 3);
    for (int s = 0; s < n_segments_; ++s)
      for (int k = std::max(begins_[s], first_step_); k < begins_[s + 1]; ++k)
        e.row(k) = curve_.step(k) * nu.row(s);
    solve(e);
    if (first_step_ > 0) e.rowwise() += nu.row(n_segments_);
    return e;
  }

 private:
  /// X ← T⁻¹ X by tridiagonal elimination (Thomas).
  void solve(Points& X) const {
    if (n_ <= 0) return;
    // Path: 1 + 1 on the diagonal everywhere (neighbour before or end row, neighbour after or end row).
    // Ring without step 0: the same.
    Eigen::VectorXd upper(n_);
    double pivot = 2;
    upper[0] = -1 / pivot;
    X.row(first_step_) /= pivot;
    for (int k = 1; k < n_; ++k) {
      pivot = 2 + upper[k - 1];
      upper[k] = -1 / pivot;
      X.row(first_step_ + k) = (X.row(first_step_ + k) + X.row(first_step_ + k - 1)) / pivot;
    }
    for (int k = n_ - 2; k >= 0; --k) X.row(first_step_ + k) -= upper[k] * X.row(first_step_ + k + 1);
  }

  const SampledCurve& curve_;
  int first_step_;  ///< of those that T is over
  int n_;           ///< how many those are
  int n_segments_;
  std::vector<int> begins_;  ///< first step of each segment, and the end
  Eigen::MatrixXd multipliers_;
};

/// Component of every vertex below `n`, by the segments; the number of components.
int count_components(int n, const std::vector<Segment>& segments) {
  std::vector<int> root(n);
  for (int i = 0; i < n; ++i) root[i] = i;
  const auto find = [&root](int i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  int components = n;
  for (const Segment& segment : segments) {
    const int a = find(segment.from), b = find(segment.to);
    if (a != b) root[a] = b, --components;
  }
  return components;
}

/// The steps of a scan as one linear system over its nodes and the free ends of its curves, which then places
/// the samples between them.
class StepIntegration {
 public:
  /// All must outlive this. @throws InvalidInput when the curves are not connected.
  StepIntegration(const SampledScan& scan, const std::vector<Points>& steps, ClosureForm form)
      : scan_(scan),
        steps_(steps),
        form_(form),
        numbering_(number_vertices(scan)),
        segments_(segments_of(scan, numbering_, steps)),
        slot_(numbering_.n_vertices, -1),
        range_of_curve_(scan.curves.size()) {
    number_slots();
    if (count_components(n_slots_, segments_) != 1)
      throw InvalidInput("the curves are not connected: positions of separate parts cannot be observed");
    right_ = Eigen::MatrixXd::Zero(n_slots_, 3);
    for (size_t s = 0; s < segments_.size();) {
      size_t end = s;
      while (end < segments_.size() && segments_[end].curve == segments_[s].curve) ++end;
      range_of_curve_[segments_[s].curve] = {s, end};
      s = end;
    }
  }

  IntegrationResult integrate() {
    for (size_t c = 0; c < scan_.curves.size(); ++c) couple_curve(c);
    solve_nodes();
    IntegrationResult result;
    result.positions.resize(numbering_.n_vertices, 3);
    for (int v = 0; v < numbering_.n_vertices; ++v)
      if (slot_[v] >= 0) result.positions.row(v) = nodes_.row(slot_[v]);
    measure_closure(result);
    parallel_for(static_cast<Eigen::Index>(scan_.curves.size()), 1,
                 [&](Eigen::Index begin, Eigen::Index end) {
                   for (Eigen::Index c = begin; c < end; ++c) place_samples(c, result.positions);
                 });
    const Eigen::RowVector3d origin = result.positions.row(0);
    result.positions.rowwise() -= origin;
    return result;
  }

 private:
  /// Free ends of curves are vertices of the condensed system as well; numbers what it needs.
  void number_slots() {
    for (const Segment& segment : segments_)
      for (const int vertex : {segment.from, segment.to})
        if (slot_[vertex] < 0) slot_[vertex] = n_slots_++;
    for (Segment& segment : segments_) segment.from = slot_[segment.from], segment.to = slot_[segment.to];
  }

  /// Adds k (x_to − x_from − Σd)_a · (x_to − x_from − Σd)_b.
  void couple(const Segment& a, const Segment& b, double k) {
    entries_.emplace_back(a.to, b.to, k);
    entries_.emplace_back(a.from, b.from, k);
    entries_.emplace_back(a.to, b.from, -k);
    entries_.emplace_back(a.from, b.to, -k);
    right_.row(a.to) += k * b.sum.transpose();
    right_.row(a.from) -= k * b.sum.transpose();
  }

  void couple_curve(size_t c) {
    const auto [first, last] = range_of_curve_[c];
    if (form_ == ClosureForm::FirstDifference) {
      for (size_t s = first; s < last; ++s) couple(segments_[s], segments_[s], 1 / segments_[s].length);
      return;
    }
    bending_.emplace_back(scan_.curves[c], segments_, first, last);
    const Eigen::MatrixXd K = bending_.back().stiffness();
    for (size_t a = first; a < last; ++a)
      for (size_t b = first; b < last; ++b)
        couple(segments_[a], segments_[b],
               K(static_cast<Eigen::Index>(a - first), static_cast<Eigen::Index>(b - first)));
  }

  /// The Laplacian over nodes and free ends. The first is held at the origin, or the matrix is singular.
  void solve_nodes() {
    nodes_ = Eigen::MatrixXd::Zero(n_slots_, 3);
    if (n_slots_ <= 1) return;
    std::vector<Eigen::Triplet<double>> free_entries;
    for (const Eigen::Triplet<double>& entry : entries_)
      if (entry.row() > 0 && entry.col() > 0)
        free_entries.emplace_back(entry.row() - 1, entry.col() - 1, entry.value());
    SparseMatrix L(n_slots_ - 1, n_slots_ - 1);
    L.setFromTriplets(free_entries.begin(), free_entries.end());
    SparseCholesky solver("positions of the nodes");
    solver.factorize(L);
    nodes_.bottomRows(n_slots_ - 1) = solver.solve(right_.bottomRows(n_slots_ - 1));
  }

  void measure_closure(IntegrationResult& result) const {
    result.n_loops = static_cast<int>(segments_.size()) - n_slots_ + 1;
    double squares = 0;
    for (const Segment& s : segments_) {
      const double misfit2 = (nodes_.row(s.to) - nodes_.row(s.from) - s.sum.transpose()).squaredNorm();
      result.closure_energy += misfit2 / s.length;
      squares += misfit2;
    }
    result.closure_misfit = std::sqrt(squares / static_cast<double>(segments_.size()));
  }

  /// The samples of a curve between its nodes: its steps, and its share of the misfits.
  void place_samples(Eigen::Index c, Points& positions) const {
    const SampledCurve& curve = scan_.curves[c];
    const auto [first, last] = range_of_curve_[c];
    Eigen::MatrixXd misfits(static_cast<Eigen::Index>(last - first), 3);
    for (size_t s = first; s < last; ++s)
      misfits.row(static_cast<Eigen::Index>(s - first)) =
          nodes_.row(segments_[s].to) - nodes_.row(segments_[s].from) - segments_[s].sum.transpose();
    Points strain(0, 3);
    if (form_ == ClosureForm::SecondDifference) strain = bending_[c].strain(misfits);
    for (size_t s = first; s < last; ++s) {
      Eigen::RowVector3d x = nodes_.row(segments_[s].from);
      const Eigen::RowVector3d rate = misfits.row(static_cast<Eigen::Index>(s - first)) / segments_[s].length;
      for (int k = segments_[s].begin; k + 1 < segments_[s].end; ++k) {
        const double h = curve.step(k);
        x += steps_[c].row(k);
        x += h * (strain.size() > 0 ? Eigen::RowVector3d(strain.row(k)) : rate);
        positions.row(numbering_.vertices[c][k + 1]) = x;
      }
    }
  }

  const SampledScan& scan_;
  const std::vector<Points>& steps_;
  ClosureForm form_;
  VertexNumbering numbering_;
  std::vector<Segment> segments_;  ///< from and to are slots once these are numbered
  std::vector<int> slot_;          ///< per vertex its unknown, or −1
  int n_slots_ = 0;
  std::vector<std::pair<size_t, size_t>> range_of_curve_;  ///< its segments
  std::vector<CurveBending> bending_;                      ///< second differences: per curve
  std::vector<Eigen::Triplet<double>> entries_;
  Eigen::MatrixXd right_, nodes_;  ///< n_slots × 3
};

}  // namespace

Eigen::Vector3d frame_step(const Eigen::Matrix3d& X, const Eigen::Matrix3d& Y, double h, StepRule rule) {
  if (rule == StepRule::Tangent) return h * X.col(0);
  // J(φ) = ∫₀¹ exp(u φ) du is the left Jacobian of SO(3), the right Jacobian at −φ.
  const Eigen::Vector3d phi = so3_log(X.transpose() * Y);
  return h * (X * so3_right_jacobian(-phi).col(0));
}

std::vector<Points> frame_steps(const SampledScan& scan, StepRule rule) {
  std::vector<Points> steps(scan.curves.size());
  for (size_t c = 0; c < scan.curves.size(); ++c) {
    const SampledCurve& curve = scan.curves[c];
    steps[c].resize(curve.n_samples() - 1, 3);
    parallel_for(curve.n_samples() - 1, 4096, [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index k = begin; k < end; ++k)
        steps[c].row(k) =
            frame_step(curve.frames[k], curve.frames[k + 1], curve.step(static_cast<int>(k)), rule);
    });
  }
  return steps;
}

std::vector<Points> fourth_order_steps(const SampledScan& scan) {
  std::vector<Points> steps = frame_steps(scan, StepRule::ConstantRate);
  for (size_t c = 0; c < scan.curves.size(); ++c) {
    const SampledCurve& curve = scan.curves[c];
    const int n = curve.n_samples() - 1;
    std::vector<Eigen::Vector3d> omega;
    std::vector<double> lengths;
    for (int k = 0; k < n; ++k) {
      lengths.push_back(curve.step(k));
      omega.push_back(so3_log(curve.frames[k].transpose() * curve.frames[k + 1]) / curve.step(k));
    }
    const std::vector<Eigen::Vector3d> changes = rate_changes(omega, lengths, curve.smooth_seam);
    for (int k = 0; k < n; ++k)
      steps[c].row(k) += step_of_rate_change(curve.frames[k], lengths[k] * omega[k], lengths[k],
                                             0.5 * (changes[k] + changes[k + 1]));
  }
  return steps;
}

IntegrationResult integrate_steps(const SampledScan& scan, const std::vector<Points>& steps,
                                  ClosureForm form) {
  return StepIntegration(scan, steps, form).integrate();
}

std::vector<Points> integrate_preview(const SampledScan& scan, StepRule rule) {
  const VertexNumbering numbering = number_vertices(scan);
  const std::vector<Points> steps = frame_steps(scan, rule);
  const int n_curves = static_cast<int>(scan.curves.size());
  std::vector<Points> lines(n_curves);
  std::map<int, Eigen::RowVector3d> placed;
  std::vector<char> done(n_curves, 0);
  for (int round = 0; round < n_curves; ++round) {
    // The first curve that touches what is placed, else the first left.
    int next = -1, anchor = 0;
    for (int c = 0; c < n_curves && next < 0; ++c) {
      if (done[c]) continue;
      for (const int k : scan.curves[c].node_samples) {
        if (next < 0 && placed.count(numbering.vertices[c][k]) > 0) next = c, anchor = k;
      }
    }
    for (int c = 0; c < n_curves && next < 0; ++c)
      if (!done[c]) next = c;
    const int n = scan.curves[next].n_samples();
    Points& line = lines[next];
    line.setZero(n, 3);
    for (int k = 0; k + 1 < n; ++k) line.row(k + 1) = line.row(k) + steps[next].row(k);
    const auto known = placed.find(numbering.vertices[next][anchor]);
    if (known != placed.end()) line.rowwise() += (known->second - line.row(anchor)).eval();
    for (int k = 0; k < n; ++k)
      if (numbering.vertices[next][k] < numbering.n_nodes)
        placed.emplace(numbering.vertices[next][k], line.row(k));
    done[next] = 1;
  }
  return lines;
}

double scan_size(const Points& positions) {
  if (positions.rows() == 0) return 0;
  const Eigen::RowVector3d centroid = positions.colwise().mean();
  return 2 * std::sqrt((positions.rowwise() - centroid).rowwise().squaredNorm().maxCoeff());
}

}  // namespace batten
