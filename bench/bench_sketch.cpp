// A tool call on models of growing size (its cost should follow the edit, not the model), undo of it, and the
// surface of a model from nothing.
#include "sketch/strokes.hpp"

#include <map>

#include <benchmark/benchmark.h>

#include "batten/session/document.hpp"
#include "batten/sketch/diffusion_surface.hpp"

namespace batten {
namespace {

using namespace strokes;
using Eigen::Vector3d;

/// A square sheet with n curves, half along x and half along y.
const Document& sheet_of(int n_curves) {
  static std::map<int, Document> sheets;
  const auto found = sheets.find(n_curves);
  if (found != sheets.end()) return found->second;
  Document document;
  document.apply(InsertEdit{{polygon({kO, kX, kX + kY, kY, kO}), true}, {}});
  const int half = n_curves / 2;
  for (int k = 1; k <= half; ++k) {
    const double t = static_cast<double>(k) / (half + 1);
    document.apply(InsertEdit{{polygon({t * kY, kX + t * kY}), false}, {.snap = 1e-4}});
    document.apply(InsertEdit{{polygon({t * kX, kY + t * kX}), false}, {.snap = 1e-4}});
  }
  return sheets[n_curves] = std::move(document);
}

/// A curve over three faces in the middle of the sheet, and its undo.
void BM_InsertAndUndo(benchmark::State& state) {
  Document document = sheet_of(static_cast<int>(state.range(0)));
  const double cell = 1.0 / (static_cast<double>(state.range(0)) / 2 + 1);
  const int row = static_cast<int>(0.5 / cell);
  const double y = (row + 0.4) * cell, x0 = row * cell;
  const Edit edit =
      InsertEdit{{polygon({Vector3d(x0, y, 0), Vector3d(x0 + 3 * cell, y, 0)}), false}, {.snap = 1e-4}};
  for (auto _ : state) {
    document.apply(edit);
    document.apply(UndoEdit{});
  }
  state.counters["edges"] = document.mesh().counts().edges;
}

void BM_WholeSurface(benchmark::State& state) {
  Document document;
  document.apply(InsertEdit{circle(kO, kX, kY, 200), {}});
  document.apply(InsertEdit{circle(kO, kX, kZ, 200), {}});
  document.apply(InsertEdit{circle(kO, kY, kZ, 200), {}});
  DiffusionSurface surface;
  for (auto _ : state)
    surface = diffusion_surface(document.mesh(), {.splits = static_cast<int>(state.range(0)), .rounds = 5});
  state.counters["quads"] = static_cast<double>(surface.refined.mesh.n_faces());
}

BENCHMARK(BM_InsertAndUndo)->Arg(50)->Arg(150)->Arg(500)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_WholeSurface)->DenseRange(3, 6)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace batten

BENCHMARK_MAIN();
