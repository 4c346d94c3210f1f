#include "batten/strokes/stroke_cleaning.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "batten/core/disjoint_sets.hpp"
#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/box_tree.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/network/contacts.hpp"
#include "batten/strokes/network_pieces_detail.hpp"
#include "batten/strokes/open_segments_detail.hpp"
#include "batten/strokes/overdrawn_strokes_detail.hpp"

namespace batten {

namespace {

using detail::compacted;
using detail::coordinates;
using detail::CurveIndex;
using detail::in_segments;
using detail::length_of;
using detail::position;
using Vector = Eigen::Vector3d;

/// Weld tolerances along a loop, or along both of two curves between the same nodes, that make no patch.
constexpr double kShortest = 6;

std::vector<int> degrees_of(const CurveNetwork& network) {
  std::vector<int> degree(at(static_cast<int>(network.positions.rows())), 0);
  for (const NetworkCurve& curve : network.curves)
    for (size_t k = 1; k < curve.vertices.size(); ++k) {
      ++degree[at(curve.vertices[k])];
      ++degree[at(curve.vertices[k - 1])];
    }
  return degree;
}

/// Free ends go on to the nearest stroke within reach: to a vertex of it, or one put there.
CurveNetwork with_extended_ends(const CurveNetwork& network, double reach, double tolerance,
                                int& n_extended) {
  const CurveIndex index(network, tolerance);
  const std::vector<int> degree = degrees_of(network);
  CurveNetwork result = network;
  std::vector<Vector> added;
  const auto n = static_cast<int>(network.positions.rows());
  struct Insertion {
    double place;
    int vertex;
  };
  std::vector<std::vector<Insertion>> insertions(network.curves.size());
  std::set<std::pair<int, int>> joined;  // pairs of ends that were led to each other
  struct Extension {
    int curve;
    bool at_last;
    int vertex;
  };
  std::vector<Extension> extensions;
  for (int c = 0; c < static_cast<int>(network.curves.size()); ++c) {
    const NetworkCurve& curve = network.curves[at(c)];
    if (curve.closed()) continue;
    for (const bool at_last : {false, true}) {
      const int end = at_last ? curve.vertices.back() : curve.vertices.front();
      if (degree[at(end)] != 1) continue;
      const auto place = index.nearest_other(c, at_last, reach);
      if (!place) continue;
      const std::vector<int>& theirs = network.curves[at(place->curve)].vertices;
      const double gap = (place->point - position(network, end)).norm();
      // A vertex hardly farther away than the nearest point is taken as it is, an end before others.
      const double near = std::max(tolerance, 0.3 * gap);
      int target = -1;
      double least = near;
      for (const int v :
           {theirs.front(), theirs.back(), theirs[at(place->edge)], theirs[at(place->edge) + 1]}) {
        const double distance = (position(network, v) - place->point).norm() * (degree[at(v)] == 1 ? 0.5 : 1);
        if (v != end && distance < least) {
          least = distance;
          target = v;
        }
      }
      if (target < 0) {
        target = n + static_cast<int>(added.size());
        added.push_back(place->point);
        insertions[at(place->curve)].push_back({place->edge + place->fraction, target});
      } else if (!joined.insert({std::min(end, target), std::max(end, target)}).second) {
        continue;  // the other end was led here already
      }
      extensions.push_back({c, at_last, target});
      ++n_extended;
    }
  }
  for (size_t c = 0; c < insertions.size(); ++c) {
    std::sort(insertions[c].begin(), insertions[c].end(),
              [](const Insertion& a, const Insertion& b) { return a.place < b.place; });
    std::vector<int> vertices;
    size_t next = 0;
    for (size_t k = 0; k < network.curves[c].vertices.size(); ++k) {
      vertices.push_back(network.curves[c].vertices[k]);
      while (next < insertions[c].size() && insertions[c][next].place < static_cast<double>(k + 1))
        vertices.push_back(insertions[c][next++].vertex);
    }
    result.curves[c].vertices = std::move(vertices);
  }
  for (const Extension& extension : extensions) {
    std::vector<int>& vertices = result.curves[at(extension.curve)].vertices;
    vertices.insert(extension.at_last ? vertices.end() : vertices.begin(), extension.vertex);
  }
  result.positions.conservativeResize(n + static_cast<Eigen::Index>(added.size()), 3);
  for (size_t i = 0; i < added.size(); ++i)
    result.positions.row(n + static_cast<Eigen::Index>(i)) = added[i].transpose();
  return result;
}

/// Segments shorter than the tolerance shrink to a node between their ends, and of segments that run beside
/// each other between the same nodes one is left.
CurveNetwork without_slivers(const CurveNetwork& network, double tolerance, double shortest,
                             double shortest_loop, int& n_dropped) {
  CurveNetwork pieces = in_segments(network);
  const auto n = static_cast<int>(pieces.positions.rows());
  DisjointSets merged(n);
  std::vector<NetworkCurve> kept;
  for (NetworkCurve& piece : pieces.curves) {
    if (length_of(pieces, piece.vertices) >= tolerance) {
      kept.push_back(std::move(piece));
      continue;
    }
    merged.unite(piece.vertices.front(), piece.vertices.back());
  }
  std::vector<Vector> sum(at(n), Vector::Zero());
  std::vector<int> count(at(n), 0);
  for (int v = 0; v < n; ++v) {
    sum[at(merged.root(v))] += position(network, v);
    ++count[at(merged.root(v))];
  }
  for (int v = 0; v < n; ++v)
    if (count[at(v)] > 1) pieces.positions.row(v) = sum[at(v)] / count[at(v)];
  std::map<std::pair<int, int>, std::vector<size_t>> between;
  std::vector<NetworkCurve> result;
  for (NetworkCurve& piece : kept) {
    piece.vertices.front() = merged.root(piece.vertices.front());
    piece.vertices.back() = merged.root(piece.vertices.back());
    const int a = piece.vertices.front(), b = piece.vertices.back();
    // Loops, and pairs between the same nodes, too short to bound a patch; a loop has both sides in one.
    const double length = length_of(pieces, piece.vertices);
    const bool is_short = length < shortest;
    if (a == b && (length < shortest_loop || piece.vertices.size() < 4)) {
      ++n_dropped;
      continue;
    }
    std::vector<size_t>& others = between[{std::min(a, b), std::max(a, b)}];
    const auto beside = [&](size_t other) {
      const std::vector<int>& theirs = result[other].vertices;
      return std::all_of(piece.vertices.begin(), piece.vertices.end(), [&](int v) {
        for (size_t k = 1; k < theirs.size(); ++k)
          if (closest_point_on_segment(position(pieces, v), position(pieces, theirs[k - 1]),
                                       position(pieces, theirs[k]))
                  .squared_distance <= 4 * tolerance * tolerance)
            return true;
        return false;
      });
    };
    // Twice the tolerance: either may have moved by it.
    const auto as_short = [&](size_t other) {
      return is_short && length_of(pieces, result[other].vertices) < shortest;
    };
    if (std::any_of(others.begin(), others.end(), [&](size_t o) { return as_short(o) || beside(o); })) {
      ++n_dropped;
      continue;
    }
    others.push_back(result.size());
    result.push_back(std::move(piece));
  }
  pieces.curves = std::move(result);
  return compacted(std::move(pieces));
}

/// Leaves out segments that end in nothing, and bridges, which would have one patch on both sides.
/// @param result takes a warning for each. @param left_out takes the segments themselves.
CurveNetwork without_tails(const CurveNetwork& network, CleanedStrokes& result,
                           std::vector<std::vector<Vector>>& left_out) {
  CurveNetwork pieces = in_segments(network);
  const NetworkTopology topology = network_topology(pieces);
  const std::vector<NetworkSegment>& segments = topology.segments;
  const auto leave_out = [&](int s, const char* reason) {
    const std::vector<int>& vertices = segments[at(s)].vertices;
    const std::string& name = pieces.curves[at(segments[at(s)].curve)].name;
    ++result.n_left_out;
    left_out.emplace_back();
    for (const int v : vertices) left_out.back().push_back(position(pieces, v));
    result.warnings.push_back(concat("the piece ", name.empty() ? std::string() : concat("of ", name, " "),
                                     "from ", coordinates(position(pieces, vertices.front())), " to ",
                                     coordinates(position(pieces, vertices.back())),
                                     " was left out: ", reason));
  };
  detail::OpenSegments open(topology);
  for (const int s : open.take_tails())
    leave_out(s, "it ends in nothing; connect its end to have patches on both of its sides");
  for (const int s : open.take_bridges())
    leave_out(s,
              "it is the only way between two parts, so that one patch would lie on both of its sides; "
              "connect the parts by a second curve");
  std::vector<NetworkCurve> curves;
  for (size_t s = 0; s < segments.size(); ++s)
    if (open.is_kept(static_cast<int>(s)))
      curves.push_back({pieces.curves[at(segments[s].curve)].name, segments[s].boundary, segments[s].vertices,
                        pieces.curves[at(segments[s].curve)].sharp});
  pieces.curves = std::move(curves);
  return compacted(std::move(pieces));
}

/// Reports strokes of which nothing is left, neither in the network nor among the warnings there are: they
/// are so small that welding has drawn them together.
void report_lost_strokes(const CurveNetwork& strokes, std::vector<std::vector<Vector>> lines,
                         double tolerance, CleanedStrokes& result) {
  for (const NetworkCurve& curve : result.network.curves) {
    lines.emplace_back();
    for (const int v : curve.vertices) lines.back().push_back(position(result.network, v));
  }
  std::vector<std::pair<Vector, Vector>> edges;
  std::vector<Box> boxes;
  for (const std::vector<Vector>& line : lines)
    for (size_t k = 1; k < line.size(); ++k) {
      edges.emplace_back(line[k - 1], line[k]);
      boxes.push_back({line[k - 1].cwiseMin(line[k]), line[k - 1].cwiseMax(line[k])});
    }
  const BoxTree tree(boxes);
  const auto is_near = [&](const Vector& p) {
    bool found = false;
    tree.query({p.array() - tolerance, p.array() + tolerance}, [&](int e) {
      const auto& [a, b] = edges[at(e)];
      found = closest_point_on_segment(p, a, b).squared_distance <= tolerance * tolerance;
      return !found;
    });
    return found;
  };
  for (size_t c = 0; c < strokes.curves.size(); ++c) {
    const std::vector<int>& vertices = strokes.curves[c].vertices;
    if (std::any_of(vertices.begin(), vertices.end(), [&](int v) { return is_near(position(strokes, v)); }))
      continue;
    ++result.n_left_out;
    result.warnings.push_back(concat(curve_name(strokes, static_cast<int>(c)), " from ",
                                     coordinates(position(strokes, vertices.front())), " to ",
                                     coordinates(position(strokes, vertices.back())),
                                     " was left out: it is too short to bound a patch beside the size of the "
                                     "sketch; surface small parts on their own, or weld within less"));
  }
}

void add(WeldReport& sum, const WeldReport& report) {
  sum.n_merged_vertices += report.n_merged_vertices;
  sum.n_inserted_nodes += report.n_inserted_nodes;
  sum.n_removed_curves += report.n_removed_curves;
}

}  // namespace

std::optional<std::string> StrokeCleaningOptions::problem() const {
  if (!(weld_tolerance > 0) || !(weld_tolerance < 0.2))
    return concat("weld_tolerance must be between 0 and 0.2 of the diameter, got ", weld_tolerance);
  if (!(reach >= 0) || !(reach < 0.5))
    return concat("reach must be from 0 to 0.5 of the diameter, got ", reach);
  if (!(shortest_side >= 0) || !(shortest_side < 0.5))
    return concat("shortest_side must be from 0 to 0.5 of the diameter, got ", shortest_side);
  return std::nullopt;
}

CurveNetwork joined_curves(const CurveNetwork& network) {
  const NetworkTopology topology = network_topology(network);
  const std::vector<NetworkSegment>& segments = topology.segments;
  std::vector<std::vector<int>> leaving(topology.nodes.size());  // half-edges: 2s forwards, 2s + 1 backwards
  for (size_t s = 0; s < segments.size(); ++s) {
    leaving[at(segments[s].from)].push_back(static_cast<int>(2 * s));
    leaving[at(segments[s].to)].push_back(static_cast<int>(2 * s + 1));
  }
  const std::set<int> tagged(network.tagged_nodes.begin(), network.tagged_nodes.end());
  // A curve goes on where two segments meet, and where it did before (at crossings).
  const auto following = [&](int half_edge) {
    const int node = half_edge % 2 == 0 ? segments[at(half_edge / 2)].to : segments[at(half_edge / 2)].from;
    const std::vector<int>& half_edges = leaving[at(node)];
    if (half_edges.size() == 2 && half_edges[0] / 2 != half_edges[1] / 2 &&
        tagged.count(topology.nodes[at(node)]) == 0) {
      const int next = half_edges[0] == (half_edge ^ 1) ? half_edges[1] : half_edges[0];
      const NetworkSegment &here = segments[at(half_edge / 2)], &there = segments[at(next / 2)];
      const bool same_kind = here.boundary == there.boundary &&
                             network.curves[at(here.curve)].sharp == network.curves[at(there.curve)].sharp;
      return same_kind ? next : -1;
    }
    const int beside =
        half_edge % 2 == 0 ? half_edge + 2 : half_edge - 2;  // segments of a curve follow each other
    if (beside < 0 || at(beside / 2) >= segments.size()) return -1;
    const NetworkSegment& next = segments[at(beside / 2)];
    const bool same =
        next.curve == segments[at(half_edge / 2)].curve && (beside % 2 == 0 ? next.from : next.to) == node;
    return same ? beside : -1;
  };
  CurveNetwork result = network;
  result.curves.clear();
  std::vector<char> taken(segments.size(), 0);
  const auto walk = [&](int half_edge) {
    const NetworkSegment& first = segments[at(half_edge / 2)];
    NetworkCurve curve{
        network.curves[at(first.curve)].name, first.boundary, {}, network.curves[at(first.curve)].sharp};
    for (; half_edge >= 0 && !taken[at(half_edge / 2)]; half_edge = following(half_edge)) {
      taken[at(half_edge / 2)] = 1;
      std::vector<int> vertices = segments[at(half_edge / 2)].vertices;
      if (half_edge % 2 == 1) std::reverse(vertices.begin(), vertices.end());
      curve.vertices.insert(curve.vertices.end(), vertices.begin() + (curve.vertices.empty() ? 0 : 1),
                            vertices.end());
    }
    result.curves.push_back(std::move(curve));
  };
  for (size_t s = 0; s < segments.size(); ++s)
    for (const int half_edge : {static_cast<int>(2 * s), static_cast<int>(2 * s + 1)})
      if (!taken[s] && following(half_edge ^ 1) < 0) walk(half_edge);
  for (size_t s = 0; s < segments.size(); ++s)
    if (!taken[s]) walk(static_cast<int>(2 * s));
  return result;
}

CleanedStrokes clean_strokes(const CurveNetwork& given, const StrokeCleaningOptions& options) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  CleanedStrokes result;
  CurveNetwork strokes = given;
  strokes.normals.resize(0, 3);
  strokes = compacted(joined_curves(strokes));
  result.n_strokes = static_cast<int>(strokes.curves.size());
  const double diameter = bounding_box_diagonal(strokes.positions);
  if (!(diameter > 0) || !std::isfinite(diameter))
    throw InvalidInput("the sketch has no extent, or a coordinate that is not a number");
  result.findings = diagnose_network(strokes);
  const double tolerance = options.weld_tolerance * diameter;

