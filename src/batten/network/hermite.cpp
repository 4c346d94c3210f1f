#include "batten/network/hermite.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/linalg/sparse_cholesky.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

namespace {

using Vector = Eigen::Vector3d;

/// Five-point Gauss–Legendre on [0, 1]; exact for polynomials of degree 9.
constexpr std::array<double, 5> kGaussPlaces = {0.046910077030668, 0.230765344947158, 0.5, 0.769234655052842,
                                                0.953089922969332};
constexpr std::array<double, 5> kGaussWeights = {0.118463442528095, 0.239314335249683, 0.284444444444444,
                                                 0.239314335249683, 0.118463442528095};

/// The clamped C² spline through given points as it depends on its end tangents a and b (derivatives by the
/// parameter). Its bending energy ∫|x''|² is quadratic in them; with x'' at the ends its gradient is
/// ∂E/∂a = −2 x''(0), ∂E/∂b = +2 x''(L), which for uniform knots is (C.19).
class ClampedSpline {
 public:
  ClampedSpline(const Points& points, const Eigen::VectorXd& knots)
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

  /// E(a, b) = aa |a|² + 2 ab a·b + bb |b|² − 2 pull_a·a − 2 pull_b·b + constant
  double aa() const { return energy_aa_; }
  double ab() const { return energy_ab_; }
  double bb() const { return energy_bb_; }
  Vector pull_a() const { return pull_a_; }
  Vector pull_b() const { return pull_b_; }

  Points tangents(const Vector& a, const Vector& b) const {
    const Eigen::Index n = points_.rows() - 2;
    Points t(n + 2, 3);
    t.row(0) = a.transpose();
    t.row(n + 1) = b.transpose();
    for (Eigen::Index i = n; i-- > 0;)
      t.row(i + 1) = data_.row(i) + from_a_(i) * a.transpose() - ratio_(i) * t.row(i + 2);
    return t;
  }

 private:
  struct Affine {
    Eigen::RowVector3d constant;
    double a, b;
  };
  const Points& points_;
  Eigen::VectorXd h_, ratio_, from_a_;
  Points slopes_, data_;
  Affine first_, last_;
  double energy_aa_ = 0, energy_ab_ = 0, energy_bb_ = 0;
  Vector pull_a_, pull_b_;
};

/// One end of a segment at a node. Its tangent, pointing away from the node, is Σ coefficient · vector.
struct End {
  int segment;
  bool at_last;
  Vector direction;  // estimated, of unit length, away from the node
  std::array<int, 2> vectors{-1, -1};
  std::array<double, 2> coefficients{0, 0};
};

struct NodeFrame {
  Eigen::Matrix3d basis;  // columns span the directions allowed; the first `dimension` of them
  int dimension = 3;
  int first_vector = 0;
  int n_vectors = 0;
};

/// Pairs the ends at a node that pass through it: those of one curve first, then the straightest.
std::vector<std::array<int, 2>> through_pairs(const std::vector<End>& ends,
                                              const std::vector<HermiteSegment>& segments,
                                              double corner_angle) {
  struct Candidate {
    bool foreign;
    double bend;
    int i, j;
  };
  std::vector<Candidate> candidates;
  for (int i = 0; i < static_cast<int>(ends.size()); ++i)
    for (int j = i + 1; j < static_cast<int>(ends.size()); ++j) {
      const End &a = ends[at(i)], &b = ends[at(j)];
      const double bend = std::acos(std::clamp(-a.direction.dot(b.direction), -1.0, 1.0));
      // Pieces of one curve that follow each other; the last and the first one of a closed curve too.
      const bool same_curve =
          segments[at(a.segment)].curve == segments[at(b.segment)].curve && a.at_last != b.at_last;
      if (bend < (same_curve ? corner_angle : 0.5 * corner_angle))
        candidates.push_back({!same_curve, bend, i, j});
    }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& x, const Candidate& y) {
    return std::tie(x.foreign, x.bend, x.i, x.j) < std::tie(y.foreign, y.bend, y.i, y.j);
  });
  std::vector<char> taken(ends.size(), 0);
  std::vector<std::array<int, 2>> pairs;
  for (const Candidate& candidate : candidates)
    if (!taken[at(candidate.i)] && !taken[at(candidate.j)]) {
      taken[at(candidate.i)] = taken[at(candidate.j)] = 1;
      pairs.push_back({candidate.i, candidate.j});
    }
  return pairs;
}

