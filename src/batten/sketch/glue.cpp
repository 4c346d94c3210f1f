#include <algorithm>

#include "batten/core/text.hpp"
#include "batten/sketch/tools_detail.hpp"

namespace batten {

namespace {

using detail::StrokeContact;

/// A side without a face that leaves a vertex, or −1.
int border_side(const PolylineMesh& mesh, int vertex) {
  for (const int e : mesh.vertex(vertex).edges) {
    const int side = side_of(e, mesh.edge(e).vertices[0] != vertex);
    if (mesh.face_of(side) < 0) return side;
  }
  return -1;
}

bool on_border(const PolylineMesh& mesh, const StrokeContact& contact) {
  if (contact.vertex >= 0) return border_side(mesh, contact.vertex) >= 0;
  const auto& faces = mesh.edge(contact.edge).faces;
  return faces[0] < 0 || faces[1] < 0;
}

std::vector<StrokeContact> end_contacts(const PolylineMesh& mesh, const Stroke& stroke, double snap,
                                        const char* which) {
  std::vector<StrokeContact> contacts = detail::find_contacts(mesh, stroke, snap);
  const auto far = [&](Eigen::Index row, const char* verb) {
    detail::refuse_end(mesh, stroke.points.row(row), concat("the ", which, " stroke ", verb), snap,
                       "border to border");
  };
  if (contacts.empty() || contacts.front().arc > 0) far(0, "starts");
  if (contacts.size() < 2 || contacts.back().arc < stroke.length) far(stroke.points.rows() - 1, "ends");
  if (contacts.size() > 2)
    throw RefusedEdit(
        concat("the ", which, " stroke crosses ", detail::name_of(mesh, contacts[1]), " on its way"),
        "draw it from border to border without meeting other curves");
  for (const StrokeContact& contact : contacts)
    if (!on_border(mesh, contact))
      throw RefusedEdit(concat("the ", which, " stroke ends on ", detail::name_of(mesh, contact),
                               ", which is not on a border"),
                        "draw it from border to border; cut a hole where there is none");
  return contacts;
}

/// The part of an opening from one vertex to another.
std::vector<int> half_of(const PolylineMesh& mesh, const std::vector<int>& walk, int from, int to) {
  std::vector<int> half;
  const auto at = [&](int v) {
    return static_cast<size_t>(
        std::find_if(walk.begin(), walk.end(), [&](int s) { return mesh.start_of(s) == v; }) - walk.begin());
  };
  for (size_t k = at(from); k != at(to); k = (k + 1) % walk.size()) half.push_back(walk[k]);
  return half;
}

bool has_corner(const PolylineMesh& mesh, const std::vector<int>& walk, int vertex) {
  return std::any_of(walk.begin(), walk.end(), [&](int s) { return mesh.start_of(s) == vertex; });
}

bool has_curve(const PolylineMesh& mesh, const std::vector<int>& chain, int curve) {
  return std::any_of(chain.begin(), chain.end(), [&](int s) { return mesh.edge(edge_of(s)).curve == curve; });
}

/// Whether a way over faces leads from the one to the other. Searched from both ends in turns.
bool connected(const PolylineMesh& mesh, int face, int other) {
  if (face == other) return true;
  std::array<detail::Spread, 2> parts{detail::Spread(mesh, face), detail::Spread(mesh, other)};
  for (size_t k = 0; !parts[0].is_complete() && !parts[1].is_complete(); k = 1 - k)
    for (const int f : parts[k].step([](int) { return true; }))
      if (parts[1 - k].has(f)) return true;
  return false;
}

/// Which half of the walk a curve names: 0 or 1; −1 where it lies on both, −2 where on neither.
int named_half(const PolylineMesh& mesh, const std::array<std::vector<int>, 2>& halves, int curve) {
  const bool first = has_curve(mesh, halves[0], curve), second = has_curve(mesh, halves[1], curve);
  return first && second ? -1 : first ? 0 : second ? 1 : -2;
}

/// The two strokes of a tube and where they end: contacts and vertices of the first, then of the second.
struct TubeStrokes {
  std::array<Stroke, 2> strokes;
  std::vector<StrokeContact> contacts;
  std::vector<int> vertices;
};

TubeStrokes ready_strokes(const PolylineMesh& mesh, const std::array<const DrawnStroke*, 2>& drawn,
                          double snap, double reach_factor) {
  TubeStrokes tube;
  tube.strokes = {detail::ready_stroke(*drawn[0], snap), detail::ready_stroke(*drawn[1], snap)};
  for (size_t k = 0; k < 2; ++k) {
    Stroke& stroke = tube.strokes[k];
    const char* which = k == 0 ? "first" : "second";
    if (stroke.closed)
      throw RefusedEdit(concat("the ", which, " stroke is closed"), "draw it from one border to the other");
    if (reach_factor > 0)
      stroke =
          detail::reaching_stroke(mesh, stroke, detail::reach_of(mesh, stroke, reach_factor), [&](int e) {
            const auto& faces = mesh.edge(e).faces;
            return faces[0] < 0 || faces[1] < 0;
          });
    const auto own = end_contacts(mesh, stroke, snap, which);
    tube.contacts.insert(tube.contacts.end(), own.begin(), own.end());
  }
  return tube;
}

/// The borders that the first stroke joins, as walks. The second stroke is turned where it was drawn the
/// other way. @throws RefusedEdit where the strokes do not join the same two borders in different places.
std::array<std::vector<int>, 2> joined_borders(const PolylineMesh& mesh, TubeStrokes& tube) {
  auto& [strokes, contacts, vertices] = tube;
  const std::vector<int> walk_a = mesh.opening(border_side(mesh, vertices[0]));
  const std::vector<int> walk_b = mesh.opening(border_side(mesh, vertices[1]));
  if (has_corner(mesh, walk_a, vertices[1]))
    throw RefusedEdit(concat("the first stroke starts and ends on the same border, at ",
                             detail::name_of(mesh, contacts[0]), " and ", detail::name_of(mesh, contacts[1])),
                      "glue two different borders; to close one border, insert the stroke");
  if (has_corner(mesh, walk_b, vertices[2]) &&
      has_corner(mesh, walk_a, vertices[3])) {  // drawn the other way
    strokes[1] = detail::reversed_stroke(strokes[1]);
    std::swap(vertices[2], vertices[3]);
    std::swap(contacts[2], contacts[3]);
    contacts[2].arc = 0;
    contacts[3].arc = strokes[1].length;
  }
  if (!has_corner(mesh, walk_a, vertices[2]) || !has_corner(mesh, walk_b, vertices[3]))
    throw RefusedEdit("the two strokes do not join the same two borders",
                      "draw both from the one border to the other");
  if (vertices[0] == vertices[2] || vertices[1] == vertices[3])
    throw RefusedEdit(
        concat("the two strokes meet at v", vertices[0] == vertices[2] ? vertices[0] : vertices[1]),
        "let them end in different places of each border");
  return {walk_a, walk_b};
}

using Halves = std::array<std::vector<int>, 2>;

/// Whether a[0] lies across from b[1] as the two curves say, or nothing where they lie on both halves.
/// @param one_part a and b bound the same part of the surface, which cannot be turned over.
std::optional<bool> crossed_as_named(const PolylineMesh& mesh, const Halves& a, const Halves& b,
                                     const std::array<int, 2>& curves, bool one_part) {
  int in_a = named_half(mesh, a, curves[0]), in_b = named_half(mesh, b, curves[1]);
  if (in_a == -2 && in_b == -2) {  // named in the other order
    in_a = named_half(mesh, a, curves[1]);
    in_b = named_half(mesh, b, curves[0]);
  }
  if (in_a == -2 || in_b == -2)
    throw RefusedEdit(concat("c", curves[0], " and c", curves[1], " are not one on each of the two borders"),
                      "name one curve of each border, both on the same side of the strokes");
  if (in_a < 0 || in_b < 0) return std::nullopt;
  if (in_a == in_b && one_part)
    throw RefusedEdit(concat("with c", curves[0], " across from c", curves[1],
                             " the handle would make the surface one-sided"),
                      concat("name the curve of the other half instead of c", curves[1]));
  return in_a != in_b;
}

std::vector<int> joined_walk(std::vector<int> walk, const std::vector<int>& b, const std::vector<int>& c,
                             const std::vector<int>& d) {
  for (const std::vector<int>* part : {&b, &c, &d}) walk.insert(walk.end(), part->begin(), part->end());
  return walk;
}

}  // namespace

EditReport glue_borders(PolylineMesh& mesh, const DrawnStroke& first, const DrawnStroke& second,
                        const std::optional<std::array<int, 2>>& halves, const InsertOptions& options) {
  const double snap = detail::snap_or_default(mesh, first.points, options);
  if (mesh.empty()) throw RefusedEdit("there is no border to glue", "insert a first boundary");
  if (halves)
    for (const int curve : *halves) detail::require_curve(mesh, curve);
  TubeStrokes tube = ready_strokes(mesh, {&first, &second}, snap, options.reach_factor);
  tube.vertices = detail::contact_vertices(mesh, tube.contacts);
  const auto [walk_a, walk_b] = joined_borders(mesh, tube);
  const std::vector<int>& vertices = tube.vertices;

  const Halves a{half_of(mesh, walk_a, vertices[0], vertices[2]),
                 half_of(mesh, walk_a, vertices[2], vertices[0])};
  Halves b{half_of(mesh, walk_b, vertices[1], vertices[3]), half_of(mesh, walk_b, vertices[3], vertices[1])};
  // Faces walk openings forwards, so a[0] can only be across from b[1] unless the other part is turned over.
  const int face_a = mesh.face_of(opposite_side(a[0].front())),
            face_b = mesh.face_of(opposite_side(b[0].front()));
  const bool one_part = connected(mesh, face_a, face_b);
  bool crossed = one_part || !detail::first_faces_first(mesh, a, b);
  if (halves) crossed = crossed_as_named(mesh, a, b, *halves, one_part).value_or(crossed);
  if (!crossed) {
    mesh.flip_component(face_b);
    b = {detail::reversed_chain(b[1]), detail::reversed_chain(b[0])};
  }
  // b[0] leads from the first stroke to the second, b[1] back.
  EditReport report;
  std::array<std::vector<int>, 2> chains;
  for (size_t k = 0; k < 2; ++k) {
    std::vector<HeldPoint> held;
    for (size_t end = 2 * k; end < 2 * k + 2; ++end)
      held.push_back({tube.contacts[end].arc, tube.contacts[end].position});
    const detail::DrawnCurve drawn =
        detail::place_stroke(mesh, tube.strokes[k], held, {vertices[2 * k], vertices[2 * k + 1]});
    chains[k] = detail::add_piece(mesh, drawn, 0, options.sharpness);
    report.curves.push_back(drawn.curve);
  }
  mesh.add_face(joined_walk(a[0], chains[1], b[1], detail::reversed_chain(chains[0])));
  mesh.add_face(joined_walk(a[1], chains[0], b[0], detail::reversed_chain(chains[1])));
  detail::dissolve_seams(mesh, detail::seams_near(mesh, vertices));
  return report;
}

}  // namespace batten
