#include "batten/scan/node_inference.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/scan/integration.hpp"
#include "batten/scan/node_search_detail.hpp"
#include "batten/scan/prefilter.hpp"
#include "batten/scan/regression.hpp"

namespace batten {

namespace {

using Eigen::Vector3d;

/// Odds of twenty to one, as a difference of −2 log likelihood.
constexpr double kSureMargin = 6;
/// Wavelength, in sizes, that the smoothing of the frames halves: nodes are not known yet, noise is not
/// shape.
constexpr double kSmoothing = 0.06;

/// What a stay costs that no other curve meets, of twice log odds: devices rest at crossings.
constexpr double kAloneCost = 25;

/// The stays of a curve: the first reading of each.
struct StayReadings {
  std::vector<int> readings, numbers;
  bool is_ring = false;  ///< the last is the first
};

StayReadings stays_of(const ScanCurve& curve) {
  StayReadings stays;
  if (!curve.node_readings.empty()) {
    stays.readings = curve.node_readings;
    stays.numbers = curve.node_ids;
  } else {
    const Eigen::Index n = curve.n_readings();
    for (Eigen::Index i = 0; i < n;) {
      Eigen::Index end = i + 1;
      while (end < n && curve.distances[end] == curve.distances[i]) ++end;
      if (end > i + 1) stays.readings.push_back(static_cast<int>(i));
      i = end;
    }
    stays.numbers.assign(stays.readings.size(), kNoNodeNumber);
  }
  const size_t n = stays.readings.size();
  if (!curve.closed || n < 2) return stays;
  const auto distance = [&](size_t j) { return curve.distances[stays.readings[j]]; };
  stays.is_ring =
      distance(0) == curve.distances[0] && distance(n - 1) == curve.distances[curve.n_readings() - 1];
  if (stays.is_ring && stays.numbers[0] < 0) stays.numbers[0] = stays.numbers[n - 1];
  return stays;
}

/// The scan with every stay as a node of its own, so that readings can be put in order and smoothed.
Scan marked_scan(const Scan& scan, const std::vector<StayReadings>& stays) {
  Scan marked = scan;
  int next = 0;
  for (size_t c = 0; c < scan.curves.size(); ++c) {
    ScanCurve& curve = marked.curves[c];
    curve.node_readings = stays[c].readings;
    curve.node_ids.clear();
    for (size_t j = 0; j < stays[c].readings.size(); ++j) curve.node_ids.push_back(next++);
    if (stays[c].is_ring) curve.node_ids.back() = curve.node_ids.front();
    // A closed curve whose marks are elsewhere is an open one to the integration.
    if (!stays[c].is_ring && !curve.node_ids.empty()) curve.closed = false;
  }
  return marked;
}

/// Stays with places and normals from the frames of each curve alone.
struct StayGeometry {
  std::vector<std::vector<CurveStay>> curves;
  double noise = 0;  ///< of a reading, radians
  double size = 0;   ///< of the largest curve, in the unit of the scan
};

StayGeometry geometry_of(const Scan& scan, const std::vector<StayReadings>& stays, const Progress& progress) {
  const Scan marked = marked_scan(scan, stays);
  std::vector<std::string> ignored;
  const std::vector<CleanCurve> clean = clean_readings(marked, {}, ignored, progress);
  PrefilterOptions prefilter;
  prefilter.wrap = false;
  SampledScan samples = resample(marked, clean, prefilter, progress);
  StayGeometry result;
  result.noise = reading_noise(clean);
  const auto lines_of = [](const SampledScan& frames) {
    std::vector<Points> lines = fourth_order_steps(frames);
    for (Points& line : lines) {
      Points sums = Points::Zero(line.rows() + 1, 3);
      for (Eigen::Index k = 0; k < line.rows(); ++k) sums.row(k + 1) = sums.row(k) + line.row(k);
      line = std::move(sums);
    }
    return lines;
  };
  std::vector<Points> lines = lines_of(samples);
  for (const Points& line : lines)
    result.size = std::max(result.size, (line.colwise().maxCoeff() - line.colwise().minCoeff()).norm());
  RegressionOptions regression;
  regression.unit = result.size;
  regression.mu = std::pow(kSmoothing / (2 * kPi), 4);
  regression.xi = 0;
  regression.robust = true;
  regression.tolerance = 1e-6;
  if (result.noise > 0) samples = regress_frames(samples, regression, nullptr, progress);
  lines = lines_of(samples);
  for (size_t c = 0; c < samples.curves.size(); ++c) {
    const SampledCurve& curve = samples.curves[c];
    Points& line = lines[c];
    if (stays[c].is_ring) {  // its ends are one point
      const Eigen::RowVector3d gap = line.row(line.rows() - 1) - line.row(0);
      for (Eigen::Index k = 0; k < line.rows(); ++k)
        line.row(k) -= gap * ((curve.parameters[k] - curve.parameters[0]) / curve.length());
    }
    std::vector<CurveStay> of_curve;
    for (size_t j = 0; j < curve.node_samples.size(); ++j) {
      const int k = curve.node_samples[j];
      CurveStay stay;
      stay.place = line.row(k).transpose() / result.size;
      stay.normal = curve.frames[k].col(1);
      stay.distance = curve.parameters[k] / result.size;
      stay.number = stays[c].numbers[j];
      if (stays[c].is_ring && j + 1 == curve.node_samples.size()) stay.same_as = 0;
      of_curve.push_back(stay);
    }
    result.curves.push_back(std::move(of_curve));
  }
  return result;
}

/// What stays may differ by when the slow drift of the frames is so many times the noise of a reading.
StayNoise stay_noise(double reading_noise, double drift) {
  StayNoise noise;
  noise.normal = drift * reading_noise + radians(0.15);
  noise.floor = 0.0015;
  const double wandering = drift * reading_noise + radians(0.05);
  noise.walk = 0.4 * wandering * wandering;  // over a fifth of the size the drift forgets itself
  noise.part = 0.002 * (1 + drift);
  return noise;
}

/// The numberings of a scan under the noise that explains them best.
struct BestSearch {
  std::vector<StayNumbering> numberings;
  StayNoise noise;
};

BestSearch search_with_noise(const StayGeometry& stays, const Progress& progress) {
  BestSearch best;
  double most = -std::numeric_limits<double>::infinity();
  for (const double drift : {0.3, 0.6, 1.2, 2.4}) {
    const StayNoise noise = stay_noise(stays.noise, drift);
    std::vector<StayNumbering> found = search_numberings(stays.curves, noise, progress);
    // A visit is the more likely the narrower the noise that explains it.
    int n_stays = 0;
    for (const std::vector<CurveStay>& curve : stays.curves)
      for (const CurveStay& stay : curve) n_stays += stay.same_as < 0 ? 1 : 0;
    const double n_matched = n_stays - static_cast<double>(found.front().places.size());
    int n_alone = 0;
    std::vector<int> visits(found.front().places.size(), 0);
    for (size_t c = 0; c < stays.curves.size(); ++c)
      for (size_t i = 0; i < stays.curves[c].size(); ++i)
        if (const int node = found.front().node_of[c][i]; node < 0)
          ++n_alone;
        else if (stays.curves[c][i].same_as < 0)
          ++visits[static_cast<size_t>(node)];
    n_alone += static_cast<int>(std::count(visits.begin(), visits.end(), 1));
    const double variance = 2 * noise.floor * noise.floor + 0.5 * noise.walk;
    const double score =
        found.front().gain - kAloneCost * n_alone -
        n_matched * (4 * std::log(noise.normal / radians(1.0)) + 3 * std::log(variance / 1e-5));
    if (!(score > most)) continue;
    most = score;
    best = {std::move(found), noise};
  }
  return best;
}

/// Curves and nodes at rest: each curve at the mean of what its nodes say, each node at that of its visits.
void relax(const std::vector<std::vector<CurveStay>>& curves, StayNumbering& found) {
  constexpr int kSweeps = 60;
  const size_t n_nodes = found.places.size();
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    std::vector<Vector3d> sums(n_nodes, Vector3d::Zero());
    std::vector<int> counts(n_nodes, 0);
    for (size_t c = 0; c < curves.size(); ++c)
      for (size_t i = 0; i < curves[c].size(); ++i) {
        if (found.node_of[c][i] < 0 || curves[c][i].same_as >= 0) continue;
        const auto k = static_cast<size_t>(found.node_of[c][i]);
        sums[k] += curves[c][i].place + found.shifts[c];
        ++counts[k];
      }
    for (size_t k = 0; k < n_nodes; ++k)
      if (counts[k] > 0) found.places[k] = sums[k] / counts[k];
    for (size_t c = 0; c < curves.size(); ++c) {
      Vector3d sum = Vector3d::Zero();
      int n = 0;
      for (size_t i = 0; i < curves[c].size(); ++i) {
        if (found.node_of[c][i] < 0 || curves[c][i].same_as >= 0) continue;
        sum += found.places[static_cast<size_t>(found.node_of[c][i])] - curves[c][i].place;
        ++n;
      }
      if (n > 0) found.shifts[c] = sum / n;
    }
  }
}

/// Collects nodes, evidence and doubts of the best numbering.
class InferenceReport {
 public:
  InferenceReport(const Scan& scan, const std::vector<StayReadings>& stays, const StayGeometry& geometry,
                  const BestSearch& search)
      : scan_(scan), stays_(stays), geometry_(geometry), search_(search), best_(search.numberings.front()) {
    relax(geometry.curves, best_);
    result_.scan = scan;
    number();
    for (size_t c = 0; c < scan.curves.size(); ++c)
      for (size_t i = 0; i < geometry.curves[c].size(); ++i) add_visit(c, i);
    judge();
  }
  NodeInference result() { return std::move(result_); }

