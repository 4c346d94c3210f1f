#include "batten/capture/pen_strokes.hpp"

#include <cmath>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

/// A stroke from its samples, thinned; the last one stays.
PenStroke thinned(const std::vector<const PenSample*>& samples, double spacing) {
  std::vector<const PenSample*> kept;
  for (const PenSample* sample : samples)
    if (kept.empty() || (sample->smoothed.tip - kept.back()->smoothed.tip).norm() >= spacing)
      kept.push_back(sample);
  if (kept.back() != samples.back()) {
    if (kept.size() > 1)
      kept.back() = samples.back();
    else
      kept.push_back(samples.back());
  }
  PenStroke stroke;
  const auto n = static_cast<Eigen::Index>(kept.size());
  stroke.points.resize(n, 3);
  stroke.sigma.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const PenSample& sample = *kept[static_cast<std::size_t>(i)];
    stroke.points.row(i) = sample.smoothed.tip;
    stroke.sigma[i] = std::sqrt(sample.smoothed_covariance.topLeftCorner<3, 3>().trace() / 3);
  }
  stroke.from = samples.front()->time;
  stroke.to = samples.back()->time;
  return stroke;
}

}  // namespace

std::optional<std::string> PenStrokeOptions::problem() const {
  if (!(spacing >= 0)) return concat("spacing is ", spacing, "; expected metres, at least 0");
  if (!(gap >= 0)) return concat("gap is ", gap, "; expected seconds, at least 0");
  if (!(shortest >= 0)) return concat("shortest is ", shortest, "; expected metres, at least 0");
  return {};
}

PenStrokes strokes_of_track(std::span<const PenSample> samples, std::span<const ButtonEvent> buttons,
                            const PenStrokeOptions& options) {
  if (const auto found = options.problem()) throw InvalidInput(*found);
  PenStrokes result;
  std::vector<const PenSample*> open;
  const auto close = [&] {
    if (!open.empty()) {
      double length = 0;
      for (std::size_t i = 1; i < open.size(); ++i)
        length += (open[i]->smoothed.tip - open[i - 1]->smoothed.tip).norm();
      if (open.size() >= 2 && length > 0 && length >= options.shortest)
        result.strokes.push_back(thinned(open, options.spacing));
      else
        ++result.slips;
    }
    open.clear();
  };
  bool has_button = false;
  for (const ButtonEvent& event : buttons) has_button = has_button || event.button == "draw";
  bool down = !has_button;
  std::size_t next = 0;
  for (const PenSample& sample : samples) {
    for (; next < buttons.size() && buttons[next].time <= sample.time; ++next) {
      if (buttons[next].button != "draw") continue;
      if (down && !buttons[next].down) close();
      down = buttons[next].down;
    }
    if (!down || sample.state == PenState::Lost) continue;
    if (!open.empty() && sample.time - open.back()->time > options.gap) {
      ++result.broken;
      close();
    }
    open.push_back(&sample);
  }
  close();
  return result;
}

}  // namespace batten
