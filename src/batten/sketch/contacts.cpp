#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include <Eigen/Geometry>

#include "batten/core/text.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/sketch/contacts_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Times the snapping distance: nearer along a stroke, two places are one.
constexpr double kSamePlace = 0.05;

/// Closest points of two segments p + s d and q + t e (Ericson, Real-Time Collision Detection, 5.1.9).
struct SegmentPair {
  double s = 0, t = 0, distance = 0;
};
SegmentPair closest(const Vector3d& p, const Vector3d& d, const Vector3d& q, const Vector3d& e) {
  const Vector3d r = p - q;
  const double a = d.dot(d), b = e.dot(e), c = d.dot(e), f = e.dot(r), g = d.dot(r);
  const double det = a * b - c * c;
  SegmentPair pair;
  pair.s = det > 1e-12 * a * b ? std::clamp((c * f - g * b) / det, 0.0, 1.0) : 0;
  pair.t = b > 0 ? (c * pair.s + f) / b : 0;
  if (pair.t < 0 || pair.t > 1) {
    pair.t = std::clamp(pair.t, 0.0, 1.0);
    pair.s = a > 0 ? std::clamp((c * pair.t - g) / a, 0.0, 1.0) : 0;
  }
  pair.distance = (p + pair.s * d - q - pair.t * e).norm();
  return pair;
}

Box grown(Box box, double by) {
  box.low.array() -= by;
  box.high.array() += by;
  return box;
}

/// The same line with segments of at most `step` (and at most 20,000 of them): where a stroke runs along a
/// curve, the nearest places of each segment then show it.
Polyline finely_divided(const Points& points, double step) {
  double length = 0;
  for (Index i = 1; i < points.rows(); ++i) length += (points.row(i) - points.row(i - 1)).norm();
  step = std::max(step, length / 20000);
  std::vector<Vector3d> fine{points.row(0)};
  for (Index i = 1; i < points.rows(); ++i) {
    const Vector3d a = points.row(i - 1), b = points.row(i);
    const int parts = std::max(1, static_cast<int>(std::ceil((b - a).norm() / step)));
    for (int k = 1; k < parts; ++k) fine.emplace_back(a + (b - a) * k / parts);
    fine.push_back(b);
  }
  Points rows(static_cast<Index>(fine.size()), 3);
  for (size_t i = 0; i < fine.size(); ++i) rows.row(static_cast<Index>(i)) = fine[i].transpose();
  return Polyline(std::move(rows));
}

