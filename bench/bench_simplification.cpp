// Simplification beside CGAL's Lindstrom-Turk in one run, one thread each, on one mesh to 5 % of its faces
// and on a torus of three sizes. Usage: bench_simplification [--benchmark_filter=...]
#include "mesh/shapes.hpp"

#include <cmath>
#include <filesystem>
#include <string>

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_ratio_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>
#include <Eigen/Core>
#include <benchmark/benchmark.h>

#include "batten/core/units.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/mesh/compare.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/simplification/simplify.hpp"

namespace {

using namespace batten;
using CgalMesh = CGAL::Surface_mesh<CGAL::Simple_cartesian<double>::Point_3>;

TriangleMesh torus(int n) {
  const Shape shape = fixtures::grid(2 * n, n, true, true, [](double u, double v) {
    const double a = 2 * kPi * u, b = 2 * kPi * v, r = 2 + 0.7 * std::cos(b);
    return Eigen::Vector3d(r * std::cos(a), r * std::sin(a), 0.7 * std::sin(b));
  });
  TriangleMesh mesh;
  mesh.positions = shape.positions;
  mesh.triangles = shape.triangles;
  return mesh;
}

/// A flat square: no collapse costs anything, the trap for methods that stall on equal costs.
TriangleMesh square(int n) {
  const Shape shape =
      fixtures::grid(n, n, false, false, [](double u, double v) { return Eigen::Vector3d(u, v, 0); });
  TriangleMesh mesh;
  mesh.positions = shape.positions;
  mesh.triangles = shape.triangles;
  return mesh;
}

CgalMesh to_cgal(const TriangleMesh& mesh) {
  CgalMesh result;
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v)
    result.add_vertex({mesh.positions(v, 0), mesh.positions(v, 1), mesh.positions(v, 2)});
  using Vertex = CgalMesh::Vertex_index;
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f)
    result.add_face(Vertex(mesh.triangles(f, 0)), Vertex(mesh.triangles(f, 1)), Vertex(mesh.triangles(f, 2)));
  return result;
}

TriangleMesh from_cgal(CgalMesh& mesh) {
  mesh.collect_garbage();
  TriangleMesh result;
  result.positions.resize(mesh.number_of_vertices(), 3);
  result.triangles.resize(mesh.number_of_faces(), 3);
  Eigen::Index row = 0;
  for (const auto v : mesh.vertices()) {
    const auto& p = mesh.point(v);
    result.positions.row(row++) << p.x(), p.y(), p.z();
  }
  row = 0;
  for (const auto f : mesh.faces()) {
    int k = 0;
    for (const auto v : CGAL::vertices_around_face(mesh.halfedge(f), mesh))
      result.triangles(row, k++) = static_cast<int>(v);
    ++row;
  }
  return result;
}

/// The figures of the tables: distances over the diameter, largest over both directions.
void score(benchmark::State& state, const TriangleMesh& input, const TriangleMesh& result) {
  const Comparison c =
      compare({input.positions, input.triangles, {}}, {result.positions, result.triangles, {}});
  const double diameter = bounding_box_diagonal(input.positions);
  state.counters["faces"] = static_cast<double>(result.n_triangles());
  state.counters["drms"] = c.a_to_b.samples.rms / diameter;
  state.counters["dmax"] = c.a_to_b.samples.max / diameter;
  state.counters["back_rms"] = c.b_to_a.samples.rms / diameter;
  state.counters["back_max"] = c.b_to_a.samples.max / diameter;
  state.counters["angle"] = degrees(mesh_quality(result.positions, result.triangles).mean_min_angle);
  state.counters["crossings"] =
      static_cast<double>(self_intersections(result.positions, result.triangles).size());
}

void run_batten(benchmark::State& state, const TriangleMesh& mesh, double removed, int fit_rounds) {
  SimplifyOptions options;
  options.remove = removed;
  options.fit_rounds = fit_rounds;
  SimplifyResult result;
  for (auto _ : state) result = simplify(mesh, options);
  score(state, mesh, result.mesh);
}

void run_cgal(benchmark::State& state, const TriangleMesh& mesh, double removed) {
  const CgalMesh input = to_cgal(mesh);
  CgalMesh result;
  for (auto _ : state) {
    state.PauseTiming();
    result = input;
    state.ResumeTiming();
    CGAL::Surface_mesh_simplification::Count_ratio_stop_predicate<CgalMesh> stop(1 - removed);
    CGAL::Surface_mesh_simplification::edge_collapse(result, stop);
  }
  score(state, mesh, from_cgal(result));
}

void register_all(const std::string& name, const TriangleMesh& mesh, double removed) {
  const auto label = [&](const char* peer) {
    return name + "/" + std::to_string(static_cast<int>(1000 * removed)) + "permille/" + peer;
  };
  const auto once = [](benchmark::internal::Benchmark* b) {
    b->Unit(benchmark::kMillisecond)->Iterations(1);
  };
  once(benchmark::RegisterBenchmark(label("batten").c_str(),
                                    [=](benchmark::State& s) { run_batten(s, mesh, removed, 6); }));
  once(benchmark::RegisterBenchmark(label("batten_collapses_only").c_str(),
                                    [=](benchmark::State& s) { run_batten(s, mesh, removed, 0); }));
  once(benchmark::RegisterBenchmark(label("cgal_lindstrom_turk").c_str(),
                                    [=](benchmark::State& s) { run_cgal(s, mesh, removed); }));
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  for (const char* file : {"fandisk.obj", "rocker-arm.obj", "bunny_34835.off.gz", "igea.ply.gz"}) {
    const std::string path = std::string(BATTEN_SHARED_DATA) + "/meshes/" + file;
    if (!std::filesystem::exists(path)) continue;
    const TriangleMesh mesh = read_mesh(path);
    for (const double removed : {0.8, 0.9, 0.95, 0.97, 0.99}) register_all(file, mesh, removed);
    if (mesh.n_triangles() > 50000) register_all(file, mesh, 0.999);
  }
  for (const int n : {100, 200, 400}) register_all("torus_" + std::to_string(4 * n * n), torus(n), 0.95);
  register_all("square_80000", square(200), 0.95);
  // 5,000,000 faces: the memory is that of the process (VmHWM in /proc/self/status, /usr/bin/time -v).
  benchmark::RegisterBenchmark("torus_5000000/batten",
                               [](benchmark::State& s) { run_batten(s, torus(1118), 0.95, 6); })
      ->Unit(benchmark::kMillisecond)
      ->Iterations(1);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
