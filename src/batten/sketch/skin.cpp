#include <algorithm>
#include <limits>

#include "batten/core/text.hpp"
#include "batten/sketch/tools_detail.hpp"

namespace batten {

namespace {

using detail::StrokeContact;

/// The profile that each contact of a spine lies on, in the order of the spine.
std::vector<int> profiles_met(const PolylineMesh& mesh, const std::vector<StrokeContact>& contacts,
                              const std::vector<int>& curves, const char* which) {
  std::vector<int> met;
  for (const StrokeContact& contact : contacts) {
    const int edge = contact.edge >= 0 ? contact.edge : mesh.vertex(contact.vertex).edges.front();
    const auto found = std::find(curves.begin(), curves.end(), mesh.edge(edge).curve);
    if (found == curves.end())
      throw RefusedEdit(
          concat("the ", which, " spine meets c", mesh.edge(edge).curve, ", which is no profile"),
          "draw the tube clear of other curves and glue it on afterwards");
    const int profile = static_cast<int>(found - curves.begin());
    if (std::count(met.begin(), met.end(), profile) > 0)
      throw RefusedEdit(concat("the ", which, " spine meets profile ", profile + 1, " twice"),
                        "draw a spine that crosses every profile once");
    met.push_back(profile);
  }
  return met;
}

/// The closed profiles of a tube in the model: a curve and a loop of sides for each.
struct Profiles {
  std::vector<int> curves;
  std::vector<std::vector<int>> loops;

  bool has(int curve) const { return std::find(curves.begin(), curves.end(), curve) != curves.end(); }
};

Points points_of(const std::vector<DrawnStroke>& strokes) {
  Eigen::Index rows = 0;
  for (const DrawnStroke& stroke : strokes) rows += stroke.points.rows();
  Points all(rows, 3);
  rows = 0;
  for (const DrawnStroke& stroke : strokes) {
    all.middleRows(rows, stroke.points.rows()) = stroke.points;
    rows += stroke.points.rows();
  }
  return all;
}

Profiles add_profiles(PolylineMesh& mesh, const std::vector<DrawnStroke>& drawn, double snap,
                      double sharpness) {
  Profiles profiles;
  for (size_t k = 0; k < drawn.size(); ++k) {
    DrawnStroke closed = drawn[k];
    closed.closed = true;
    const Stroke stroke = detail::ready_stroke(closed, snap);
    if (const auto contacts = detail::find_contacts(mesh, stroke, snap); !contacts.empty())
      throw RefusedEdit(
          concat("profile ", k + 1, " comes within ", detail::text_of_length(contacts[0].distance), " of ",
                 detail::name_of(mesh, contacts[0])),
          "draw the tube clear of other curves and glue it on afterwards");
    profiles.curves.push_back(mesh.add_curve());
    profiles.loops.push_back(detail::add_loop(mesh, stroke, sharpness, profiles.curves.back()));
  }
  return profiles;
}

/// A stroke across all profiles, its contacts with them, and which profile each is on.
struct Spine {
  Stroke stroke;
  std::vector<StrokeContact> contacts;
  std::vector<int> met;
};

[[noreturn]] void refuse_passing(const PolylineMesh& mesh, const Stroke& spine, const Profiles& profiles,
                                 size_t profile, double snap, const char* which) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const int side : profiles.loops[profile]) {
    const Polyline& line = *mesh.edge(edge_of(side)).polyline;
    for (Eigen::Index i = 0; i < line.n_points(); ++i)
      nearest =
          std::min(nearest, (spine.points.rowwise() - line.points().row(i)).rowwise().norm().minCoeff());
  }
  throw RefusedEdit(concat("the ", which, " spine passes profile ", profile + 1, " at a distance of ",
                           detail::text_of_length(nearest), ", more than the snapping distance of ",
                           detail::text_of_length(snap)),
                    concat("draw it across every profile, or give a snap of ",
                           detail::text_of_length(1.05 * nearest), " or more"));
}

Spine ready_spine(const PolylineMesh& mesh, const DrawnStroke& drawn, const Profiles& profiles, double snap,
                  double reach_factor, const char* which) {
  Spine spine;
  spine.stroke = detail::ready_stroke(drawn, snap);
  if (spine.stroke.closed)
    throw RefusedEdit(concat("the ", which, " spine is closed"),
                      "draw it from the first profile to the last");
  if (reach_factor > 0)
    spine.stroke =
        detail::reaching_stroke(mesh, spine.stroke, detail::reach_of(mesh, spine.stroke, reach_factor),
                                [&](int e) { return profiles.has(mesh.edge(e).curve); });
  spine.contacts = detail::find_contacts(mesh, spine.stroke, snap);
  spine.met = profiles_met(mesh, spine.contacts, profiles.curves, which);
  for (size_t k = 0; k < profiles.curves.size(); ++k)
    if (std::count(spine.met.begin(), spine.met.end(), static_cast<int>(k)) == 0)
      refuse_passing(mesh, spine.stroke, profiles, k, snap, which);
  return spine;
}

