#include "thesis_h.hpp"

#include "thesis_h_definitions.hpp"
#include "thesis_h_tables.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/deformation/deformer.hpp"
#include "batten/deformation/multiresolution.hpp"
#include "batten/fairing/fair.hpp"
#include "batten/fairing/noise.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/compare.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/operators/mesh_variation.hpp"
#include "batten/remeshing/measures.hpp"
#include "batten/remeshing/remesh.hpp"
#include "batten/simplification/simplify.hpp"

namespace batten::experiments {

namespace {

/// Meshes with more vertices are left out of a quick run.
constexpr Eigen::Index kQuickVertices = 30000;
/// Meshes with more vertices get the noise of one seed: twenty take minutes.
constexpr Eigen::Index kManySeedsVertices = 30000;

/// The numbers of vertices and faces of a mesh, for captions.
std::string counts(const TriangleMesh& mesh) {
  return concat(mesh.n_vertices(), " vertices, ", mesh.n_triangles(), " triangles.");
}

/// The mesh of a row; null, with what is missing written into it, where it is not there or too large for a
/// quick run.
const TriangleMesh* mesh_of(ThesisRun& run, const std::string& name, ThesisRow& row) {
  const TriangleMesh* mesh = run.mesh(name, &row.data);
  if (mesh == nullptr) {
    row.needs = concat("a mesh ", name, " (.ply, .obj, .off or .stl) in the folder of --data");
  } else if (run.options.quick && mesh->n_vertices() > kQuickVertices) {
    row.needs = "a run without --quick: the mesh is large";
    row.data.clear();
    return nullptr;
  }
  return mesh;
}

/// fandisk is at hand with a quarter of the thesis's triangles, from which one subdivision makes them.
TriangleMesh as_large_as_printed(const TriangleMesh& mesh, const MeshData& data) {
  const bool is_quarter =
      mesh_edges(mesh.triangles, mesh.n_vertices()).n_edges() + mesh.n_vertices() == data.n_vertices;
  return is_quarter ? midpoint_subdivided(mesh) : mesh;
}

/// Igea and the like stand along y in the public collections.
RenderOptions view_of(const std::string& name, Shading shading, double zoom = 1) {
  RenderOptions how;
  how.shading = shading;
  how.width = 560;
  how.height = 420;
  if (name == "igea") how.view = {.azimuth_deg = 70, .elevation_deg = 10, .up_axis = 1};
  how.view.zoom = zoom;
  return how;
}

// Table 2.1

void counts_row(ThesisRun& run, const MeshData& data) {
  ThesisRow row;
  row.id = concat("H 2.1 ", data.mesh);
  row.claim = concat("The mesh ", data.mesh, " has ", data.n_vertices, " vertices.");
  row.thesis = {{"vertices", data.n_vertices}, {"volume", data.volume}};
  const TriangleMesh* given = run.mesh(data.mesh, &row.data);
  if (given == nullptr) {
    row.needs = concat("a mesh ", data.mesh, " (.ply, .obj, .off or .stl) in the folder of --data");
  } else {
    const TriangleMesh mesh = as_large_as_printed(*given, data);
    row.ours = {{"vertices", mesh.n_vertices()}, {"volume", enclosed_volume(mesh.positions, mesh.triangles)}};
    row.decide(mesh.n_vertices() == data.n_vertices);
    row.remark = concat(
        mesh.n_vertices() == given->n_vertices() ? "" : "Subdivided once by midpoints. ",
        "The volume depends on the unit of the file; by it, printed lengths are brought to the diameter.");
  }
  run.add(std::move(row));
}

// Table 2.2

/// How far positions are from those without noise.
struct FairingErrors {
  double volume = 0;   ///< per cent of that without noise
  double normals = 0;  ///< degrees
};

/// Noisy, then MCF, SDF and NL-SDF as in the rows of the thesis, then automatic.
struct FairedSeed {
  FairingErrors errors[5];
  Points positions[5];
};

FairedSeed faired_seed(const TriangleMesh& clean, const MeshData& data, std::span<const FairingRow> rows,
                       int seed) {
  constexpr FairingMethod kMethods[] = {FairingMethod::MeanCurvature, FairingMethod::SurfaceDiffusion,
                                        FairingMethod::NonlocalSurfaceDiffusion, FairingMethod::Automatic};
  const double volume = enclosed_volume(clean.positions, clean.triangles);
  FairedSeed made;
  const auto measure = [&](std::size_t k, Points positions) {
    made.errors[k].volume = 100 * std::abs(enclosed_volume(positions, clean.triangles) / volume - 1);
    made.errors[k].normals = degrees(mean_normal_angle(clean.positions, positions, clean.triangles));
    made.positions[k] = std::move(positions);
  };
  const Points noisy = add_thesis_noise(clean.positions, clean.triangles, std::abs(data.c1),
                                        std::abs(data.c2), static_cast<std::uint64_t>(seed));
  measure(0, noisy);
  for (std::size_t k = 0; k < std::size(kMethods); ++k) {
    FairingOptions options;
    options.method = kMethods[k];
    if (k < rows.size()) options.iterations = rows[k].iterations;
    try {
      measure(k + 1, fair(noisy, clean.triangles, options).positions);
    } catch (const Cancelled&) {
      throw;
    } catch (const Error&) {
      made.errors[k + 1] = {NAN, NAN};  // noise of some seeds leaves triangles without area
    }
  }
  return made;
}

void fairing_rows(ThesisRun& run, const MeshData& data, std::span<const FairingRow> printed) {
  std::vector<ThesisRow> rows;
  const TriangleMesh* given = nullptr;
  for (const FairingRow& line : printed) {
    ThesisRow& row = rows.emplace_back();
    row.id = concat("H 2.2 ", data.mesh, " ", line.algorithm);
    row.claim = line.similarity > 0 || std::string(line.algorithm) == "SDF"
                    ? concat(line.algorithm, " changes the volume less than MCF.")
                    : std::string("MCF changes the volume most.");
    row.thesis = {{"time_step", line.time_step},
                  {"iterations", line.iterations},
                  {"volume_change", line.volume_change}};
    if (line.similarity > 0) row.thesis["similarity"] = line.similarity;
    given = mesh_of(run, data.mesh, row);
  }
  if (given != nullptr) {
    const TriangleMesh clean = run.options.quick ? *given : as_large_as_printed(*given, data);
    std::vector<FairedSeed> seeds;
    if (clean.n_vertices() > kManySeedsVertices)
      seeds.push_back(faired_seed(clean, data, printed, 1));
    else
      seeds = run.for_seeds([&](int seed) { return faired_seed(clean, data, printed, seed); });
    const auto spread = [&](std::size_t k, double FairingErrors::*figure) {
      std::vector<double> values;
      for (const FairedSeed& seed : seeds) values.push_back(seed.errors[k].*figure);
      return spread_of(std::move(values));
    };
    ReportGrid grid;
    grid.note = concat(
        "H's ΔV as printed, whatever its unit; ours in per cent of the volume without noise. Normals: mean "
        "angle between the triangles of the result and those without noise. Median / worst of ",
        seeds.size() == 1 ? std::string("one seed") : concat(seeds.size(), " seeds"), ".");
    grid.columns = {"method", "steps (H)", "τ (H)", "ΔV (H)", "ΔV ours, %", "normals ours"};
    constexpr const char* kNames[] = {"noisy", "MCF", "SDF", "NL-SDF", "auto"};
    for (std::size_t k = 0; k < std::size(kNames); ++k) {
      const Spread volume = spread(k, &FairingErrors::volume), normals = spread(k, &FairingErrors::normals);
      std::vector<std::string> cells = {kNames[k],
                                        "",
                                        "",
                                        "",
                                        concat(number(volume.median), " / ", number(volume.worst)),
                                        concat(number(normals.median), "° / ", number(normals.worst), "°")};
      if (k > 0 && k <= printed.size()) {
        cells[1] = concat(printed[k - 1].iterations);
        cells[2] = number(printed[k - 1].time_step);
        cells[3] = number(printed[k - 1].volume_change);
        ThesisRow& row = rows[k - 1];
        row.ours = {{"volume_change_percent", volume.median},
                    {"normals_deg", normals.median},
                    {"noisy_normals_deg", spread(0, &FairingErrors::normals).median},
                    {"normals_by_auto_deg", spread(4, &FairingErrors::normals).median}};
        row.data += seeds.size() == 1 ? ", noise of (2.36), seed 1" : run.seeds_text(", noise of (2.36)");
        row.remark = "H's ΔV has no usable unit, so that the order alone is decided, by the medians.";
        const auto refused = std::count_if(seeds.begin(), seeds.end(), [k](const FairedSeed& seed) {
          return !std::isfinite(seed.errors[k].normals);
        });
        if (refused > 0)
          row.remark += concat(" The method refused ", refused, " of ", seeds.size(),
                               ", where the matrix of a step became singular.");
        if (k == 1)
          row.stand_in(std::nullopt);
        else
          row.stand_in(volume.median < spread(1, &FairingErrors::volume).median);
      }
      grid.rows.push_back(std::move(cells));
      if (seeds.front().positions[k].rows() == 0) continue;
      TriangleMesh picture = clean;
      picture.positions = seeds.front().positions[k];
      run.draw(rows.front(), kNames[k], "Seed 1.", {.mesh = &picture}, view_of(data.mesh, Shading::Shaded));
    }
    rows.front().grids = {std::move(grid)};
  }
  for (ThesisRow& row : rows) run.add(std::move(row));
}

// Table 2.3

struct Remeshed {
  RemeshMeasures measures;
  MeshVariation as_printed;
  double printed_areas = 0;
  TriangleMesh mesh;
};

Remeshed remeshed(const TriangleMesh& original, RemeshMethod method, int iterations) {
  RemeshOptions options;
  options.method = method;
  options.max_iterations = iterations;
  Remeshed made;
  made.mesh = remesh(original, options).mesh;
  made.measures = remesh_measures(original, made.mesh, options.keep_edges);
  made.as_printed =
      mesh_variation(original.positions, original.triangles, made.mesh.positions, made.mesh.triangles, {});
  made.printed_areas = printed_area_variance(original, made.mesh);
  return made;
}

/// A column of table 2.3.
struct RemeshMeasure {
  const char* name;
  double RemeshRow::*printed;
  double (*ours)(const Remeshed&);
  double (*as_printed)(const Remeshed&);
};
constexpr RemeshMeasure kRemeshMeasures[] = {
    {"ΔH", &RemeshRow::curvature, [](const Remeshed& r) { return 100 * r.measures.curvature_change; },
     [](const Remeshed& r) { return 100 * r.as_printed.mean_curvature; }},
    {"ΔVar(E)", &RemeshRow::edges, [](const Remeshed& r) { return 100 * r.measures.edge_variance_change; },
     [](const Remeshed& r) { return 100 * r.as_printed.edge_variance; }},
    {"ΔVar(A)", &RemeshRow::areas, [](const Remeshed& r) { return 100 * r.measures.area_variance_change; },
     [](const Remeshed& r) { return 100 * r.printed_areas; }},
    {"ΔVar(H)", &RemeshRow::curvature_variance,
     [](const Remeshed& r) { return 100 * r.measures.curvature_variance_change; },
     [](const Remeshed& r) { return 100 * r.as_printed.curvature_variance; }},
    {"d_h", &RemeshRow::distance, [](const Remeshed& r) { return r.measures.mean_distance; }, nullptr}};

std::string remesh_id(const char* mesh, const RemeshMeasure& measure) {
  return concat("H 2.3 ", mesh, " ", measure.name);
}

void remesh_rows(ThesisRun& run, const RemeshRow& ar, const RemeshRow& lf) {
  std::vector<ThesisRow> rows;
  const TriangleMesh* original = nullptr;
  for (const RemeshMeasure& measure : kRemeshMeasures) {
    ThesisRow& row = rows.emplace_back();
    row.id = remesh_id(ar.mesh, measure);
    const double a = ar.*measure.printed, l = lf.*measure.printed;
    row.claim = concat(measure.name, a < l ? " is smaller" : " is larger", " after AR than after LF.");
    row.thesis = {{"AR", a}, {"LF", l}};
    original = mesh_of(run, ar.mesh, row);
  }
  if (original != nullptr) {
    std::optional<Remeshed> made[2];
    parallel_for(
        2, 1,
        [&](Eigen::Index begin, Eigen::Index end) {
          for (Eigen::Index k = begin; k < end; ++k)
            made[k] = remeshed(*original, k == 0 ? RemeshMethod::Adaptive : RemeshMethod::LaplacianFlow,
                               ar.iterations);
        },
        run.progress);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const RemeshMeasure& measure = kRemeshMeasures[i];
      const double a = measure.ours(*made[0]), l = measure.ours(*made[1]);
      rows[i].ours = {{"AR", a}, {"LF", l}};
      if (measure.as_printed != nullptr) {
        const auto known = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
        rows[i].ours["as_H_defines_it"] = {{"AR", known(measure.as_printed(*made[0]))},
                                           {"LF", known(measure.as_printed(*made[1]))}};
      }
      rows[i].remark =
          i + 1 == rows.size()
              ? "H in the unit of its mesh, ours over the diameter; the order decides."
              : "Per cent. Ours with areas and edges over their means, ΔH and ΔVar(H) without borders and "
                "kept edges. H states neither numbers of vertices nor connectivity; the order decides.";
      rows[i].decide((ar.*measure.printed < lf.*measure.printed) == (a < l));
    }
    // Enlarged until triangles can be told apart.
    const double zoom =
        std::max(1.0, std::round(std::sqrt(static_cast<double>(original->n_triangles()) / 6000.0)));
    const auto draw = [&](const char* title, const TriangleMesh& mesh) {
      run.draw(rows.front(), title,
               concat(counts(mesh), zoom > 1 ? concat(" Enlarged ", zoom, " times.") : ""), {.mesh = &mesh},
               view_of(ar.mesh, Shading::Wireframe, zoom));
    };
    draw("original", *original);
    draw("AR", made[0]->mesh);
    draw("LF", made[1]->mesh);
  }
  for (ThesisRow& row : rows) run.add(std::move(row));
}

// Tables 2.4 and 2.5

std::string simplify_id(const char* table, const SimplifyRow& line) {
  return concat("H ", table, " ", line.mesh, " ", number(line.removed));
}

struct Simplified {
  DistanceFigures distances;  ///< of the original's vertices (2.102–2.104), over the diameter
  double back = 0;            ///< the largest one of the result from the original
  double angle = 0;           ///< mean smallest angle, degrees
  bool reached = true;
  TriangleMesh mesh;
};

Simplified simplified(const TriangleMesh& original, double removed, SimplifyMethod method) {
  SimplifyOptions options;
  options.method = method;
  options.remove = removed / 100;
  SimplifyResult result = simplify(original, options);
  CompareOptions compared;
  compared.samples = 50000;
  const Comparison comparison = compare({original.positions, original.triangles, {}},
                                        {result.mesh.positions, result.mesh.triangles, {}}, compared);
  const double diameter = bounding_box_diagonal(original.positions);
  Simplified made;
  made.distances = comparison.a_to_b.vertices;
  for (double* figure : {&made.distances.max, &made.distances.mean, &made.distances.rms}) *figure /= diameter;
  made.back = std::max(comparison.b_to_a.vertices.max, comparison.b_to_a.samples.max) / diameter;
  made.angle = degrees(mesh_quality(result.mesh.positions, result.mesh.triangles).mean_min_angle);
  made.reached = result.reached;
  made.mesh = std::move(result.mesh);
  return made;
}

Json distances_json(const double (&figures)[3], double scale) {
  return {{"dmax", figures[0] * scale}, {"dmean", figures[1] * scale}, {"drms", figures[2] * scale}};
}

void simplify_rows(ThesisRun& run, const char* table, std::span<const SimplifyRow> printed) {
  const std::string name = printed.front().mesh;
  std::vector<ThesisRow> rows;
  const TriangleMesh* original = nullptr;
  for (const SimplifyRow& line : printed) {
    ThesisRow& row = rows.emplace_back();
    row.id = simplify_id(table, line);
    row.claim = concat(name, " without ", number(line.removed),
                       " % of its triangles is no further from the original than H prints.");
    row.thesis = distances_json(line.thesis, 1);
    row.thesis["MeshLab"] = distances_json(line.meshlab, 1);
    original = mesh_of(run, name, row);
  }
  if (original != nullptr) {
    const double unit = printed_diameter(name, *original);
    std::vector<Simplified> made(2 * printed.size());
    parallel_for(
        static_cast<Eigen::Index>(made.size()), 1,
        [&](Eigen::Index begin, Eigen::Index end) {
          for (Eigen::Index i = begin; i < end; ++i)
            made[static_cast<std::size_t>(i)] =
                simplified(*original, printed[static_cast<std::size_t>(i / 2)].removed,
                           i % 2 == 0 ? SimplifyMethod::Quadric : SimplifyMethod::PLaplacian);
        },
        run.progress);
    ReportGrid grid;
    grid.note =
        "Distances of the original's vertices from the result (2.102–2.104), ours over the diameter. Back: "
        "the largest "
        "distance of the result from the original. p-Laplacian: batten simplify --method plaplacian, the "
        "thesis's.";
    grid.columns = {"removed, %", "by", "dmax", "dmean", "dRMS", "back", "smallest angle", "faces"};
    const auto printed_cells = [&](const SimplifyRow& line, const char* by, const double(&figures)[3]) {
      std::vector<std::string> cells = {number(line.removed), by};
      for (const double figure : figures)
        cells.push_back(
            concat(number(figure, "%.6f"), unit > 0 ? concat(" (", number(figure / unit, "%.1e"), ")") : ""));
      grid.rows.push_back(std::move(cells));
    };
    run.draw(rows.front(), "original", counts(*original), {.mesh = original},
             view_of(name, Shading::Wireframe));
    for (std::size_t i = 0; i < printed.size(); ++i) {
      ThesisRow& row = rows[i];
      printed_cells(printed[i], "MeshLab (H)", printed[i].meshlab);
      printed_cells(printed[i], "H", printed[i].thesis);
      constexpr const char* kNames[] = {"default", "p-Laplacian"};
      for (std::size_t m = 0; m < 2; ++m) {
        const Simplified& one = made[2 * i + m];
        grid.rows.push_back({number(printed[i].removed), kNames[m], number(one.distances.max, "%.1e"),
                             number(one.distances.mean, "%.1e"), number(one.distances.rms, "%.1e"),
                             number(one.back, "%.1e"), number(one.angle, "%.1f") + "°",
                             concat(one.mesh.n_triangles())});
        const double figures[3] = {one.distances.max, one.distances.mean, one.distances.rms};
        row.ours[m == 0 ? "default" : "plaplacian"] = distances_json(figures, 1);
        if (!one.reached)
          run.warnings.push_back(concat(row.id, ": no more than ",
                                        original->n_triangles() - one.mesh.n_triangles(), " of ",
                                        original->n_triangles(), " faces could be removed"));
        run.draw(rows.front(), concat(number(printed[i].removed), " % removed, ", kNames[m]),
                 counts(one.mesh), {.mesh = &one.mesh}, view_of(name, Shading::Wireframe));
      }
      const double ours = made[2 * i].distances.rms;
      if (unit > 0) {
        row.thesis["over_the_diameter"] = distances_json(printed[i].thesis, 1 / unit);
        row.remark = "dRMS decides, H's brought to the diameter by the volume of table 2.1.";
        row.decide(ours <= printed[i].thesis[2] / unit);
      } else {
        row.remark =
            "H prints lengths in a unit that table 2.1 does not tell, so that nothing is decided; ours over "
            "the diameter.";
        row.stand_in(std::nullopt);
      }
    }
    rows.front().grids = {std::move(grid)};
  }
  for (ThesisRow& row : rows) run.add(std::move(row));
}

// Figures 2.14 to 2.16

/// A closed round bar along x, with a ring of vertices at every step.
struct Bar {
  static constexpr int kAround = 32, kRings = 81;
  static constexpr double kRadius = 0.25, kLength = 2;
  TriangleMesh mesh;
  std::vector<int> handles;  ///< the rings near both ends, and the ends

