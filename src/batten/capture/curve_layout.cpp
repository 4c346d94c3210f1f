#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "batten/capture/keys.hpp"
#include "batten/capture/readings_detail.hpp"
#include "batten/core/text.hpp"

namespace batten::detail {

namespace {

// A stay reaches this far to both sides of its key (microseconds).
constexpr std::int64_t kStay = 300000;
// A node needs a reading no farther from its key than this.
constexpr std::int64_t kFarthestReading = 500000;
// Distances of ticks differ by more than this, or not at all (metres).
constexpr double kSameDistance = 1e-9;
constexpr std::size_t kOddMarksTold = 5;

/// Readings of one curve: positions in the log, and metres from its start.
struct LaidCurve {
  std::vector<Eigen::Index> rows;
  std::vector<double> distances;
  std::vector<int> nodes;  // per row
  bool lost = false;
};

class Layout {
 public:
  Layout(const Readings& readings, DecodedRecording& decoded) : readings_(readings), decoded_(decoded) {}

  void lay_out(const std::optional<int>& n_nodes) {
    fill_columns();
    find_direction();
    read_keys(n_nodes);
    number_the_unnumbered();
    for (std::size_t c = 0; c < curves_.size(); ++c) lay_curve(c);
    close_gaps_of_numbers();
  }

 private:
  void fill_columns() {
    SensorLog& log = decoded_.log;
    const auto n = static_cast<Eigen::Index>(readings_.readings.size());
    log.axes = readings_.axes;
    log.resize(n);
    decoded_.orientations.resize(n, 4);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Reading& r = readings_.readings[static_cast<std::size_t>(i)];
      log.time[i] = static_cast<double>(r.time_us) * 1e-6;
      log.accelerometer.row(i) = r.accelerometer;
      log.magnetometer.row(i) = r.magnetometer;
      log.gyroscope.row(i) = r.gyroscope;
      decoded_.orientations.row(i) = r.orientation;
    }
  }

  /// A wheel mounted the other way round counts down.
  void find_direction() {
    double first = kMissingValue, last = kMissingValue;
    for (const Reading& r : readings_.readings) {
      if (std::isnan(r.distance)) continue;
      if (std::isnan(first)) first = r.distance;
      last = r.distance;
    }
    if (last < first) {
      direction_ = -1;
      decoded_.warnings.emplace_back(
          "the wheel turned backwards all in all; its count was taken the other way");
    }
  }

  void read_keys(const std::optional<int>& n_nodes) {
    KeyReader reader(n_nodes);
    MarkBook book;
    std::size_t n_odd = 0;
    const auto apply = [&](const std::vector<Mark>& marks) {
      for (const Mark& mark : marks)
        if (const auto odd = book.apply(mark); odd && ++n_odd <= kOddMarksTold)
          decoded_.warnings.push_back(concat("at ", static_cast<double>(mark.time_us) * 1e-6, " s: ", *odd));
    };
    for (const auto& [time, key] : readings_.keys) apply(reader.press(time, key));
    const std::int64_t end = readings_.readings.back().time_us;
    apply(reader.wait(std::max(end, readings_.keys.empty() ? end : readings_.keys.back().first) + 10000000));
    curves_ = book.curves();
    if (!curves_.empty() && !curves_.back().end_us) {
      curves_.back().end_us = end;
      decoded_.warnings.push_back(
          concat("curve ", curves_.size(), " was not finished; it ends with the recording"));
    }
  }

  void number_the_unnumbered() {
    int next = 0;
    long n = 0;
    for (const MarkedCurve& curve : curves_)
      for (const MarkedCurve::Node& node : curve.nodes) next = std::max(next, node.number + 1);
    for (MarkedCurve& curve : curves_)
      for (MarkedCurve::Node& node : curve.nodes)
        if (node.number == Mark::kUnnumbered) {
          node.number = next++;
          ++n;
        }
    if (n > 0)
      decoded_.warnings.push_back(
          concat(n, " nodes were marked without a number and were taken for nodes of their own"));
  }

  static bool in_a_pause(const MarkedCurve& curve, std::int64_t time) {
    return std::any_of(curve.pauses.begin(), curve.pauses.end(),
                       [time](const auto& pause) { return time > pause.first && time < pause.second; });
  }

