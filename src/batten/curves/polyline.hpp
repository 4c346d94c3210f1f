#pragma once
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/mesh/box_tree.hpp"

namespace batten {

/// Arc length from the first point to each, in the unit of the points.
std::vector<double> arc_lengths(const Points& points);

/// A polyline of two or more points that never changes, with its arc lengths and boxes for quick searches.
/// Handed about by shared pointer, so that a copy of a model and the history of its edits share it.
class Polyline {
 public:
  /// @pre points has two rows or more.
  explicit Polyline(Points points);

  const Points& points() const { return points_; }
  Eigen::Index n_points() const { return points_.rows(); }
  Eigen::Vector3d front() const { return points_.row(0); }
  Eigen::Vector3d back() const { return points_.row(points_.rows() - 1); }
  /// Arc length from the start to point i, in the unit of the model.
  double arc(Eigen::Index i) const { return arcs_[static_cast<size_t>(i)]; }
  double length() const { return arcs_.back(); }
  /// The point at an arc length; held within the polyline.
  Eigen::Vector3d at(double arc_length) const;
  /// The segment that holds an arc length: 0 … n_points − 2.
  Eigen::Index segment_at(double arc_length) const;
  /// `n` + 1 points at equal distances along it, ends exact.
  Points sampled(int n) const;
  /// Unit direction in which it leaves its start, taken over a twentieth of its length; zero where that
  /// has none.
  Eigen::Vector3d direction_at_front() const;
  Eigen::Vector3d direction_at_back() const;  ///< in which it leaves its end, backwards

  const Box& box() const { return box_; }
  /// Boxes of runs of kBlock segments: block b holds segments b · kBlock and following.
  const std::vector<Box>& blocks() const { return blocks_; }
  static constexpr Eigen::Index kBlock = 16;

 private:
  Points points_;
  std::vector<double> arcs_;
  Box box_;
  std::vector<Box> blocks_;
};

using SharedPolyline = std::shared_ptr<const Polyline>;

/// The two parts of a polyline, cut at an arc length; `at` becomes the end of the first and the start of the
/// second. @pre 0 < arc_length < length.
std::pair<SharedPolyline, SharedPolyline> cut(const Polyline& polyline, double arc_length,
                                              const Eigen::Vector3d& at);
SharedPolyline reversed(const Polyline& polyline);
/// One after the other; the end of the first and the start of the second are the same point.
SharedPolyline joined(const Polyline& first, const Polyline& second);

}  // namespace batten
