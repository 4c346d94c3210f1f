// Fairing: time of one whole job and the error that is left, for auto, the peers that live in the library and
// MeshLab's two-step and Taubin smoothing, with Gaussian noise of three levels and with impulses, on meshes
// of ../shared/data. Usage: bench_fairing [--benchmark_filter=...]
#include "meshlab.hpp"
#include "peers.hpp"

#include <cmath>
#include <memory>
#include <string>

#include <benchmark/benchmark.h>

#include "batten/core/units.hpp"
#include "batten/fairing/fair.hpp"
#include "batten/fairing/noise.hpp"
#include "batten/mesh/normals.hpp"

namespace {

using namespace batten;

/// `level`: of Gaussian noise; negative: a third of the vertices moved by that many edges.
Points with_noise(const TriangleMesh& mesh, double level) {
  return level >= 0 ? add_gaussian_noise(mesh.positions, mesh.triangles, level, 1)
                    : add_impulsive_noise(mesh.positions, mesh.triangles, 1.0 / 3, -level,
                                          ImpulseKind::AlongNormal, 1);
}

void score_fairing(benchmark::State& state, const TriangleMesh& truth, const Points& noisy,
                   const Points& faired) {
  state.counters["vertices"] = static_cast<double>(truth.n_vertices());
  state.counters["noisy_deg"] = degrees(mean_normal_angle(noisy, truth.positions, truth.triangles));
  state.counters["faired_deg"] = degrees(mean_normal_angle(faired, truth.positions, truth.triangles));
  state.counters["crossings_before"] = static_cast<double>(self_intersections(noisy, truth.triangles).size());
  state.counters["crossings"] = static_cast<double>(self_intersections(faired, truth.triangles).size());
}

void run_batten(benchmark::State& state, Subject& subject, FairingMethod method, double level) {
  const Points noisy = with_noise(subject.mesh, level);
  FairingOptions options;
  options.method = method;
  FairingResult result;
  const ProcessorClock clock;
  for (auto _ : state) result = fair(noisy, subject.mesh.triangles, options);
  if (method == FairingMethod::Automatic) subject.own_seconds = clock.seconds();
  score_fairing(state, subject.mesh, noisy, result.positions);
}

void run_meshlab(benchmark::State& state, const Subject& subject, const meshlab::Filter& filter,
                 double level) {
  if (!meshlab::is_available()) {
    state.SkipWithError("meshlabserver or xvfb-run is missing; tools/setup bench installs them");
    return;
  }
  TriangleMesh noisy = subject.mesh;
  noisy.positions = with_noise(subject.mesh, level);
  for (auto _ : state) {
    const meshlab::Result result = meshlab::apply(filter, noisy);
    state.SetIterationTime(result.seconds);
    report_ratio(state, subject, result.cpu_seconds);
    if (result.mesh.n_triangles() == noisy.n_triangles())
      score_fairing(state, subject.mesh, noisy.positions, result.mesh.positions);
    else
      state.SkipWithError("MeshLab has changed the triangles");
  }
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  for (const char* file : {"fandisk.obj", "cubehole.off.gz", "rocker-arm.obj", "bunny_34835.off.gz"}) {
    const auto subject = public_mesh(file);
    if (!subject) continue;
    for (const double level : {0.1, 0.2, 0.3, -0.5}) {
      const auto add = [&, level](const std::string& method, auto run) {
        const std::string name = "fair/" + subject->name + "/" + (level > 0 ? "gauss" : "impulse") +
                                 std::to_string(std::abs(level)).substr(0, 3) + "/" + method;
        return once(benchmark::RegisterBenchmark(name.c_str(), run));
      };
      for (const FairingMethod method :
           {FairingMethod::Automatic, FairingMethod::GuidedNormal, FairingMethod::BilateralNormal,
            FairingMethod::Taubin, FairingMethod::NonlocalSurfaceDiffusion})
        add(std::string(word_of(method)),
            [=](benchmark::State& s) { run_batten(s, *subject, method, level); });
      add("meshlab_two_step", [=](benchmark::State& s) {
        run_meshlab(s, *subject, meshlab::two_step_smoothing(), level);
      })->UseManualTime();
      add("meshlab_taubin", [=](benchmark::State& s) {
        run_meshlab(s, *subject, meshlab::taubin_smoothing(), level);
      })->UseManualTime();
    }
  }
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
