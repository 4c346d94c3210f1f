#include <algorithm>
#include <cmath>
#include <numeric>

#include "batten/scan/joint_layout_detail.hpp"

namespace batten {

JointLayout::JointLayout(const SampledScan& scan, double size, double knot_spacing, const Progress& progress)
    : n_curves(static_cast<int>(scan.curves.size())),
      vertices(number_vertices(scan)),
      frames(number_frames(scan)) {
  progress.report("ordering", 0);
  number(scan, size, knot_spacing);
  pair_up(scan);
  find_segments(scan);
  turns.find(scan, frames, n_blocks);
  progress.report("ordering", 0);
  normals = frames.node_pairs;
  std::vector<char> multiplier(n_blocks, 0);
  for (const JointSegment& s : segments) multiplier[s.multiplier] = 1;
  multiplier[mean_at] = 1;
  system = FrameLdlt(n_blocks, joined(progress), multiplier, progress);
  std::vector<std::pair<int, int>> chain;
  for (const StepPair& p : pairs) chain.emplace_back(p.k, p.l);
  shape = BlockLdlt<1>(static_cast<int>(steps.size()), chain, {}, progress);
  progress.report("ordering", 1);
  find_slots();
}

void JointLayout::number(const SampledScan& scan, double size, double knot_spacing) {
  const double all = scan.length();
  first_knot.push_back(0);
  for (int c = 0; c < n_curves; ++c) {
    const SampledCurve& curve = scan.curves[c];
    const double length = curve.length();
    const int n_knots =
        knot_spacing > 0 ? 1 + std::max(1, static_cast<int>(std::ceil(length / size / knot_spacing))) : 1;
    const int first = first_knot.back();
    first_knot.push_back(first + n_knots);
    knot_share.resize(first_knot.back(), 0);
    first_sample.push_back(n_samples);
    first_step.push_back(static_cast<int>(steps.size()));
    for (int k = 0; k + 1 < curve.n_samples(); ++k) {
      const double middle = 0.5 * (curve.parameters[k] + curve.parameters[k + 1]) - curve.parameters[0];
      const double place = middle / length * (n_knots - 1);
      const int knot = std::clamp(static_cast<int>(place), 0, std::max(0, n_knots - 2));
      const double beyond = place - knot, share = curve.step(k) / all;
      steps.push_back({frames.frames[c][k],
                       frames.frames[c][k + 1],
                       n_samples + k,
                       curve.step(k) / size,
                       first + knot,
                       beyond,
                       {}});
      knot_share[first + knot] += (1 - beyond) * share;
      if (n_knots > 1) knot_share[first + knot + 1] += beyond * share;
    }
    n_samples += curve.n_samples();
    frame_of_sample.insert(frame_of_sample.end(), frames.frames[c].begin(), frames.frames[c].end());
  }
  first_sample.push_back(n_samples);
  first_step.push_back(static_cast<int>(steps.size()));
  n_frames = frames.n_frames;
  n_nodes = vertices.n_nodes;
  drift_at = n_frames;
  node_at = drift_at + n_samples;
  scale_at = node_at + n_nodes;
  mean_at = scale_at + n_knots();
  n_blocks = mean_at + 1;
}

/// ∫|ω|², ∫|ω'|² and ∫|ω''|² by differences of ω on neighbouring steps, each over the length it stands for.
void JointLayout::pair_up(const SampledScan& scan) {
  for (int c = 0; c < n_curves; ++c) {
    first_pair.push_back(static_cast<int>(pairs.size()));
    const SampledCurve& curve = scan.curves[c];
    const int first = first_step[c], n = curve.n_samples() - 1;
    const bool ring = curve.smooth_seam && n >= 4;
    for (int distance = 0; distance < 3; ++distance)
      for (int k = 0; k < n; ++k) pairs.push_back({first + k, first + (k + distance) % n, {0, 0, 0}, {}, {}});
    const auto weight = [&](int distance, int k, int order) -> double& {
      return pairs[first_pair[c] + distance * n + k % n].weights[order];
    };
    const auto h = [&](int k) { return steps[first + k % n].length; };
    const auto between = [&](int k) { return 0.5 * (h(k) + h(k + 1)); };
    for (int k = 0; k < n; ++k) weight(0, k, 0) += h(k);
    for (int k = 0; k + 1 < (ring ? n + 1 : n); ++k) {
      const double w = 1 / between(k);
      weight(0, k, 1) += w;
      weight(0, k + 1, 1) += w;
      weight(1, k, 1) -= w;
    }
    for (int k = 0; k + 2 < (ring ? n + 2 : n); ++k) {
      const double a = 1 / between(k), b = 1 / between(k + 1), w = 2 / (between(k) + between(k + 1));
      const std::array<double, 3> coefficients{a, -a - b, b};
      for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) weight(j - i, k + i, 2) += w * coefficients[i] * coefficients[j];
    }
    const auto unused = [](const StepPair& p) { return p.weights == std::array<double, 3>{0, 0, 0}; };
    pairs.erase(std::remove_if(pairs.begin() + first_pair[c], pairs.end(), unused), pairs.end());
  }
  first_pair.push_back(static_cast<int>(pairs.size()));
}

