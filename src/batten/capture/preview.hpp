#pragma once
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "batten/capture/clock.hpp"
#include "batten/capture/keys.hpp"
#include "batten/capture/line_protocol.hpp"
#include "batten/capture/morphorider.hpp"
#include "batten/capture/recording.hpp"
#include "batten/scan/calibration.hpp"

namespace batten {

/// What a live view shows.
struct PreviewState {
  std::int64_t time_us = 0;  ///< of the event that led to it
  std::string source;        ///< "open", "lost REASON", "back", "end"; empty before
  int n_curves = 0;          ///< begun and not discarded
  bool drawing = false;      ///< the last of them
  bool paused = false;
  std::string digits;                 ///< of a node number being typed
  int n_nodes = 0;                    ///< with a known place
  double distance_m = 0;              ///< along the curve
  Eigen::Vector3d position{0, 0, 0};  ///< of the device, metres; the first node of all is at the origin
  Eigen::Matrix3d frame = Eigen::Matrix3d::Identity();  ///< [t N B] in the world
  bool placed = false;                                  ///< the curve has met a node whose place is known
  /// At the node with a known place that was marked last: how far from it the curve came out, and over which
  /// way since the node before; nothing before the first.
  std::optional<double> drift_m;
  double drift_way_m = 0;
  int drift_node = 0;
  double rate_hz = 0;   ///< of the last two seconds
  double jitter_s = 0;  ///< standard deviation of the time between samples, of the last two seconds
  long n_readings = 0;  ///< believed
  long n_refused = 0;   ///< wrong check, or not like their neighbours
  long n_missing = 0;   ///< by the counts of the device
  long n_gaps = 0;      ///< stretches of more than half a second without a reading
};

/// Follows a recording while it is made: every curve by Euler's method from its start node, the orientation
/// of every reading by accelerometer and magnetometer, or as the device gives it (S 5.2.1, with the frames of
/// docs/methods.md#positions). What it shows is a sketch; the scan is made by decode_recording().
/// An event costs some microseconds; memory grows with the number of nodes alone.
class LivePreview {
 public:
  /// @throws InvalidInput when the header holds a calibration or form that cannot be read.
  explicit LivePreview(const RecordingHeader& header);

  /// @return whether the state has changed.
  bool push(const CaptureEvent& event);
  const PreviewState& state() const { return state_; }

 private:
  struct Sample {
    std::int64_t time_us = 0;
    std::optional<double> distance;
    Eigen::Vector3d accelerometer, magnetometer;
    std::optional<Eigen::Matrix3d> orientation;
  };

  bool take_packet(const CaptureEvent& event);
  bool take_line(const CaptureEvent& event);
  void take_key(std::int64_t time_us, std::string_view key);
  void apply(const Mark& mark);
  void meet_node(int node);
  void move(const Sample& sample);
  std::optional<Eigen::Matrix3d> orientation_of(const Sample& sample);
  void count_time(std::int64_t time_us);
  void settle_form(const std::string& packet);

  RecordingHeader header_;
  std::optional<Calibration> calibration_;
  DeviceAxes axes_;
  PreviewState state_;
  KeyReader keys_;
  MarkBook book_;

  std::optional<PacketForm> form_;
  std::vector<std::string> first_packets_;  // until the form is settled
  PacketGate gate_;
  std::optional<std::uint16_t> last_index_;
  int refused_since_ = 0;  // packets since last_index_, which are not missing

  DeviceHeader device_;
  Unwrapper unwrap_time_, unwrap_ticks_;
  LiveClock clock_;
  std::optional<std::uint32_t> last_seq_;
  bool device_orients_ = false;

  std::optional<double> last_distance_;
  double turned_ = 0;  // signed way of the wheel so far: which way it counts
  std::optional<Eigen::Matrix3d> last_frame_;
  double sine_of_dip_ = 0;
  long n_dips_ = 0;
  std::deque<std::int64_t> times_;

  std::map<int, Eigen::Vector3d> places_;           // of nodes
  std::map<int, Eigen::Vector3d> places_in_curve_;  // of a curve that is not placed yet
  std::vector<int> new_nodes_;                      // of this curve
  double way_at_node_ = 0;
  bool met_node_ = false;
};

}  // namespace batten