/// Pairs (edge, block of the line) whose boxes come within `snap` of each other, in this order.
std::vector<std::pair<int, int>> near_pairs(const PolylineMesh& mesh, const Polyline& line, double snap) {
  std::vector<std::pair<int, int>> pairs;
  for (size_t block = 0; block < line.blocks().size(); ++block)
    for (const int edge : mesh.edge_boxes().meeting(grown(line.blocks()[block], snap)))
      pairs.emplace_back(edge, static_cast<int>(block));
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

StrokeContact contact_of(const PolylineMesh& mesh, const Hit& hit, double snap) {
  const SketchEdge& edge = mesh.edge(hit.edge);
  StrokeContact contact;
  contact.arc = hit.arc;
  contact.edge = hit.edge;
  contact.edge_arc = hit.edge_arc;
  contact.distance = hit.distance;
  contact.position = edge.polyline->at(hit.edge_arc);
  const double to_ends[2] = {hit.edge_arc, edge.polyline->length() - hit.edge_arc};
  const int nearer = to_ends[0] <= to_ends[1] ? 0 : 1;
  // A seam is invisible to whoever draws, so it does not attract; it is only taken where it would leave a
  // sliver.
  const int vertex = edge.vertices[static_cast<size_t>(nearer)];
  const double reach = mesh.vertex(vertex).is_seam ? kSamePlace * snap : snap;
  if ((contact.position - mesh.vertex(vertex).position).norm() <= reach && to_ends[nearer] <= 2 * reach) {
    contact.vertex = vertex;
    contact.edge = -1;
    contact.position = mesh.vertex(vertex).position;
  }
  return contact;
}

/// Whether a way of at most `most` leads along the edges of the model from one contact to the other.
bool near_along_edges(const PolylineMesh& mesh, const StrokeContact& a, const StrokeContact& b, double most) {
  // The vertices that a contact is next to, and how far away.
  const auto ends_of = [&](const StrokeContact& contact) {
    std::vector<std::pair<double, int>> ends;
    if (contact.vertex >= 0) {
      ends.emplace_back(0, contact.vertex);
    } else {
      const SketchEdge& edge = mesh.edge(contact.edge);
      ends.emplace_back(contact.edge_arc, edge.vertices[0]);
      ends.emplace_back(edge.polyline->length() - contact.edge_arc, edge.vertices[1]);
    }
    return ends;
  };
  if (a.edge >= 0 && a.edge == b.edge && std::abs(a.edge_arc - b.edge_arc) <= most) return true;
  std::map<int, double> reached;
  std::set<std::pair<double, int>> front;  // Dijkstra's, from a
  for (const auto& [distance, vertex] : ends_of(a)) front.emplace(distance, vertex);
  const auto goals = ends_of(b);
  while (!front.empty()) {
    const auto [distance, vertex] = *front.begin();
    front.erase(front.begin());
    if (distance > most) return false;
    if (!reached.emplace(vertex, distance).second) continue;
    for (const auto& [rest, goal] : goals)
      if (goal == vertex && distance + rest <= most) return true;
    for (const int e : mesh.vertex(vertex).edges) {
      const auto& ends = mesh.edge(e).vertices;
      front.emplace(distance + mesh.edge(e).polyline->length(), ends[0] == vertex ? ends[1] : ends[0]);
    }
  }
  return false;
}

/// How two contacts near each other are to be understood.
enum class Relation {
  kApart,    ///< two places that the stroke meets one after the other
  kOne,      ///< one place, or two at an end of the stroke, which ends on the nearer
  kUnclear,  ///< two curves side by side: which is met first, or at all, cannot be told
};

Relation relation(const PolylineMesh& mesh, const Stroke& stroke, const StrokeContact& a,
                  const StrokeContact& b, double snap) {
  double along = std::abs(a.arc - b.arc);
  if (stroke.closed) along = std::min(along, stroke.length - along);
  if (along > 4 * snap) return Relation::kApart;
  const double apart = (a.position - b.position).norm();
  if (apart > 2 * snap) return Relation::kApart;
  if (a.vertex >= 0 && a.vertex == b.vertex) return Relation::kOne;
  const bool has_vertex = a.vertex >= 0 || b.vertex >= 0;
  const bool is_near = near_along_edges(mesh, a, b, 4 * snap);
  // Through a vertex, its edges are met there and nowhere else; to meet one edge twice takes a longer way.
  if (is_near && (has_vertex || (a.edge == b.edge && std::abs(a.edge_arc - b.edge_arc) <= 2 * snap)))
    return Relation::kOne;
  // The stroke goes from the one to the other rather than past both, and its curve, held at both, by less
  // than 45° aslant.
  if (along >= 0.7 * apart && along >= kSamePlace * snap) return Relation::kApart;
  if (is_near) return Relation::kOne;
  const double from_start = std::max(a.arc, b.arc), from_end = stroke.length - std::min(a.arc, b.arc);
  return !stroke.closed && std::min(from_start, from_end) <= 2 * snap ? Relation::kOne : Relation::kUnclear;
}

/// Adds a contact unless it is one of those that there are, which are better ones.
void add_contact(const PolylineMesh& mesh, const Stroke& stroke, double snap, const StrokeContact& contact,
                 std::vector<StrokeContact>& contacts) {
  const StrokeContact* unclear = nullptr;
  for (const StrokeContact& other : contacts) {
    const Relation how = relation(mesh, stroke, contact, other, snap);
    if (how == Relation::kOne) return;
    if (how == Relation::kUnclear) unclear = &other;
  }
  if (unclear) {
    const double apart = (contact.position - unclear->position).norm();
    throw RefusedEdit(
        concat("the stroke meets ", name_of(mesh, *unclear), " and ", name_of(mesh, contact), " in places ",
               text_of_length(apart), " apart, too near each other for the snapping distance of ",
               text_of_length(snap), " to tell which is meant"),
        apart > kSamePlace * snap ? concat("give a snap of ", text_of_length(0.95 * contact.distance),
                                           " or less, or draw it clear of one of them")
                                  : std::string("draw it where they lie apart"));
  }
  contacts.push_back(contact);
}

/// Hits on one edge, those gathered that lie near each other along both. @param hits in order of arc.
std::vector<std::vector<Hit>> runs_of(const std::vector<Hit>& hits, double snap) {
  struct Run {
    std::vector<Hit> hits;
    double from, to;  // along the edge
  };
  std::vector<Run> runs;
  for (const Hit& hit : hits) {
    Run run{{hit}, hit.edge_arc, hit.edge_arc};
    // More than one where a hit lies between them.
    for (size_t k = 0; k < runs.size();) {
      Run& other = runs[k];
      if (hit.arc - other.hits.back().arc > 2 * snap || hit.edge_arc < other.from - 2 * snap ||
          hit.edge_arc > other.to + 2 * snap) {
        ++k;
        continue;
      }
      other.hits.insert(other.hits.end(), run.hits.begin(), run.hits.end());
      run = {std::move(other.hits), std::min(run.from, other.from), std::max(run.to, other.to)};
      runs.erase(runs.begin() + static_cast<std::ptrdiff_t>(k));
    }
    runs.push_back(std::move(run));
  }
  std::vector<std::vector<Hit>> result;
  for (Run& run : runs) {
    std::stable_sort(run.hits.begin(), run.hits.end(),
                     [](const Hit& x, const Hit& y) { return x.arc < y.arc; });
    result.push_back(std::move(run.hits));
  }
  return result;
}

}  // namespace

