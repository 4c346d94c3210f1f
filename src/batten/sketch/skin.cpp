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

}  // namespace

EditReport skin_profiles(PolylineMesh& mesh, const std::vector<DrawnStroke>& profiles,
                         const std::array<DrawnStroke, 2>& spines, const InsertOptions& options) {
  if (profiles.size() < 2)
    throw RefusedEdit(concat("there are ", profiles.size(), " profiles"), "draw two profiles or more");
  Eigen::Index rows = 0;
  for (const DrawnStroke& profile : profiles) rows += profile.points.rows();
  Points all(rows, 3);
  rows = 0;
  for (const DrawnStroke& profile : profiles) {
    all.middleRows(rows, profile.points.rows()) = profile.points;
    rows += profile.points.rows();
  }
  const double snap = detail::snap_or_default(mesh, all, options);
  EditReport report;
  std::vector<std::vector<int>> loops;
  for (size_t k = 0; k < profiles.size(); ++k) {
    DrawnStroke closed = profiles[k];
    closed.closed = true;
    const Stroke stroke = detail::ready_stroke(closed, snap);
    if (const auto contacts = detail::find_contacts(mesh, stroke, snap); !contacts.empty())
      throw RefusedEdit(
          concat("profile ", k + 1, " comes within ", detail::text_of_length(contacts[0].distance), " of ",
                 detail::name_of(mesh, contacts[0])),
          "draw the tube clear of other curves and glue it on afterwards");
    report.curves.push_back(mesh.add_curve());
    loops.push_back(detail::add_loop(mesh, stroke, options.sharpness, report.curves.back()));
  }

  std::array<Stroke, 2> strokes;
  std::array<std::vector<StrokeContact>, 2> contacts;
  std::array<std::vector<int>, 2> met;
  const auto n = profiles.size();
  for (size_t s = 0; s < 2; ++s) {
    const char* which = s == 0 ? "first" : "second";
    strokes[s] = detail::ready_stroke(spines[s], snap);
    if (strokes[s].closed)
      throw RefusedEdit(concat("the ", which, " spine is closed"),
                        "draw it from the first profile to the last");
    if (options.reach_factor > 0)
      strokes[s] = detail::reaching_stroke(
          mesh, strokes[s], detail::reach_of(mesh, strokes[s], options.reach_factor), [&](int e) {
            return std::find(report.curves.begin(), report.curves.end(), mesh.edge(e).curve) !=
                   report.curves.end();
          });
    contacts[s] = detail::find_contacts(mesh, strokes[s], snap);
    met[s] = profiles_met(mesh, contacts[s], report.curves, which);
    for (size_t k = 0; k < n; ++k)
      if (std::count(met[s].begin(), met[s].end(), static_cast<int>(k)) == 0) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const int side : loops[k]) {
          const Polyline& line = *mesh.edge(edge_of(side)).polyline;
          for (Eigen::Index i = 0; i < line.n_points(); ++i)
            nearest = std::min(
                nearest, (strokes[s].points.rowwise() - line.points().row(i)).rowwise().norm().minCoeff());
        }
        throw RefusedEdit(concat("the ", which, " spine passes profile ", k + 1, " at a distance of ",
                                 detail::text_of_length(nearest), ", more than the snapping distance of ",
                                 detail::text_of_length(snap)),
                          concat("draw it across every profile, or give a snap of ",
                                 detail::text_of_length(1.05 * nearest), " or more"));
      }
  }
  if (met[1] != met[0]) {
    std::reverse(met[1].begin(), met[1].end());
    if (met[1] != met[0])
      throw RefusedEdit("the two spines do not meet the profiles in the same order",
                        "draw both along the same sequence of profiles");
    strokes[1] = detail::reversed_stroke(strokes[1]);
    std::reverse(contacts[1].begin(), contacts[1].end());
    for (StrokeContact& contact : contacts[1]) contact.arc = strokes[1].length - contact.arc;
  }
  // What a spine overshoots is cut off.
  for (size_t s = 0; s < 2; ++s) {
    const double from = contacts[s].front().arc;
    strokes[s] = detail::part_of(strokes[s], from, contacts[s].back().arc);
    for (StrokeContact& contact : contacts[s]) contact.arc -= from;
    contacts[s].back().arc = strokes[s].length;
  }
  std::vector<StrokeContact> both = contacts[0];
  both.insert(both.end(), contacts[1].begin(), contacts[1].end());
  const std::vector<int> vertices = detail::contact_vertices(mesh, both);
  std::array<detail::DrawnCurve, 2> drawn;
  for (size_t s = 0; s < 2; ++s) {
    std::vector<HeldPoint> held;
    for (const StrokeContact& contact : contacts[s]) held.push_back({contact.arc, contact.position});
    const auto begin = vertices.begin() + static_cast<std::ptrdiff_t>(s * n);
    drawn[s] = detail::place_stroke(mesh, strokes[s], held, {begin, begin + static_cast<std::ptrdiff_t>(n)});
    report.curves.push_back(drawn[s].curve);
  }

  // The two halves of every profile, both as chains from the first spine to the second.
  std::vector<std::array<std::vector<int>, 2>> halves(n);
  for (size_t k = 0; k < n; ++k) {
    const int from = vertices[k], to = vertices[n + k];
    if (from == to)
      throw RefusedEdit(concat("the two spines meet on profile ", met[0][k] + 1), "keep the spines apart");
    for (size_t half = 0; half < 2; ++half) {
      const int start = half == 0 ? from : to, end = half == 0 ? to : from;
      // Walk the loop forwards; its edges all run in the sense of the stroke.
      std::vector<int> chain;
      int at = start;
      while (at != end) {
        int next = -1;
        for (const int e : mesh.vertex(at).edges)
          if (mesh.edge(e).curve == report.curves[static_cast<size_t>(met[0][k])] &&
              mesh.edge(e).vertices[0] == at)
            next = e;
        chain.push_back(side_of(next, false));
        at = mesh.edge(next).vertices[1];
      }
      halves[k][half] = half == 0 ? chain : detail::reversed_chain(chain);
    }
  }
  size_t left = 0;  // the half of profile k that the first face of section k has
  for (size_t k = 0; k + 1 < n; ++k) {
    const size_t next = detail::first_faces_first(mesh, halves[k], halves[k + 1]) ? left : 1 - left;
    const std::vector<int> first = detail::add_piece(mesh, drawn[0], k, options.sharpness);
    const std::vector<int> second = detail::add_piece(mesh, drawn[1], k, options.sharpness);
    const auto face = [&](std::vector<int> walk, const std::vector<int>& b, const std::vector<int>& c,
                          const std::vector<int>& d) {
      for (const std::vector<int>* part : {&b, &c, &d}) walk.insert(walk.end(), part->begin(), part->end());
      mesh.add_face(std::move(walk));
    };
    face(halves[k][left], second, detail::reversed_chain(halves[k + 1][next]), detail::reversed_chain(first));
    face(detail::reversed_chain(halves[k][1 - left]), first, halves[k + 1][1 - next],
         detail::reversed_chain(second));
    left = next;
  }
  detail::dissolve_seams(mesh, detail::seams_near(mesh, vertices));
  return report;
}

}  // namespace batten
