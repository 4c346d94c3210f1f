#pragma once
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/curves/hermite_cubic.hpp"
#include "batten/network/curve_network.hpp"

namespace batten {

/// How the tangents of the curves at a node depend on each other.
enum class NodeTangents {
  /// Every curve has a tangent of its own in the tangent plane of the node; a curve that passes through keeps
  /// its
  /// direction. Reproduces any smooth network, however its curves cross.
  Free,
  /// S (C.8): the tangents are even turns of one affine frame per node, in the order of the curves around it.
  /// Stiffer; crossings are pulled towards even angles. Nodes of degree 1, 2, and of degree 3 with a curve
  /// that
  /// passes through, are treated as by Free, where (C.8) is singular or bends the curve
  /// (docs/errata.md#s-c-8).
  EvenAngles,
};

/// Options of hermite_network().
struct HermiteOptions {
  NodeTangents node_tangents = NodeTangents::Free;
  /// A curve that turns by more than this at one sample has a corner there, in radians; at a node a pair of
  /// curves that meet straighter than that is taken for one that passes through.
  double corner_angle = 1.0;
  /// Rounds in which the parameter of every piece is set to its length: the first guess, chord lengths,
  /// bulges where samples are uneven (docs/errata.md#s-c-9).
  int parameter_rounds = 3;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// The cubic spline of one segment: C² inside, parametrised nearly by arc length.
struct HermiteSegment {
  std::vector<int>
      vertices;           ///< of the network, one per row of `points`; samples at the same place are left out
  Eigen::VectorXd knots;  ///< k, increasing from 0
  Points points;          ///< k × 3
  Points tangents;        ///< k × 3, derivatives by the parameter
  int curve = -1;         ///< index in the network
  /// Position, first and second derivative at a parameter within the knots.
  Eigen::Vector3d position(double parameter) const;
  Eigen::Vector3d derivative(double parameter) const;
  Eigen::Vector3d second_derivative(double parameter) const;
  /// Arc length of the whole, by Gauss's rule on every piece.
  double length() const;
  /// The piece between knots i and i + 1.
  HermiteCubic piece(Eigen::Index i) const;
};

/// A network of splines that meet with a common tangent plane at every node.
struct HermiteNetwork {
  /// Segments in the order of network_topology(), those with corners split there; consecutive ones of a curve
  /// follow each other.
  std::vector<HermiteSegment> segments;
  double energy = 0;  ///< Σ ∫ |x''|² of (C.1) over the parameter, in 1/length
};

/// Interpolates the samples of a network by cubic splines of least bending whose tangents at nodes are
/// perpendicular to the normals there (S appendix C, (C.22)): all node tangents from one sparse system, then
/// one tridiagonal system per segment. Deviations from the thesis, each for a reason given in
/// docs/errata.md#s-c: the pieces are parametrised by arc length, ends are numbered by segment so that loops
/// and parallel segments are right, the tridiagonal systems are solved by ratios and do not overflow, curves
/// that pass through a T stay straight. Without normals the tangents are not confined.
/// @throws InvalidInput as network_topology(), when an option is out of range, or when a segment has no
/// length or a normal vanishes, naming curve and vertex.
HermiteNetwork hermite_network(const CurveNetwork& network, const HermiteOptions& options = {});

}  // namespace batten
