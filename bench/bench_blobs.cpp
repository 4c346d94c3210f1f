#include <benchmark/benchmark.h>

#include "batten/capture/blob_extraction.hpp"
#include "batten/simulation/pen.hpp"

// Finding LEDs in images of 1.3 megapixels, beside looking at each pixel once.
namespace batten {
namespace {

/// An image in the middle of a recording with four LEDs, mirrored ones and lamps.
GreyImage image_of_a_pen(double distance) {
  SimulatePenOptions options;
  options.motion.distance = distance;
  options.motion.duration = 0.5;
  options.false_blobs = 2;
  options.images = true;
  const SimulatedPen pen = simulate_pen(strokes_of(PenPath::Circle), options);
  return pen_image(pen.actual.left, pen.lights[pen.lights.size() / 2 / 2 * 2], 1, 0);
}

void BM_ExtractBlobs(benchmark::State& state) {
  const GreyImage image = image_of_a_pen(1e-2 * static_cast<double>(state.range(0)));
  std::size_t blobs = 0;
  for (auto _ : state) blobs = extract_blobs(image).blobs.size();
  state.counters["blobs"] = static_cast<double>(blobs);
}
BENCHMARK(BM_ExtractBlobs)->Arg(30)->Arg(60)->Arg(100)->Unit(benchmark::kMillisecond);

void BM_HistogramOfPixels(benchmark::State& state) {
  const GreyImage image = image_of_a_pen(0.6);
  for (auto _ : state) {
    std::uint32_t histogram[256] = {};
    for (const std::uint8_t pixel : image.pixels) ++histogram[pixel];
    benchmark::DoNotOptimize(histogram);
  }
}
BENCHMARK(BM_HistogramOfPixels)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace batten
