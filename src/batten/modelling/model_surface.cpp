#include "batten/modelling/model_surface.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/box_tree.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/modelling/model_network.hpp"
#include "batten/modelling/refilling_detail.hpp"
#include "batten/subdivision/subdivide.hpp"

namespace batten {

namespace {

/// Quads as triangles, cut along the shorter diagonal, but through a vertex that has only two quads: both cut
/// past it would share the diagonal as well, and the mesh would be no surface there.
Triangles cut_quads(const PolygonMesh& mesh) {
  Triangles triangles(2 * mesh.n_faces(), 3);
  std::vector<int> n_quads(static_cast<size_t>(mesh.positions.rows()), 0);
  for (const int v : mesh.corners) ++n_quads[static_cast<size_t>(v)];
  for (Eigen::Index f = 0; f < mesh.n_faces(); ++f) {
    const int* c = &mesh.corners[at(mesh.offsets[at(f)])];
    const auto p = [&](int k) { return mesh.positions.row(c[k]); };
    const auto has_two = [&](int k) { return n_quads[static_cast<size_t>(c[k])] == 2; };
    const bool through_even = has_two(0) || has_two(2), through_odd = has_two(1) || has_two(3);
    const bool shorter_even = (p(0) - p(2)).squaredNorm() <= (p(1) - p(3)).squaredNorm();
    const int first = (through_even != through_odd ? through_even : shorter_even) ? 0 : 1;
    triangles.row(2 * f) << c[first], c[first + 1], c[first + 2];
    triangles.row(2 * f + 1) << c[first], c[first + 2], c[(first + 3) % 4];
  }
  return triangles;
}

struct LimitMesh {
  TriangleMesh mesh;
  std::vector<int> face_of_triangle;  ///< of the model
  std::vector<char> on_crease;        ///< per vertex
};

/// The limit surface of a cage at a level. @param face_of_quad face of the model per quad of the cage.
LimitMesh limit_mesh(const ControlCage& cage, int levels, const std::vector<int>& face_of_quad,
                     const Progress& progress) {
  SubdivisionOptions subdivision;
  subdivision.levels = levels;
  subdivision.limit = true;
  const SubdividedSurface fine = subdivide(cage, subdivision, progress);
  LimitMesh limit;
  limit.mesh.positions = fine.limit_positions;
  limit.mesh.normals = fine.limit_normals;
  limit.mesh.triangles = cut_quads(fine.cage.mesh);
  for (const int parent : fine.face_parent)
    limit.face_of_triangle.insert(limit.face_of_triangle.end(), 2, face_of_quad[static_cast<size_t>(parent)]);
  limit.on_crease.assign(static_cast<size_t>(fine.limit_positions.rows()), 0);
  for (const SharpEdge& edge : fine.cage.sharp_edges)
    for (const int v : {edge.from, edge.to}) limit.on_crease[static_cast<size_t>(v)] = 1;
  return limit;
}

/// Checks the mesh of `result`, and warns where it is broken.
void check(const std::vector<int>& turned, const std::vector<int>& face_of_triangle, ModelSurface& result) {
  const ScopedStage stage(result.times, "check");
  result.soundness = surface_soundness(result.mesh, turned, face_of_triangle);
  if (!result.soundness->is_sound()) result.warnings.push_back(result.soundness->sentence());
}

ModelSurface coons_model_surface(const PolylineMesh& model, const ModelSurfaceOptions& options,
                                 const Progress& progress) {
  CoonsOptions coons = options.coons;
  coons.levels = options.levels;
  CoonsSurface surface = coons_surface(model, coons, progress);
  ModelSurface result;
  result.times.add(surface.times);
  FaceDivision division;
  for (const BaseFace& face : surface.base.faces) division.n_triangles += face.sides.size() == 3;
  division.n_quads = static_cast<int>(surface.base.faces.size()) - division.n_triangles;
  division.n_divided = surface.base.n_divided;
  division.n_diagonals = surface.base.n_diagonals;
  division.cost = surface.base.cost;
  result.division = division;
  result.n_quads = surface.refined.mesh.n_faces();
  result.mesh.triangles = cut_at_first_corners(surface.fine);
  result.mesh.positions = std::move(surface.fine.positions);
  result.mesh.normals = std::move(surface.normals);
  result.cage = std::move(surface.cage);
  std::vector<int> face_of_triangle;
  face_of_triangle.reserve(2 * surface.face_of_fine.size());
  for (const int face : surface.face_of_fine) face_of_triangle.insert(face_of_triangle.end(), 2, face);
  check(folded_triangles(result.mesh.positions, result.mesh.triangles, result.mesh.normals), face_of_triangle,
        result);
  return result;
}

std::string not_smoothed_sentence(const std::vector<int>& faces) {
  std::string names;
  for (const int face : faces) names += concat(names.empty() ? "f" : ", f", face);
  return concat("smoothing would fold ", names,
                "; they keep their first shape and meet their neighbours in a crease; divide them by another "
                "curve for a smooth surface");
}

void fill(const PolylineMesh& model, const DiffusionSurface& surface, ModelSurface& result,
          const Progress& progress) {
  FilledModel filled = fill_model(model, surface, {}, progress);
  result.times.add(filled.times);
  result.warnings.insert(result.warnings.end(), filled.warnings.begin(), filled.warnings.end());
  result.mesh = std::move(filled.mesh);
  check(filled.turned, filled.face_of_triangle, result);
}

/// A finished mesh with the faces of the model that its triangles belong to.
struct CheckedMesh {
  const std::vector<int>& face_of_triangle;
  const std::vector<char>& on_crease;

