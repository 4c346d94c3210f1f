#include "batten/scan/scan.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

/// Sine of the angle between tangent and normal below which no frame can be made of them (3°).
constexpr double kSmallestSine = 0.05;

[[noreturn]] void fail(const std::string& where, const std::string& problem) {
  throw InvalidInput(where + ": " + problem);
}

void check_readings(const ScanCurve& curve, const std::string& where) {
  const Eigen::Index n = curve.n_readings();
  if (n < 2)
    fail(where, concat("a curve needs at least two readings, got ", n, "; record it again or leave it out"));
  if (curve.tangents.rows() != n || curve.normals.rows() != n)
    fail(where, concat(n, " distances but ", curve.tangents.rows(), " tangents and ", curve.normals.rows(),
                       " normals; every reading needs all three"));
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3d t = curve.tangents.row(i), N = curve.normals.row(i);
    // Made in words only when needed: there may be millions of readings.
    const auto reading = [&] { return concat(where, ", reading ", i + 1); };
    if (!std::isfinite(curve.distances[i]) || !t.allFinite() || !N.allFinite())
      fail(reading(), "a value is not a finite number; remove the reading");
    if (i > 0 && curve.distances[i] < curve.distances[i - 1])
      fail(reading(), concat("the distance decreases from ", curve.distances[i - 1], " to ",
                             curve.distances[i], "; readings must follow the curve"));
    if (!(t.norm() > 1e-6)) fail(reading(), "the tangent is zero; remove the reading");
    if (!(N.norm() > 1e-6)) fail(reading(), "the normal is zero; remove the reading");
    if (t.normalized().cross(N.normalized()).norm() < kSmallestSine)
      fail(reading(), "the tangent is parallel to the normal; check which device axis points forward");
  }
  if (!(curve.distances[n - 1] > curve.distances[0]))
    fail(where, "all readings have the same distance, so the curve has no length; check the odometer");
}

void check_nodes(const ScanCurve& curve, NodeNumbers numbers, const std::string& where) {
  const Eigen::Index n = curve.n_readings();
  if (curve.node_readings.size() != curve.node_ids.size())
    fail(where, concat(curve.node_readings.size(), " node readings but ", curve.node_ids.size(),
                       " node numbers; each node needs both"));
  for (size_t j = 0; j < curve.node_readings.size(); ++j) {
    const int reading = curve.node_readings[j];
    if (reading < 0 || reading >= n)
      fail(where, concat("node ", curve.node_ids[j], " is at reading ", reading + 1,
                         ", but the curve has the readings 1 to ", n));
    if (curve.node_ids[j] == kNoNodeNumber && numbers == NodeNumbers::Needed)
      fail(where, concat("the node at reading ", reading + 1,
                         " has no number; write it, or let --nodes auto find the numbers"));
    if (curve.node_ids[j] < 0 && curve.node_ids[j] != kNoNodeNumber)
      fail(where, concat("the node number ", curve.node_ids[j], " is negative"));
    if (j == 0) continue;
    if (reading <= curve.node_readings[j - 1])
      fail(where, concat("the readings of its nodes must increase, but reading ",
                         curve.node_readings[j - 1] + 1, " is followed by ", reading + 1));
    if (!(curve.distances[reading] > curve.distances[curve.node_readings[j - 1]]))
      fail(where, concat("the nodes ", curve.node_ids[j - 1], " and ", curve.node_ids[j],
                         " have the same distance; merge them or record the piece between them"));
  }
  if (!curve.closed || curve.node_ids.empty() || numbers == NodeNumbers::MayMiss) return;
  const bool spans = curve.distances[curve.node_readings.front()] == curve.distances[0] &&
                     curve.distances[curve.node_readings.back()] == curve.distances[n - 1];
  if (curve.node_ids.front() != curve.node_ids.back() || curve.node_ids.size() < 2 || !spans)
    fail(where,
         concat("a closed curve must start at a node and end at the same node, but its nodes run from ",
                curve.node_ids.front(), " at reading ", curve.node_readings.front() + 1, " to ",
                curve.node_ids.back(), " at reading ", curve.node_readings.back() + 1, " of ", n,
                "; repeat the first node at the last reading or mark the curve as open"));
}

void check_connected(const Scan& scan) {
  // Curves are joined where they name the same node.
  std::vector<int> root(scan.curves.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&root](int i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  std::map<int, int> curve_of_node;
  for (int c = 0; c < static_cast<int>(scan.curves.size()); ++c) {
    for (const int id : scan.curves[c].node_ids) {
      const auto [place, is_new] = curve_of_node.emplace(id, c);
      if (!is_new) root[find(c)] = find(place->second);
    }
  }
  for (int c = 1; c < static_cast<int>(scan.curves.size()); ++c) {
    if (find(c) == find(0)) continue;
    throw InvalidInput(concat(curve_label(scan, c), " is not connected with ", curve_label(scan, 0),
                              ": orientations and distances do not tell where separate parts lie; record a "
                              "curve that joins them, or reconstruct them one by one"));
  }
}

}  // namespace

std::string curve_label(const Scan& scan, int curve) {
  const std::string& name = scan.curves[curve].name;
  return name.empty() ? concat("curve ", curve + 1) : concat("curve ", curve + 1, " '", name, "'");
}

void check_scan(const Scan& scan, NodeNumbers numbers) {
  if (scan.curves.empty()) throw InvalidInput("the scan has no curves");
  for (int c = 0; c < static_cast<int>(scan.curves.size()); ++c) {
    const std::string where = curve_label(scan, c);
    check_readings(scan.curves[c], where);
    check_nodes(scan.curves[c], numbers, where);
  }
  if (numbers == NodeNumbers::Needed) check_connected(scan);
}

}  // namespace batten