  Bar() {
    mesh.positions.resize(kAround * kRings + 2, 3);
    const int first = kAround * kRings, last = first + 1;
    for (int r = 0; r < kRings; ++r)
      for (int k = 0; k < kAround; ++k) {
        const double t = 2 * kPi * k / kAround, x = kLength * r / (kRings - 1.0) - kLength / 2;
        mesh.positions.row(r * kAround + k) << x, kRadius * std::cos(t), kRadius * std::sin(t);
        if (std::abs(x) > 0.4 * kLength) handles.push_back(r * kAround + k);
      }
    mesh.positions.row(first) << -kLength / 2, 0, 0;
    mesh.positions.row(last) << kLength / 2, 0, 0;
    handles.push_back(first);
    handles.push_back(last);
    std::vector<Eigen::RowVector3i> triangles;
    for (int k = 0; k < kAround; ++k) {
      const int next = (k + 1) % kAround;
      for (int r = 0; r + 1 < kRings; ++r) {
        const int a = r * kAround + k, b = r * kAround + next, c = a + kAround, d = b + kAround;
        triangles.emplace_back(a, c, d);
        triangles.emplace_back(a, d, b);
      }
      triangles.emplace_back(first, k, next);
      triangles.emplace_back(last, (kRings - 1) * kAround + next, (kRings - 1) * kAround + k);
    }
    mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
    for (std::size_t f = 0; f < triangles.size(); ++f)
      mesh.triangles.row(static_cast<Eigen::Index>(f)) = triangles[f];
  }