void JointLayout::find_segments(const SampledScan& scan) {
  for (int c = 0; c < n_curves; ++c) {
    first_segment.push_back(static_cast<int>(segments.size()));
    int last = -1;
    for (int k = 0; k < scan.curves[c].n_samples(); ++k) {
      if (vertices.vertices[c][k] >= n_nodes) continue;
      if (last >= 0) {
        JointSegment s;
        s.curve = c;
        s.first_step = first_step[c] + last;
        s.end_step = first_step[c] + k;
        s.length = 0;
        for (int i = s.first_step; i < s.end_step; ++i) s.length += steps[i].length;
        s.first_knot = steps[s.first_step].knot;
        const int last_knot = std::min(steps[s.end_step - 1].knot + 1, first_knot[c + 1] - 1);
        s.to_knots.resize(static_cast<size_t>(last_knot - s.first_knot + 1));
        s.from = vertices.vertices[c][last];
        s.to = vertices.vertices[c][k];
        s.multiplier = n_blocks++;
        segments.push_back(s);
      }
      last = k;
    }
  }
  first_segment.push_back(static_cast<int>(segments.size()));
}

std::vector<std::pair<int, int>> JointLayout::joined(const Progress& progress) const {
  std::vector<std::pair<int, int>> list = normals;
  for (const StepPair& p : pairs) {
    const JointStep &k = steps[p.k], &l = steps[p.l];
    for (const int a : {k.before, k.after})
      for (const int b : {l.before, l.after}) list.emplace_back(a, b);
  }
  for (const JointStep& s : steps)
    list.emplace_back(drift_at + s.sample_before, drift_at + s.sample_before + 1);
  for (int i = 0; i < n_samples; ++i) list.emplace_back(frame_of_sample[i], drift_at + i);
  for (const JointSegment& s : segments) {
    for (int k = s.first_step; k < s.end_step; ++k) {
      list.emplace_back(s.multiplier, steps[k].before);
      list.emplace_back(s.multiplier, steps[k].after);
    }
    list.emplace_back(s.multiplier, node_at + s.from);
    list.emplace_back(s.multiplier, node_at + s.to);
    for (int j = 0; j < static_cast<int>(s.to_knots.size()); ++j)
      list.emplace_back(s.multiplier, scale_at + s.first_knot + j);
  }
  for (int c = 0; c < n_curves; ++c)
    for (int k = first_knot[c]; k < first_knot[c + 1]; ++k) {
      list.emplace_back(mean_at, scale_at + k);
      if (k + 1 < first_knot[c + 1]) list.emplace_back(scale_at + k, scale_at + k + 1);
    }
  turns.join(list);
  // Many of them are named several times.
  progress.report("ordering", 0);
  std::vector<int> first(n_blocks + 1, 0);
  for (auto& [a, b] : list) {
    if (a < b) std::swap(a, b);
    ++first[a + 1];
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<int> others(list.size());
  std::vector<int> end(first.begin(), first.end() - 1);
  for (const auto& [a, b] : list) others[end[a]++] = b;
  progress.report("ordering", 0);
  list.clear();
  for (int a = 0; a < n_blocks; ++a) {
    std::sort(others.begin() + first[a], others.begin() + first[a + 1]);
    for (int i = first[a]; i < first[a + 1]; ++i)
      if (i == first[a] || others[i] != others[i - 1]) list.emplace_back(a, others[i]);
  }
  return list;
}

void JointLayout::find_slots() {
  for (StepPair& p : pairs) {
    const JointStep &k = steps[p.k], &l = steps[p.l];
    p.slots = {system.slot(k.after, l.after), system.slot(k.before, l.before), system.slot(k.after, l.before),
               system.slot(k.before, l.after)};
    p.scalar = shape.slot(p.k, p.l);
  }
  for (JointStep& s : steps)
    s.drift_to_next = system.slot(drift_at + s.sample_before, drift_at + s.sample_before + 1);
  for (int f = 0; f < n_frames; ++f) frame_slot.push_back(system.slot(f, f));
  for (int i = 0; i < n_samples; ++i) {
    data_slot.push_back(system.slot(frame_of_sample[i], drift_at + i));
    drift_slot.push_back(system.slot(drift_at + i, drift_at + i));
  }
  for (JointSegment& s : segments) {
    s.own = system.slot(s.multiplier, s.multiplier);
    s.to_from = system.slot(s.multiplier, node_at + s.from);
    s.to_to = system.slot(s.multiplier, node_at + s.to);
    for (int j = 0; j < static_cast<int>(s.to_knots.size()); ++j)
      s.to_knots[j] = system.slot(s.multiplier, scale_at + s.first_knot + j);
    s.to_frames.push_back(system.slot(s.multiplier, steps[s.first_step].before));
    for (int k = s.first_step; k < s.end_step; ++k)
      s.to_frames.push_back(system.slot(s.multiplier, steps[k].after));
  }
  for (const auto& [a, b] : normals) normal_slot.push_back(system.slot(a, b));
  for (int v = 0; v < n_nodes; ++v) node_slot.push_back(system.slot(node_at + v, node_at + v));
  for (int c = 0; c < n_curves; ++c)
    for (int k = first_knot[c]; k < first_knot[c + 1]; ++k) {
      scale_slot.push_back(system.slot(scale_at + k, scale_at + k));
      mean_slot.push_back(system.slot(mean_at, scale_at + k));
      const bool is_last = k + 1 == first_knot[c + 1];
      next_scale_slot.push_back(is_last ? FrameLdlt::Slot{} : system.slot(scale_at + k, scale_at + k + 1));
    }
  mean_own = system.slot(mean_at, mean_at);
  turns.find_slots(system);
}

}  // namespace batten