  SurfaceSoundness soundness(const TriangleMesh& mesh) const {
    return surface_soundness(mesh, turned_triangles(mesh, on_crease), face_of_triangle);
  }

  /// The same for some of the triangles, among themselves.
  SurfaceSoundness soundness(const TriangleMesh& mesh, const std::vector<Eigen::Index>& some) const {
    TriangleMesh part;
    part.positions = mesh.positions;
    part.normals = mesh.normals;
    part.triangles.resize(static_cast<Eigen::Index>(some.size()), 3);
    std::vector<int> faces;
    for (size_t k = 0; k < some.size(); ++k) {
      part.triangles.row(static_cast<Eigen::Index>(k)) = mesh.triangles.row(some[k]);
      faces.push_back(face_of_triangle[static_cast<size_t>(some[k])]);
    }
    return surface_soundness(part, turned_triangles(part, on_crease), faces);
  }

  /// The triangles of some faces and all that are near to them in either of two meshes with the same
  /// triangles: what changes in these faces changes nothing among the others.
  std::vector<Eigen::Index> around(const TriangleMesh& before, const TriangleMesh& after,
                                   const std::vector<int>& faces) const {
    const auto box_of = [&](Eigen::Index t) {
      Box box{before.positions.row(before.triangles(t, 0)), before.positions.row(before.triangles(t, 0))};
      for (const TriangleMesh* mesh : {&before, &after})
        for (int k = 0; k < 3; ++k) {
          const Eigen::Vector3d p = mesh->positions.row(mesh->triangles(t, k));
          box.include({p, p});
        }
      return box;
    };
    const auto is_in = [&](Eigen::Index t) {
      return std::find(faces.begin(), faces.end(), face_of_triangle[static_cast<size_t>(t)]) != faces.end();
    };
    std::optional<Box> whole;
    for (Eigen::Index t = 0; t < before.n_triangles(); ++t) {
      if (!is_in(t)) continue;
      if (whole)
        whole->include(box_of(t));
      else
        whole = box_of(t);
    }
    std::vector<Eigen::Index> some;
    for (Eigen::Index t = 0; whole && t < before.n_triangles(); ++t)
      if (box_of(t).meets(*whole)) some.push_back(t);
    return some;
  }
};

/// Checks the mesh of `result`. Faces that are broken are filled one by one, as thin plates or else as
/// membranes, where that leaves fewer flaws: the others may only be crossed by one that bulges. What is left
/// is filled together. The whole is checked twice, each attempt only around its faces.
void refill_folded(const std::vector<int>& face_of_triangle, const std::vector<char>& on_crease,
                   ModelSurface& result, const Progress& progress) {
  constexpr size_t kMostFaces = 12;  // beyond that it is not single faces that are amiss
  constexpr std::array<detail::Refill, 2> kWays{detail::Refill::Plate, detail::Refill::Membrane};
  const CheckedMesh checked{face_of_triangle, on_crease};
  const auto flaws_of = [](const SurfaceSoundness& s) { return s.crossing_pairs + s.turned_triangles; };
  result.soundness = checked.soundness(result.mesh);
  const std::vector<int> broken = result.soundness->broken_faces;
  if (broken.empty() || broken.size() > kMostFaces) return;
  const double n_attempts = static_cast<double>(kWays.size() * (broken.size() + 1));
  double n_done = 0;
  std::map<int, detail::Refill> refilled;
  const auto attempt = [&](const std::vector<int>& faces, detail::Refill how) {
    progress.report("fill folded faces", std::min(n_done++ / n_attempts, 1.0));
    TriangleMesh filled = result.mesh;
    detail::refill_faces(filled, face_of_triangle, faces, on_crease, how);
    const std::vector<Eigen::Index> some = checked.around(result.mesh, filled, faces);
    const SurfaceSoundness before = checked.soundness(result.mesh, some);
    // One that others had crossed may be whole by now.
    if (std::none_of(faces.begin(), faces.end(), [&](int face) {
          return std::binary_search(before.broken_faces.begin(), before.broken_faces.end(), face);
        }))
      return;
    if (flaws_of(checked.soundness(filled, some)) >= flaws_of(before)) return;
    result.mesh = std::move(filled);
    for (const int face : faces) refilled[face] = how;
  };
  for (const int face : broken)
    for (const detail::Refill how : kWays) attempt({face}, how);
  result.soundness = checked.soundness(result.mesh);
  // Those that are left may hold each other in a fold.
  for (const detail::Refill how : kWays)
    if (!result.soundness->is_sound()) {
      attempt(result.soundness->broken_faces, how);
      result.soundness = checked.soundness(result.mesh);
    }
  for (const auto& [face, how] : refilled)
    (how == detail::Refill::Plate ? result.filled_as_plates : result.filled_as_membranes).push_back(face);
}

std::string names_of(const std::vector<int>& faces) {
  std::string names;
  for (const int face : faces) names += concat(names.empty() ? "f" : ", f", face);
  return names;
}

void subdivide_to_limit(const DiffusionSurface& surface, int levels, ModelSurface& result,
                        const Progress& progress) {
  LimitMesh limit;
  {
    const ScopedStage stage(result.times, "subdivision");
    limit = limit_mesh(surface.cage, levels, surface.face_of_quad, progress);
  }
  result.mesh = std::move(limit.mesh);
  {
    const ScopedStage stage(result.times, "check");
    refill_folded(limit.face_of_triangle, limit.on_crease, result, progress);
  }
  if (!result.soundness->is_sound()) result.warnings.push_back(result.soundness->sentence());
}

ModelSurface diffused_model_surface(const PolylineMesh& model, const ModelSurfaceOptions& options,
                                    const Progress& progress) {
  const bool is_filled = options.method == ModelSurfaceMethod::Filled;
  DiffusionOptions diffusion = options.diffusion;
  // Filling the network does not refine it any further, so it wants more samples along its curves.
  if (is_filled) diffusion.splits = std::min(diffusion.splits + 1, 6);
  diffusion.keep_folded = options.with_mesh;
  DiffusionSurface surface = diffusion_surface(model, diffusion, progress);
  ModelSurface result;
  result.times.add(surface.times);
  result.n_quads = surface.refined.mesh.n_faces();
  result.last_move = surface.last_move;
  result.not_smoothed = surface.not_smoothed;
  if (!result.not_smoothed.empty()) result.warnings.push_back(not_smoothed_sentence(result.not_smoothed));
  if (options.with_mesh && is_filled) fill(model, surface, result, progress);
  if (options.with_mesh && !is_filled) subdivide_to_limit(surface, options.levels, result, progress);
  if (!result.filled_as_plates.empty())
    result.warnings.push_back(concat("the flow folds ", names_of(result.filled_as_plates),
                                     "; filled as thin plates through their curves instead"));
  if (!result.filled_as_membranes.empty())
    result.warnings.push_back(
        concat("the flow folds ", names_of(result.filled_as_membranes),
               "; filled as membranes instead, which meet their neighbours in creases; divide "
               "them by another curve for a smooth surface"));
  result.cage = std::move(surface.cage);
  return result;
}

}  // namespace

std::optional<std::string> ModelSurfaceOptions::problem() const {
  if (levels < 0 || levels > 6) return concat("levels must lie from 0 to 6, got ", levels);
  if (method != ModelSurfaceMethod::Coons) return diffusion.problem();
  CoonsOptions subdivided = coons;
  subdivided.levels = levels;
  return subdivided.problem();
}

ModelSurface model_surface(const PolylineMesh& model, const ModelSurfaceOptions& options,
                           const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  return options.method == ModelSurfaceMethod::Coons ? coons_model_surface(model, options, progress)
                                                     : diffused_model_surface(model, options, progress);
}

}  // namespace batten
