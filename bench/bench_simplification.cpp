// Simplification beside CGAL's Lindstrom-Turk and Garland-Heckbert, MeshLab's quadric edge collapse and
// OpenMesh's decimater in one run, one thread each, on meshes of ../shared/data at six levels, on a torus of
// three sizes and on a flat square. Usage: bench_simplification [--benchmark_filter=...]
#include "cgal_mesh.hpp"
#include "meshlab.hpp"
#include "peers.hpp"
#ifdef BATTEN_BENCH_OPENMESH
#include "openmesh.hpp"
#endif

#include <cmath>
#include <memory>
#include <string>

#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_placement.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_ratio_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_plane_policies.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>
#include <Eigen/Core>
#include <benchmark/benchmark.h>

#include "batten/simplification/simplify.hpp"

namespace {

using namespace batten;
namespace SMS = CGAL::Surface_mesh_simplification;

/// A flat square: no collapse costs anything, the trap for methods that stall on equal costs.
TriangleMesh square(int n) {
  const Shape shape =
      fixtures::grid(n, n, false, false, [](double u, double v) { return Eigen::Vector3d(u, v, 0); });
  TriangleMesh mesh;
  mesh.positions = shape.positions;
  mesh.triangles = shape.triangles;
  return mesh;
}

Eigen::Index kept_faces(const TriangleMesh& mesh, double removed) {
  return std::lround((1 - removed) * static_cast<double>(mesh.n_triangles()));
}

void run_batten(benchmark::State& state, Subject& subject, double removed, int fit_rounds) {
  SimplifyOptions options;
  options.remove = removed;
  options.fit_rounds = fit_rounds;
  SimplifyResult result;
  const ProcessorClock clock;
  for (auto _ : state) result = simplify(subject.mesh, options);
  if (fit_rounds > 0) subject.own_seconds = clock.seconds();
  score(state, subject.mesh, result.mesh);
}

enum class CgalMethod { LindstromTurk, GarlandHeckbert };

void run_cgal(benchmark::State& state, const Subject& subject, double removed, CgalMethod method) {
  CgalMesh mesh = to_cgal(subject.mesh.positions, subject.mesh.triangles);
  SMS::Count_ratio_stop_predicate<CgalMesh> stop(1 - removed);
  const ProcessorClock clock;
  for (auto _ : state) {
    if (method == CgalMethod::LindstromTurk) {
      SMS::edge_collapse(mesh, stop);
    } else {
      using Policies = SMS::GarlandHeckbert_plane_policies<CgalMesh, CGAL::Simple_cartesian<double>>;
      const Policies policies(mesh);
      const SMS::Bounded_normal_change_placement<Policies::Get_placement> placement(policies.get_placement());
      SMS::edge_collapse(mesh, stop,
                         CGAL::parameters::get_cost(policies.get_cost()).get_placement(placement));
    }
  }
  report_ratio(state, subject, clock.seconds());
  score(state, subject.mesh, from_cgal(mesh));
}

void run_meshlab(benchmark::State& state, const Subject& subject, double removed) {
  if (!meshlab::is_available()) {
    state.SkipWithError("meshlabserver or xvfb-run is missing; tools/setup bench installs them");
    return;
  }
  for (auto _ : state) {
    const meshlab::Result result =
        meshlab::apply(meshlab::quadric_edge_collapse(kept_faces(subject.mesh, removed)), subject.mesh);
    state.SetIterationTime(result.seconds);
    report_ratio(state, subject, result.cpu_seconds);
    score(state, subject.mesh, result.mesh);
  }
}

void run_openmesh(benchmark::State& state, [[maybe_unused]] const Subject& subject,
                  [[maybe_unused]] double removed) {
#ifdef BATTEN_BENCH_OPENMESH
  for (auto _ : state) {
    const OpenMeshDecimation result = decimate_with_openmesh(subject.mesh, kept_faces(subject.mesh, removed));
    state.SetIterationTime(result.seconds);
    report_ratio(state, subject, result.cpu_seconds);
    score(state, subject.mesh, result.mesh);
  }
#else
  state.SkipWithError("built without OpenMesh; tools/setup bench installs it");
#endif
}

void register_all(const std::shared_ptr<Subject>& subject, double removed) {
  const auto add = [&](const char* peer, auto run) {
    const std::string name =
        subject->name + "/" + std::to_string(static_cast<int>(1000 * removed)) + "permille/" + peer;
    return once(benchmark::RegisterBenchmark(name.c_str(), run));
  };
  add("batten", [=](benchmark::State& s) { run_batten(s, *subject, removed, 6); });
  add("batten_collapses_only", [=](benchmark::State& s) { run_batten(s, *subject, removed, 0); });
  add("cgal_lindstrom_turk",
      [=](benchmark::State& s) { run_cgal(s, *subject, removed, CgalMethod::LindstromTurk); });
  add("cgal_garland_heckbert",
      [=](benchmark::State& s) { run_cgal(s, *subject, removed, CgalMethod::GarlandHeckbert); });
  add("meshlab", [=](benchmark::State& s) { run_meshlab(s, *subject, removed); })->UseManualTime();
  add("openmesh", [=](benchmark::State& s) { run_openmesh(s, *subject, removed); })->UseManualTime();
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  for (const char* file : {"fandisk.obj", "rocker-arm.obj", "bunny_34835.off.gz", "igea.ply.gz"})
    if (const auto subject = public_mesh(file)) {
      for (const double removed : {0.8, 0.9, 0.95, 0.97, 0.99}) register_all(subject, removed);
      if (subject->mesh.n_triangles() > 50000) register_all(subject, 0.999);
    }
  for (const int n : {100, 200, 400})
    register_all(std::make_shared<Subject>(Subject{"torus_" + std::to_string(4 * n * n), torus(n)}), 0.95);
  register_all(std::make_shared<Subject>(Subject{"square_80000", square(200)}), 0.95);
  // 5,000,000 faces: the memory is that of the process (VmHWM in /proc/self/status, /usr/bin/time -v).
  once(benchmark::RegisterBenchmark("torus_5000000/batten", [](benchmark::State& s) {
    Subject subject{"torus_5000000", torus(1118)};
    run_batten(s, subject, 0.95, 6);
  }));
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