/// The network with corners inside curves tagged as nodes, so that no spline swings around them.
CurveNetwork with_corners(const CurveNetwork& network, double corner_angle) {
  CurveNetwork result = network;
  for (const NetworkCurve& curve : network.curves) {
    const auto n = static_cast<int>(curve.vertices.size());
    for (int k = curve.closed() ? 0 : 1; k + 1 < n; ++k) {
      const Eigen::RowVector3d p = network.positions.row(curve.vertices[at(k)]);
      const Eigen::RowVector3d before = p - network.positions.row(curve.vertices[at(k > 0 ? k - 1 : n - 2)]);
      const Eigen::RowVector3d after = network.positions.row(curve.vertices[at(k + 1)]) - p;
      if (std::atan2(before.cross(after).norm(), before.dot(after)) > corner_angle)
        result.tagged_nodes.push_back(curve.vertices[at(k)]);
    }
  }
  return result;
}

/// A segment's samples without those at the same place as the one before, with chord lengths as knots.
HermiteSegment prepared(const CurveNetwork& network, const NetworkSegment& segment, double diameter) {
  constexpr double kSamePlace = 1e-13;  // of the diameter: below the rounding of the coordinates
  HermiteSegment result;
  result.curve = segment.curve;
  std::vector<double> knots;
  const auto n = static_cast<int>(segment.vertices.size());
  for (int k = 0; k < n; ++k) {
    const Eigen::RowVector3d p = network.positions.row(segment.vertices[at(k)]);
    if (!result.vertices.empty()) {
      const double chord = (p - network.positions.row(result.vertices.back())).norm();
      if (chord <= kSamePlace * diameter) {
        if (k + 1 < n) continue;
        if (result.vertices.size() > 1) {  // the last sample is the node itself: the one before it goes
          result.vertices.pop_back();
          knots.pop_back();
        } else {
          throw InvalidInput(concat(curve_name(network, segment.curve), " has no length between vertex ",
                                    segment.vertices.front(), " and vertex ", segment.vertices.back(),
                                    "; remove it or merge the two"));
        }
      }
      knots.push_back(knots.back() + (p - network.positions.row(result.vertices.back())).norm());
    } else {
      knots.push_back(0);
    }
    result.vertices.push_back(segment.vertices[at(k)]);
  }
  result.knots = Eigen::Map<const Eigen::VectorXd>(knots.data(), static_cast<Eigen::Index>(knots.size()));
  result.points.resize(result.knots.size(), 3);
  for (Eigen::Index k = 0; k < result.knots.size(); ++k)
    result.points.row(k) = network.positions.row(result.vertices[static_cast<size_t>(k)]);
  return result;
}

/// The direction at the first (or last) point, inwards: of the parabola through the three points there.
Vector end_direction(const HermiteSegment& segment, bool at_last) {
  const Eigen::Index n = segment.points.rows();
  const auto point = [&](Eigen::Index k) { return Vector(segment.points.row(at_last ? n - 1 - k : k)); };
  const Vector u = point(1) - point(0);
  if (n < 3) return u.normalized();
  const Vector v = point(2) - point(1);
  const double h = u.norm(), k = v.norm();
  Vector direction = u / h - h / (h + k) * (v / k - u / h);
  // Where the curve turns sharply the parabola means nothing.
  if (direction.dot(u) <= 0.5 * direction.norm() * h) direction = u;
  return direction.normalized();
}

Eigen::Index piece_of(const Eigen::VectorXd& knots, double parameter) {
  const auto place =
      std::upper_bound(knots.data(), knots.data() + knots.size(), parameter) - knots.data() - 1;
  return std::clamp<Eigen::Index>(place, 0, knots.size() - 2);
}

}  // namespace

Vector HermiteSegment::position(double parameter) const {
  const Eigen::Index i = piece_of(knots, parameter);
  const double h = knots(i + 1) - knots(i), t = (parameter - knots(i)) / h, t2 = t * t, t3 = t2 * t;
  return ((2 * t3 - 3 * t2 + 1) * points.row(i) + h * (t3 - 2 * t2 + t) * tangents.row(i) +
          (3 * t2 - 2 * t3) * points.row(i + 1) + h * (t3 - t2) * tangents.row(i + 1))
      .transpose();
}

