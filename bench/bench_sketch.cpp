// Tool calls on models of growing size (their cost should follow the edit, not the model), undo of them, and
// the surface after an edit beside the surface from nothing.
#include "sketch/strokes.hpp"

#include <functional>
#include <map>

#include <benchmark/benchmark.h>

#include "batten/modelling/diffusion_surface.hpp"
#include "batten/session/document.hpp"

namespace batten {
namespace {

using namespace strokes;
using Eigen::Vector3d;

constexpr double kSnap = 2e-4;  // curves of the densest sheet are 0.001 apart

constexpr ObjectId kModel{1};

Edit on_model(SketchEdit edit) {
  return ModelEdit{kModel, std::move(edit), 0};
}

/// A polygon laid on gentle waves.
Points on_waves(std::initializer_list<Vector3d> corners) {
  Points points = polygon(corners, 200);
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    points(i, 2) = 0.1 * std::sin(2.5 * points(i, 0)) * std::cos(2 * points(i, 1));
  return points;
}

/// A gently waved sheet of n × n faces.
const Document& waves_of(int n) {
  static std::map<int, Document> sheets;
  const auto found = sheets.find(n);
  if (found != sheets.end()) return found->second;
  Document document;
  document.apply(AddEdit{kModel, "sheet", "", SharedModel()});
  document.apply(on_model(InsertEdit{{on_waves({kO, kX, kX + kY, kY, kO}), true}, {.snap = kSnap}}));
  for (int k = 1; k < n; ++k) {
    const double t = static_cast<double>(k) / n;
    document.apply(on_model(InsertEdit{{on_waves({t * kY, kX + t * kY}), false}, {.snap = kSnap}}));
    document.apply(on_model(InsertEdit{{on_waves({t * kX, kY + t * kX}), false}, {.snap = kSnap}}));
  }
  // Without what led to it, which fills memory.
  return sheets[n] =
             Document::restored({{kModel, document.object(kModel)}},
                                {{kModel, std::make_shared<const PolylineMesh>(document.model(kModel))}});
}

/// An edit of three faces or so in the middle of a sheet of so many curves, and its undo.
void edit_and_undo(benchmark::State& state, const std::function<Edit(int)>& edit_of) {
  const int n = static_cast<int>(state.range(0)) / 2 + 1;
  Document document = waves_of(n);
  const Edit edit = edit_of(n);
  document.apply(edit);  // a copy has no room to grow: what makes it is not counted
  document.apply(UndoEdit{});
  for (auto _ : state) {
    document.apply(edit);
    document.apply(UndoEdit{});
  }
  state.counters["edges"] = document.model(kModel).counts().edges;
}

/// A curve over three faces.
void BM_InsertAndUndo(benchmark::State& state) {
  edit_and_undo(state, [](int n) {
    const double x = static_cast<double>(n / 2) / n, y = (n / 2 + 0.4) / n;
    return on_model(
        InsertEdit{{on_waves({Vector3d(x, y, 0), Vector3d(x + 3.0 / n, y, 0)}), false}, {.snap = kSnap}});
  });
}

/// A stroke that ends in the middle of a face: its refusal names the nearest curve.
void BM_RefuseStroke(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0)) / 2 + 1;
  Document document = waves_of(n);
  const double x = static_cast<double>(n / 2) / n, y = (n / 2 + 0.4) / n;
  const Edit edit = on_model(
      InsertEdit{{on_waves({Vector3d(x, y, 0), Vector3d(x + 2.5 / n, y, 0)}), false}, {.snap = kSnap}});
  for (auto _ : state) try {
      document.apply(edit);
      state.SkipWithError("done although it should be refused");
    } catch (const RefusedEdit&) {
    }
}

/// A closed stroke of a third of a face.
DrawnStroke ring(int n, double x, double y) {
  DrawnStroke stroke = circle(Vector3d(x / n, y / n, 0), 0.3 / n * kX, 0.3 / n * kY);
  for (Eigen::Index i = 0; i < stroke.points.rows(); ++i)
    stroke.points(i, 2) = 0.1 * std::sin(2.5 * stroke.points(i, 0)) * std::cos(2 * stroke.points(i, 1));
  return stroke;
}

/// A hole within one face.
void BM_HoleInFaceAndUndo(benchmark::State& state) {
  edit_and_undo(state, [](int n) {
    return on_model(HoleEdit{ring(n, n / 2 + 0.5, n / 2 + 0.5), {.snap = 0.05 / n}});
  });
}

