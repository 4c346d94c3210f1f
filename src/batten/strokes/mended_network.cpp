#include "batten/strokes/mended_network.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/network/contacts.hpp"
#include "batten/strokes/network_pieces_detail.hpp"
#include "batten/strokes/open_segments_detail.hpp"

namespace batten {

namespace {

/// Tolerances that are tried: from curves on meshes, which miss by rounding and chords, to drawn ones.
constexpr std::array<double, 5> kWeldTolerances{1e-4, 5e-4, 1e-3, 2.5e-3, 5e-3};
/// Curves that stay this near without a vertex in common probably cross, in diameters.
constexpr double kMissedCrossing = 2.5e-3;
/// Vertices nearer than this are one, in diameters.
constexpr double kSamePlace = 1e-9;
/// Normals of two sides of a sharp curve differ by more.
constexpr double kSharpAngle = radians(20);

/// For each vertex, the first one at its place.
std::vector<int> first_at_place(const CurveNetwork& network, double distance) {
  std::map<std::array<std::int64_t, 3>, int> cells;
  std::vector<int> first(at(static_cast<int>(network.positions.rows())));
  for (std::size_t v = 0; v < first.size(); ++v) {
    std::array<std::int64_t, 3> cell{};
    for (int k = 0; k < 3; ++k)
      cell[at(k)] = std::llround(
          (network.positions(static_cast<Eigen::Index>(v), k) - network.positions(0, k)) / distance);
    first[v] = cells.emplace(cell, static_cast<int>(v)).first->second;
  }
  return first;
}

/// The network with vertices at one place merged, cut at nodes, every piece once.
CurveNetwork without_doubles(const CurveNetwork& network, const std::vector<int>& first,
                             MendedNetwork& report) {
  const auto n = first.size();
  std::vector<std::set<int>> neighbours(n);
  std::vector<char> is_node(n, 0);
  for (const NetworkCurve& curve : network.curves) {
    for (std::size_t k = 1; k < curve.vertices.size(); ++k) {
      const int a = first[at(curve.vertices[k - 1])], b = first[at(curve.vertices[k])];
      if (a == b) continue;
      neighbours[at(a)].insert(b);
      neighbours[at(b)].insert(a);
    }
    if (first[at(curve.vertices.front())] != first[at(curve.vertices.back())])
      is_node[at(first[at(curve.vertices.front())])] = is_node[at(first[at(curve.vertices.back())])] = 1;
  }
  for (const int v : network.tagged_nodes) is_node[at(first[at(v)])] = 1;
  for (std::size_t v = 0; v < n; ++v)
    if (neighbours[v].size() > 2) is_node[v] = 1;
  CurveNetwork result = network;
  result.curves.clear();
  result.normals.setZero();
  for (std::size_t v = 0; v < n; ++v)
    result.normals.row(first[v]) += network.normals.row(static_cast<Eigen::Index>(v));
  for (std::size_t v = 0; v < n; ++v) {
    const auto row = static_cast<Eigen::Index>(v);
    result.normals.row(row) = result.normals.row(row).norm() > 1e-6 ? result.normals.row(row).normalized()
                                                                    : network.normals.row(row);
    report.weld.n_merged_vertices += first[v] != static_cast<int>(v);
  }
  struct Piece {
    std::size_t curve;
    std::vector<int> originals;
  };
  std::map<std::vector<int>, Piece> seen;
  for (const NetworkCurve& curve : network.curves) {
    std::vector<int> walk = curve.vertices;
    if (first[at(walk.front())] ==
        first[at(walk.back())]) {  // a loop: from a node, else from its least vertex
      walk.pop_back();
      auto begin = std::find_if(walk.begin(), walk.end(), [&](int v) { return is_node[at(first[at(v)])]; });
      if (begin == walk.end())
        begin = std::min_element(walk.begin(), walk.end(),
                                 [&](int a, int b) { return first[at(a)] < first[at(b)]; });
      std::rotate(walk.begin(), begin, walk.end());
      walk.push_back(walk.front());
    }
    std::vector<int> piece, originals;
    for (std::size_t k = 0; k < walk.size(); ++k) {
      const int v = first[at(walk[k])];
      if (!piece.empty() && piece.back() == v) continue;
      piece.push_back(v);
      originals.push_back(walk[k]);
      if (piece.size() < 2 || (k + 1 < walk.size() && !is_node[at(v)])) continue;
      if (std::lexicographical_compare(piece.rbegin(), piece.rend(), piece.begin(), piece.end())) {
        std::reverse(piece.begin(), piece.end());
        std::reverse(originals.begin(), originals.end());
      }
      const auto [found, is_new] = seen.emplace(piece, Piece{result.curves.size(), originals});
      if (is_new) {
        result.curves.push_back({curve.name, curve.boundary, piece, curve.sharp});
      } else {
        ++report.n_doubled;
        double least = kPi;  // ends aside: there other curves meet
        for (std::size_t i = 1; i + 1 < piece.size(); ++i) {
          const Eigen::Vector3d a = network.normals.row(found->second.originals[i]),
                                b = network.normals.row(originals[i]);
          least = std::min(least, std::atan2(a.cross(b).norm(), a.dot(b)));
        }
        if (piece.size() > 2 && least > kSharpAngle) {
          result.curves[found->second.curve].sharp = true;
          ++report.n_sharp;
        }
      }
      piece = {v};
      originals = {walk[k]};
    }
  }
  for (int& v : result.tagged_nodes) v = first[at(v)];
  return result;
}

/// Leaves out what ends in nothing, and single ways between two parts.
CurveNetwork without_open_pieces(const CurveNetwork& network, MendedNetwork& report) {
  const NetworkTopology topology = network_topology(network);
  detail::OpenSegments open(topology);
  const std::vector<int> tails = open.take_tails();
  const std::vector<int> bridges = open.take_bridges();
  if (tails.empty() && bridges.empty()) return network;
  for (const auto& [list, reason] :
       {std::pair{&tails, "it ends in nothing"}, std::pair{&bridges, "it is the only way between two parts"}})
    for (const int s : *list) {
      const NetworkSegment& segment = topology.segments[at(s)];
      ++report.n_left_out;
      report.warnings.push_back(concat(
          "the piece of ", curve_name(network, segment.curve), " from ",
          detail::coordinates(network.positions.row(segment.vertices.front())), " to ",
          detail::coordinates(network.positions.row(segment.vertices.back())), " was left out: ", reason));
    }
  CurveNetwork result = network;
  result.curves.clear();
  for (std::size_t s = 0; s < topology.segments.size(); ++s)
    if (open.is_kept(static_cast<int>(s))) {
      const NetworkSegment& segment = topology.segments[s];
      const NetworkCurve& curve = network.curves[at(segment.curve)];
      result.curves.push_back({curve.name, segment.boundary, segment.vertices, curve.sharp});
    }
  return detail::compacted(std::move(result));
}

bool has_free_end(const CurveNetwork& network) {
  std::vector<int> degree(at(static_cast<int>(network.positions.rows())), 0);
  for (const NetworkCurve& curve : network.curves)
    for (std::size_t k = 1; k < curve.vertices.size(); ++k) {
      ++degree[at(curve.vertices[k - 1])];
      ++degree[at(curve.vertices[k])];
    }
  return std::find(degree.begin(), degree.end(), 1) != degree.end();
}

/// Places where curves come this near without meeting.
int count_touches(const CurveNetwork& network, double distance) {
  if (network.curves.empty()) return 0;
  const detail::CurveIndex index(network, distance);
  const std::vector<detail::Contact> contacts = index.contacts();
  return static_cast<int>(std::count_if(contacts.begin(), contacts.end(),
                                        [](const detail::Contact& contact) { return !contact.joined; }));
}

MendedNetwork attempt_at(const MendedNetwork& start, double tolerance, double diameter) {
  MendedNetwork result = start;
  WeldedNetwork welded_network = welded(start.network, tolerance * diameter);
  result.weld.n_merged_vertices += welded_network.report.n_merged_vertices;
  result.weld.n_inserted_nodes += welded_network.report.n_inserted_nodes;
  result.weld.n_removed_curves += welded_network.report.n_removed_curves;
  result.weld_tolerance = tolerance;
  result.network = without_open_pieces(welded_network.network, result);
  return result;
}

bool has_patches(const CurveNetwork& network) {
  try {
    find_cycles(network);
    return true;
  } catch (const InvalidInput&) {
    return false;
  }
}

}  // namespace

std::optional<std::string> NetworkMendingOptions::problem() const {
  if (!(weld_tolerance >= 0) || !(weld_tolerance < 0.2))
    return concat("weld_tolerance must be from 0 to 0.2 of the diameter, got ", weld_tolerance);
  return std::nullopt;
}

MendedNetwork mended_network(const CurveNetwork& network, const NetworkMendingOptions& options) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  if (!network.has_normals()) throw InvalidInput("the network has no normals; mend it as a stroke set");
  network_topology(network);  // checks the indices
  MendedNetwork result;
  result.network = network;
  const double diameter = bounding_box_diagonal(network.positions);
  if (network.curves.empty() || !(diameter > 0) || !std::isfinite(diameter)) return result;
  const std::vector<int> first = first_at_place(network, kSamePlace * diameter);
  for (std::size_t v = 0; v < first.size(); ++v)
    result.changed = result.changed || first[v] != static_cast<int>(v);
  if (result.changed) result.network = without_doubles(network, first, result);
  const double least = options.weld_tolerance > 0 ? options.weld_tolerance : kWeldTolerances.front();
  if (has_free_end(result.network) || count_touches(result.network, least * diameter) > 0) {
    result.changed = true;
    const MendedNetwork start = result;
    if (options.weld_tolerance > 0) {
      result = attempt_at(start, options.weld_tolerance, diameter);
    } else {
      bool found = false;
      int blemishes = 0;
      for (const double tolerance : kWeldTolerances) {
        MendedNetwork next = attempt_at(start, tolerance, diameter);
        const bool good = !next.network.curves.empty() && has_patches(next.network);
        // A crossing that is missed takes a patch on both sides of a curve for one.
        const int count = next.n_left_out + count_touches(next.network, kMissedCrossing * diameter);
        const bool better = good != found ? good : count < blemishes;
        if (better || tolerance == kWeldTolerances.front()) {
          result = std::move(next);
          blemishes = count;
        }
        found = found || good;
      }
    }
  }
  if (!result.changed) return result;
  if (result.network.curves.empty())
    throw InvalidInput(
        "the curves form no closed cycle once what ends in nothing is left out; connect their ends");
  if (result.weld.n_merged_vertices + result.weld.n_inserted_nodes > 0)
    result.warnings.insert(
        result.warnings.begin(),
        concat("welded: ", result.weld.n_merged_vertices, " vertices became one with others, ",
               result.weld.n_inserted_nodes, " nodes were put where curves touch (within ",
               100 * result.weld_tolerance, " % of the diameter), ", result.n_doubled,
               " pieces were drawn twice, ", result.n_sharp, " of them as sharp edges"));
  return result;
}

}  // namespace batten
