// Dragging a part of a torus of three sizes: before the first drag (factorisation), a linear drag of a handle
// that moves as one (an affine map) and of one that does not (a back-substitution), and a drag
// with five iterations of detail preservation, beside CGAL's "smoothed rotation enhanced"
// as-rigid-as-possible deformation in one run, one thread each (OMP_NUM_THREADS=1). A tenth of the vertices
// (the least x) is fixed, a twentieth (the largest) dragged by a fifth of the diameter. Usage:
// bench_deformation [--benchmark_filter=...]
#include "cgal_mesh.hpp"
#include "memory.hpp"
#include "mesh/shapes.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <CGAL/Surface_mesh_deformation.h>
#include <Eigen/Core>
#include <benchmark/benchmark.h>

#include "batten/core/units.hpp"
#include "batten/deformation/deformer.hpp"

namespace {

using namespace batten;

struct Subject {
  Points positions;
  Triangles triangles;
  std::vector<int> fixed, moved;

  std::vector<int> constrained() const {
    std::vector<int> all = fixed;
    all.insert(all.end(), moved.begin(), moved.end());
    return all;
  }
  /// @param uneven moves every handle vertex a little differently, so that no handle moves as one.
  Points targets(double share, bool uneven = false) const {
    const std::vector<int> all = constrained();
    const double diameter = (positions.colwise().maxCoeff() - positions.colwise().minCoeff()).norm();
    Points result(static_cast<Eigen::Index>(all.size()), 3);
    for (std::size_t c = 0; c < all.size(); ++c) {
      result.row(static_cast<Eigen::Index>(c)) = positions.row(all[c]);
      if (c >= fixed.size())
        result.row(static_cast<Eigen::Index>(c)) +=
            share * (uneven ? 1 + 0.1 * std::sin(static_cast<double>(c)) : 1) * diameter *
            Eigen::RowVector3d(0.1, 0.2, 0.05);
    }
    return result;
  }
};

Subject torus(int n_vertices) {
  const int n = static_cast<int>(std::lround(std::sqrt(n_vertices / 2.0)));
  const Shape shape = fixtures::grid(2 * n, n, true, true, [](double u, double v) {
    const double a = 2 * kPi * u, b = 2 * kPi * v, r = 2 + 0.7 * std::cos(b);
    return Eigen::Vector3d(r * std::cos(a), r * std::sin(a), 0.7 * std::sin(b));
  });
  Subject subject{shape.positions, shape.triangles, {}, {}};
  std::vector<int> order(subject.positions.rows());
  for (std::size_t v = 0; v < order.size(); ++v) order[v] = static_cast<int>(v);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return subject.positions(a, 0) < subject.positions(b, 0); });
  subject.fixed.assign(order.begin(), order.begin() + static_cast<long>(order.size() / 10));
  subject.moved.assign(order.end() - static_cast<long>(order.size() / 20), order.end());
  return subject;
}

DeformOptions options_for(DeformationEnergy energy, DetailPreservation detail) {
  DeformOptions options;
  options.energy = energy;
  options.detail = detail;
  options.max_iterations = 5;
  options.tolerance = 1e-300;  // all five
  return options;
}

void run_factorise(benchmark::State& state, const DeformOptions& options) {
  const Subject subject = torus(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    const Deformer deformer(subject.positions, subject.triangles, subject.constrained(), options);
    benchmark::DoNotOptimize(&deformer);
  }
  state.counters["vertices"] = static_cast<double>(subject.positions.rows());
  state.counters["peak_MB"] = peak_megabytes();
}

void run_drag(benchmark::State& state, const DeformOptions& options, bool uneven = false) {
  const Subject subject = torus(static_cast<int>(state.range(0)));
  const Deformer deformer(subject.positions, subject.triangles, subject.constrained(), options);
  Points last = deformer.deform(subject.targets(0.25, uneven)).positions;
  double share = 0.25;
  for (auto _ : state) {
    share = share < 1 ? share + 0.25 : 0.25;
    last = deformer
               .deform(subject.targets(share, uneven),
                       options.detail == DetailPreservation::None ? nullptr : &last)
               .positions;
  }
  state.counters["vertices"] = static_cast<double>(subject.positions.rows());
}

using CgalDeformation =
    CGAL::Surface_mesh_deformation<CgalMesh, CGAL::Default, CGAL::Default, CGAL::SRE_ARAP>;

void run_cgal(benchmark::State& state) {
  const Subject subject = torus(static_cast<int>(state.range(0)));
  CgalMesh mesh = to_cgal(subject.positions, subject.triangles);
  CgalDeformation deformation(mesh);
  for (const auto v : mesh.vertices()) deformation.insert_roi_vertex(v);
  const std::vector<int> constrained = subject.constrained();
  for (const int v : constrained) deformation.insert_control_vertex(CgalMesh::Vertex_index(v));
  deformation.preprocess();
  double share = 0;
  for (auto _ : state) {
    share = share < 1 ? share + 0.25 : 0.25;
    const Points targets = subject.targets(share);
    for (std::size_t c = 0; c < constrained.size(); ++c) {
      const auto row = targets.row(static_cast<Eigen::Index>(c));
      deformation.set_target_position(CgalMesh::Vertex_index(constrained[c]), {row.x(), row.y(), row.z()});
    }
    deformation.deform(5, 0);
  }
  state.counters["vertices"] = static_cast<double>(subject.positions.rows());
}

void sizes(benchmark::internal::Benchmark* b) {
  b->Arg(10000)->Arg(31250)->Arg(100000)->Unit(benchmark::kMillisecond);
}

const DeformOptions kLinear = options_for(DeformationEnergy::Bend, DetailPreservation::None);
const DeformOptions kNonlinear =
    options_for(DeformationEnergy::TotalCurvature, DetailPreservation::GaussNewton);
const DeformOptions kRigid = options_for(DeformationEnergy::Stretch, DetailPreservation::ShapeMatching);

void BM_FactoriseLinear(benchmark::State& state) {
  run_factorise(state, kLinear);
}
void BM_FactoriseNonlinear(benchmark::State& state) {
  run_factorise(state, kNonlinear);
}
void BM_DragLinear(benchmark::State& state) {
  run_drag(state, kLinear);
}
void BM_DragLinearUnevenly(benchmark::State& state) {
  run_drag(state, kLinear, true);
}
void BM_DragNonlinear(benchmark::State& state) {
  run_drag(state, kNonlinear);
}
void BM_DragAsRigidAsPossible(benchmark::State& state) {
  run_drag(state, kRigid);
}
void BM_DragCgal(benchmark::State& state) {
  run_cgal(state);
}
BENCHMARK(BM_FactoriseLinear)->Apply(sizes);
BENCHMARK(BM_FactoriseNonlinear)->Apply(sizes);
BENCHMARK(BM_DragLinear)->Apply(sizes);
BENCHMARK(BM_DragLinearUnevenly)->Apply(sizes);
BENCHMARK(BM_DragNonlinear)->Apply(sizes);
BENCHMARK(BM_DragAsRigidAsPossible)->Apply(sizes);
BENCHMARK(BM_DragCgal)->Apply(sizes);

}  // namespace

BENCHMARK_MAIN();
