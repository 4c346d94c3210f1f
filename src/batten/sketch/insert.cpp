#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Geometry>

#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/sketch/tools_detail.hpp"

namespace batten {

namespace detail {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

double angle(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// A face or opening that has two given corners.
struct Walkway {
  int face = -1;
  int opening = -1;  ///< a side of the opening, where there is no face
  std::vector<int> walk;
};

size_t corner_in(const PolylineMesh& mesh, const std::vector<int>& walk, int vertex) {
  return static_cast<size_t>(
      std::find_if(walk.begin(), walk.end(), [&](int s) { return mesh.start_of(s) == vertex; }) -
      walk.begin());
}

bool is_at_border(const PolylineMesh& mesh, int vertex) {
  const auto& edges = mesh.vertex(vertex).edges;
  return std::any_of(edges.begin(), edges.end(),
                     [&](int e) { return mesh.edge(e).faces[0] < 0 || mesh.edge(e).faces[1] < 0; });
}

std::vector<Walkway> walkways(const PolylineMesh& mesh, int from, int to) {
  std::vector<Walkway> found;
  for (const int e : mesh.vertex(from).edges) {
    const int side = side_of(e, mesh.edge(e).vertices[0] != from);
    Walkway way;
    way.face = mesh.face_of(side);
    if (way.face >= 0) {
      way.walk = mesh.face(way.face).sides;
    } else {
      if (mesh.face_of(opposite_side(side)) < 0 || !is_at_border(mesh, to)) continue;
      way.opening = side;
      way.walk = mesh.opening(side);
    }
    if (corner_in(mesh, way.walk, to) < way.walk.size()) found.push_back(std::move(way));
  }
  return found;
}

/// How far a direction lies outside the corner of a walk, in radians: 0 within it.
double misfit(const PolylineMesh& mesh, const std::vector<int>& walk, int vertex, const Vector3d& direction) {
  const size_t at = corner_in(mesh, walk, vertex);
  const Vector3d out = mesh.direction_of(walk[at]);
  const Vector3d in = mesh.direction_of(opposite_side(walk[(at + walk.size() - 1) % walk.size()]));
  const double corner = angle(in, out), sum = angle(in, direction) + angle(direction, out);
  const double outside = sum - corner;
  // With two edges alone the corner may also be the other, reflex, side of the same angle.
  if (mesh.vertex(vertex).edges.size() == 2) return std::min(outside, std::abs(2 * kPi - corner - sum) + 0.2);
  return outside;
}

/// How far a direction turns away from the middle of a walk, in radians: where border and stroke leave it
/// open which side is meant, the side that the stroke heads for.
double off_course(const PolylineMesh& mesh, const std::vector<int>& walk, int vertex,
                  const Vector3d& direction) {
  return angle(direction, face_fan(mesh, walk).centre - mesh.vertex(vertex).position);
}

/// Whether a stroke runs over the middle of an opening and far from every face at its ends.
bool runs_over(const PolylineMesh& mesh, const Walkway& opening, int from, int to,
               const std::vector<Points>& piece) {
  const Points& part = piece[piece.size() / 2];
  const Vector3d middle = part.row(part.rows() / 2);
  const double over_opening = face_fan(mesh, opening.walk).distance(middle);
  for (const int vertex : {from, to})
    for (const int e : mesh.vertex(vertex).edges)
      for (const int face : mesh.edge(e).faces)
        if (face >= 0 && face_fan(mesh, mesh.face(face).sides).distance(middle) < 3 * over_opening)
          return false;
  return true;
}

/// How far a piece of a stroke lies from a face, in the mean of a few places inside it.
double distance_from(const PolylineMesh& mesh, int face, const std::vector<Points>& piece) {
  const FaceFan fan = face_fan(mesh, mesh.face(face).sides);
  double sum = 0;
  int n = 0;
  for (const Points& points : piece)
    for (Index k = 1; k < 8; ++k, ++n) sum += fan.distance(points.row(k * (points.rows() - 1) / 8));
  return sum / n;
}

/// Whether a stroke without a common face heads rather for the faces at its ends than for the opening: then
/// it has missed a curve and is no lid.
bool heads_for_faces(const PolylineMesh& mesh, const Walkway& opening, int from, int to,
                     const Vector3d& leaving, const Vector3d& arriving) {
  double into_opening = 0, into_faces = 0;
  for (const auto& [vertex, direction] : {std::pair(from, leaving), std::pair(to, arriving)}) {
    into_opening +=
        misfit(mesh, opening.walk, vertex, direction) + off_course(mesh, opening.walk, vertex, direction);
    double least = std::numeric_limits<double>::infinity();
    for (const int e : mesh.vertex(vertex).edges)
      for (const int face : mesh.edge(e).faces)
        if (face >= 0)
          least = std::min(least, misfit(mesh, mesh.face(face).sides, vertex, direction) +
                                      off_course(mesh, mesh.face(face).sides, vertex, direction));
    into_faces += least;
  }
  return into_faces <= into_opening + 0.3;
}

/// The curve that a piece passes although it does not touch it, for the sentence of a refusal.
[[noreturn]] void refuse_piece(const PolylineMesh& mesh, const std::vector<Points>& piece, int from, int to,
                               double snap, Into into) {
  if (into == Into::Opening)
    throw RefusedEdit(concat("no opening has both v", from, " and v", to, " on its border"),
                      "leave \"into\" out, or draw across an opening");
  NearestPlace passed;
  passed.distance = std::numeric_limits<double>::infinity();
  for (const Points& points : piece)
    for (Index i = 0; i < points.rows(); ++i) {
      const NearestPlace place = nearest_place(mesh, points.row(i));
      const auto& ends = mesh.edge(place.edge).vertices;
      if (std::any_of(ends.begin(), ends.end(), [&](int v) { return v == from || v == to; })) continue;
      if (place.distance < passed.distance) passed = place;
    }
  const std::string where =
      concat("the stroke goes from v", from, " to v", to, ", which have no face in common");
  if (passed.edge < 0)
    throw RefusedEdit(where, "cross every curve on the way, or draw it in parts from curve to curve");
  const std::string distance = text_of_length(passed.distance);
  const bool is_within = passed.distance <= snap;  // met, but taken for one place with a curve beside it
  throw RefusedEdit(
      concat(where, ": it passes c", mesh.edge(passed.edge).curve, " at a distance of ", distance,
             is_within ? ", which counts as one place with another that it meets"
                       : concat(", more than the snapping distance of ", text_of_length(snap))),
      concat("draw it through c", mesh.edge(passed.edge).curve,
             is_within ? concat(", or give a snap below ", text_of_length(snap))
                       : concat(", or give a snap of ", text_of_length(1.05 * passed.distance), " or more"),
             "; to close the opening instead, give \"into\": \"opening\""));
}

/// Refuses a closed stroke that lies on a face without touching a curve: it would be meant as a hole.
void refuse_on_face(const PolylineMesh& mesh, const Stroke& stroke, double snap) {
  const Box own{stroke.points.colwise().minCoeff(), stroke.points.colwise().maxCoeff()};
  const double reach = std::max(2 * snap, 0.05 * (own.high - own.low).norm());
  Box near = own;
  near.low.array() -= 1.01 * reach;  // more than the box of the fan below is grown by, whatever the rounding
  near.high.array() += 1.01 * reach;
  for (const int f : mesh.face_boxes().meeting(near)) {
    const FaceFan fan = face_fan(mesh, mesh.face(f).sides);
    Box box{fan.outline.colwise().minCoeff(), fan.outline.colwise().maxCoeff()};
    box.low.array() -= reach;
    box.high.array() += reach;
    if (!box.meets(own)) continue;
    double furthest = 0;
    for (Index k = 0; k < 24; ++k)
      furthest = std::max(furthest, fan.distance(stroke.points.row(k * stroke.points.rows() / 24)));
    if (furthest > reach) continue;
    const NearestPlace place = nearest_place(mesh, stroke.points.row(0));
    throw RefusedEdit(concat("the closed stroke lies on f", f, " and meets no curve; the nearest, c",
                             mesh.edge(place.edge).curve, ", is ", text_of_length(place.distance), " away"),
                      "use the hole tool, or draw it across at least one curve");
  }
}

}  // namespace

void refuse_end(const PolylineMesh& mesh, const Vector3d& end, const std::string& what, double snap,
                const std::string& course) {
  const NearestPlace place = nearest_place(mesh, end);
  // Near enough, but what the stroke touches there is one place with what it touches elsewhere.
  if (place.distance <= snap)
    throw RefusedEdit(
        concat(what, " on c", mesh.edge(place.edge).curve, ", but within the snapping distance of ",
               text_of_length(snap), " both of its ends are one place"),
        "use a smaller snapping distance, or draw a longer stroke");
  throw RefusedEdit(
      concat(what, " ", text_of_length(place.distance), " from the nearest curve, c",
             mesh.edge(place.edge).curve, ", more than the snapping distance of ", text_of_length(snap)),
      concat("draw it from ", course, ", or give a snap of ", text_of_length(1.05 * place.distance),
             " or more"));
}

bool runs_between_curves(const PolylineMesh& mesh, const DrawnStroke& drawn, double snap) {
  if (mesh.empty() || drawn.points.rows() < 2 || !drawn.points.allFinite()) return false;
  const NearestPlace start = nearest_place(mesh, drawn.points.row(0)),
                     end = nearest_place(mesh, drawn.points.row(drawn.points.rows() - 1));
  return start.distance <= snap && end.distance <= snap && (start.position - end.position).norm() > 3 * snap;
}

std::vector<int> add_loop(PolylineMesh& mesh, const Stroke& stroke, double sharpness, int curve) {
  // Held where vertices will be: the corners, and seams so that there are two.
  std::vector<HeldPoint> held;
  const std::vector<double> arcs = stroke.arcs();
  if (stroke.corners.size() < 2) {
    const double start = stroke.corners.empty() ? 0 : arcs[static_cast<size_t>(stroke.corners.front())];
    const auto row_at = [&](double arc) {
      const auto found = std::lower_bound(arcs.begin(), arcs.end() - 1, arc);
      return static_cast<Index>(found - arcs.begin()) % stroke.points.rows();
    };
    std::vector<Index> rows{row_at(std::fmod(start + stroke.length / 2, stroke.length))};
    if (stroke.corners.empty()) rows.push_back(0);
    std::sort(rows.begin(), rows.end());
    for (const Index row : rows) held.push_back({arcs[static_cast<size_t>(row)], stroke.points.row(row)});
  }
  // Seams are not measured places: first fit freely through one, then hold the other on that curve.
  if (held.size() == 2 && stroke.noise > 0) {
    const FittedStroke free = fit_stroke(stroke, {held[1]});
    const Polyline line(free.pieces.front().points);
    held[0].position = line.at(line.length() - (held[1].arc - held[0].arc));
  }
  const FittedStroke fitted = fit_stroke(stroke, held);
  std::vector<int> vertex_of_piece;
  for (const FittedStroke::Piece& piece : fitted.pieces)
    vertex_of_piece.push_back(mesh.add_vertex(piece.points.row(0), piece.from >= 0));
  std::vector<int> sides;
  for (size_t k = 0; k < fitted.pieces.size(); ++k)
    sides.push_back(
        side_of(mesh.add_edge(vertex_of_piece[k], vertex_of_piece[(k + 1) % vertex_of_piece.size()],
                              std::make_shared<Polyline>(fitted.pieces[k].points), curve, sharpness, true),
                false));
  return sides;
}

DrawnCurve place_stroke(PolylineMesh& mesh, const Stroke& stroke, const std::vector<HeldPoint>& held,
                        std::vector<int> vertices) {
  DrawnCurve drawn;
  drawn.closed = stroke.closed;
  drawn.vertices = std::move(vertices);
  const FittedStroke fitted = fit_stroke(stroke, held);
  // Pieces of the fit end at corners too; gather them from held point to held point, starting at the first.
  const size_t n = fitted.pieces.size();
  size_t first = 0;
  while (first < n && fitted.pieces[first].from != 0) ++first;
  drawn.pieces.resize(stroke.closed ? held.size() : held.size() - 1);
  size_t piece = 0;
  for (size_t k = 0; k < n && piece < drawn.pieces.size(); ++k) {
    const FittedStroke::Piece& part = fitted.pieces[(first + k) % n];
    drawn.pieces[piece].push_back(part.points);
    if (part.to >= 0) ++piece;
  }
  drawn.curve = mesh.add_curve();
  return drawn;
}

DrawnCurve place_stroke(PolylineMesh& mesh, const Stroke& stroke,
                        const std::vector<StrokeContact>& contacts) {
  std::vector<HeldPoint> held;
  held.reserve(contacts.size());
  for (const StrokeContact& contact : contacts) held.push_back({contact.arc, contact.position});
  return place_stroke(mesh, stroke, held, contact_vertices(mesh, contacts));
}

std::vector<int> add_piece(PolylineMesh& mesh, const DrawnCurve& drawn, size_t piece, double sharpness,
                           bool is_drawn) {
  std::vector<int> chain;
  int from = drawn.vertices[piece];
  const auto& parts = drawn.pieces[piece];
  for (size_t k = 0; k < parts.size(); ++k) {
    const Points& points = parts[k];
    const int to = k + 1 == parts.size() ? drawn.vertices[(piece + 1) % drawn.vertices.size()]
                                         : mesh.add_vertex(points.row(points.rows() - 1));
    chain.push_back(
        side_of(mesh.add_edge(from, to, std::make_shared<Polyline>(points), drawn.curve, sharpness, is_drawn),
                false));
    from = to;
  }
  return chain;
}

namespace {

/// @throws RefusedEdit where a stroke does not reach curves with its ends, or meets one vertex twice in a
/// row.
void check_contacts(const PolylineMesh& mesh, const Stroke& stroke,
                    const std::vector<StrokeContact>& contacts, double snap) {
  if (!stroke.closed) {
    if (mesh.empty())
      throw RefusedEdit(
          concat("the first curve is open: its ends are ",
                 text_of_length((stroke.points.row(0) - stroke.points.row(stroke.points.rows() - 1)).norm()),
                 " apart, more than the snapping distance of ", text_of_length(snap)),
          "begin with a closed curve, the border of the object");
    if (contacts.empty() || contacts.front().arc > 0)
      refuse_end(mesh, stroke.points.row(0), "the stroke starts", snap, "curve to curve");
    if (contacts.size() < 2 || contacts.back().arc < stroke.length)
      refuse_end(mesh, stroke.points.row(stroke.points.rows() - 1), "the stroke ends", snap,
                 "curve to curve");
  }
  if (stroke.closed && contacts.size() == 1)
    throw RefusedEdit(
        concat("the closed stroke meets the network in one place only, on ", name_of(mesh, contacts[0])),
        "draw it across curves in two places or more");
  for (size_t k = 0; k + (stroke.closed ? 0 : 1) < contacts.size(); ++k) {
    const StrokeContact &a = contacts[k], &b = contacts[(k + 1) % contacts.size()];
    if (a.vertex >= 0 && a.vertex == b.vertex)
      throw RefusedEdit(concat("the stroke meets v", a.vertex, " twice, in places ",
                               text_of_length(std::abs(b.arc - a.arc)), " apart along it"),
                        "draw a longer way, or use a smaller snapping distance");
  }
}

/// The face that a piece of a stroke divides, or the opening that it closes: where the directions at its ends
/// fit best. Nothing where there is none.
std::optional<Walkway> best_way(const PolylineMesh& mesh, int from, int to, const std::vector<Points>& parts,
                                Into into) {
  const Vector3d leaving = Polyline(parts.front()).direction_at_front();
  const Vector3d arriving = Polyline(parts.back()).direction_at_back();
  const std::vector<Walkway> ways = walkways(mesh, from, to);
  // Where curves leave a vertex side by side, directions alone do not tell which face is meant.
  std::vector<double> distances(ways.size(), 0);
  double nearest = std::numeric_limits<double>::infinity();
  bool common_face = false;
  for (size_t w = 0; w < ways.size(); ++w)
    if (ways[w].face >= 0) {
      common_face = true;
      distances[w] = distance_from(mesh, ways[w].face, parts);
      nearest = std::min(nearest, distances[w]);
    }
  const Walkway* best = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (size_t w = 0; w < ways.size(); ++w) {
    const Walkway& way = ways[w];
    if ((into == Into::Face && way.face < 0) || (into == Into::Opening && way.face >= 0)) continue;
    constexpr double kFacesFirst = 0.3;  // radians; an opening has to be meant
    constexpr double kFarther = 0.6;     // radians, for a face much farther away than another
    const auto farther = [&](double distance) {
      return distance > nearest ? kFarther * (1 - nearest / distance) : 0;
    };
    const double cost = misfit(mesh, way.walk, from, leaving) + misfit(mesh, way.walk, to, arriving) +
                        (way.face < 0 ? kFacesFirst : farther(distances[w]));
    if (cost < least - 1e-6) {
      least = cost;
      best = &way;
    }
  }
  if (!best) return std::nullopt;
  if (best->face < 0 && !common_face && into == Into::Auto &&
      heads_for_faces(mesh, *best, from, to, leaving, arriving) && !runs_over(mesh, *best, from, to, parts))
    return std::nullopt;
  return *best;
}

}  // namespace

EditReport insert_ready(PolylineMesh& mesh, const Stroke& stroke, const std::vector<StrokeContact>& contacts,
                        double snap, const InsertOptions& options, int* curve) {
  check_contacts(mesh, stroke, contacts, snap);
  EditReport report;
  if (contacts.empty()) {  // a first boundary
    refuse_on_face(mesh, stroke, snap);
    const int own = mesh.add_curve();
    mesh.add_face(add_loop(mesh, stroke, options.sharpness, own));
    report.euler_change = 1;
    report.curves = {own};
    if (curve) *curve = own;
    return report;
  }
  const DrawnCurve drawn = place_stroke(mesh, stroke, contacts);
  for (size_t piece = 0; piece < drawn.pieces.size(); ++piece) {
    const int from = drawn.vertices[piece], to = drawn.vertices[(piece + 1) % drawn.vertices.size()];
    if (from == to)
      throw RefusedEdit(concat("the stroke meets v", from, " twice"), "use a smaller snapping distance");
    const std::optional<Walkway> way = best_way(mesh, from, to, drawn.pieces[piece], options.into);
    if (!way) refuse_piece(mesh, drawn.pieces[piece], from, to, snap, options.into);
    const std::vector<int> chain = add_piece(mesh, drawn, piece, options.sharpness);
    if (way->face >= 0) {
      mesh.split_face(way->face, chain);
    } else {
      mesh.close_opening(way->opening, chain);
      report.euler_change += 1;
      report.remarks.push_back(concat("c", drawn.curve, " closes an opening"));
    }
  }
  dissolve_seams(mesh, seams_near(mesh, drawn.vertices));
  report.curves = {drawn.curve};
  if (curve) *curve = drawn.curve;
  return report;
}

}  // namespace detail

EditReport insert_curve(PolylineMesh& mesh, const DrawnStroke& drawn, const InsertOptions& options) {
  const double snap = detail::snap_or_default(mesh, drawn.points, options);
  Stroke stroke = detail::ready_stroke(drawn, snap, !detail::runs_between_curves(mesh, drawn, snap));
  if (options.reach_factor > 0)
    stroke = detail::reaching_stroke(mesh, stroke, detail::reach_of(mesh, stroke, options.reach_factor));
  return detail::insert_ready(mesh, stroke, detail::find_contacts(mesh, stroke, snap), snap, options);
}

}  // namespace batten