  /// Length of the line through the centres of the rings.
  static double length(const Points& positions) {
    double sum = 0;
    Eigen::RowVector3d before;
    for (int r = 0; r < kRings; ++r) {
      const Eigen::RowVector3d centre = positions.middleRows(r * kAround, kAround).colwise().mean();
      if (r > 0) sum += (centre - before).norm();
      before = centre;
    }
    return sum;
  }
};

/// Where a point of the bar goes.
Eigen::Vector3d twisted(const Eigen::Vector3d& p, double angle) {
  const double turn = angle * p.x() / Bar::kLength;
  return Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitX()) * p;
}
Eigen::Vector3d bent(const Eigen::Vector3d& p, double angle) {
  const double radius = Bar::kLength / angle, turn = p.x() / radius;
  return {(radius + p.z()) * std::sin(turn), p.y(), (radius + p.z()) * std::cos(turn) - radius};
}

void deformation_row(ThesisRun& run, const std::string& id, const std::string& claim,
                     Eigen::Vector3d (*move)(const Eigen::Vector3d&, double), double angle) {
  ThesisRow row;
  row.id = id;
  row.claim = claim;
  row.data = concat("formula: a round bar, ends moved by ", number(degrees(angle)), "°");
  row.needs = "the meshes of H";
  const Bar bar;
  const auto targets_at = [&](double at) {
    Points targets(static_cast<Eigen::Index>(bar.handles.size()), 3);
    for (std::size_t i = 0; i < bar.handles.size(); ++i)
      targets.row(static_cast<Eigen::Index>(i)) =
          move(bar.mesh.positions.row(bar.handles[i]).transpose(), at).transpose();
    return targets;
  };
  const double volume = enclosed_volume(bar.mesh.positions, bar.mesh.triangles),
               length = Bar::length(bar.mesh.positions);
  ReportGrid grid;
  grid.note = "Volume and length of the middle line against those at rest, per cent.";
  grid.columns = {"method", "volume", "length"};
  const auto measure = [&](const char* name, const Points& positions) {
    const double v = 100 * enclosed_volume(positions, bar.mesh.triangles) / volume,
                 l = 100 * Bar::length(positions) / length;
    grid.rows.push_back({name, number(v, "%.1f"), number(l, "%.1f")});
    row.ours[name] = {{"volume_percent", v}, {"length_percent", l}};
    TriangleMesh made = bar.mesh;
    made.positions = positions;
    run.draw(row, name, "", {.mesh = &made}, view_of("bar", Shading::Wireframe));
  };
  const auto deformed = [&](const char* name, DeformationEnergy energy, DetailPreservation detail) {
    DeformOptions options;
    options.energy = energy;
    options.detail = detail;
    measure(name, Deformer(bar.mesh.positions, bar.mesh.triangles, bar.handles, options, run.progress)
                      .deform(targets_at(angle), nullptr, run.progress)
                      .positions);
  };
  deformed("stretch", DeformationEnergy::Stretch, DetailPreservation::None);
  deformed("combined", DeformationEnergy::Combined, DetailPreservation::None);
  deformed("total with detail kept", DeformationEnergy::TotalCurvature, DetailPreservation::GaussNewton);
  MultiresolutionOptions in_two;
  in_two.base_vertices = 600;
  const MultiresolutionDeformer multiresolution(bar.mesh.positions, bar.mesh.triangles, bar.handles, in_two,
                                                run.progress);
  measure("in two resolutions",
          multiresolution.deform(targets_at(angle), {targets_at(angle / 2)}, run.progress).positions);
  row.grids = {std::move(grid)};
  row.verdict = Verdict::Shown;
  run.add(std::move(row));
}

