#include "batten/pipeline/repaired_mesh.hpp"

#include <algorithm>
#include <cmath>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/mesh/welding.hpp"
#include "batten/pipeline/mesh_input.hpp"
#include "batten/surfacing/crossing_removal.hpp"

namespace batten {

namespace {

using Eigen::Index;

/// Places named in one flaw; more are counted.
constexpr std::size_t kMostPlaces = 5;

std::string counted(Index n, std::string_view one, std::string_view many) {
  return concat(n, ' ', n == 1 ? one : many);
}

void tell_what_was_done(RepairedMesh& result) {
  const MendingReport& report = result.mended;
  const auto tell = [&](Index n, std::string_view one, std::string_view many, std::string_view what) {
    if (n > 0) result.done.push_back(counted(n, one, many) + std::string(what));
  };
  tell(report.welded, "vertex", "vertices", concat(" welded within ", report.tolerance));
  tell(report.repeated, "triangle", "triangles", " left out that named a vertex twice");
  tell(report.degenerate, "triangle", "triangles", " left out that had no area");
  tell(report.doubled, "triangle", "triangles", " left out that lay on an equal one");
  tell(report.junctions, "vertex", "vertices", " in the middle of an edge joined to it");
  tell(report.branching, "edge", "edges", " of three or more triangles separated into sheets");
  tell(report.split_vertices, "vertex", "vertices", " added where sheets or fans were separated");
  tell(report.cut, "edge", "edges", " cut open where a part is one-sided");
  tell(report.turned, "triangle", "triangles", " turned over");
  tell(report.unused, "vertex", "vertices", " left out that no triangle used");
  tell(static_cast<Index>(result.crossings_removed), "pair", "pairs", " of crossing triangles made anew");
  const auto n_fair = std::count_if(result.holes.begin(), result.holes.end(),
                                    [](const MeshHole& hole) { return hole.filled && hole.fair; });
  tell(n_fair, "hole", "holes", " filled fairly");
  tell(result.n_filled() - n_fair, "hole", "holes", " filled by a membrane");
}

void find_flaws(RepairedMesh& result) {
  const TriangleMesh& mesh = result.mesh;
  for (const std::string& problem : result.topology.problems) result.flaws.push_back(problem);
  const std::vector<int> flat = degenerate_triangles(mesh.positions, mesh.triangles);
  if (!flat.empty())
    result.flaws.push_back(concat(counted(static_cast<Index>(flat.size()), "triangle has", "triangles have"),
                                  " no area, the first at ", place_in_words(mesh, flat[0])));
  if (result.crossings.empty()) return;
  std::string places;
  for (std::size_t k = 0; k < std::min(kMostPlaces, result.crossings.size()); ++k) {
    const auto [f, g] = result.crossings[k];
    places += concat(k == 0 ? "" : ", ", f, " and ", g, " at ", place_in_words(mesh, f));
  }
  result.flaws.push_back(concat(result.crossings.size() >= kMostListedIntersections ? "at least " : "",
                                counted(static_cast<Index>(result.crossings.size()),
                                        "pair of triangles crosses", "pairs of triangles cross"),
                                ": ", places, result.crossings.size() > kMostPlaces ? ", …" : ""));
}

void add_warnings(const RepairedMeshOptions& options, RepairedMesh& result) {
  if (result.mended.nested > 0)
    result.warnings.push_back(
        concat(counted(result.mended.nested, "closed part lies", "closed parts lie"),
               " within another and look outward, as a body in a body; `orient` makes cavities of them"));
  if (options.fill_holes > 0) {
    const auto n = std::count_if(result.holes.begin(), result.holes.end(), [&](const MeshHole& hole) {
      return !hole.filled && hole.rim.size() <= at(options.fill_holes);
    });
    if (n > 0)
      result.warnings.push_back(concat(counted(n, "hole was", "holes were"),
                                       " left open: every patch would cross its surroundings"));
  }
}

}  // namespace

std::optional<std::string> RepairedMeshOptions::problem() const {
  if (weld_length && !(weld_length->value >= 0 && std::isfinite(weld_length->value)))
    return concat("weld_length must be at least 0, got ", weld_length->value);
  if (fill_holes < 0 || (fill_holes > 0 && fill_holes < 3))
    return concat("fill_holes must be 0 or at least 3, for a hole has three edges or more; got ", fill_holes);
  return std::nullopt;
}

int RepairedMesh::n_filled() const {
  return static_cast<int>(
      std::count_if(holes.begin(), holes.end(), [](const MeshHole& h) { return h.filled; }));
}

RepairedMesh repaired_mesh(const TriangleMesh& mesh, const RepairedMeshOptions& options,
                           const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  if (mesh.n_triangles() == 0) throw InvalidInput("there are no faces, so nothing to repair");
  RepairedMesh result;
  {
    const ScopedStage stage(result.times, "mend");
    MendingOptions mending;
    mending.weld = options.weld;
    mending.orient = options.orient;
    if (options.weld_length)
      mending.tolerance = options.weld_length->in_file_units(bounding_box_diagonal(mesh.positions));
    MendedMesh mended = mended_mesh(mesh, mending, progress);
    result.mesh = std::move(mended.mesh);
    result.mended = mended.report;
    if (result.mesh.n_triangles() == 0)
      throw InvalidInput("no triangle has an area, so nothing is left; check the positions");
  }
  {
    const ScopedStage stage(result.times, "crossings");
    UncrossedMesh uncrossed = uncrossed_mesh(result.mesh, progress);
    result.crossings_removed = uncrossed.crossings_before - uncrossed.crossings.size();
    result.mesh = std::move(uncrossed.mesh);
    result.crossings = std::move(uncrossed.crossings);
  }
  {
    const ScopedStage stage(result.times, "fill");
    HoleFillingOptions filling;
    // Nothing asked for: the holes are listed all the same.
    filling.most_edges = std::max(3, options.fill_holes);
    if (options.fill_holes == 0) filling.left_open.assign(static_cast<size_t>(result.mesh.n_vertices()), 1);
    FilledMesh filled = filled_mesh(result.mesh, filling, progress);
    result.mesh = std::move(filled.mesh);
    result.holes = std::move(filled.holes);
    if (result.n_filled() > 0) {
      // What was open may now be closed, and inside out.
      MendingOptions mending;
      mending.weld = false;
      mending.orient = options.orient;
      MendedMesh mended = mended_mesh(result.mesh, mending, progress);
      result.mesh = std::move(mended.mesh);
      result.mended.turned += mended.report.turned;
      result.mended.nested = mended.report.nested;
      result.crossings = self_intersections(result.mesh.positions, result.mesh.triangles,
                                            kMostListedIntersections, progress);
    }
  }
  if (result.crossings.size() > kMostListedIntersections) result.crossings.resize(kMostListedIntersections);
  result.topology = mesh_topology(result.mesh.triangles, result.mesh.n_vertices());
  if (result.topology.is_watertight())
    result.volume = enclosed_volume(result.mesh.positions, result.mesh.triangles);
  tell_what_was_done(result);
  find_flaws(result);
  add_warnings(options, result);
  return result;
}

std::optional<std::string> weld_soup(TriangleMesh& mesh) {
  if (mesh.n_triangles() == 0) return std::nullopt;
  // Quick for nearly all meshes: a soup has about three vertices for each triangle, others half of one.
  if (mesh.n_vertices() < mesh.n_triangles()) return std::nullopt;
  const VertexWelding welding = weld_borders(mesh.positions, mesh.triangles);
  if (!is_triangle_soup(mesh.triangles, welding)) return std::nullopt;
  std::vector<char> gone(static_cast<size_t>(mesh.n_vertices()), 0);
  for (Index v = 0; v < mesh.n_vertices(); ++v) {
    const int to = welding.vertex_of[static_cast<size_t>(v)];
    if (to == v) continue;
    gone[static_cast<size_t>(v)] = 1;
    if (mesh.normals.rows() > 0) mesh.normals.row(to) += mesh.normals.row(v);
  }
  for (Index v = 0; v < mesh.normals.rows(); ++v) mesh.normals.row(v).stableNormalize();
  const std::string note = concat("every triangle had vertices of its own: ", welding.n_welded, " of ",
                                  mesh.n_vertices(), " vertices were welded within ", welding.tolerance);
  mesh.triangles = welded_triangles(mesh.triangles, welding);
  mesh = without_vertices(mesh, gone);
  return note;
}

}  // namespace batten