  const auto weld = [&](const CurveNetwork& loose) {
    WeldedNetwork welded_network = welded(loose, tolerance);
    add(result.weld, welded_network.report);
    return std::move(welded_network.network);
  };
  CurveNetwork network = weld(detail::without_overdrawn(strokes, tolerance, result.n_overdrawn));
  if (options.reach > options.weld_tolerance)
    network = with_extended_ends(network, options.reach * diameter, tolerance, result.n_extended_ends);
  network = weld(network);
  const double shortest = std::max(kShortest * tolerance, options.shortest_side * diameter);
  const double shortest_loop = std::max(shortest, 2 * options.shortest_side * diameter);
  network = without_slivers(network, 2 * tolerance, shortest, shortest_loop, result.n_overdrawn);
  std::vector<std::vector<Vector>> left_out;
  network = joined_curves(without_tails(network, result, left_out));
  // What was left out may leave other curves behind that are too short to bound a patch.
  for (std::size_t before = 0; before != network.curves.size();) {
    before = network.curves.size();
    network = without_slivers(network, 0, options.shortest_side * diameter,
                              2 * options.shortest_side * diameter, result.n_overdrawn);
    network = joined_curves(without_tails(network, result, left_out));
  }
  result.network = std::move(network);
  // Ends may have been moved by the tolerance more than once, and overdrawn strokes lie beside another.
  report_lost_strokes(strokes, std::move(left_out), 3 * tolerance, result);
  return result;
}

}  // namespace batten