/// The rows of a table of one mesh, which follow each other there.
template <typename Row>
std::vector<std::span<const Row>> by_mesh(std::span<const Row> table) {
  std::vector<std::span<const Row>> parts;
  for (std::size_t begin = 0, end = 0; begin < table.size(); begin = end) {
    while (end < table.size() && std::string(table[end].mesh) == table[begin].mesh) ++end;
    parts.push_back(table.subspan(begin, end - begin));
  }
  return parts;
}

}  // namespace

std::vector<ThesisExperiment> thesis_h() {
  std::vector<ThesisExperiment> experiments;
  for (const MeshData& data : kTable21)
    experiments.push_back(
        {{concat("H 2.1 ", data.mesh)}, [&data](ThesisRun& run) { counts_row(run, data); }});
  for (const std::span<const FairingRow> part : by_mesh(std::span<const FairingRow>(kTable22))) {
    const MeshData& data = *std::find_if(std::begin(kTable21), std::end(kTable21), [&](const MeshData& mesh) {
      return std::string(mesh.mesh) == part.front().mesh;
    });
    std::vector<std::string> ids;
    for (const FairingRow& line : part) ids.push_back(concat("H 2.2 ", line.mesh, " ", line.algorithm));
    experiments.push_back({ids, [&data, part](ThesisRun& run) { fairing_rows(run, data, part); }});
  }
  for (const std::span<const RemeshRow> part : by_mesh(std::span<const RemeshRow>(kTable23))) {
    std::vector<std::string> ids;
    for (const RemeshMeasure& measure : kRemeshMeasures) ids.push_back(remesh_id(part.front().mesh, measure));
    experiments.push_back({ids, [part](ThesisRun& run) { remesh_rows(run, part[0], part[1]); }});
  }
  const auto add_table = [&](const char* table, std::span<const SimplifyRow> lines) {
    for (const std::span<const SimplifyRow> part : by_mesh(lines)) {
      std::vector<std::string> ids;
      for (const SimplifyRow& line : part) ids.push_back(simplify_id(table, line));
      experiments.push_back({ids, [table, part](ThesisRun& run) { simplify_rows(run, table, part); }});
    }
  };
  add_table("2.4", kTable24);
  add_table("2.5", kTable25);
  experiments.push_back({{"H 2.15 twist"}, [](ThesisRun& run) {
                           deformation_row(
                               run, "H 2.15 twist",
                               "A twisted bar under three energies, the last with its detail kept.", twisted,
                               radians(90));
                         }});
  experiments.push_back({{"H 2.15 bend"}, [](ThesisRun& run) {
                           deformation_row(run, "H 2.15 bend",
                                           "A bent bar under three energies, the last with its detail kept.",
                                           bent, radians(90));
                         }});
  experiments.push_back(without_data("H 2.14", "The bumpy plane deformed under three energies.",
                                     "the mesh of H with its handles"));
  experiments.push_back(
      without_data("H 2.16", "The cube deformed under three energies.", "the mesh of H with its handles"));
  return experiments;
}

}  // namespace batten::experiments