Vector HermiteSegment::derivative(double parameter) const {
  const Eigen::Index i = piece_of(knots, parameter);
  const double h = knots(i + 1) - knots(i), t = (parameter - knots(i)) / h, t2 = t * t;
  return ((6 * t2 - 6 * t) / h * (points.row(i) - points.row(i + 1)) +
          (3 * t2 - 4 * t + 1) * tangents.row(i) + (3 * t2 - 2 * t) * tangents.row(i + 1))
      .transpose();
}

Vector HermiteSegment::second_derivative(double parameter) const {
  const Eigen::Index i = piece_of(knots, parameter);
  const double h = knots(i + 1) - knots(i), t = (parameter - knots(i)) / h;
  return ((12 * t - 6) / (h * h) * (points.row(i) - points.row(i + 1)) + (6 * t - 4) / h * tangents.row(i) +
          (6 * t - 2) / h * tangents.row(i + 1))
      .transpose();
}

double HermiteSegment::piece_length(Eigen::Index i) const {
  const double h = knots(i + 1) - knots(i);
  double sum = 0;
  for (size_t g = 0; g < kGaussPlaces.size(); ++g) {
    const double t = kGaussPlaces[g], t2 = t * t;
    sum +=
        kGaussWeights[g] * ((6 * t2 - 6 * t) / h * (points.row(i) - points.row(i + 1)) +
                            (3 * t2 - 4 * t + 1) * tangents.row(i) + (3 * t2 - 2 * t) * tangents.row(i + 1))
                               .norm();
  }
  return h * sum;
}

double HermiteSegment::length() const {
  double sum = 0;
  for (Eigen::Index i = 0; i + 1 < knots.size(); ++i) sum += piece_length(i);
  return sum;
}

