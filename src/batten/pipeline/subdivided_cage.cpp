#include "batten/pipeline/subdivided_cage.hpp"

#include <algorithm>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/subdivision/bspline_blocks.hpp"

namespace batten {

namespace {

/// Quads cut along the diagonal from their first corner, other polygons by ears.
TriangleMesh as_triangles(const PolygonMesh& mesh) {
  for (std::size_t f = 0; f + 1 < mesh.offsets.size(); ++f)
    if (mesh.offsets[f + 1] - mesh.offsets[f] != 4) return triangulated(mesh);
  TriangleMesh triangles;
  triangles.positions = mesh.positions;
  triangles.triangles = cut_at_first_corners(mesh);
  return triangles;
}

RefinedCage refined_cage(SubdividedSurface surface, bool limit) {
  RefinedCage refined;
  refined.normals.resize(0, 3);
  refined.cage = std::move(surface.cage);
  if (limit) {
    refined.cage.mesh.positions = std::move(surface.limit_positions);
    if (refined.cage.sharp_edges.empty() && refined.cage.sharp_vertices.empty())
      refined.normals = std::move(surface.limit_normals);
  }
  refined.triangles = as_triangles(refined.cage.mesh);
  return refined;
}

CagePatches cage_patches(const ControlCage& cage, const CagePatchesOptions& options, bool smooth_corners,
                         const Progress& progress, StageTimes& times) {
  CagePatches patches;
  {
    const ScopedStage stage(times, "patches");
    BsplineOptions limit;
    limit.tolerance = options.tolerance;
    limit.smooth_corners = smooth_corners;
    patches.surface = joined_bsplines(limit_bsplines(cage, limit, progress), progress);
  }
  {
    const ScopedStage stage(times, "step");
    patches.text = format_cad(options.format, patches.surface, options.step);
  }
  patches.n_exact =
      static_cast<std::size_t>(std::count_if(patches.surface.patches.begin(), patches.surface.patches.end(),
                                             [](const BsplinePatch& patch) { return patch.is_exact; }));
  patches.n_sharp =
      static_cast<std::size_t>(std::count_if(patches.surface.edges.begin(), patches.surface.edges.end(),
                                             [](const BsplineEdge& edge) { return edge.is_sharp; }));
  patches.diameter = bounding_box_diagonal(cage.mesh.positions);
  patches.deviation = patches.surface.deviation * options.step.millimetres_per_unit;
  return patches;
}

void add_warnings(const CagePatches& patches, double tolerance, std::vector<std::string>& warnings) {
  if (patches.surface.deviation > tolerance * patches.diameter)
    warnings.push_back(concat("near extraordinary vertices the patches are ", patches.deviation,
                              " mm off, more than `step_tolerance`; subdivide the cage once first"));
  if (patches.surface.levels > 0)
    warnings.push_back(concat("faces that are no quads and semi-sharp features were resolved: patches lie ",
                              patches.surface.levels, " levels below the faces of the cage"));
}

void describe(const ControlCage& cage, SubdividedCage& result) {
  const ScopedStage stage(result.times, "check");
  subdivide(cage, {.scheme = SubdivisionScheme::Linear, .levels = 0});  // names what is wrong with the cage
  result.topology = mesh_topology(as_triangles(cage.mesh).triangles, cage.mesh.positions.rows());
  result.n_vertices = cage.mesh.positions.rows();
  result.n_faces = cage.mesh.n_faces();
  result.n_sharp_edges = cage.sharp_edges.size();
  result.n_sharp_vertices = cage.sharp_vertices.size();
  result.n_polylines = cage.polylines.size();
}

}  // namespace

std::optional<std::string> CagePatchesOptions::problem() const {
  BsplineOptions limit;
  limit.tolerance = tolerance;
  if (auto wrong = limit.problem()) return wrong;
  return step.problem();
}

std::optional<std::string> SubdividedCageOptions::problem() const {
  if (patches && subdivision.scheme != SubdivisionScheme::CatmullClark)
    return "patches are those of the limit surface of Catmull-Clark; the other schemes have no B-splines as "
           "their "
           "limit";
  if (auto problem = subdivision.problem()) return problem;
  return patches ? patches->problem() : std::nullopt;
}

SubdividedCage subdivided_cage(const ControlCage& cage, const SubdividedCageOptions& options,
                               const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  if (options.patches) require_step();
  SubdividedCage result;
  describe(cage, result);
  ControlCage start = cage;
  SubdivisionOptions subdivision = options.subdivision;
  {
    const ScopedStage stage(result.times, "subdivide");
    SubdivisionOptions one = options.subdivision;
    one.levels = 1;
    one.limit = false;
    for (const SubdivisionScheme scheme : options.first_schemes) {
      if (subdivision.levels == 0) break;
      one.scheme = scheme;
      start = subdivide(start, one, progress).cage;
      --subdivision.levels;
    }
    if (options.refine)
      result.refined = refined_cage(subdivide(start, subdivision, progress), subdivision.limit);
  }
  if (options.patches) {
    result.patches =
        cage_patches(start, *options.patches, options.subdivision.smooth_corners, progress, result.times);
    add_warnings(*result.patches, options.patches->tolerance, result.warnings);
  }
  return result;
}

}  // namespace batten