 private:
  /// Given numbers stay; the others are the least that are free, in the order of the visits.
  void number() {
    number_of_.assign(best_.places.size(), -1);
    std::vector<char> is_taken(best_.places.size() + 1, 0);
    const auto each = [&](const auto& body) {
      for (size_t c = 0; c < geometry_.curves.size(); ++c)
        for (size_t i = 0; i < geometry_.curves[c].size(); ++i)
          if (best_.node_of[c][i] >= 0) body(c, i, static_cast<size_t>(best_.node_of[c][i]));
    };
    each([&](size_t c, size_t i, size_t k) {
      const int given = geometry_.curves[c][i].number;
      if (given < 0) return;
      number_of_[k] = given;
      if (given < static_cast<int>(is_taken.size())) is_taken[static_cast<size_t>(given)] = 1;
    });
    int next = 0;
    each([&](size_t, size_t, size_t k) {
      if (number_of_[k] >= 0) return;
      while (next < static_cast<int>(is_taken.size()) && is_taken[static_cast<size_t>(next)] != 0) ++next;
      number_of_[k] = next++;
    });
    for (size_t c = 0; c < geometry_.curves.size(); ++c) {
      ScanCurve& curve = result_.scan.curves[c];
      curve.node_readings.clear();
      curve.node_ids.clear();
      for (size_t i = 0; i < geometry_.curves[c].size(); ++i) {
        const int k = best_.node_of[c][i];
        curve.node_readings.push_back(stays_[c].readings[i]);
        curve.node_ids.push_back(k < 0 ? kNoNodeNumber : number_of_[static_cast<size_t>(k)]);
      }
    }
    node_at_.assign(best_.places.size(), 0);
    std::vector<std::pair<int, size_t>> order;
    for (size_t k = 0; k < number_of_.size(); ++k) order.emplace_back(number_of_[k], k);
    std::sort(order.begin(), order.end());
    for (const auto& [number, k] : order) {
      node_at_[k] = result_.nodes.size();
      result_.nodes.emplace_back().number = number;
    }
  }

