#include "batten/scan/prefilter.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "batten/core/error.hpp"
#include "batten/core/parallel.hpp"
#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/average.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/turn_path_detail.hpp"

namespace batten {

namespace {

/// Median of the length of a normally distributed vector with unit variance per axis: √ of the median of χ²₃.
/// Lengths, not components, so that turning the world changes nothing.
constexpr double kMedianOfNorm = 1.538172;

double angle_between(const Eigen::Matrix3d& A, const Eigen::Matrix3d& B) {
  return so3_log(A.transpose() * B).norm();
}

bool agree(const Eigen::Matrix3d& A, const Eigen::Matrix3d& B, double cosine) {
  return std::cos(0.5 * angle_between(A, B)) >= cosine;  // |q·q'| = cos(θ/2)
}

/// The thesis's rule, extended to short runs. The sequence is cut where neighbours disagree; short pieces
/// between long ones are outliers unless they agree with both long neighbours (or the one there is).
std::vector<char> outliers_by_neighbours(const std::vector<Eigen::Matrix3d>& frames, double cosine,
                                         int longest_run) {
  const int n = static_cast<int>(frames.size());
  std::vector<char> outlier(n, 0);
  std::vector<std::pair<int, int>> pieces;  // [begin, end)
  int begin = 0;
  for (int i = 1; i <= n; ++i) {
    if (i < n && agree(frames[i - 1], frames[i], cosine)) continue;
    pieces.emplace_back(begin, i);
    begin = i;
  }
  const int n_pieces = static_cast<int>(pieces.size());
  if (n_pieces == 1) return outlier;
  const auto is_long = [&](int p) { return pieces[p].second - pieces[p].first > longest_run; };
  for (int p = 0; p < n_pieces; ++p) {
    if (is_long(p)) continue;
    const auto [first, end] = pieces[p];
    int before = p - 1, after = p + 1;
    while (before >= 0 && !is_long(before)) --before;
    while (after < n_pieces && !is_long(after)) ++after;
    const bool has_before = before >= 0, has_after = after < n_pieces;
    if (!has_before && !has_after) {
      // Nothing to hold it against but the neighbours: the printed rule, for single readings.
      if (end - first == 1) outlier[first] = 1;
      continue;
    }
    const bool fits_before = has_before && agree(frames[pieces[before].second - 1], frames[first], cosine);
    const bool fits_after = has_after && agree(frames[end - 1], frames[pieces[after].first], cosine);
    if (fits_before || fits_after) continue;
    const bool bridged = has_before && has_after &&
                         agree(frames[pieces[before].second - 1], frames[pieces[after].first], cosine);
    if (bridged || end - first == 1 || !has_before || !has_after)
      std::fill(outlier.begin() + first, outlier.begin() + end, 1);
  }
  return outlier;
}

/// Median slope and level of three components over distance (Theil, Sen): half of the readings may be wrong.
Eigen::Vector3d robust_level(const std::vector<double>& distances, const std::vector<Eigen::Vector3d>& values,
                             double at) {
  Eigen::Vector3d level;
  std::vector<double> scratch;
  for (int a = 0; a < 3; ++a) {
    scratch.clear();
    for (size_t i = 0; i < values.size(); ++i)
      for (size_t j = 0; j < i; ++j)
        if (distances[i] != distances[j])
          scratch.push_back((values[i][a] - values[j][a]) / (distances[i] - distances[j]));
    const double slope = median(scratch);
    scratch.clear();
    for (size_t i = 0; i < values.size(); ++i) scratch.push_back(values[i][a] - slope * (distances[i] - at));
    level[a] = median(scratch);
  }
  return level;
}

/// Readings to each side that a reading is held against.
constexpr int kNeighbours = 5;
/// Readings of a chunk, of some 10 µs each.
constexpr Eigen::Index kGrain = 100;

/// How far every reading lies from a robust line through the readings around it.
std::vector<Eigen::Vector3d> residuals_to_surroundings(const Eigen::VectorXd& distances,
                                                       const std::vector<Eigen::Matrix3d>& frames,
                                                       const Progress& progress) {
  const int n = static_cast<int>(frames.size());
  std::vector<Eigen::Vector3d> residuals(n, Eigen::Vector3d::Zero());
  const auto one = [&](int i) {
    const int begin = std::max(0, i - kNeighbours), end = std::min(n, i + kNeighbours + 1);
    if (end - begin < 5) return;
    // The base is the reading nearest to all others, so that an outlier never is the base.
    int base = begin;
    double least = std::numeric_limits<double>::infinity();
    for (int j = begin; j < end; ++j) {
      double sum = 0;
      for (int k = begin; k < end; ++k) sum += angle_between(frames[j], frames[k]);
      if (sum < least * (1 - 1e-12)) least = sum, base = j;
    }
    std::vector<double> s;
    std::vector<Eigen::Vector3d> v;
    for (int j = begin; j < end; ++j) {
      if (j == i) continue;
      s.push_back(distances[j]);
      v.push_back(so3_log(frames[j] * frames[base].transpose()));
    }
    residuals[i] = so3_log(frames[i] * frames[base].transpose()) - robust_level(s, v, distances[i]);
  };
  parallel_for(
      n, kGrain,
      [&](Eigen::Index begin, Eigen::Index end) {
        for (Eigen::Index i = begin; i < end; ++i) one(static_cast<int>(i));
      },
      progress);
  return residuals;
}

std::vector<Eigen::Matrix3d> reading_frames(const ScanCurve& curve) {
  std::vector<Eigen::Matrix3d> frames;
  frames.reserve(curve.n_readings());
  for (Eigen::Index i = 0; i < curve.n_readings(); ++i)
    frames.push_back(darboux_frame(curve.tangents.row(i), curve.normals.row(i), false));
  return frames;
}

/// Merges readings at one distance and carries the nodes along.
CleanCurve merged(const ScanCurve& curve, const std::vector<Eigen::Matrix3d>& frames,
                  const std::vector<char>& outlier) {
  const int n = static_cast<int>(frames.size());
  CleanCurve clean;
  std::vector<double> distances, counts, times;
  const TurnPath path = turn_path(curve);
  const auto add_path = [&](int begin, int end) {
    if (path.empty()) return;
    const auto first = path.frames.begin();
    clean.turned.frames.push_back(rotation_average(std::vector<Eigen::Matrix3d>(first + begin, first + end)));
    times.push_back(path.times.segment(begin, end - begin).mean());
    clean.turned.gaps.push_back(path.gaps[end - 1]);
  };
  std::vector<int> group_of_reading(n, -1);
  for (int i = 0; i < n;) {
    int end = i + 1;
    while (end < n && curve.distances[end] == curve.distances[i]) ++end;
    std::vector<Eigen::Matrix3d> group;
    for (int j = i; j < end; ++j)
      if (!outlier[j]) group.push_back(frames[j]);
    const bool is_end = i == 0 || end == n;
    const auto node = std::lower_bound(curve.node_readings.begin(), curve.node_readings.end(), i);
    const bool is_node = node != curve.node_readings.end() && *node < end;
    if (group.empty() && (is_end || is_node)) {
      // The place is needed although its reading is not: a weight of zero lets the neighbours fill it in.
      distances.push_back(curve.distances[i] - curve.distances[0]);
      clean.frames.push_back(frames[i]);
      counts.push_back(0);
      add_path(i, end);
    } else if (!group.empty()) {
      distances.push_back(curve.distances[i] - curve.distances[0]);
      clean.frames.push_back(group.size() == 1 ? group.front() : rotation_average(group));
      counts.push_back(static_cast<double>(group.size()));
      add_path(i, end);
      clean.n_duplicates += static_cast<int>(group.size()) - 1;
    }
    for (int j = i; j < end; ++j) group_of_reading[j] = static_cast<int>(distances.size()) - 1;
    i = end;
  }
  clean.distances =
      Eigen::Map<Eigen::VectorXd>(distances.data(), static_cast<Eigen::Index>(distances.size()));
  clean.counts = Eigen::Map<Eigen::VectorXd>(counts.data(), static_cast<Eigen::Index>(counts.size()));
  clean.turned.times = Eigen::Map<Eigen::VectorXd>(times.data(), static_cast<Eigen::Index>(times.size()));
  for (size_t j = 0; j < curve.node_readings.size(); ++j) {
    clean.node_readings.push_back(group_of_reading[curve.node_readings[j]]);
    clean.node_ids.push_back(curve.node_ids[j]);
  }
  clean.n_outliers = static_cast<int>(std::count(outlier.begin(), outlier.end(), 1));
  return clean;
}

}  // namespace

std::optional<std::string> CleanOptions::problem() const {
  if (!(outlier_cosine >= 0 && outlier_cosine <= 1))
    return concat("outlier_cosine must be in [0, 1], got ", outlier_cosine);
  return std::nullopt;
}

std::vector<CleanCurve> clean_readings(const Scan& scan, const CleanOptions& options,
                                       std::vector<std::string>& warnings, const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  std::vector<std::vector<Eigen::Matrix3d>> frames;
  std::vector<std::vector<char>> outlier;
  for (int c = 0; c < static_cast<int>(scan.curves.size()); ++c) {
    const ScanCurve& curve = scan.curves[c];
    progress.report("prefilter", 0);
    frames.push_back(reading_frames(curve));
    const int n = static_cast<int>(frames[c].size());
    std::vector<char> marked(n, 0);
    if (options.outlier_cosine > 0 && n > 2) {
      marked = outliers_by_neighbours(frames[c], options.outlier_cosine, options.robust ? 3 : 1);
      const int count = static_cast<int>(std::count(marked.begin(), marked.end(), 1));
      if (4 * count > n) {
        warnings.push_back(concat(curve_label(scan, c), ": ", count, " of ", n,
                                  " readings turn by more than ",
                                  degrees(2 * std::acos(options.outlier_cosine)),
                                  "° from their neighbours, too many to be outliers; all were kept (record "
                                  "more readings where the curve turns)"));
        std::fill(marked.begin(), marked.end(), 0);
      }
    }
    outlier.push_back(std::move(marked));
  }
  if (options.robust) {
    std::vector<std::vector<Eigen::Vector3d>> residuals(frames.size());
    std::vector<std::vector<int>> kept(frames.size());
    std::vector<double> sizes;
    for (size_t c = 0; c < frames.size(); ++c) {
      std::vector<Eigen::Matrix3d> kept_frames;
      std::vector<double> kept_distances;
      for (int i = 0; i < static_cast<int>(frames[c].size()); ++i) {
        if (outlier[c][i]) continue;
        kept[c].push_back(i);
        kept_frames.push_back(frames[c][i]);
        kept_distances.push_back(scan.curves[c].distances[i]);
      }
      residuals[c] = residuals_to_surroundings(
          Eigen::Map<Eigen::VectorXd>(kept_distances.data(),
                                      static_cast<Eigen::Index>(kept_distances.size())),
          kept_frames, progress.part("prefilter", 0.1, 0.5));
      for (const Eigen::Vector3d& r : residuals[c]) sizes.push_back(r.norm());
    }
    const double sigma = median(sizes) / kMedianOfNorm;
    for (size_t c = 0; c < frames.size(); ++c) {
      const int n = static_cast<int>(residuals[c].size());
      progress.report("prefilter", 0.5);
      for (int i = 0; i < n; ++i) {
        const double size = residuals[c][i].norm();
        if (size < std::max(5 * sigma, radians(3.0))) continue;
        // A sharp bend makes large residuals too, but to all readings around it.
        std::vector<double> around;
        for (int j = std::max(0, i - 4); j < std::min(n, i + 5); ++j)
          if (j != i) around.push_back(residuals[c][j].norm());
        if (size > 3 * median(around)) outlier[c][kept[c][i]] = 1;
      }
    }
  }
  std::vector<CleanCurve> clean;
  for (int c = 0; c < static_cast<int>(scan.curves.size()); ++c) {
    progress.report("prefilter", 0.5);
    clean.push_back(merged(scan.curves[c], frames[c], outlier[c]));
    if (!(clean.back().counts.array() > 0).any())
      throw InvalidInput(curve_label(scan, c) + ": no reading is left after the removal of outliers");
  }
  return clean;
}

double reading_noise(const std::vector<CleanCurve>& curves) {
  std::vector<double> sizes;
  for (const CleanCurve& curve : curves) {
    const int n = static_cast<int>(curve.frames.size());
    for (int i = 1; i + 1 < n; ++i) {
      if (curve.counts[i - 1] == 0 || curve.counts[i] == 0 || curve.counts[i + 1] == 0) continue;
      const double u =
          (curve.distances[i] - curve.distances[i - 1]) / (curve.distances[i + 1] - curve.distances[i - 1]);
      const Eigen::Vector3d before = so3_log(curve.frames[i - 1] * curve.frames[i].transpose());
      const Eigen::Vector3d after = so3_log(curve.frames[i + 1] * curve.frames[i].transpose());
      const Eigen::Vector3d r = (1 - u) * before + u * after;
      // Variance of r per axis in units of that of one reading.
      const double spread =
          1 / curve.counts[i] + (1 - u) * (1 - u) / curve.counts[i - 1] + u * u / curve.counts[i + 1];
      sizes.push_back(r.norm() / std::sqrt(spread));
    }
  }
  return median(sizes) / kMedianOfNorm;
}

}  // namespace batten