/// A hole over four faces around a crossing.
void BM_HoleOverFacesAndUndo(benchmark::State& state) {
  edit_and_undo(state, [](int n) { return on_model(HoleEdit{ring(n, n / 2, n / 2), {.snap = 0.05 / n}}); });
}

/// A deletion of a curve over three faces, which is the last one drawn.
void BM_DeleteAndUndo(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0)) / 2 + 1;
  Document document = waves_of(n);
  const double x = static_cast<double>(n / 2) / n, y = (n / 2 + 0.4) / n;
  document.apply(on_model(
      InsertEdit{{on_waves({Vector3d(x, y, 0), Vector3d(x + 3.0 / n, y, 0)}), false}, {.snap = kSnap}}));
  const Edit edit = on_model(DeleteEdit{document.model(kModel).n_curves() - 1});
  for (auto _ : state) {
    document.apply(edit);
    document.apply(UndoEdit{});
  }
}

/// A copy of the model, which no edit makes.
void BM_CopyOfModel(benchmark::State& state) {
  const Document& document = waves_of(static_cast<int>(state.range(0)) / 2 + 1);
  for (auto _ : state) {
    PolylineMesh copy = document.model(kModel);
    benchmark::DoNotOptimize(copy);
  }
}

/// The surface after a curve over one face in the middle was inserted, then after it was taken back: two
/// updates.
void BM_SurfaceAfterEdit(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0));
  Document document = waves_of(n);
  EditedSurface surface;
  surface.update(document.model(kModel));
  const double y = (n / 2 + 0.5) / n, x = static_cast<double>(n / 2) / n;
  const Edit edit = on_model(
      InsertEdit{{on_waves({Vector3d(x, y, 0), Vector3d(x + 1.0 / n, y, 0)}), false}, {.snap = kSnap}});
  SurfaceUpdate update;
  for (auto _ : state) {
    state.PauseTiming();
    document.apply(edit);
    state.ResumeTiming();
    update = surface.update(document.model(kModel));
    state.PauseTiming();
    document.apply(UndoEdit{});
    state.ResumeTiming();
    surface.update(document.model(kModel));
  }
  state.counters["quads_made"] = static_cast<double>(update.quads);
  state.counters["quads"] =
      static_cast<double>(surface.surface(document.model(kModel)).refined.mesh.n_faces());
}

/// All of the same sheet.
void BM_SurfaceFromNothing(benchmark::State& state) {
  const Document& document = waves_of(static_cast<int>(state.range(0)));
  DiffusionSurface surface;
  for (auto _ : state) surface = diffusion_surface(document.model(kModel));
  state.counters["quads"] = static_cast<double>(surface.refined.mesh.n_faces());
  for (const auto& [stage, seconds] : surface.times.stages()) state.counters[stage + "_ms"] = 1e3 * seconds;
}

/// The copy of the whole that EditedSurface::surface() hands out.
void BM_CopyOfSurface(benchmark::State& state) {
  const Document& document = waves_of(static_cast<int>(state.range(0)));
  EditedSurface surface;
  surface.update(document.model(kModel));
  for (auto _ : state) benchmark::DoNotOptimize(surface.surface(document.model(kModel)));
}

void sizes(benchmark::internal::Benchmark* benchmark) {
  for (const int curves : {100, 500, 1000, 2000}) benchmark->Arg(curves);
  benchmark->Unit(benchmark::kMillisecond);
}

BENCHMARK(BM_InsertAndUndo)->Apply(sizes);
BENCHMARK(BM_RefuseStroke)->Apply(sizes);
BENCHMARK(BM_HoleInFaceAndUndo)->Apply(sizes);
BENCHMARK(BM_HoleOverFacesAndUndo)->Apply(sizes);
BENCHMARK(BM_DeleteAndUndo)->Apply(sizes);
BENCHMARK(BM_CopyOfModel)->Apply(sizes);
BENCHMARK(BM_SurfaceAfterEdit)->Arg(6)->Arg(12)->Arg(24)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_SurfaceFromNothing)->Arg(6)->Arg(12)->Arg(24)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_CopyOfSurface)->Arg(6)->Arg(12)->Arg(24)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace batten

BENCHMARK_MAIN();