std::string text_of_length(double length) {
  std::ostringstream out;
  out.precision(3);
  out << length;
  return out.str();
}

std::string name_of(const PolylineMesh& mesh, const StrokeContact& contact) {
  return contact.vertex >= 0 ? concat("v", contact.vertex) : concat("c", mesh.edge(contact.edge).curve);
}

std::vector<Hit> find_hits(const PolylineMesh& mesh, const Polyline& line, double snap) {
  std::vector<Hit> hits;
  for (const auto& [e, block] : near_pairs(mesh, line, snap)) {
    const Polyline& old = *mesh.edge(e).polyline;
    const Box block_reach = grown(line.blocks()[static_cast<size_t>(block)], snap);
    for (size_t other = 0; other < old.blocks().size(); ++other) {
      if (!old.blocks()[other].meets(block_reach)) continue;
      const auto i0 = static_cast<Index>(block) * Polyline::kBlock,
                 j0 = static_cast<Index>(other) * Polyline::kBlock;
      const Index i1 = std::min(i0 + Polyline::kBlock, line.n_points() - 1),
                  j1 = std::min(j0 + Polyline::kBlock, old.n_points() - 1);
      for (Index i = i0; i < i1; ++i) {
        const Vector3d p = line.points().row(i), d = line.points().row(i + 1).transpose() - p;
        for (Index j = j0; j < j1; ++j) {
          const Vector3d q = old.points().row(j), f = old.points().row(j + 1).transpose() - q;
          const SegmentPair pair = closest(p, d, q, f);
          if (pair.distance > snap) continue;
          hits.push_back({line.arc(i) + pair.s * (line.arc(i + 1) - line.arc(i)), e,
                          old.arc(j) + pair.t * (old.arc(j + 1) - old.arc(j)), pair.distance});
        }
      }
    }
  }
  std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) {
    return a.arc != b.arc ? a.arc < b.arc : a.edge != b.edge ? a.edge < b.edge : a.edge_arc < b.edge_arc;
  });
  return hits;
}

std::vector<StrokeContact> find_contacts(const PolylineMesh& mesh, const Stroke& stroke, double snap) {
  Points points = stroke.points;
  if (stroke.closed) {
    points.conservativeResize(points.rows() + 1, 3);
    points.row(points.rows() - 1) = stroke.points.row(0);
  }
  const Polyline line = finely_divided(points, snap);
  // Runs of hits on one edge; each has one place where it comes nearest.
  std::map<int, std::vector<Hit>> hits_of_edge;
  for (const Hit& hit : find_hits(mesh, line, snap)) hits_of_edge[hit.edge].push_back(hit);
  std::vector<Hit> nearest;
  for (const auto& [edge, hits] : hits_of_edge)
    for (const auto& run : runs_of(hits, snap)) {
      const double along = run.back().arc - run.front().arc;
      if (along > 12 * snap)
        throw RefusedEdit(
            concat("the stroke runs along c", mesh.edge(edge).curve, " for ", text_of_length(along),
                   ", within the snapping distance of ", text_of_length(snap)),
            "cross the curve once, or use a smaller snapping distance");
      nearest.push_back(*std::min_element(
          run.begin(), run.end(), [](const Hit& a, const Hit& b) { return a.distance < b.distance; }));
    }
  // Vertices first, as edges that meet at a vertex are all met there; then what is nearest.
  std::vector<StrokeContact> found, contacts;
  for (const Hit& hit : nearest) {
    found.push_back(contact_of(mesh, hit, snap));
    found.back().arc = std::min(hit.arc, stroke.length);
  }
  std::stable_sort(found.begin(), found.end(), [](const StrokeContact& a, const StrokeContact& b) {
    const bool a_has = a.vertex >= 0, b_has = b.vertex >= 0;
    return a_has != b_has ? a_has : a.distance != b.distance ? a.distance < b.distance : a.arc < b.arc;
  });
  for (const StrokeContact& contact : found) add_contact(mesh, stroke, snap, contact, contacts);
  std::stable_sort(contacts.begin(), contacts.end(),
                   [](const StrokeContact& a, const StrokeContact& b) { return a.arc < b.arc; });
  // Open strokes end on what their ends touch.
  if (!stroke.closed && !contacts.empty()) {
    if (contacts.front().arc <= 2 * snap) contacts.front().arc = 0;
    if (stroke.length - contacts.back().arc <= 2 * snap && contacts.size() > 1)
      contacts.back().arc = stroke.length;  // exactly, whatever rounding did to the line
  }
  return contacts;
}

