#pragma once
#include <cstddef>
#include <vector>

#include "batten/capture/preview.hpp"

namespace batten::studio {

/// The way of a device as its preview tells it, for windows to draw. However long a capture lasts, the track
/// has a bounded number of points: where they are too many, every second one goes, and from then on every
/// second one is taken.
class LiveTrack {
 public:
  static constexpr std::size_t kMostPoints = 20000;
  static constexpr int kColumns = 5;  ///< of a point: number of its curve, x, y, z (metres), 1 at a new node

  explicit LiveTrack(std::size_t most_points = kMostPoints) : most_points_(most_points) {}

  /// Follows the preview; states between may be left out.
  void push(const PreviewState& state);

  std::size_t n_points() const { return values_.size() / kColumns; }
  /// n × kColumns, row after row.
  const std::vector<float>& values() const { return values_; }
  /// Changes where points were moved or taken away: whoever has some needs all anew.
  int version() const { return version_; }

 private:
  void add(const PreviewState& state, bool is_node);
  void drop_curve();
  void place_curve(const Eigen::Vector3d& shift);
  void thin();

  std::size_t most_points_;
  std::vector<float> values_;
  int version_ = 0;
  PreviewState last_;
  std::size_t curve_begin_ = 0;  // the first point of the curve that is drawn, or was last
  int every_ = 1;                // reading that is taken
  int n_skipped_ = 0;
};

}  // namespace batten::studio
