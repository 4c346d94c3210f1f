// Fairing: time of one whole job and the error that is left, for auto and the peers that live in the library.
// Run with BATTEN_SHARED_DATA naming the folder of the public meshes.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <string>

#include <benchmark/benchmark.h>

#include "batten/core/units.hpp"
#include "batten/fairing/fair.hpp"
#include "batten/fairing/noise.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/mesh/normals.hpp"

namespace {

using namespace batten;

/// Mean angle between the normals of the triangles, degrees.
double normal_error(const Points& a, const Points& b, const Triangles& triangles) {
  const Points na = face_normals(a, triangles), nb = face_normals(b, triangles);
  double sum = 0;
  for (Eigen::Index f = 0; f < na.rows(); ++f)
    sum += std::acos(std::clamp(na.row(f).dot(nb.row(f)), -1.0, 1.0));
  return degrees(sum / static_cast<double>(na.rows()));
}

/// Fairs `file` with noise of `level` (negative: a third of the vertices moved by that many edges).
void fair_mesh(benchmark::State& state, const std::string& file, FairingMethod method, double level) {
  const char* folder = std::getenv("BATTEN_SHARED_DATA");
  const std::string path = std::string(folder != nullptr ? folder : "../shared/data") + "/meshes/" + file;
  static std::map<std::string, TriangleMesh> meshes;
  try {
    if (meshes.find(path) == meshes.end()) meshes[path] = read_mesh(path);
  } catch (const Error& error) {
    state.SkipWithError(error.what());
    return;
  }
  const TriangleMesh& mesh = meshes[path];
  const Points noisy = level >= 0 ? add_gaussian_noise(mesh.positions, mesh.triangles, level, 1)
                                  : add_impulsive_noise(mesh.positions, mesh.triangles, 1.0 / 3, -level,
                                                        ImpulseKind::AlongNormal, 1);
  FairingOptions options;
  options.method = method;
  FairingResult result;
  for (auto _ : state) {
    result = fair(noisy, mesh.triangles, options);
    benchmark::DoNotOptimize(result.positions.data());
  }
  state.counters["vertices"] = static_cast<double>(mesh.n_vertices());
  state.counters["noisy_deg"] = normal_error(noisy, mesh.positions, mesh.triangles);
  state.counters["faired_deg"] = normal_error(result.positions, mesh.positions, mesh.triangles);
}

}  // namespace

int main(int argc, char** argv) {
  for (const char* file : {"fandisk.obj", "cubehole.off.gz", "rocker-arm.obj", "bunny_34835.off.gz"})
    for (const FairingMethod method :
         {FairingMethod::Automatic, FairingMethod::GuidedNormal, FairingMethod::BilateralNormal,
          FairingMethod::Taubin, FairingMethod::NonlocalSurfaceDiffusion})
      for (const double level : {0.1, 0.2, 0.3, -0.5}) {
        const std::string name =
            "fair/" + std::string(file) + "/" + fairing_method_names()[static_cast<std::size_t>(method)] +
            "/" + (level > 0 ? "gauss" : "impulse") + std::to_string(std::abs(level)).substr(0, 3);
        benchmark::RegisterBenchmark(name.c_str(), fair_mesh, file, method, level)
            ->Unit(benchmark::kMillisecond)
            ->MeasureProcessCPUTime();
      }
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
