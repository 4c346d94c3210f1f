#include "studio/live_track.hpp"

namespace batten::studio {

void LiveTrack::push(const PreviewState& state) {
  // A curve that was forgotten, also where the next one began at once.
  const bool was_dropped = state.n_curves < last_.n_curves ||
                           (state.drawing && last_.drawing && state.n_curves == last_.n_curves &&
                            state.distance_m < last_.distance_m);
  if (was_dropped) drop_curve();
  const bool begins = state.drawing && (!last_.drawing || was_dropped || state.n_curves != last_.n_curves);
  if (begins) {
    curve_begin_ = n_points();
    add(state, state.n_nodes > last_.n_nodes);
  } else if (state.drawing) {
    // Until a curve meets a node whose place is known, it is drawn as if it began at the origin.
    if (state.placed && !last_.placed) place_curve(state.position - last_.position);
    const bool is_node = state.n_nodes > last_.n_nodes;
    const bool moved = state.distance_m > last_.distance_m;
    if (is_node || (moved && ++n_skipped_ >= every_)) add(state, is_node);
  }
  last_ = state;
  if (n_points() > most_points_) thin();
}

void LiveTrack::add(const PreviewState& state, bool is_node) {
  n_skipped_ = 0;
  for (const double value : {static_cast<double>(state.n_curves), state.position.x(), state.position.y(),
                             state.position.z(), is_node ? 1.0 : 0.0})
    values_.push_back(static_cast<float>(value));
}

void LiveTrack::drop_curve() {
  values_.resize(curve_begin_ * kColumns);
  ++version_;
}

void LiveTrack::place_curve(const Eigen::Vector3d& shift) {
  if (shift.isZero(0)) return;
  for (std::size_t i = curve_begin_; i < n_points(); ++i)
    for (int k = 0; k < 3; ++k) values_[i * kColumns + 1 + k] += static_cast<float>(shift[k]);
  ++version_;
}

/// Nodes and the ends of curves stay.
void LiveTrack::thin() {
  std::vector<float> kept;
  const std::size_t n = n_points();
  std::size_t begin = 0;
  bool even = true;
  for (std::size_t i = 0; i < n; ++i) {
    if (i == curve_begin_) begin = kept.size() / kColumns;
    const float* point = &values_[i * kColumns];
    const bool is_end = i + 1 == n || i == 0 || point[0] != point[kColumns] || point[0] != point[-kColumns];
    even = !even;
    if (is_end || even || point[4] != 0) kept.insert(kept.end(), point, point + kColumns);
  }
  // Where all that is left are nodes and ends, a bound is a bound.
  if (kept.size() / kColumns > most_points_) kept.clear();
  curve_begin_ = kept.empty() ? 0 : begin;
  values_ = std::move(kept);
  every_ *= 2;
  ++version_;
}

}  // namespace batten::studio