/// Turns the second spine where it was drawn the other way, and cuts off what the two overshoot.
void align_spines(std::array<Spine, 2>& spines) {
  Spine& second = spines[1];
  if (second.met != spines[0].met) {
    std::reverse(second.met.begin(), second.met.end());
    if (second.met != spines[0].met)
      throw RefusedEdit("the two spines do not meet the profiles in the same order",
                        "draw both along the same sequence of profiles");
    second.stroke = detail::reversed_stroke(second.stroke);
    std::reverse(second.contacts.begin(), second.contacts.end());
    for (StrokeContact& contact : second.contacts) contact.arc = second.stroke.length - contact.arc;
  }
  for (Spine& spine : spines) {
    const double from = spine.contacts.front().arc;
    spine.stroke = detail::part_of(spine.stroke, from, spine.contacts.back().arc);
    for (StrokeContact& contact : spine.contacts) contact.arc -= from;
    spine.contacts.back().arc = spine.stroke.length;
  }
}

/// The part of a closed curve, whose edges all run in one sense, from one vertex to another.
std::vector<int> chain_along(const PolylineMesh& mesh, int curve, int from, int to) {
  std::vector<int> chain;
  for (int at = from; at != to;) {
    int next = -1;
    for (const int e : mesh.vertex(at).edges)
      if (mesh.edge(e).curve == curve && mesh.edge(e).vertices[0] == at) next = e;
    chain.push_back(side_of(next, false));
    at = mesh.edge(next).vertices[1];
  }
  return chain;
}

/// The two halves of every profile in the order of the spines, both as chains from the first spine to the
/// second. @param vertices those of the first spine, then those of the second.
std::vector<std::array<std::vector<int>, 2>> halves_of(const PolylineMesh& mesh, const Profiles& profiles,
                                                       const std::vector<int>& met,
                                                       const std::vector<int>& vertices) {
  const size_t n = met.size();
  std::vector<std::array<std::vector<int>, 2>> halves(n);
  for (size_t k = 0; k < n; ++k) {
    const int from = vertices[k], to = vertices[n + k];
    if (from == to)
      throw RefusedEdit(concat("the two spines meet on profile ", met[k] + 1), "keep the spines apart");
    const int curve = profiles.curves[static_cast<size_t>(met[k])];
    halves[k] = {chain_along(mesh, curve, from, to),
                 detail::reversed_chain(chain_along(mesh, curve, to, from))};
  }
  return halves;
}

/// Two faces between each profile and the next.
void add_sections(PolylineMesh& mesh, const std::vector<std::array<std::vector<int>, 2>>& halves,
                  const std::array<detail::DrawnCurve, 2>& spines, double sharpness) {
  const auto add_face = [&](std::vector<int> walk, const std::vector<int>& b, const std::vector<int>& c,
                            const std::vector<int>& d) {
    for (const std::vector<int>* part : {&b, &c, &d}) walk.insert(walk.end(), part->begin(), part->end());
    mesh.add_face(std::move(walk));
  };
  size_t left = 0;  // the half of profile k that the first face of section k has
  for (size_t k = 0; k + 1 < halves.size(); ++k) {
    const size_t next = detail::first_faces_first(mesh, halves[k], halves[k + 1]) ? left : 1 - left;
    const std::vector<int> first = detail::add_piece(mesh, spines[0], k, sharpness);
    const std::vector<int> second = detail::add_piece(mesh, spines[1], k, sharpness);
    add_face(halves[k][left], second, detail::reversed_chain(halves[k + 1][next]),
             detail::reversed_chain(first));
    add_face(detail::reversed_chain(halves[k][1 - left]), first, halves[k + 1][1 - next],
             detail::reversed_chain(second));
    left = next;
  }
}

}  // namespace

EditReport skin_profiles(PolylineMesh& mesh, const std::vector<DrawnStroke>& drawn_profiles,
                         const std::array<DrawnStroke, 2>& drawn_spines, const InsertOptions& options) {
  const size_t n = drawn_profiles.size();
  if (n < 2) throw RefusedEdit(concat("there are ", n, " profiles"), "draw two profiles or more");
  const double snap = detail::snap_or_default(mesh, points_of(drawn_profiles), options);
  const Profiles profiles = add_profiles(mesh, drawn_profiles, snap, options.sharpness);
  std::array<Spine, 2> spines;
  for (size_t s = 0; s < 2; ++s)
    spines[s] =
        ready_spine(mesh, drawn_spines[s], profiles, snap, options.reach_factor, s == 0 ? "first" : "second");
  align_spines(spines);

  std::vector<StrokeContact> both = spines[0].contacts;
  both.insert(both.end(), spines[1].contacts.begin(), spines[1].contacts.end());
  const std::vector<int> vertices = detail::contact_vertices(mesh, both);
  EditReport report;
  report.curves = profiles.curves;
  std::array<detail::DrawnCurve, 2> placed;
  for (size_t s = 0; s < 2; ++s) {
    std::vector<HeldPoint> held;
    for (const StrokeContact& contact : spines[s].contacts) held.push_back({contact.arc, contact.position});
    const auto begin = vertices.begin() + static_cast<std::ptrdiff_t>(s * n);
    placed[s] =
        detail::place_stroke(mesh, spines[s].stroke, held, {begin, begin + static_cast<std::ptrdiff_t>(n)});
    report.curves.push_back(placed[s].curve);
  }
  add_sections(mesh, halves_of(mesh, profiles, spines[0].met, vertices), placed, options.sharpness);
  detail::dissolve_seams(mesh, detail::seams_near(mesh, vertices));
  return report;
}

}  // namespace batten
