#pragma once
#include <array>
#include <vector>

#include "batten/scan/block_ldlt_detail.hpp"
#include "batten/scan/joint_turns_detail.hpp"
#include "batten/scan/samples.hpp"

namespace batten {

/// Two neighbouring samples of a curve.
struct JointStep {
  int before, after;              ///< frames
  int sample_before;              ///< the other sample is the next
  double length;                  ///< in sizes
  int knot;                       ///< of the log factors of lengths; the step lies between it and the next
  double beyond;                  ///< how far, [0, 1); 0 with one knot for the curve
  FrameLdlt::Slot drift_to_next;  ///< blocks of both drifts
};

/// Two steps k ≤ l of a curve, at most two apart, whose rates of turn the prior of the shape joins.
struct StepPair {
  int k, l;
  /// Coefficients of ω_k·ω_l in ∫|ω|², ∫|ω'|² and ∫|ω''|²; for k ≠ l of ω_l·ω_k as well.
  std::array<double, 3> weights;
  /// Blocks of the frames: after k with after l, before with before, after with before, before with after.
  std::array<FrameLdlt::Slot, 4> slots;
  BlockLdlt<1>::Slot scalar;
};

/// The steps between two nodes of a curve, whose sum the positions of the nodes must meet.
struct JointSegment {
  int curve;
  int first_step, end_step;
  double length;       ///< in sizes
  int from, to;        ///< nodes
  int multiplier;      ///< block of unknowns
  int first_knot = 0;  ///< of its steps
  FrameLdlt::Slot to_from, to_to, own;
  std::vector<FrameLdlt::Slot> to_knots;   ///< of all knots of its steps
  std::vector<FrameLdlt::Slot> to_frames;  ///< of the first step's frame before, then of every frame after
};

/// Sizes, numbers and slots of the joint system of a scan; nothing in it changes with the state or the noise.
///
/// Blocks of three unknowns each: turns of the frames, drift per sample, one multiplier per segment (the
/// force that makes its steps meet its nodes), positions of the nodes, log factors of lengths at one knot per
/// curve or at evenly spaced ones (two of the three idle), and one multiplier for the mean of the factors.
/// Positions between the nodes are eliminated: the multiplier stands for the whole sum of steps. With a
/// gyroscope: its bias, one block per some seconds, and three columns of scale and alignment.
struct JointLayout {
  /// @param knot_spacing of the log factors, in sizes; 0: one per curve.
  JointLayout(const SampledScan& scan, double size, double knot_spacing = 0, const Progress& progress = {});
  int n_knots() const { return first_knot.back(); }

  int n_curves = 0, n_samples = 0, n_nodes = 0, n_frames = 0;
  int drift_at = 0, node_at = 0, scale_at = 0, mean_at = 0, n_blocks = 0;  ///< first blocks of each kind
  std::vector<int> first_sample, first_step, first_pair, first_segment;    ///< per curve, and the end
  std::vector<int> first_knot;                                             ///< the same
  std::vector<double> knot_share;                                          ///< of all length, per knot
  std::vector<int> frame_of_sample;
  std::vector<JointStep> steps;
  std::vector<StepPair> pairs;
  std::vector<JointSegment> segments;
  TurnLayout turns;                          ///< empty without a gyroscope
  std::vector<std::pair<int, int>> normals;  ///< frames that must agree in their normals
  VertexNumbering vertices;
  FrameNumbering frames;

  FrameLdlt system;    ///< pattern and factor
  BlockLdlt<1> shape;  ///< of the prior of one component of the rates of turn
  std::vector<FrameLdlt::Slot> frame_slot, data_slot,
      drift_slot;  ///< frame; frame with drift, drift: per sample
  std::vector<FrameLdlt::Slot> normal_slot, node_slot;
  std::vector<FrameLdlt::Slot> scale_slot, next_scale_slot, mean_slot;  ///< per knot; with the next
  FrameLdlt::Slot mean_own;

 private:
  void number(const SampledScan& scan, double size, double knot_spacing);
  void pair_up(const SampledScan& scan);
  void find_segments(const SampledScan& scan);
  std::vector<std::pair<int, int>> joined(const Progress& progress) const;
  void find_slots();
};

}  // namespace batten
