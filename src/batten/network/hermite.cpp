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
#include "batten/curves/clamped_spline.hpp"
#include "batten/linalg/sparse_cholesky.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

namespace {

using Vector = Eigen::Vector3d;

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
  return (u / h - h / (h + k) * (v / k - u / h)).normalized();
}

Eigen::Index piece_of(const Eigen::VectorXd& knots, double parameter) {
  const auto place =
      std::upper_bound(knots.data(), knots.data() + knots.size(), parameter) - knots.data() - 1;
  return std::clamp<Eigen::Index>(place, 0, knots.size() - 2);
}

/// The unknown vectors at every node and how the ends of segments are made of them.
struct NodeUnknowns {
  struct EndPlace {
    int node, index;
  };
  /// Part of the tangent at an end, in the direction of the walk.
  struct Term {
    int unknown;
    Vector value;
  };
  std::vector<std::vector<End>> ends;           // per node
  std::vector<NodeFrame> frames;                // per node
  std::vector<std::array<EndPlace, 2>> places;  // per segment
  int n_unknowns = 0;

  /// The tangent at an end of a segment in the unknowns.
  std::vector<Term> terms(size_t segment, size_t which) const {
    const EndPlace& place = places[segment][which];
    const End& end = ends[at(place.node)][at(place.index)];
    const NodeFrame& frame = frames[at(place.node)];
    std::vector<Term> terms;
    for (size_t k = 0; k < 2; ++k)
      if (end.vectors[k] >= 0)
        for (int d = 0; d < frame.dimension; ++d)
          terms.push_back({frame.first_vector + end.vectors[k] * frame.dimension + d,
                           (end.at_last ? -1 : 1) * end.coefficients[k] * frame.basis.col(d)});
    return terms;
  }
};

/// The directions that tangents at a node may have: all, or those perpendicular to its normal.
NodeFrame frame_of_node(const CurveNetwork& network, int vertex) {
  NodeFrame frame;
  frame.basis = Eigen::Matrix3d::Identity();
  if (!network.has_normals()) return frame;
  const Vector normal = network.normals.row(vertex);
  if (!(normal.norm() > 0))
    throw InvalidInput(
        concat("the normal of vertex ", vertex, ", a node, has no length; give it a direction"));
  const Vector u = normal.unitOrthogonal();
  frame.basis.col(0) = u;
  frame.basis.col(1) = normal.normalized().cross(u);
  frame.dimension = 2;
  return frame;
}

/// All ends at even angles around the node: two vectors for any number of ends.
void share_even_angles(std::vector<End>& ends, NodeFrame& frame) {
  const auto degree = static_cast<int>(ends.size());
  std::vector<std::pair<double, int>> order;
  for (int e = 0; e < degree; ++e) {
    const Vector& d = ends[at(e)].direction;
    order.emplace_back(std::atan2(d.dot(frame.basis.col(1)), d.dot(frame.basis.col(0))), e);
  }
  std::sort(order.begin(), order.end());
  for (int mu = 0; mu < degree; ++mu) {
    End& end = ends[at(order[at(mu)].second)];
    end.vectors = {0, 1};
    end.coefficients = {std::cos(2 * kPi * mu / degree), std::sin(2 * kPi * mu / degree)};
  }
  frame.n_vectors = 2;
}

/// One vector for each pair that passes through, one for each end that is left.
void share_through_pairs(std::vector<End>& ends, const std::vector<std::array<int, 2>>& pairs,
                         NodeFrame& frame) {
  for (const auto& pair : pairs) {
    for (int k = 0; k < 2; ++k) {
      End& end = ends[at(pair[at(k)])];
      end.vectors[0] = frame.n_vectors;
      end.coefficients[0] = k == 0 ? 1 : -1;
    }
    ++frame.n_vectors;
  }
  for (End& end : ends)
    if (end.vectors[0] < 0) {
      end.vectors[0] = frame.n_vectors++;
      end.coefficients[0] = 1;
    }
}

NodeUnknowns node_unknowns(const CurveNetwork& network, const NetworkTopology& topology,
                           const std::vector<HermiteSegment>& segments, const HermiteOptions& options) {
  NodeUnknowns unknowns;
  unknowns.ends.resize(topology.nodes.size());
  unknowns.places.resize(topology.segments.size());
  for (int s = 0; s < static_cast<int>(topology.segments.size()); ++s)
    for (const bool at_last : {false, true}) {
      const NetworkSegment& segment = topology.segments[at(s)];
      const int node = at_last ? segment.to : segment.from;
      std::vector<End>& there = unknowns.ends[at(node)];
      unknowns.places[at(s)][at_last ? 1 : 0] = {node, static_cast<int>(there.size())};
      there.push_back({s, at_last, end_direction(segments[at(s)], at_last)});
    }
  for (size_t node = 0; node < unknowns.ends.size(); ++node) {
    std::vector<End>& ends = unknowns.ends[node];
    NodeFrame frame = frame_of_node(network, topology.nodes[node]);
    frame.first_vector = unknowns.n_unknowns;
    const auto pairs = through_pairs(ends, segments, options.corner_angle);
    if (options.node_tangents == NodeTangents::EvenAngles &&
        (ends.size() > 3 || (ends.size() == 3 && pairs.empty())))
      share_even_angles(ends, frame);
    else
      share_through_pairs(ends, pairs, frame);
    unknowns.n_unknowns += frame.n_vectors * frame.dimension;
    unknowns.frames.push_back(frame);
  }
  return unknowns;
}

