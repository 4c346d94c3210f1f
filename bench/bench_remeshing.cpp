// Remeshing at the mean edge length of the input beside CGAL's and MeshLab's isotropic remeshing in one run,
// one thread each (OMP_NUM_THREADS=1), on meshes of ../shared/data and a torus of three sizes. Usage:
// bench_remeshing [--benchmark_filter=...]
#include "cgal_mesh.hpp"
#include "memory.hpp"
#include "meshlab.hpp"
#include "peers.hpp"

#include <memory>
#include <string>

#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <Eigen/Core>
#include <benchmark/benchmark.h>

#include "batten/remeshing/measures.hpp"
#include "batten/remeshing/remesh.hpp"

namespace {

using namespace batten;

void score_remeshing(benchmark::State& state, const TriangleMesh& input, const TriangleMesh& result) {
  score(state, input, result);
  const RemeshMeasures measures = remesh_measures(input, result);
  state.counters["normals"] = degrees(measures.normal_error);
  state.counters["dH"] = measures.curvature_change;
  state.counters["peak_MB"] = peak_megabytes();
}

void run_batten(benchmark::State& state, Subject& subject, RemeshMethod method) {
  RemeshOptions options;
  options.method = method;
  RemeshResult result;
  const ProcessorClock clock;
  for (auto _ : state) result = remesh(subject.mesh, options);
  if (method == RemeshMethod::Adaptive) subject.own_seconds = clock.seconds();
  for (const auto& [stage, seconds] : result.times.stages()) state.counters[stage] = seconds;
  score_remeshing(state, subject.mesh, result.mesh);
}

double mean_edge(const TriangleMesh& mesh) {
  return mesh_quality(mesh.positions, mesh.triangles).mean_edge;
}

void run_cgal(benchmark::State& state, const Subject& subject) {
  CgalMesh remeshed = to_cgal(subject.mesh.positions, subject.mesh.triangles);
  const double length = mean_edge(subject.mesh);
  const ProcessorClock clock;
  for (auto _ : state)
    CGAL::Polygon_mesh_processing::isotropic_remeshing(
        faces(remeshed), length, remeshed,
        CGAL::Polygon_mesh_processing::parameters::number_of_iterations(5));
  report_ratio(state, subject, clock.seconds());
  score_remeshing(state, subject.mesh, from_cgal(remeshed));
}

void run_meshlab(benchmark::State& state, const Subject& subject) {
  if (!meshlab::is_available()) {
    state.SkipWithError("meshlabserver or xvfb-run is missing; tools/setup bench installs them");
    return;
  }
  const meshlab::Filter filter =
      meshlab::isotropic_remeshing(mean_edge(subject.mesh), bounding_box_diagonal(subject.mesh.positions));
  for (auto _ : state) {
    const meshlab::Result result = meshlab::apply(filter, subject.mesh);
    state.SetIterationTime(result.seconds);
    report_ratio(state, subject, result.cpu_seconds);
    score_remeshing(state, subject.mesh, result.mesh);
  }
}

void register_all(const std::shared_ptr<Subject>& subject) {
  const auto add = [&](const char* peer, auto run) {
    return once(benchmark::RegisterBenchmark((subject->name + "/" + peer).c_str(), run));
  };
  add("batten_ar", [=](benchmark::State& s) { run_batten(s, *subject, RemeshMethod::Adaptive); });
  add("batten_lf", [=](benchmark::State& s) { run_batten(s, *subject, RemeshMethod::LaplacianFlow); });
  add("cgal_isotropic", [=](benchmark::State& s) { run_cgal(s, *subject); });
  add("meshlab_isotropic", [=](benchmark::State& s) { run_meshlab(s, *subject); })->UseManualTime();
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  for (const char* file : {"fandisk.obj", "rocker-arm.obj", "bunny_34835.off.gz", "igea.ply.gz"})
    if (const auto subject = public_mesh(file)) register_all(subject);
  for (const int n : {50, 100, 200})
    register_all(std::make_shared<Subject>(Subject{"torus_" + std::to_string(4 * n * n), torus(n)}));
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
