#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "batten/core/units.hpp"
#include "batten/remeshing/fit_samples_detail.hpp"

// Private to the room: what the fit to the normals of the reference costs around one vertex.
namespace batten::remeshing {

/// Points whose normal differs from that of the nearest triangle by more than 60° lie on the other side of an
/// edge; a triangle may not turn by more in one move.
constexpr double kSameSide = 0.5;

inline Eigen::Vector3d cross(const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
  return {u.y() * v.z() - u.z() * v.y(), u.z() * v.x() - u.x() * v.z(), u.x() * v.y() - u.y() * v.x()};
}

/// The sine of the smallest angle of a triangle, which lies between the two longest sides.
/// @param uu, vv, ww the squares of its sides.
inline double sine_of_smallest_angle(double doubled_area, double uu, double vv, double ww) {
  const double longest_two = uu <= vv && uu <= ww ? vv * ww : (vv <= ww ? uu * ww : uu * vv);
  return doubled_area / std::sqrt(longest_two);
}

/// What is weighed against each other; see NormalFitOptions.
struct FitWeights {
  double shape = 0;     ///< now
  double distance = 0;  ///< as NormalFitOptions::distance

  /// Of a sample on the plane through `on_plane`, in unit of length squared. @param length of edges there.
  double of_point(const AreaSample& s, const Eigen::Vector3d& normal, const Eigen::Vector3d& on_plane,
                  double length) const {
    return s.area *
           ((s.normal - normal).norm() + distance * std::abs(normal.dot(s.point - on_plane)) / length);
  }
  /// Of a triangle by the sine of its smallest angle: 0 where it has three equal sides.
  double of_shape(double sine, double length) const {
    return shape * 0.433 * length * length * (kPi / 3 - std::asin(std::min(1.0, sine)));
  }
};

/// A place where a vertex could go.
struct FitPlace {
  double squared;  ///< distance from the vertex
  int number;      ///< tells apart places at the same distance
  Eigen::Vector3d point;
};

/// The nearest `n` different places of those offered, nearest first. Places as far as another up to
/// rounding, with the same number, are the same: an edge is seen from both of its triangles.
template <int n>
struct NearestPlaces {
  std::array<FitPlace, n> places;
  int size = 0;

  void clear() { size = 0; }
  void offer(const FitPlace& place) {
    int at = size;
    while (at > 0 && before(place, places[at - 1])) --at;
    if (at == n || (at > 0 && same(places[at - 1], place)) || (at < size && same(place, places[at]))) return;
    if (size < n) ++size;
    for (int i = size - 1; i > at; --i) places[i] = places[i - 1];
    places[at] = place;
  }
  static bool before(const FitPlace& a, const FitPlace& b) {
    return a.squared != b.squared ? a.squared < b.squared : a.number < b.number;
  }
  static bool same(const FitPlace& a, const FitPlace& b) {
    return a.number == b.number && b.squared <= a.squared * (1 + 1e-9);
  }
};

/// What is known of the triangles around one vertex while it is looked at. Every thread has its own.
struct FitRing {
  /// A triangle around the vertex: its two other corners and the sector between feature edges that it is in.
  struct Spoke {
    Eigen::Vector3d b, c, normal;
    double squared_far_side;  ///< |c − b|²
    int face, sector;
  };
  /// The same with the vertex at a trial place x: a point p of its plane lies between the rays to b and c
  /// where (p − x) · after_b and (p − x) · before_c are both positive.
  struct Trial {
    Eigen::Vector3d normal, after_b, before_c;
  };
  /// A sample on one of the triangles around the vertex.
  struct Entry {
    AreaSample sample;
    int number;  ///< of the sample
    int spoke;
  };

  std::vector<Spoke> spokes;
  std::vector<Entry> entries;
  bool has_sectors = false;  ///< whether feature edges part the spokes
  double area = 0;           ///< of the samples
  double shape = 0;          ///< what the triangles of the last cost() cost
  std::vector<Trial> trials;

  /// Takes the triangles around a vertex and their samples.
  void gather(const HalfedgeMesh& mesh, const FitSamples& samples, int vertex);

  /// The spoke on which a sample lies for the trial, its offset from the vertex being p: the first that holds
  /// it, from the one where it is now, else the one that it is least outside of.
  std::size_t spoke_of(const Entry& entry, const Eigen::Vector3d& p) const;

  /// The sum over the triangles with the vertex at x; infinite where a triangle would be bad: without area,
  /// turned by more than 60°, or with a smaller angle. Leaves the triangles in `trials`, and in `shape` what
  /// their shapes cost.
  /// @param least_sine of the smallest angles. @param bound above it the sum is of no interest: infinite is
  /// returned.
  double cost(const Eigen::Vector3d& x, double length, double least_sine, double bound,
              const FitWeights& weights);

  /// Of the smallest angles, with the vertex at x.
  double least_sine(const Eigen::Vector3d& x) const;
};

}  // namespace batten::remeshing
