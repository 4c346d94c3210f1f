#pragma once
#include "mesh/shapes.hpp"

#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <memory>
#include <string>

#include <benchmark/benchmark.h>

#include "batten/core/units.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/mesh/compare.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/mesh/triangle_mesh.hpp"

/// What the benchmarks that set us beside peers share: subjects, scores and the ratio of times.
namespace batten {

/// A mesh, and how long our own job on it took in this run.
struct Subject {
  std::string name;
  TriangleMesh mesh;
  double own_seconds = 0;  ///< of the processor; 0 until our job has run
};

/// A mesh of ../shared/data, or of the folder that the environment variable BATTEN_SHARED_DATA names; nothing
/// when the file is missing.
inline std::shared_ptr<Subject> public_mesh(const std::string& file) {
  const char* folder = std::getenv("BATTEN_SHARED_DATA");
  const std::string path = std::string(folder != nullptr ? folder : BATTEN_SHARED_DATA) + "/meshes/" + file;
  if (!std::filesystem::exists(path)) return nullptr;
  return std::make_shared<Subject>(Subject{file, read_mesh(path)});
}

/// A torus of radii 2 and 0.7 with 4 n² triangles.
inline TriangleMesh torus(int n) {
  const Shape shape = fixtures::grid(2 * n, n, true, true, [](double u, double v) {
    const double a = 2 * kPi * u, b = 2 * kPi * v, r = 2 + 0.7 * std::cos(b);
    return Eigen::Vector3d(r * std::cos(a), r * std::sin(a), 0.7 * std::sin(b));
  });
  TriangleMesh mesh;
  mesh.positions = shape.positions;
  mesh.triangles = shape.triangles;
  return mesh;
}

/// Processor time of this process since it was made.
class ProcessorClock {
 public:
  double seconds() const { return static_cast<double>(std::clock() - start_) / CLOCKS_PER_SEC; }

 private:
  std::clock_t start_ = std::clock();
};

/// The counter ours_over: our processor time over the peer's. Left out when ours has not run (a filter), and
/// when the peer's is too short to be told from its start.
inline void report_ratio(benchmark::State& state, const Subject& subject, double peer_seconds) {
  if (subject.own_seconds > 0 && peer_seconds > 0.05)
    state.counters["ours_over"] = subject.own_seconds / peer_seconds;
}

/// Distances over the diameter from the input to the result, and back; shapes; self-intersections.
/// @return the comparison, for what else may be read off it.
inline Comparison score(benchmark::State& state, const TriangleMesh& input, const TriangleMesh& result) {
  Comparison c = compare({input.positions, input.triangles, {}}, {result.positions, result.triangles, {}});
  const double diameter = bounding_box_diagonal(input.positions);
  state.counters["vertices"] = static_cast<double>(result.n_vertices());
  state.counters["faces"] = static_cast<double>(result.n_triangles());
  state.counters["dmax"] = c.a_to_b.samples.max / diameter;
  state.counters["dmean"] = c.a_to_b.samples.mean / diameter;
  state.counters["drms"] = c.a_to_b.samples.rms / diameter;
  state.counters["back_max"] = c.b_to_a.samples.max / diameter;
  state.counters["back_mean"] = c.b_to_a.samples.mean / diameter;
  state.counters["back_rms"] = c.b_to_a.samples.rms / diameter;
  state.counters["angle"] = degrees(mesh_quality(result.positions, result.triangles).mean_min_angle);
  state.counters["crossings"] =
      static_cast<double>(self_intersections(result.positions, result.triangles).size());
  return c;
}

inline benchmark::internal::Benchmark* once(benchmark::internal::Benchmark* b) {
  return b->Unit(benchmark::kMillisecond)->Iterations(1);
}

}  // namespace batten