HermiteNetwork hermite_network(const CurveNetwork& network, const HermiteOptions& options) {
  network_topology(network);  // checks the indices before they are used
  const double diameter = bounding_box_diagonal(network.positions);
  const NetworkTopology topology = network_topology(with_corners(network, options.corner_angle));
  HermiteNetwork result;
  for (const NetworkSegment& segment : topology.segments)
    result.segments.push_back(prepared(network, segment, diameter));

  // The unknown vectors at every node and how the ends are made of them.
  std::vector<std::vector<End>> ends(topology.nodes.size());
  for (int s = 0; s < static_cast<int>(topology.segments.size()); ++s)
    for (const bool at_last : {false, true}) {
      const NetworkSegment& segment = topology.segments[at(s)];
      ends[at(at_last ? segment.to : segment.from)].push_back(
          {s, at_last, end_direction(result.segments[at(s)], at_last)});
    }
  std::vector<NodeFrame> frames(topology.nodes.size());
  int n_unknowns = 0;
  for (size_t node = 0; node < ends.size(); ++node) {
    NodeFrame& frame = frames[node];
    frame.basis = Eigen::Matrix3d::Identity();
    const int vertex = topology.nodes[node];
    if (network.has_normals()) {
      const Vector normal = network.normals.row(vertex);
      if (!(normal.norm() > 0))
        throw InvalidInput(
            concat("the normal of vertex ", vertex, ", a node, has no length; give it a direction"));
      const Vector u = normal.unitOrthogonal();
      frame.basis.col(0) = u;
      frame.basis.col(1) = normal.normalized().cross(u);
      frame.dimension = 2;
    }
    frame.first_vector = n_unknowns;
    const auto pairs = through_pairs(ends[node], result.segments, options.corner_angle);
    const int degree = static_cast<int>(ends[node].size());
    const bool even =
        options.node_tangents == NodeTangents::EvenAngles && (degree > 3 || (degree == 3 && pairs.empty()));
    if (even) {
      std::vector<std::pair<double, int>> order;
      for (int e = 0; e < degree; ++e) {
        const Vector& d = ends[node][at(e)].direction;
        order.emplace_back(std::atan2(d.dot(frame.basis.col(1)), d.dot(frame.basis.col(0))), e);
      }
      std::sort(order.begin(), order.end());
      for (int mu = 0; mu < degree; ++mu) {
        End& end = ends[node][at(order[at(mu)].second)];
        end.vectors = {0, 1};
        end.coefficients = {std::cos(2 * kPi * mu / degree), std::sin(2 * kPi * mu / degree)};
      }
      frame.n_vectors = 2;
    } else {
      for (const auto& pair : pairs) {
        for (int k = 0; k < 2; ++k) {
          End& end = ends[node][at(pair[at(k)])];
          end.vectors[0] = frame.n_vectors;
          end.coefficients[0] = k == 0 ? 1 : -1;
        }
        ++frame.n_vectors;
      }
      for (End& end : ends[node])
        if (end.vectors[0] < 0) {
          end.vectors[0] = frame.n_vectors++;
          end.coefficients[0] = 1;
        }
    }
    n_unknowns += frame.n_vectors * frame.dimension;
  }
  struct EndPlace {
    int node, index;
  };
  std::vector<std::array<EndPlace, 2>> places(topology.segments.size());
  for (int node = 0; node < static_cast<int>(ends.size()); ++node)
    for (int e = 0; e < static_cast<int>(ends[at(node)].size()); ++e)
      places[at(ends[at(node)][at(e)].segment)][ends[at(node)][at(e)].at_last ? 1 : 0] = {node, e};

  // Rows of the tangent at an end (in the direction of the walk) in the unknowns: 3 × few.
  struct Term {
    int unknown;
    Vector value;
  };
  const auto terms_of = [&](const EndPlace& place) {
    const End& end = ends[at(place.node)][at(place.index)];
    const NodeFrame& frame = frames[at(place.node)];
    std::vector<Term> terms;
    for (size_t k = 0; k < 2; ++k)
      if (end.vectors[k] >= 0)
        for (int d = 0; d < frame.dimension; ++d)
          terms.push_back({frame.first_vector + end.vectors[k] * frame.dimension + d,
                           (end.at_last ? -1 : 1) * end.coefficients[k] * frame.basis.col(d)});
    return terms;
  };
  SparseCholesky solver("Hermite network");
  for (int round = 0; round <= std::max(0, options.parameter_rounds); ++round) {
    std::vector<ClampedSpline> splines;
    splines.reserve(result.segments.size());
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n_unknowns);
    for (size_t s = 0; s < result.segments.size(); ++s) {
      splines.emplace_back(result.segments[s].points, result.segments[s].knots);
      const ClampedSpline& spline = splines.back();
      const std::array<std::vector<Term>, 2> terms{terms_of(places[s][0]), terms_of(places[s][1])};
      const double weights[2][2] = {{spline.aa(), spline.ab()}, {spline.ab(), spline.bb()}};
      const Vector pulls[2] = {spline.pull_a(), spline.pull_b()};
      for (size_t i = 0; i < 2; ++i)
        for (const Term& x : terms[i]) {
          right(x.unknown) += x.value.dot(pulls[i]);
          for (size_t j = 0; j < 2; ++j)
            for (const Term& y : terms[j])
              entries.emplace_back(x.unknown, y.unknown, weights[i][j] * x.value.dot(y.value));
        }
    }
    SparseMatrix H(n_unknowns, n_unknowns);
    H.setFromTriplets(entries.begin(), entries.end());
    Eigen::VectorXd u;
    if (n_unknowns > 0) {
      solver.factorize(H);
      u = solver.solve(right);
    }
    result.energy = 0;
    for (size_t s = 0; s < result.segments.size(); ++s) {
      HermiteSegment& segment = result.segments[s];
      Vector tangents[2] = {Vector::Zero(), Vector::Zero()};
      for (size_t i = 0; i < 2; ++i)
        for (const Term& term : terms_of(places[s][i])) tangents[i] += u(term.unknown) * term.value;
      segment.tangents = splines[s].tangents(tangents[0], tangents[1]);
      for (Eigen::Index k = 0; k + 1 < segment.knots.size(); ++k) {
        // (C.3) of a piece whose x'' is linear: h (|p|² + p·q + |q|²)/3 with its values p, q at both ends
        const double h = segment.knots(k + 1) - segment.knots(k);
        const Eigen::RowVector3d slope = (segment.points.row(k + 1) - segment.points.row(k)) / h;
        const Eigen::RowVector3d p =
            (6 * slope - 4 * segment.tangents.row(k) - 2 * segment.tangents.row(k + 1)) / h;
        const Eigen::RowVector3d q =
            (-6 * slope + 2 * segment.tangents.row(k) + 4 * segment.tangents.row(k + 1)) / h;
        result.energy += h * (p.squaredNorm() + p.dot(q) + q.squaredNorm()) / 3;
      }
    }
    if (round < options.parameter_rounds)
      for (HermiteSegment& segment : result.segments) {
        Eigen::VectorXd knots(segment.knots.size());
        knots(0) = 0;
        for (Eigen::Index k = 0; k + 1 < knots.size(); ++k) knots(k + 1) = knots(k) + segment.piece_length(k);
        segment.knots = knots;
      }
  }
  return result;
}

}  // namespace batten
