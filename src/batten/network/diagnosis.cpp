#include "batten/network/diagnosis.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <tuple>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/network/contacts.hpp"

namespace batten {

namespace {

using detail::Contact;
using detail::CurveIndex;
using detail::CurvePlace;
using Vector = Eigen::Vector3d;

std::string coordinates(const Vector& p) {
  return concat("(", p.x(), ", ", p.y(), ", ", p.z(), ")");
}

class Diagnosis {
 public:
  Diagnosis(const CurveNetwork& network, const DiagnosisOptions& options)
      : network_(network),
        options_(options),
        topology_(network_topology(network)),
        diameter_(bounding_box_diagonal(network.positions)) {}

  std::vector<NetworkFinding> run() {
    if (network_.curves.empty()) return {};
    const double meeting = options_.meeting_distance * diameter_;
    if (meeting > 0) {
      const CurveIndex index(network_, meeting);
      look_at_ends(index);
      look_at_contacts(index);
    }
    look_at_parts();
    look_at_boundary();
    look_at_normals();
    look_at_patches();
    std::stable_sort(
        findings_.begin(), findings_.end(), [](const NetworkFinding& a, const NetworkFinding& b) {
          return std::tie(a.defect, a.curve, a.other_curve) < std::tie(b.defect, b.curve, b.other_curve);
        });
    return std::move(findings_);
  }

 private:
  std::string name(int curve) const { return curve_name(network_, curve); }
  Vector position(int vertex) const { return network_.positions.row(vertex); }
  int vertex_near(const CurvePlace& place) const {
    return network_.curves[at(place.curve)].vertices[at(place.edge + (place.fraction > 0.5 ? 1 : 0))];
  }

  void add(NetworkDefect defect, int curve, int other, int vertex, const Vector& where, double distance,
           std::string sentence) {
    findings_.push_back({defect, curve, other, vertex, where, distance, std::move(sentence)});
  }

  /// Ends of open curves that no other curve shares.
  void look_at_ends(const CurveIndex& index) {
    std::vector<int> degree(at(static_cast<int>(network_.positions.rows())), 0);
    for (const NetworkCurve& curve : network_.curves)
      for (size_t k = 1; k < curve.vertices.size(); ++k) {
        ++degree[at(curve.vertices[k])];
        ++degree[at(curve.vertices[k - 1])];
      }
    for (int c = 0; c < static_cast<int>(network_.curves.size()); ++c) {
      const NetworkCurve& curve = network_.curves[at(c)];
      if (curve.closed()) continue;
      for (const bool at_last : {false, true}) {
        const int vertex = at_last ? curve.vertices.back() : curve.vertices.front();
        if (degree[at(vertex)] != 1) continue;
        const Vector end = position(vertex);
        const auto nearest = index.nearest_other(c, at_last, std::numeric_limits<double>::infinity());
        const char* which = at_last ? "the end" : "the beginning";
        const std::string place =
            concat(which, " of ", name(c), " (vertex ", vertex, " at ", coordinates(end), ")");
        if (!nearest) {
          add(NetworkDefect::DanglingEnd, c, -1, vertex, end, 0,
              concat(place, " meets no other curve; there is none to connect it to"));
          continue;
        }
        const double gap = (nearest->point - end).norm();
        const int there = vertex_near(*nearest);
        const std::string target = concat(name(nearest->curve), " near its vertex ", there);
        const std::string far = concat(gap, ", ", 100 * gap / diameter_, " % of the diameter");
        if (gap <= options_.meeting_distance * diameter_) {
          free_ends_.push_back(end);
          add(NetworkDefect::TJunction, c, nearest->curve, vertex, end, gap,
              concat(place, " lies on ", target, " (", far,
                     " away) without sharing a vertex; weld with a tolerance above that"));
        } else if (gap <= options_.near_miss_distance * diameter_) {
          add(NetworkDefect::NearMiss, c, nearest->curve, vertex, end, gap,
              concat(place, " stops ", far, ", short of ", target,
                     "; extend the curve or weld with a tolerance above that"));
        } else {
          add(NetworkDefect::DanglingEnd, c, nearest->curve, vertex, end, gap,
              concat(place, " meets no other curve, the nearest is ", target, " (", far,
                     " away); connect it or remove the curve"));
        }
      }
    }
  }

