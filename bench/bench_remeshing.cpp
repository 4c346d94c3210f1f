// Remeshing at the mean edge length of the input beside CGAL's isotropic remeshing in one run, one thread
// each (OMP_NUM_THREADS=1), on meshes of ../shared/data and a torus of three sizes. Usage: bench_remeshing
// [--benchmark_filter=...]
#include "memory.hpp"
#include "mesh/shapes.hpp"

#include <cmath>
#include <filesystem>
#include <string>

#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <Eigen/Core>
#include <benchmark/benchmark.h>

#include "batten/core/units.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/mesh/compare.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/remeshing/measures.hpp"
#include "batten/remeshing/remesh.hpp"

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

void score(benchmark::State& state, const TriangleMesh& input, const TriangleMesh& result) {
  const Comparison c =
      compare({input.positions, input.triangles, {}}, {result.positions, result.triangles, {}});
  const RemeshMeasures measures = remesh_measures(input, result);
  state.counters["vertices"] = static_cast<double>(result.n_vertices());
  state.counters["angle"] = degrees(mesh_quality(result.positions, result.triangles).mean_min_angle);
  state.counters["drms"] = c.a_to_b.samples.rms / bounding_box_diagonal(input.positions);
  state.counters["normals"] = degrees(measures.normal_error);
  state.counters["dH"] = measures.curvature_change;
  state.counters["peak_MB"] = peak_megabytes();
}

void run_batten(benchmark::State& state, const TriangleMesh& mesh, RemeshMethod method) {
  RemeshOptions options;
  options.method = method;
  TriangleMesh result;
  for (auto _ : state) result = remesh(mesh, options).mesh;
  score(state, mesh, result);
}

void run_cgal(benchmark::State& state, const TriangleMesh& mesh) {
  CgalMesh input;
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v)
    input.add_vertex({mesh.positions(v, 0), mesh.positions(v, 1), mesh.positions(v, 2)});
  using Vertex = CgalMesh::Vertex_index;
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f)
    input.add_face(Vertex(mesh.triangles(f, 0)), Vertex(mesh.triangles(f, 1)), Vertex(mesh.triangles(f, 2)));
  const double length = mesh_quality(mesh.positions, mesh.triangles).mean_edge;
  CgalMesh remeshed;
  for (auto _ : state) {
    remeshed = input;
    CGAL::Polygon_mesh_processing::isotropic_remeshing(
        faces(remeshed), length, remeshed,
        CGAL::Polygon_mesh_processing::parameters::number_of_iterations(5));
  }
  remeshed.collect_garbage();
  TriangleMesh result;
  result.positions.resize(remeshed.number_of_vertices(), 3);
  result.triangles.resize(remeshed.number_of_faces(), 3);
  Eigen::Index row = 0;
  for (const auto v : remeshed.vertices()) {
    const auto& p = remeshed.point(v);
    result.positions.row(row++) << p.x(), p.y(), p.z();
  }
  row = 0;
  for (const auto f : remeshed.faces()) {
    int k = 0;
    for (const auto v : CGAL::vertices_around_face(remeshed.halfedge(f), remeshed))
      result.triangles(row, k++) = static_cast<int>(v);
    ++row;
  }
  score(state, mesh, result);
}

void register_all(const std::string& name, const TriangleMesh& mesh) {
  const auto once = [](benchmark::internal::Benchmark* b) {
    b->Unit(benchmark::kMillisecond)->Iterations(1);
  };
  once(benchmark::RegisterBenchmark((name + "/batten_ar").c_str(), [=](benchmark::State& s) {
    run_batten(s, mesh, RemeshMethod::Adaptive);
  }));
  once(benchmark::RegisterBenchmark((name + "/batten_lf").c_str(), [=](benchmark::State& s) {
    run_batten(s, mesh, RemeshMethod::LaplacianFlow);
  }));
  once(benchmark::RegisterBenchmark((name + "/cgal_isotropic").c_str(),
                                    [=](benchmark::State& s) { run_cgal(s, mesh); }));
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  for (const char* file : {"fandisk.obj", "rocker-arm.obj", "bunny_34835.off.gz", "igea.ply.gz"}) {
    const std::string path = std::string(BATTEN_SHARED_DATA) + "/meshes/" + file;
    if (std::filesystem::exists(path)) register_all(file, read_mesh(path));
  }
  for (const int n : {50, 100, 200}) register_all("torus_" + std::to_string(4 * n * n), torus(n));
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