/// The tangents of least bending for the knots of the segments: the quadratic energies of all splines in the
/// unknowns of the nodes, one solve, then one tridiagonal system per segment.
void set_tangents(std::vector<HermiteSegment>& segments, const NodeUnknowns& unknowns,
                  SparseCholesky& solver) {
  using Term = NodeUnknowns::Term;
  std::vector<ClampedSpline> splines;
  splines.reserve(segments.size());
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns.n_unknowns);
  for (size_t s = 0; s < segments.size(); ++s) {
    splines.emplace_back(segments[s].points, segments[s].knots);
    const ClampedSpline& spline = splines.back();
    const std::array<std::vector<Term>, 2> terms{unknowns.terms(s, 0), unknowns.terms(s, 1)};
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
  SparseMatrix H(unknowns.n_unknowns, unknowns.n_unknowns);
  H.setFromTriplets(entries.begin(), entries.end());
  Eigen::VectorXd u;
  if (unknowns.n_unknowns > 0) {
    solver.factorize(H);
    u = solver.solve(right);
  }
  for (size_t s = 0; s < segments.size(); ++s) {
    Vector tangents[2] = {Vector::Zero(), Vector::Zero()};
    for (size_t i = 0; i < 2; ++i)
      for (const Term& term : unknowns.terms(s, i)) tangents[i] += u(term.unknown) * term.value;
    segments[s].tangents = splines[s].tangents(tangents[0], tangents[1]);
  }
}

/// (C.3) of pieces whose x'' is linear: h (|p|² + p·q + |q|²)/3 with its values p, q at both ends of each.
double bending_energy(const HermiteSegment& segment) {
  double energy = 0;
  for (Eigen::Index k = 0; k + 1 < segment.knots.size(); ++k) {
    const double h = segment.knots(k + 1) - segment.knots(k);
    const Eigen::RowVector3d slope = (segment.points.row(k + 1) - segment.points.row(k)) / h;
    const Eigen::RowVector3d p =
        (6 * slope - 4 * segment.tangents.row(k) - 2 * segment.tangents.row(k + 1)) / h;
    const Eigen::RowVector3d q =
        (-6 * slope + 2 * segment.tangents.row(k) + 4 * segment.tangents.row(k + 1)) / h;
    energy += h * (p.squaredNorm() + p.dot(q) + q.squaredNorm()) / 3;
  }
  return energy;
}

/// Arc length at every knot, along the cubics.
Eigen::VectorXd arc_lengths_of(const HermiteSegment& segment) {
  Eigen::VectorXd knots(segment.knots.size());
  knots(0) = 0;
  for (Eigen::Index k = 0; k + 1 < knots.size(); ++k) knots(k + 1) = knots(k) + segment.piece(k).length();
  return knots;
}

}  // namespace

HermiteCubic HermiteSegment::piece(Eigen::Index i) const {
  return {knots(i + 1) - knots(i), points.row(i), points.row(i + 1), tangents.row(i), tangents.row(i + 1)};
}

Vector HermiteSegment::position(double parameter) const {
  const Eigen::Index i = piece_of(knots, parameter);
  const HermiteCubic cubic = piece(i);
  return cubic.at((parameter - knots(i)) / cubic.width).transpose();
}

Vector HermiteSegment::derivative(double parameter) const {
  const Eigen::Index i = piece_of(knots, parameter);
  const HermiteCubic cubic = piece(i);
  return cubic.derivative((parameter - knots(i)) / cubic.width).transpose();
}

Vector HermiteSegment::second_derivative(double parameter) const {
  const Eigen::Index i = piece_of(knots, parameter);
  const HermiteCubic cubic = piece(i);
  return cubic.second_derivative((parameter - knots(i)) / cubic.width).transpose();
}

double HermiteSegment::length() const {
  double sum = 0;
  for (Eigen::Index i = 0; i + 1 < knots.size(); ++i) sum += piece(i).length();
  return sum;
}

std::optional<std::string> HermiteOptions::problem() const {
  if (!(corner_angle > 0)) return concat("corner_angle must be above 0, got ", corner_angle);
  if (parameter_rounds < 0) return concat("parameter_rounds must be at least 0, got ", parameter_rounds);
  return std::nullopt;
}

HermiteNetwork hermite_network(const CurveNetwork& network, const HermiteOptions& options) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  network_topology(network);  // checks the indices before they are used
  const double diameter = bounding_box_diagonal(network.positions);
  const NetworkTopology topology = network_topology(with_corners(network, options.corner_angle));
  HermiteNetwork result;
  for (const NetworkSegment& segment : topology.segments)
    result.segments.push_back(prepared(network, segment, diameter));
  const NodeUnknowns unknowns = node_unknowns(network, topology, result.segments, options);
  SparseCholesky solver("Hermite network");
  for (int round = 0; round <= options.parameter_rounds; ++round) {
    set_tangents(result.segments, unknowns, solver);
    result.energy = 0;
    for (const HermiteSegment& segment : result.segments) result.energy += bending_energy(segment);
    if (round < options.parameter_rounds)
      for (HermiteSegment& segment : result.segments) segment.knots = arc_lengths_of(segment);
  }
  return result;
}

}  // namespace batten