  void look_at_contacts(const CurveIndex& index) {
    const double meeting = options_.meeting_distance * diameter_;
    // Two lines that cross at 6 degrees stay this near to each other over 20 times the distance.
    const double overlap = 20 * meeting;
    for (const Contact& contact : index.contacts()) {
      const int a = contact.first.curve, b = contact.second.curve;
      const int vertex = vertex_near(contact.first);
      const Vector& where = contact.first.point;
      const std::string place = concat("near vertex ", vertex, " at ", coordinates(where));
      if (a != b && contact.length > overlap) {
        const bool all = contact.length > 0.9 * index.length(a) && contact.length > 0.9 * index.length(b);
        add(all ? NetworkDefect::DuplicateCurve : NetworkDefect::Overlap, a, b, vertex, where, contact.length,
            all ? concat(name(a), " and ", name(b), " are the same curve; remove one of them")
                : concat(name(a), " and ", name(b), " run along each other for ", contact.length, " ", place,
                         "; cut one of them back to where they meet"));
        continue;
      }
      if (contact.joined) continue;
      if (std::any_of(free_ends_.begin(), free_ends_.end(),
                      [&](const Vector& end) { return (end - where).norm() <= 3 * meeting; }))
        continue;
      if (a == b)
        add(NetworkDefect::SelfCrossing, a, -1, vertex, where, contact.distance,
            concat(name(a), " crosses itself ", place,
                   " without a vertex there; split it at the crossing or draw it again"));
      else
        add(NetworkDefect::Crossing, a, b, vertex, where, contact.distance,
            concat(name(a), " and ", name(b), " cross ", place, " (", contact.distance,
                   " apart) without sharing a vertex; weld with a tolerance above that"));
    }
  }

  void look_at_parts() {
    if (topology_.n_components < 2) return;
    const auto parts = at(topology_.n_components);
    std::vector<std::vector<int>> edges(parts);
    std::vector<int> first_curve(parts, -1);
    std::vector<int> n_curves(parts, 0), part_of_curve(network_.curves.size(), -1);
    for (const NetworkSegment& segment : topology_.segments) {
      const size_t part = at(topology_.component_of_node[at(segment.from)]);
      if (first_curve[part] < 0) first_curve[part] = segment.curve;
      if (part_of_curve[at(segment.curve)] < 0) ++n_curves[part];
      part_of_curve[at(segment.curve)] = static_cast<int>(part);
      for (size_t k = 1; k < segment.vertices.size(); ++k) {
        edges[part].push_back(segment.vertices[k - 1]);
        edges[part].push_back(segment.vertices[k]);
      }
    }
    const auto largest = static_cast<size_t>(
        std::max_element(edges.begin(), edges.end(),
                         [](const auto& x, const auto& y) { return x.size() < y.size(); }) -
        edges.begin());
    const Segments main = Eigen::Map<const Segments>(edges[largest].data(),
                                                     static_cast<Eigen::Index>(edges[largest].size() / 2), 2);
    const SegmentTree tree(network_.positions, main);
    for (size_t part = 0; part < parts; ++part) {
      if (part == largest || edges[part].empty()) continue;
      int nearest = edges[part][0];
      double least = std::numeric_limits<double>::infinity();
      for (const int v : edges[part])
        if (const double squared = tree.closest(position(v)).squared_distance; squared < least) {
          least = squared;
          nearest = v;
        }
      const double gap = std::sqrt(least);
      add(NetworkDefect::SeparateParts, first_curve[part], first_curve[largest], nearest, position(nearest),
          gap,
          concat("the part with ", name(first_curve[part]),
                 n_curves[part] > 1 ? concat(" and ", n_curves[part] - 1, " more") : std::string(),
                 " shares no vertex with the part of ", name(first_curve[largest]),
                 "; it comes nearest at vertex ", nearest, ", ", gap,
                 " away; connect them or surface them one by one if they belong to one object"));
    }
  }

