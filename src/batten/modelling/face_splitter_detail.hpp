#pragma once
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "batten/core/index.hpp"
#include "batten/core/units.hpp"
#include "batten/modelling/face_split_detail.hpp"

// Private to the room.
namespace batten::detail {

/// Corners that turn in by less than this are left alone: hands do not draw straight angles.
inline constexpr double kReflexFrom = 1.15 * kPi;
/// What is left of a concave corner may be cut again while it is wider than this: three right angles make it
/// regular.
inline constexpr double kWideFrom = 0.8 * kPi;
/// No concave corner is cut off.
inline constexpr double kWhole = std::numeric_limits<double>::infinity();

/// A face laid out in the plane, while it is divided into quads.
class FaceSplitter {
 public:
  /// @param m segments of each side.
  /// @param reach over how many of them angles at corners are taken: a side that turns in beside a corner
  /// makes it concave, although it goes on smoothly there.
  FaceSplitter(int n_sides, int m, PlanePoints boundary, int reach = 1)
      : n_sides_(n_sides), m_(m), reach_(reach), boundary_(std::move(boundary)) {}

  /// @param widest angle that a concave corner may keep; infinite: the face stays whole.
  FaceSplit run(double widest);

  /// Into how many parts the sides should be divided so that cuts from concave corners find a vertex where
  /// the sides there, drawn on, would end: three right angles are then left. Nothing is asked for where a cut
  /// to a vertex that is there does.
  std::vector<int> parts_at_concave_corners();

  /// A quadrilateral as rows and columns of quads. @param corners its corners, numbers of sides; as many
  /// sides lie between the first two as between the last.
  FaceSplit run_grid(const std::vector<size_t>& corners);

  bool is_valid() const { return !folded(0); }

  /// How near the triangles come to equilateral ones: the mean of their quality by area, 0 to 1.
  double shape() const;

 private:
  /// The vertices of one side of a piece, from corner to corner.
  using Chain = std::vector<int>;

  void begin();

  std::vector<Chain> whole_face();

  /// Where a ray from a corner first meets the boundary again: the side and how far along it, or −1.
  std::pair<int, double> first_hit(const Eigen::Vector2d& from, const Eigen::Vector2d& direction) const;

  /// The fewest equal parts, up to four, that have an end near every foot.
  static int parts_through(std::vector<double> feet);

  FaceSplit result() const;

  int add(const Eigen::Vector2d& position);

  const Eigen::Vector2d& p(int v) const { return positions_[at(v)]; }

  /// A vertex is a concave corner of the face.
  bool is_concave(int v) const { return v < n_sides_ * m_ && v % m_ == 0 && concave_[at(v / m_)]; }

  /// The inner angle at corner k of a piece, 0 to 2π.
  double angle_at(const std::vector<Chain>& piece, size_t k) const;

  /// From a counter-clockwise to b, 0 to 2π.
  static double angle_between(const Eigen::Vector2d& a, const Eigen::Vector2d& b);

  /// The straight line between two corners runs inside the piece.
  bool is_inside(const std::vector<Chain>& piece, size_t a, size_t b) const;

  /// Cuts a piece at its most concave corner, again and again, where a straight line within it helps.
  void divide_piece(std::vector<Chain> piece);

  /// The split of Catmull–Clark: n grids around the centroid, their inner vertices bilinearly blended from
  /// their sides (H 6.1.2).
  void fill_piece(const std::vector<Chain>& piece);

  void fill_grid(const std::vector<size_t>& corners);

  bool folded(size_t from) const;

  /// Puts every inner vertex of a piece into the mean of its neighbours [tutte1963].
  void relax(size_t first_quad, int first_inner);

  int n_sides_, m_, reach_, n_pieces_ = 0;
  PlanePoints boundary_;
  std::vector<Eigen::Vector2d> positions_;
  std::vector<std::array<int, 4>> quads_;
  std::vector<std::array<int, 2>> cuts_;
  std::vector<char> concave_;  // per corner of the face
  double widest_ = kReflexFrom;
};

}  // namespace batten::detail
