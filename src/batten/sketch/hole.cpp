#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/sketch/tools_detail.hpp"

namespace batten {

namespace {

using detail::FaceFan;
using Eigen::Index;
using Eigen::Vector3d;

double turn(double from, double to) {
  return std::remainder(to - from, 2 * kPi);
}

/// The face that a stroke lies in.
struct FoundFace {
  int face = -1;
  FaceFan fan;
};

/// By the mean distance of probes along the stroke and in its middle; of faces equally near, the lowest.
FoundFace face_below(const PolylineMesh& mesh, const Stroke& stroke, double snap) {
  FoundFace found;
  double least = std::numeric_limits<double>::infinity();
  const Vector3d centre = stroke.points.colwise().mean();
  Points probes(13, 3);
  probes.row(0) = centre.transpose();
  for (Index k = 0; k < 12; ++k) probes.row(k + 1) = stroke.points.row(k * stroke.points.rows() / 12);
  // A fan lies in the box of its face.
  const auto bound = [&](const Box& box) {
    double sum = 0;
    for (Index k = 0; k < probes.rows(); ++k) sum += detail::distance_below(box, probes.row(k));
    return sum / 13;
  };
  const auto visit = [&](int f) {
    FaceFan candidate = detail::face_fan(mesh, mesh.face(f).sides);
    double sum = 0;
    for (Index k = 0; k < probes.rows(); ++k) sum += candidate.distance(probes.row(k));
    if (sum / 13 < least || (sum / 13 == least && f < found.face)) {
      least = sum / 13;
      found = {f, std::move(candidate)};
    }
    return least;
  };
  mesh.face_boxes().visit_nearest(bound, visit);
  const double allowed = std::max(2 * snap, 0.35 * std::sqrt(found.fan.area));
  if (found.face < 0 || least > allowed)
    throw RefusedEdit(found.face < 0 ? std::string("there is no face to cut")
                                     : concat("the stroke lies ", detail::text_of_length(least),
                                              " from the nearest face, f", found.face,
                                              ", whose curves allow ", detail::text_of_length(allowed)),
                      "draw the hole on the surface");
  return found;
}

/// Angles around the middle of a closed stroke, in its plane.
class AnglesAround {
 public:
  explicit AnglesAround(const Stroke& stroke) : centre_(stroke.points.colwise().mean()) {
    Vector3d normal = Vector3d::Zero();
    const Index n = stroke.points.rows();
    for (Index i = 0; i < n; ++i)
      normal += (stroke.points.row(i).transpose() - centre_)
                    .cross(stroke.points.row((i + 1) % n).transpose() - centre_);
    normal.stableNormalize();
    x_ = normal.unitOrthogonal();
    y_ = normal.cross(x_);
  }
  double operator()(const Vector3d& p) const {
    return std::atan2((p - centre_).dot(y_), (p - centre_).dot(x_));
  }