  void look_at_boundary() {
    std::map<int, int> degree;  // of vertices, counting edges of border curves
    std::map<int, int> curve_at;
    for (int c = 0; c < static_cast<int>(network_.curves.size()); ++c) {
      const NetworkCurve& curve = network_.curves[at(c)];
      if (!curve.boundary) continue;
      for (size_t k = 1; k < curve.vertices.size(); ++k)
        for (const int v : {curve.vertices[k - 1], curve.vertices[k]}) {
          ++degree[v];
          curve_at.emplace(v, c);
        }
    }
    for (const auto& [vertex, n] : degree)
      if (n % 2 == 1)
        add(NetworkDefect::OpenBoundary, curve_at[vertex], -1, vertex, position(vertex), 0,
            concat("the border does not close: ", n, n == 1 ? " tagged edge ends" : " tagged edges meet",
                   " at vertex ", vertex, " of ", name(curve_at[vertex]),
                   "; tag the curve that continues the border there as boundary"));
  }

  void look_at_normals() {
    if (!network_.has_normals()) return;
    const auto n = static_cast<int>(network_.positions.rows());
    const auto normal = [&](int v) { return Vector(network_.normals.row(v)); };
    // Neighbours on one side of the surface have normals less than a right angle apart. Vertices are coloured
    // by the side that this gives; the smaller colour of each part is the flipped one.
    std::vector<std::vector<int>> neighbours(at(n));
    for (const NetworkCurve& curve : network_.curves)
      for (size_t k = 1; k < curve.vertices.size(); ++k) {
        neighbours[at(curve.vertices[k])].push_back(curve.vertices[k - 1]);
        neighbours[at(curve.vertices[k - 1])].push_back(curve.vertices[k]);
      }
    std::vector<int> side(at(n), 0);
    for (int seed = 0; seed < n; ++seed) {
      if (side[at(seed)] != 0 || neighbours[at(seed)].empty()) continue;
      std::vector<int> part{seed};
      side[at(seed)] = 1;
      long sum = 0;
      for (size_t k = 0; k < part.size(); ++k) {
        const int v = part[k];
        sum += side[at(v)];
        for (const int w : neighbours[at(v)])
          if (side[at(w)] == 0) {
            side[at(w)] = normal(v).dot(normal(w)) < 0 ? -side[at(v)] : side[at(v)];
            part.push_back(w);
          }
      }
      if (sum < 0)
        for (const int v : part) side[at(v)] = -side[at(v)];
    }
    for (int c = 0; c < static_cast<int>(network_.curves.size()); ++c) {
      const std::vector<int>& vertices = network_.curves[at(c)].vertices;
      const auto flipped =
          std::count_if(vertices.begin(), vertices.end(), [&](int v) { return side[at(v)] < 0; });
      // A node shared with a flipped curve is told there.
      const auto first =
          std::find_if(vertices.begin(), vertices.end(), [&](int v) { return side[at(v)] < 0; });
      if (flipped > 0 && (flipped > 1 || neighbours[at(*first)].size() == 2 || vertices.size() <= 2))
        add(NetworkDefect::FlippedNormals, c, -1, *first, position(*first), 0,
            concat(flipped, " of the ", vertices.size(), " normals of ", name(c), ", the first at vertex ",
                   *first, ", point to the other side than their neighbours'; turn them over"));
      double worst = 0;
      int worst_vertex = -1;
      const auto last = static_cast<int>(vertices.size()) - 1;
      const bool closed = network_.curves[at(c)].closed();
      for (int k = 0; k <= last; ++k) {
        const int before = k > 0 ? k - 1 : closed ? last - 1 : k, after = k < last ? k + 1 : closed ? 1 : k;
        const Vector u = position(vertices[at(after)]) - position(vertices[at(k)]),
                     v = position(vertices[at(k)]) - position(vertices[at(before)]);
        // At a corner of the curve either side will do; the smaller tilt counts.
        double tilt = std::numeric_limits<double>::infinity();
        const Vector both = position(vertices[at(after)]) - position(vertices[at(before)]);
        for (const Vector& tangent : {u, v, both})
          if (tangent.norm() > 0)
            tilt = std::min(
                tilt, std::asin(std::min(1.0, std::abs(tangent.normalized().dot(normal(vertices[at(k)]))))));
        if (std::isfinite(tilt) && tilt > worst) {
          worst = tilt;
          worst_vertex = vertices[at(k)];
        }
      }
      if (worst > options_.max_normal_tilt)
        add(NetworkDefect::TiltedNormal, c, -1, worst_vertex, position(worst_vertex), worst,
            concat("the normal at vertex ", worst_vertex, " of ", name(c), " is ", degrees(worst),
                   " degrees from perpendicular to the curve; check it"));
    }
  }