  void add_visit(size_t c, size_t i) {
    const CurveStay& stay = geometry_.curves[c][i];
    if (stay.same_as >= 0) return;
    ++result_.n_stays;
    const int node = best_.node_of[c][i];
    if (node < 0) return;
    const auto k = static_cast<size_t>(node);
    NodeVisit visit;
    visit.curve = static_cast<int>(c);
    visit.reading = stays_[c].readings[i];
    visit.distance = scan_.curves[c].distances[visit.reading];
    visit.normal_angle = std::acos(std::clamp(stay.normal.dot(best_.normals[k]), -1.0, 1.0));
    visit.misfit = (stay.place + best_.shifts[c] - best_.places[k]).norm();
    const auto misfit_to = [&](size_t other) {
      return stay_misfit(stay, best_.shifts[c], best_.places[other], best_.normals[other], 0, search_.noise);
    };
    double next = kMostStayMisfit;
    for (size_t other = 0; other < best_.places.size(); ++other)
      if (other != k) next = std::min(next, misfit_to(other));
    visit.margin = next - misfit_to(k);
    result_.nodes[node_at_[k]].visits.push_back(visit);
  }

  std::string place_in_words(const NodeVisit& visit) const {
    return concat("reading ", visit.reading + 1, " of ", curve_label(scan_, visit.curve));
  }