  LaidCurve collect(const MarkedCurve& marked) const {
    LaidCurve curve;
    double at = 0, last = kMissingValue;
    const auto& all = readings_.readings;
    const auto begin = std::lower_bound(all.begin(), all.end(), marked.begin_us,
                                        [](const Reading& r, std::int64_t t) { return r.time_us < t; });
    for (auto r = begin; r != all.end() && r->time_us <= *marked.end_us; ++r) {
      const double distance = direction_ * r->distance;
      if (in_a_pause(marked, r->time_us)) {
        last = distance;
        continue;
      }
      if (!curve.rows.empty() && r->distance_lost_before) curve.lost = true;
      if (!std::isnan(last) && !std::isnan(distance)) at += distance - last;
      last = distance;
      // Where the wheel turned back the device stood still, as far as the curve is concerned.
      const double furthest = curve.distances.empty() ? at : std::max(at, curve.distances.back());
      curve.rows.push_back(static_cast<Eigen::Index>(r - all.begin()));
      curve.distances.push_back(std::isnan(distance) ? kMissingValue : furthest);
      curve.nodes.push_back(SensorLog::kNone);
    }
    return curve;
  }

  void mark_nodes(const MarkedCurve& marked, std::size_t number, LaidCurve& curve) {
    const auto time = [&](std::size_t k) {
      return readings_.readings[static_cast<std::size_t>(curve.rows[k])].time_us;
    };
    for (const MarkedCurve::Node& node : marked.nodes) {
      std::size_t best = 0;
      for (std::size_t k = 1; k < curve.rows.size(); ++k)
        if (std::abs(time(k) - node.time_us) < std::abs(time(best) - node.time_us)) best = k;
      if (std::abs(time(best) - node.time_us) > kFarthestReading) {
        decoded_.warnings.push_back(concat("curve ", number, ": node ", node.number,
                                           " was marked when the device was silent, and left out"));
        continue;
      }
      const auto stays = [&](std::size_t k) {
        return std::abs(curve.distances[k] - curve.distances[best]) < kSameDistance &&
               std::abs(time(k) - node.time_us) <= kStay;
      };
      std::size_t first = best, last = best;
      while (first > 0 && stays(first - 1)) --first;
      while (last + 1 < curve.rows.size() && stays(last + 1)) ++last;
      // A number typed again at the same place replaces the one before.
      for (std::size_t k = first; k > 0 && curve.nodes[k - 1] != SensorLog::kNone &&
                                  std::abs(curve.distances[k - 1] - curve.distances[best]) < kSameDistance;)
        curve.nodes[--k] = SensorLog::kNone;
      for (std::size_t k = first; k <= last; ++k) curve.nodes[k] = node.number;
    }
  }

  void lay_curve(std::size_t c) {
    const MarkedCurve& marked = curves_[c];
    LaidCurve curve = collect(marked);
    if (curve.lost) {
      decoded_.warnings.push_back(concat("curve ", c + 1,
                                         ": the device lost its count while it was drawn, so that its "
                                         "lengths are not known; it was left out, draw it again"));
      return;
    }
    if (curve.rows.size() < 2) {
      decoded_.warnings.push_back(concat("curve ", c + 1, " has no readings and was left out"));
      return;
    }
    mark_nodes(marked, c + 1, curve);
    std::size_t begin = 0, end = curve.rows.size();
    if (marked.closed()) {  // it begins and ends at its node
      while (begin < end && curve.nodes[begin] == SensorLog::kNone) ++begin;
      while (end > begin && curve.nodes[end - 1] == SensorLog::kNone) --end;
    }
    if (end - begin < 2) return;
    SensorLog& log = decoded_.log;
    LogCurve flags;
    flags.number = static_cast<int>(log.curves.size()) + 1;
    flags.boundary = marked.boundary;
    flags.closed = marked.closed();
    for (std::size_t k = begin; k < end; ++k) {
      const Eigen::Index row = curve.rows[k];
      log.curve[static_cast<std::size_t>(row)] = static_cast<int>(log.curves.size());
      log.node[static_cast<std::size_t>(row)] = curve.nodes[k];
      log.distance[row] = curve.distances[k] - curve.distances[begin];
    }
    log.curves.push_back(flags);
  }

  /// Files want node numbers without gaps, from 0 or from 1.
  void close_gaps_of_numbers() {
    std::map<int, int> numbers;
    for (const int node : decoded_.log.node)
      if (node != SensorLog::kNone) numbers.emplace(node, 0);
    if (numbers.empty()) return;
    int next = numbers.begin()->first == 0 ? 0 : 1;
    bool changed = false;
    for (auto& [from, to] : numbers) {
      to = next++;
      changed = changed || to != from;
    }
    if (!changed) return;
    for (int& node : decoded_.log.node)
      if (node != SensorLog::kNone) node = numbers[node];
    decoded_.warnings.emplace_back("the node numbers had gaps; they were counted through");
  }

  const Readings& readings_;
  DecodedRecording& decoded_;
  std::vector<MarkedCurve> curves_;
  double direction_ = 1;
};

}  // namespace

void lay_out_curves(const Recording& recording, const Readings& readings, DecodedRecording& decoded) {
  Layout(readings, decoded).lay_out(recording.header.n_nodes);
}

}  // namespace batten::detail