  /// Cycles exist only where the rest is in order; what keeps them from being traced is told as it is thrown.
  void look_at_patches() {
    if (!network_.has_normals()) return;
    try {
      const CycleReport report = find_cycles(network_);
      for (size_t c = 0; c < report.cycles.size(); ++c)
        for (const NetworkCycle::Loop& loop : report.cycles[c].loops) {
          std::map<int, int> passes;
          for (const int v : loop.vertices) ++passes[v];
          std::map<int, int> walked;  // a segment walked both ways leads to a dangling end, told above
          for (const int s : loop.segments) ++walked[s < 0 ? ~s : s];
          const bool has_bridge =
              std::any_of(walked.begin(), walked.end(), [](const auto& w) { return w.second > 1; });
          const auto twice =
              std::find_if(passes.begin(), passes.end(), [](const auto& p) { return p.second > 1; });
          if (has_bridge || twice == passes.end()) continue;
          const int segment = loop.segments.front() < 0 ? ~loop.segments.front() : loop.segments.front();
          add(NetworkDefect::SelfCrossing, topology_.segments[at(segment)].curve, -1, twice->first,
              position(twice->first), 0,
              concat("cycle ", c, " passes vertex ", twice->first, " ", twice->second,
                     " times; split it there by another curve or separate the curves"));
        }
      for (const std::string& warning : report.warnings)
        add(NetworkDefect::UntraceablePatches, -1, -1, -1, Vector::Zero(), 0, warning);
    } catch (const InvalidInput& problem) {
      add(NetworkDefect::UntraceablePatches, -1, -1, -1, Vector::Zero(), 0, problem.what());
    }
  }

  const CurveNetwork& network_;
  DiagnosisOptions options_;
  NetworkTopology topology_;
  double diameter_;
  std::vector<Vector> free_ends_;  // that lie on another curve, told once as T-junctions
  std::vector<NetworkFinding> findings_;
};

}  // namespace

std::string_view defect_name(NetworkDefect defect) {
  switch (defect) {
    case NetworkDefect::DanglingEnd:
      return "dangling end";
    case NetworkDefect::NearMiss:
      return "near miss";
    case NetworkDefect::TJunction:
      return "T-junction without a vertex";
    case NetworkDefect::Crossing:
      return "crossing without a vertex";
    case NetworkDefect::SelfCrossing:
      return "self-crossing";
    case NetworkDefect::Overlap:
      return "overlap";
    case NetworkDefect::DuplicateCurve:
      return "duplicate curve";
    case NetworkDefect::FlippedNormals:
      return "flipped normals";
    case NetworkDefect::TiltedNormal:
      return "tilted normal";
    case NetworkDefect::OpenBoundary:
      return "open boundary";
    case NetworkDefect::UntraceablePatches:
      return "patches";
    case NetworkDefect::SeparateParts:
      return "separate parts";
  }
  return "";
}

int count_findings(const std::vector<NetworkFinding>& findings, NetworkDefect defect) {
  return static_cast<int>(std::count_if(findings.begin(), findings.end(),
                                        [&](const NetworkFinding& f) { return f.defect == defect; }));
}

std::optional<std::string> DiagnosisOptions::problem() const {
  const auto is_length = [](double value) { return value >= 0 && std::isfinite(value); };
  if (!is_length(meeting_distance))
    return concat("meeting_distance must be finite and at least 0, got ", meeting_distance);
  if (!is_length(near_miss_distance))
    return concat("near_miss_distance must be finite and at least 0, got ", near_miss_distance);
  if (!(max_normal_tilt >= 0)) return concat("max_normal_tilt must be at least 0, got ", max_normal_tilt);
  return std::nullopt;
}

std::vector<NetworkFinding> diagnose_network(const CurveNetwork& network, const DiagnosisOptions& options) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  return Diagnosis(network, options).run();
}

}  // namespace batten