  void judge() {
    for (size_t c = 0; c < geometry_.curves.size(); ++c)
      if (!geometry_.curves[c].empty() && best_.node_of[c][0] < 0)
        result_.doubts.push_back(concat(curve_label(scan_, static_cast<int>(c)), ": none of its ",
                                        geometry_.curves[c].size(), " stays fits a stay of another curve"));
      else if (geometry_.curves[c].empty() && geometry_.curves.size() > 1)
        result_.doubts.push_back(curve_label(scan_, static_cast<int>(c)) +
                                 ": the device rests nowhere on it");
    for (InferredNode& node : result_.nodes) {
      node.doubt = doubt_of(node);
      node.is_sure = node.doubt.empty();
      if (!node.is_sure) result_.doubts.push_back(concat("node ", node.number, ": ", node.doubt));
    }
    judge_next_best();
  }

  std::string doubt_of(const InferredNode& node) const {
    for (const NodeVisit& visit : node.visits)
      if (visit.margin < kSureMargin && node.visits.size() > 1)
        return concat(place_in_words(visit), " fits another node nearly as well, or none");
    if (node.visits.size() != 1) return {};
    const NodeVisit& visit = node.visits.front();
    const ScanCurve& curve = scan_.curves[static_cast<size_t>(visit.curve)];
    const bool is_end =
        visit.distance == curve.distances[0] || visit.distance == curve.distances[curve.n_readings() - 1];
    // A device rests where it starts and stops, marked or not a node.
    if (is_end && !curve.closed && curve.node_readings.empty()) return {};
    return concat(place_in_words(visit), " fits no stay of another curve");
  }

  /// How much worse the next best numbering is, and where it differs.
  void judge_next_best() {
    result_.margin = std::numeric_limits<double>::infinity();
    for (size_t s = 1; s < search_.numberings.size(); ++s) {
      const StayNumbering& other = search_.numberings[s];
      if (other.is_complete != best_.is_complete) continue;
      result_.margin = search_.numberings.front().gain - other.gain;
      if (result_.margin >= kSureMargin) return;
      result_.doubts.push_back(
          concat("another numbering explains the stays nearly as well (−2 log likelihood ", result_.margin,
                 " worse): ", difference(other)));
      return;
    }
  }

  /// The first stay that another numbering puts elsewhere.
  std::string difference(const StayNumbering& other) const {
    std::map<int, int> partner, reverse;
    for (size_t c = 0; c < geometry_.curves.size(); ++c)
      for (size_t i = 0; i < geometry_.curves[c].size(); ++i) {
        const int a = best_.node_of[c][i], b = other.node_of[c][i];
        const bool fits =
            partner.emplace(a, b).first->second == b && reverse.emplace(b, a).first->second == a;
        if (fits) continue;
        return concat("reading ", stays_[c].readings[i] + 1, " of ", curve_label(scan_, static_cast<int>(c)),
                      " may not be at node ", a < 0 ? a : number_of_[static_cast<size_t>(a)]);
      }
    return "the same nodes";
  }

  const Scan& scan_;
  const std::vector<StayReadings>& stays_;
  const StayGeometry& geometry_;
  const BestSearch& search_;
  StayNumbering best_;
  std::vector<int> number_of_;   // per node of the search
  std::vector<size_t> node_at_;  // its place in the result
  NodeInference result_;
};

}  // namespace

NodeInference infer_nodes(const Scan& scan, const Progress& progress) {
  check_scan(scan, NodeNumbers::MayMiss);
  std::vector<StayReadings> stays;
  size_t n_stays = 0;
  for (const ScanCurve& curve : scan.curves) {
    stays.push_back(stays_of(curve));
    n_stays += stays.back().readings.size();
  }
  if (n_stays == 0)
    throw InvalidInput(
        "the scan has no stays to find nodes from: let the device rest where curves cross (readings at one "
        "distance), or mark these places");
  progress.report("nodes", 0);
  const StayGeometry geometry = geometry_of(scan, stays, progress);
  const BestSearch search = search_with_noise(geometry, progress);
  return InferenceReport(scan, stays, geometry, search).result();
}

}  // namespace batten
