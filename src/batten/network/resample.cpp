#include "batten/network/resample.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/curves/hermite_cubic.hpp"

namespace batten {

namespace {

using Vector = Eigen::Vector3d;

/// Normals along a segment: a cubic through those at the samples, brought back to the sphere. Fourth order
/// where the data are smooth; where neighbours are more than a right angle apart, the nearer of both.
class NormalInterpolant {
 public:
  NormalInterpolant(const CurveNetwork& network, const HermiteSegment& segment) : knots_(segment.knots) {
    const Eigen::Index n = knots_.size();
    normals_.resize(n, 3);
    for (Eigen::Index k = 0; k < n; ++k)
      normals_.row(k) = network.normals.row(segment.vertices[static_cast<size_t>(k)]);
    // Slopes of the parabola through three neighbours; at the ends the same parabola.
    slopes_.setZero(n, 3);
    if (n == 2) slopes_.rowwise() = (normals_.row(1) - normals_.row(0)) / (knots_(1) - knots_(0));
    for (Eigen::Index k = 0; k < n && n > 2; ++k) {
      const Eigen::Index m = std::clamp<Eigen::Index>(k, 1, n - 2);
      const double h = knots_(m) - knots_(m - 1), g = knots_(m + 1) - knots_(m);
      const Eigen::RowVector3d u = (normals_.row(m) - normals_.row(m - 1)) / h,
                               v = (normals_.row(m + 1) - normals_.row(m)) / g;
      const Eigen::RowVector3d second = (v - u) / (h + g);  // half the second derivative
      slopes_.row(k) = u + second * (h + 2 * (knots_(k) - knots_(m)));
    }
  }

  Vector at(double parameter) const {
    const Eigen::Index n = knots_.size();
    const Eigen::Index i = std::clamp<Eigen::Index>(
        std::upper_bound(knots_.data(), knots_.data() + n, parameter) - knots_.data() - 1, 0, n - 2);
    const double h = knots_(i + 1) - knots_(i), t = (parameter - knots_(i)) / h;
    if (normals_.row(i).dot(normals_.row(i + 1)) <= 0) return normals_.row(t < 0.5 ? i : i + 1);
    const HermiteCubic cubic{h, normals_.row(i), normals_.row(i + 1), slopes_.row(i), slopes_.row(i + 1)};
    return cubic.at(t).transpose().normalized();
  }

 private:
  const Eigen::VectorXd& knots_;
  Points normals_, slopes_;
};

/// The parameter at which a piece has the length `wanted`, by Newton's method kept inside a bracket.
double parameter_at_length(const HermiteSegment& segment, Eigen::Index piece, double wanted, double whole) {
  const double begin = segment.knots(piece), end = segment.knots(piece + 1);
  const HermiteCubic whole_piece = segment.piece(piece);
  const auto length_to = [&](double parameter) {  // of the piece up to a parameter, a cubic of its own
    return HermiteCubic{parameter - begin, whole_piece.begin, segment.position(parameter),
                        whole_piece.begin_slope, segment.derivative(parameter)}
        .length();
  };
  double low = begin, high = end, parameter = begin + (end - begin) * wanted / whole;
  for (int i = 0; i < 50; ++i) {
    if (!(parameter > low && parameter < high)) parameter = 0.5 * (low + high);
    if (!(parameter > low && parameter < high)) break;  // neighbouring numbers
    const double error = length_to(parameter) - wanted;
    if (std::abs(error) <= 1e-14 * whole) break;
    (error > 0 ? high : low) = parameter;
    const double speed = segment.derivative(parameter).norm();
    parameter -= speed > 0 ? error / speed : 0;
  }
  return parameter;
}

}  // namespace

CurveNetwork resampled(const CurveNetwork& network, double step, const HermiteOptions& options) {
  if (!(step > 0) || !std::isfinite(step))
    throw InvalidInput(concat("the step must be more than 0, got ", step));
  const HermiteNetwork splines = hermite_network(network, options);
  std::vector<double> lengths;
  double n_samples = 0;
  for (const HermiteSegment& segment : splines.segments) {
    lengths.push_back(segment.length());
    n_samples += lengths.back() / step + 1;
  }
  constexpr double kMost = 1e8;
  if (!(n_samples <= kMost))
    throw InvalidInput(concat("a step of ", step, " gives ", n_samples, " samples, more than ", kMost,
                              "; use a longer one"));

  CurveNetwork result;
  result.unit = network.unit;
  std::vector<Vector> positions, normals;
  const bool has_normals = network.has_normals();
  std::vector<int> number(static_cast<size_t>(network.positions.rows()), -1);  // of vertices that stay
  const auto kept = [&](int vertex) {
    int& k = number[static_cast<size_t>(vertex)];
    if (k < 0) {
      k = static_cast<int>(positions.size());
      positions.emplace_back(network.positions.row(vertex));
      if (has_normals) normals.emplace_back(network.normals.row(vertex));
    }
    return k;
  };
  for (const HermiteSegment& segment : splines.segments) {  // nodes first, in order of use
    kept(segment.vertices.front());
    kept(segment.vertices.back());
  }
  for (const NetworkCurve& curve : network.curves)
    result.curves.push_back({curve.name, curve.boundary, {}, curve.sharp});
  for (size_t s = 0; s < splines.segments.size(); ++s) {
    const HermiteSegment& segment = splines.segments[s];
    std::vector<int>& vertices = result.curves[static_cast<size_t>(segment.curve)].vertices;
    if (vertices.empty()) vertices.push_back(kept(segment.vertices.front()));
    const bool loop = segment.vertices.front() == segment.vertices.back();
    const auto n = std::max<Eigen::Index>(loop ? 3 : 1, std::llround(lengths[s] / step));
    Eigen::Index piece = 0;
    double before = 0, piece_length = segment.piece(0).length();
    std::vector<NormalInterpolant> interpolant;
    if (has_normals) interpolant.emplace_back(network, segment);
    for (Eigen::Index k = 1; k < n; ++k) {
      const double wanted = lengths[s] * static_cast<double>(k) / static_cast<double>(n);
      while (before + piece_length < wanted && piece + 2 < segment.knots.size()) {
        before += piece_length;
        piece_length = segment.piece(++piece).length();
      }
      const double parameter = parameter_at_length(segment, piece, wanted - before, piece_length);
      vertices.push_back(static_cast<int>(positions.size()));
      positions.push_back(segment.position(parameter));
      if (has_normals) {
        const Vector tangent = segment.derivative(parameter).normalized();
        const Vector normal = interpolant[0].at(parameter);
        const Vector across = normal - normal.dot(tangent) * tangent;
        // A normal along the curve cannot be made perpendicular to it; it stays as it is.
        normals.push_back(across.norm() > 1e-3 ? across.normalized() : normal);
      }
    }
    vertices.push_back(kept(segment.vertices.back()));
  }
  for (const int v : network.tagged_nodes)
    if (const int k = number[static_cast<size_t>(v)]; k >= 0) result.tagged_nodes.push_back(k);
  const auto n = static_cast<Eigen::Index>(positions.size());
  result.positions.resize(n, 3);
  if (has_normals) result.normals.resize(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    result.positions.row(i) = positions[static_cast<size_t>(i)].transpose();
    if (has_normals) result.normals.row(i) = normals[static_cast<size_t>(i)].transpose();
  }
  return result;
}

}  // namespace batten