 private:
  Vector3d centre_, x_, y_;
};

/// The corners of a face as seen from the middle of a hole.
struct CornerAngles {
  std::vector<double> angles;  ///< of each corner
  double sense = 1;            ///< +1 where they turn as the stroke does, else −1
};

CornerAngles corner_angles(const FoundFace& found, size_t n_sides, const AnglesAround& angle_at) {
  const Points& outline = found.fan.outline;
  const Index per_side = outline.rows() / static_cast<Index>(n_sides);
  CornerAngles corners;
  corners.angles.resize(n_sides);
  double total = 0;
  const double angle = angle_at(outline.row(0));
  for (Index i = 0; i < outline.rows(); ++i) {
    if (i % per_side == 0) corners.angles[static_cast<size_t>(i / per_side)] = angle + total;
    total += turn(angle_at(outline.row(i)), angle_at(outline.row((i + 1) % outline.rows())));
  }
  corners.sense = total > 0 ? 1 : -1;
  bool in_order = std::abs(std::abs(total) - 2 * kPi) < 1e-6;
  for (size_t k = 0; k < n_sides && in_order; ++k) {
    const double next = k + 1 < n_sides ? corners.angles[k + 1] : corners.angles[0] + total;
    in_order = corners.sense * (next - corners.angles[k]) > 1e-3;
  }
  if (!in_order)
    throw RefusedEdit(concat("the corners of f", found.face,
                             " cannot all be tied to the hole without crossing: seen from its "
                             "middle they are not in order"),
                      concat("divide f", found.face, " by a curve first, or draw the hole across a curve"));
  return corners;
}

/// Where a corner of the face is tied to the hole.
struct Tie {
  size_t corner;
  double arc;
  Vector3d position;
  int vertex = -1;
};

/// One point of the stroke for each corner: where the ray towards the corner leaves the hole.
std::vector<Tie> ties_of_corners(const Stroke& stroke, const CornerAngles& corners,
                                 const AnglesAround& angle_at) {
  const std::vector<double> arcs = stroke.arcs();
  const Index n = stroke.points.rows();
  std::vector<Tie> ties;
  for (size_t k = 0; k < corners.angles.size(); ++k) {
    const double angle = corners.angles[k];
    Tie tie{k, 0, stroke.points.row(0)};
    for (Index i = 0; i < n; ++i) {
      const Vector3d p = stroke.points.row(i), q = stroke.points.row((i + 1) % n);
      const double before = turn(angle, angle_at(p)), after = turn(angle, angle_at(q));
      if (before > 0 || after <= 0 || after - before > kPi) continue;
      const double t = before / (before - after);
      tie.arc = arcs[static_cast<size_t>(i)] +
                t * (arcs[static_cast<size_t>(i) + 1] - arcs[static_cast<size_t>(i)]);
      tie.position = (1 - t) * p + t * q;
    }
    ties.push_back(tie);
  }
  return ties;
}

/// The same in their order along the stroke.
std::vector<Tie> along_stroke(std::vector<Tie> ties, const Stroke& stroke, int face) {
  std::sort(ties.begin(), ties.end(), [](const Tie& a, const Tie& b) { return a.arc < b.arc; });
  for (size_t k = 0; k + 1 < ties.size(); ++k)
    if (ties[k + 1].arc - ties[k].arc < 1e-6 * stroke.length)
      throw RefusedEdit(concat("two corners of f", face, " would be tied to one point of the hole"),
                        "draw the hole as a convex curve");
  return ties;
}

/// A curve from each corner of the face to its tie, as sides that leave the corner.
std::vector<int> add_ties(PolylineMesh& mesh, const std::vector<int>& sides, const std::vector<Tie>& ties,
                          EditReport& report) {
  std::vector<int> tie_side(sides.size());
  for (size_t k = 0; k < sides.size(); ++k) {
    const int corner = mesh.start_of(sides[k]);
    if (mesh.vertex(corner).is_seam) mesh.set_seam(corner, false);
    Points line(2, 3);
    line << mesh.vertex(corner).position.transpose(), ties[k].position.transpose();
    const int curve = mesh.add_curve();
    tie_side[k] = side_of(
        mesh.add_edge(corner, ties[k].vertex, std::make_shared<Polyline>(line), curve, 0, false), false);
    report.curves.push_back(curve);
  }
  return tie_side;
}

/// A stroke within one face: cut out and tied to the corners of the face (H 5.2.2, first case).
EditReport hole_in_face(PolylineMesh& mesh, const Stroke& stroke, double snap, double sharpness) {
  const FoundFace found = face_below(mesh, stroke, snap);
  const int face = found.face;
  const std::vector<int> sides = mesh.face(face).sides;
  const size_t n_sides = sides.size();
  const AnglesAround angle_at(stroke);
  const CornerAngles corners = corner_angles(found, n_sides, angle_at);
  std::vector<Tie> ties = ties_of_corners(stroke, corners, angle_at);
  std::vector<Tie> around = along_stroke(ties, stroke, face);
  std::vector<HeldPoint> held;
  std::vector<int> vertices;
  for (Tie& tie : around) {
    tie.vertex = mesh.add_vertex(tie.position);
    ties[tie.corner].vertex = tie.vertex;
    held.push_back({tie.arc, tie.position});
    vertices.push_back(tie.vertex);
  }
  const detail::DrawnCurve hole = detail::place_stroke(mesh, stroke, held, vertices);
  // Chains of the hole: from tie k to the next one along the stroke.
  std::vector<std::vector<int>> chain_from(n_sides);
  std::vector<int> corner_after(n_sides);
  for (size_t k = 0; k < around.size(); ++k) {
    chain_from[around[k].corner] = detail::add_piece(mesh, hole, k, sharpness);
    corner_after[around[k].corner] = static_cast<int>(around[(k + 1) % around.size()].corner);
  }
  EditReport report;
  report.curves = {hole.curve};
  const std::vector<int> tie_side = add_ties(mesh, sides, ties, report);
  mesh.remove_face(face);
  for (size_t k = 0; k < n_sides; ++k) {
    const size_t next = (k + 1) % n_sides;
    // The hole between the two ties, walked from that of the next corner to that of this one.
    const bool same_sense = corners.sense > 0;
    const std::vector<int> back = same_sense ? detail::reversed_chain(chain_from[k]) : chain_from[next];
    if (corner_after[same_sense ? k : next] != static_cast<int>(same_sense ? next : k))
      throw RefusedEdit(concat("the hole cannot be tied to the corners of f", face, " in their order"),
                        "draw the hole as a convex curve");
    std::vector<int> walk{sides[k], tie_side[next]};
    walk.insert(walk.end(), back.begin(), back.end());
    walk.push_back(opposite_side(tie_side[k]));
    mesh.add_face(std::move(walk));
  }
  report.euler_change = -1;
  return report;
}

/// The sides of a closed curve, each from a face at it. Both grow in turns, so that the cost follows the
/// smaller one, not the model.
/// @return the faces of the one with the smaller area; nothing where both sides are one.
std::vector<int> smaller_side(const PolylineMesh& mesh, int curve, const std::array<int, 2>& starts) {
  const auto may_cross = [&](int side) { return mesh.edge(edge_of(side)).curve != curve; };
  std::array<detail::Spread, 2> parts{detail::Spread(mesh, starts[0]), detail::Spread(mesh, starts[1])};
  size_t done = 2;
  for (size_t k = 0; done == 2; k = 1 - k) {
    for (const int f : parts[k].step(may_cross))
      if (parts[1 - k].has(f)) return {};
    if (parts[k].is_complete()) done = k;
  }
  const auto area_of = [&](int f) { return detail::face_fan(mesh, mesh.face(f).sides).area; };
  double area = 0, other_area = 0;
  for (const int f : parts[done].faces()) area += area_of(f);
  // Areas only add up: the other side is the larger as soon as a part of it is. Of equal sides the first
  // goes.
  detail::Spread& other = parts[1 - done];
  const auto is_larger = [&] { return done == 0 ? other_area >= area : other_area > area; };
  for (size_t k = 0; !is_larger(); ++k) {
    while (k >= other.faces().size() && !other.is_complete()) other.step(may_cross);
    if (k >= other.faces().size()) return other.faces();
    other_area += area_of(other.faces()[k]);
  }
  return parts[done].faces();
}

/// χ of some faces with their outlines.
int euler_characteristic(const PolylineMesh& mesh, const std::vector<int>& faces) {
  std::vector<int> edges, vertices;
  for (const int f : faces)
    for (const int side : mesh.face(f).sides) {
      edges.push_back(edge_of(side));
      vertices.push_back(mesh.start_of(side));
    }
  for (std::vector<int>* list : {&edges, &vertices}) {
    std::sort(list->begin(), list->end());
    list->erase(std::unique(list->begin(), list->end()), list->end());
  }
  return static_cast<int>(vertices.size()) - static_cast<int>(edges.size()) + static_cast<int>(faces.size());
}

}  // namespace

EditReport cut_hole(PolylineMesh& mesh, const DrawnStroke& drawn, const InsertOptions& options) {
  const double snap = detail::snap_or_default(mesh, drawn.points, options);
  DrawnStroke closed = drawn;
  closed.closed = true;
  const Stroke stroke = detail::ready_stroke(closed, snap);
  if (mesh.empty()) throw RefusedEdit("there is no face to cut", "insert a first boundary");
  const auto contacts = detail::find_contacts(mesh, stroke, snap);
  if (contacts.empty()) return hole_in_face(mesh, stroke, snap, options.sharpness);

  for (const detail::StrokeContact& contact : contacts) {
    std::vector<int> edges{contact.edge};
    if (contact.vertex >= 0) edges = mesh.vertex(contact.vertex).edges;
    for (const int e : edges)
      if (mesh.edge(e).faces[0] < 0 || mesh.edge(e).faces[1] < 0)
        throw RefusedEdit(concat("the hole comes within ", detail::text_of_length(contact.distance),
                                 " of the border, c", mesh.edge(e).curve),
                          "keep the hole clear of borders, or use a smaller snapping distance");
  }
  InsertOptions inside = options;
  inside.into = Into::Face;
  int curve = -1;
  EditReport report = detail::insert_ready(mesh, stroke, contacts, snap, inside, &curve);
  const std::vector<int> rim = mesh.edges_of_curve(curve);
  const SketchEdge& first = mesh.edge(rim.front());
  const std::vector<int> gone = smaller_side(mesh, curve, first.faces);
  if (gone.empty())
    throw RefusedEdit("the stroke goes around a handle or an opening, so that nothing lies inside it",
                      "draw the hole around a part of the surface");
  if (const int chi = euler_characteristic(mesh, gone); chi != 1)
    throw RefusedEdit("what lies inside the stroke has an opening or a handle of its own",
                      "draw the hole where the surface is whole");
  report.euler_change -= 1;
  std::vector<int> edges;
  for (const int f : gone) {
    for (const int side : mesh.face(f).sides) edges.push_back(edge_of(side));
    mesh.remove_face(f);
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  for (const int e : edges) {
    if (mesh.edge(e).faces[0] >= 0 || mesh.edge(e).faces[1] >= 0) continue;
    const auto ends = mesh.edge(e).vertices;
    mesh.remove_edge(e);
    for (const int v : ends)
      if (mesh.vertex(v).edges.empty()) mesh.remove_vertex(v);
  }
  if (const std::string problem = mesh.broken_by_edit(); !problem.empty())
    throw RefusedEdit("the hole would leave the model in pieces: " + problem, "draw it smaller or elsewhere");
  return report;
}

}  // namespace batten