double distance_below(const Box& box, const Vector3d& point) {
  const double largest =
      std::max({box.low.cwiseAbs().maxCoeff(), box.high.cwiseAbs().maxCoeff(), point.cwiseAbs().maxCoeff()});
  return (point - point.cwiseMax(box.low).cwiseMin(box.high)).norm() - 1e-14 * largest;
}

NearestPlace nearest_place(const PolylineMesh& mesh, const Vector3d& point) {
  NearestPlace best;
  best.distance = std::numeric_limits<double>::infinity();
  const auto visit = [&](int e) {
    const Polyline& line = *mesh.edge(e).polyline;
    for (size_t block = 0; block < line.blocks().size(); ++block) {
      if (distance_below(line.blocks()[block], point) > best.distance) continue;
      const auto begin = static_cast<Index>(block) * Polyline::kBlock;
      for (Index i = begin; i < std::min(begin + Polyline::kBlock, line.n_points() - 1); ++i) {
        const ClosestPoint found =
            closest_point_on_segment(point, line.points().row(i), line.points().row(i + 1));
        const double distance = std::sqrt(found.squared_distance);
        // Of places equally near, that on the lowest edge, as edges meet at vertices.
        if (distance > best.distance || (distance == best.distance && e >= best.edge)) continue;
        best = {e, line.arc(i) + found.weights(1) * (line.arc(i + 1) - line.arc(i)), found.point, distance};
      }
    }
    return best.distance;
  };
  mesh.edge_boxes().visit_nearest([&](const Box& box) { return distance_below(box, point); }, visit);
  return best;
}

std::vector<int> contact_vertices(PolylineMesh& mesh, const std::vector<StrokeContact>& contacts) {
  std::vector<int> vertices(contacts.size(), -1);
  std::vector<size_t> order(contacts.size());
  for (size_t k = 0; k < order.size(); ++k) order[k] = k;
  // From the far end of each edge, so that what is left of it keeps its number and its arc lengths.
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return contacts[a].edge_arc > contacts[b].edge_arc; });
  for (size_t position = 0; position < order.size(); ++position) {
    const size_t k = order[position];
    const StrokeContact& contact = contacts[k];
    if (contact.vertex >= 0) {
      vertices[k] = contact.vertex;
      if (mesh.vertex(contact.vertex).is_seam) mesh.set_seam(contact.vertex, false);
      continue;
    }
    // The same place twice (closed strokes that touch, two spines that meet) is one vertex.
    for (size_t earlier = 0; earlier < position && vertices[k] < 0; ++earlier)
      if (contacts[order[earlier]].edge == contact.edge &&
          contacts[order[earlier]].edge_arc == contact.edge_arc)
        vertices[k] = vertices[order[earlier]];
    if (vertices[k] < 0) vertices[k] = mesh.split_edge(contact.edge, contact.edge_arc, contact.position);
  }
  return vertices;
}

void dissolve_seams(PolylineMesh& mesh, const std::vector<int>& vertices) {
  for (const int v : vertices)
    if (mesh.vertex(v).alive && mesh.vertex(v).is_seam) {
      const auto& edges = mesh.vertex(v).edges;
      if (edges.size() == 2 && mesh.edge(edges[0]).curve == mesh.edge(edges[1]).curve)
        mesh.dissolve_vertex(v);
    }
}

double FaceFan::distance(const Vector3d& point) const {
  double best = std::numeric_limits<double>::infinity();
  for (Index i = 0; i < outline.rows(); ++i)
    best = std::min(
        best, closest_point_on_triangle(point, centre, outline.row(i), outline.row((i + 1) % outline.rows()))
                  .squared_distance);
  return std::sqrt(best);
}

FaceFan face_fan(const PolylineMesh& mesh, const std::vector<int>& walk) {
  FaceFan fan;
  constexpr int kPerSide = 8;
  fan.outline.resize(static_cast<Index>(walk.size()) * kPerSide, 3);
  Index row = 0;
  for (const int side : walk) {
    const Polyline& line = *mesh.edge(edge_of(side)).polyline;
    for (int k = 0; k < kPerSide; ++k) {
      const double t = static_cast<double>(k) / kPerSide;
      fan.outline.row(row++) = line.at(line.length() * (side & 1 ? 1 - t : t)).transpose();
    }
  }
  fan.centre = fan.outline.colwise().mean();
  for (Index i = 0; i < row; ++i) {
    const Vector3d a = fan.outline.row(i), b = fan.outline.row((i + 1) % row);
    fan.area += (a - fan.centre).cross(b - fan.centre).norm() / 2;
  }
  return fan;
}

}  // namespace batten::detail
