// Catmull–Clark against OpenSubdiv alone, on the cages of docs/performance.md and at three sizes; NULISS and
// patches for comparison. Build with -DBATTEN_BUILD_BENCH=ON; see docs/performance.md.
#include "memory.hpp"
#include "subdivision/cages.hpp"

#include <memory>
#include <vector>

#include <benchmark/benchmark.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include "batten/subdivision/bspline_surface.hpp"
#include "batten/subdivision/step.hpp"
#include "batten/subdivision/subdivide.hpp"

namespace batten {
namespace {

/// A torus of about so many quads; 10,240 is 160 × 64.
ControlCage torus_of(long quads) {
  const int m = static_cast<int>(std::lround(std::sqrt(0.4 * static_cast<double>(quads))));
  return cages::torus(static_cast<int>(quads / m), m);
}

constexpr int kLevels = 3;

void BM_CatmullClark(benchmark::State& state) {
  const ControlCage cage = torus_of(state.range(0));
  SubdividedSurface surface;
  for (auto _ : state) {
    surface = subdivide(cage, {.levels = kLevels});
    benchmark::DoNotOptimize(surface.cage.mesh.positions.data());
  }
  state.counters["faces"] = static_cast<double>(surface.cage.mesh.n_faces());
  state.counters["peak_MB"] = peak_megabytes();
}

/// What OpenSubdiv itself needs for points and quads: topology, refinement, interpolation, the faces copied
/// out.
void BM_OpenSubdivAlone(benchmark::State& state) {
  namespace Far = OpenSubdiv::Far;
  namespace Sdc = OpenSubdiv::Sdc;
  struct Point {
    double x[3];
    void Clear() { x[0] = x[1] = x[2] = 0; }
    void AddWithWeight(const Point& other, double weight) {
      for (int k = 0; k < 3; ++k) x[k] += weight * other.x[k];
    }
  };
  const ControlCage cage = torus_of(state.range(0));
  const std::vector<int> n_corners(static_cast<size_t>(cage.mesh.n_faces()), 4);
  for (auto _ : state) {
    Far::TopologyDescriptor descriptor;
    descriptor.numVertices = static_cast<int>(cage.mesh.positions.rows());
    descriptor.numFaces = static_cast<int>(cage.mesh.n_faces());
    descriptor.numVertsPerFace = n_corners.data();
    descriptor.vertIndicesPerFace = cage.mesh.corners.data();
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    Sdc::Options options;
    options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
    const std::unique_ptr<Far::TopologyRefiner> refiner(
        Factory::Create(descriptor, Factory::Options(Sdc::SCHEME_CATMARK, options)));
    refiner->RefineUniform(Far::TopologyRefiner::UniformOptions(kLevels));
    std::vector<Point> points(static_cast<size_t>(refiner->GetNumVerticesTotal()));
    for (Eigen::Index v = 0; v < cage.mesh.positions.rows(); ++v)
      for (int k = 0; k < 3; ++k) points[static_cast<size_t>(v)].x[k] = cage.mesh.positions(v, k);
    const Far::PrimvarRefinerReal<double> interpolation(*refiner);
    Point* source = points.data();
    for (int level = 1; level <= kLevels; ++level) {
      Point* target = source + refiner->GetLevel(level - 1).GetNumVertices();
      interpolation.Interpolate(level, source, target);
      source = target;
    }
    const Far::TopologyLevel& last = refiner->GetLevel(kLevels);
    std::vector<int> corners;
    corners.reserve(static_cast<size_t>(last.GetNumFaceVertices()));
    for (int f = 0; f < last.GetNumFaces(); ++f) {
      const Far::ConstIndexArray of_face = last.GetFaceVertices(f);
      corners.insert(corners.end(), of_face.begin(), of_face.end());
    }
    benchmark::DoNotOptimize(corners.data());
    benchmark::DoNotOptimize(points.data());
  }
  state.counters["peak_MB"] = peak_megabytes();
}

void BM_Nuliss(benchmark::State& state) {
  const ControlCage cage = torus_of(state.range(0));
  for (auto _ : state)
    benchmark::DoNotOptimize(
        subdivide(cage, {.scheme = SubdivisionScheme::Nuliss, .levels = kLevels}).cage.mesh.positions.data());
}

void BM_Patches(benchmark::State& state) {
  const ControlCage cage = torus_of(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(limit_bsplines(cage).patches.data());
}

void BM_StepText(benchmark::State& state) {
  const BsplineSurface surface = limit_bsplines(torus_of(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(format_step(surface).data());
}

BENCHMARK(BM_OpenSubdivAlone)->Arg(2560)->Arg(10240)->Arg(40960)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_CatmullClark)->Arg(2560)->Arg(10240)->Arg(40960)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Nuliss)->Arg(2560)->Arg(10240)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Patches)->Arg(2560)->Arg(10240)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_StepText)->Arg(640)->Arg(2560)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace batten

BENCHMARK_MAIN();
