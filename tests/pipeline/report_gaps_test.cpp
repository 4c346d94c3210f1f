#include "report_gaps.hpp"

#include "mesh/shapes.hpp"
#include "sanitizers.hpp"
#include "threads.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "batten/core/units.hpp"
#include "batten/fairing/noise.hpp"
#include "batten/mesh/handles.hpp"
#include "batten/pipeline/deformed_mesh.hpp"
#include "batten/pipeline/faired_mesh.hpp"
#include "batten/pipeline/network_surface.hpp"
#include "batten/pipeline/reconstruction.hpp"
#include "batten/pipeline/remeshed_mesh.hpp"
#include "batten/pipeline/shape_comparison.hpp"
#include "batten/pipeline/simplified_mesh.hpp"
#include "batten/simulation/shapes.hpp"
#include "batten/simulation/simulate.hpp"

namespace batten {
namespace {

/// A torus of n × n / 2 cells.
TriangleMesh torus(int n) {
  return fixtures::as_mesh(fixtures::grid(n, n / 2, true, true, [](double u, double v) {
    const double a = 2 * kPi * u, b = 2 * kPi * v, r = 1 + 0.4 * std::cos(b);
    return Eigen::Vector3d(r * std::cos(a), r * std::sin(a), 0.4 * std::sin(b) + 0.02 * std::sin(7 * a));
  }));
}

struct Work {
  const char* name;
  std::function<void(const Progress&)> run;
};

// What the commands that take long are made of reports all along, checks of the result among it, and stops at
// any report. At 2,600 vertices each takes a tenth of a second or so; a third of it without a report would be
// a stage that has none. (The longest stretch is a part of compare: 0.2 to 0.27, by the machine.)
TEST(ReportGaps, EveryRequestReportsAllAlongAndStopsWhereItIsTold) {
  const TriangleMesh mesh = torus(72);
  TriangleMesh noisy = mesh;
  noisy.positions = add_gaussian_noise(mesh.positions, mesh.triangles, 0.2, 1);
  Handles handles;
  HandleMotion motion;
  for (int v = 0; v < mesh.n_vertices(); ++v) {
    if (mesh.positions(v, 0) < -1.2) handles.fixed.push_back(v);
    if (mesh.positions(v, 0) > 1.2) motion.vertices.push_back(v);
  }
  motion.translation = {0.2, 0, 0.3};
  handles.moved.push_back(motion);
  SimplifiedMeshOptions simplify;
  simplify.simplify.remove = 0.8;
  SimulateOptions device;
  device.step = test::repeated(0.01, 0.02);
  const Scan scan = simulate_scan(trace_shape(AnalyticShape::Torus), device).scan;
  ReconstructionOptions fine;
  fine.surface.edge_length = Length{0.02, Length::Kind::Relative};
  const Shape shape = shape_of(mesh), other = shape_of(torus(70));
  const std::vector<Work> all{
      {"fair", [&](const Progress& p) { faired_mesh(noisy, {}, p); }},
      {"remesh", [&](const Progress& p) { remeshed_mesh(mesh, {}, p); }},
      {"simplify", [&](const Progress& p) { simplified_mesh(mesh, simplify, p); }},
      {"deform", [&](const Progress& p) { deformed_mesh(mesh, handles, {}, p); }},
      {"compare", [&](const Progress& p) { compared_shapes(shape, other, {}, p); }},
      {"reconstruct", [&](const Progress& p) { reconstruct(scan, fine, p); }},
  };
  const test::Threads one_thread(1);  // all the work is on the thread whose time is measured
  for (const Work& work : all) {
    const test::ReportGaps gaps(work.run);
    // A machine with other work may stop anywhere for a while, but not at one place in each of three runs.
    double share = gaps.largest_share();
    for (int again = 0; again < 2 && share >= 0.33; ++again)
      share = std::min(share, test::ReportGaps(work.run).largest_share());
    EXPECT_LT(share, 0.33) << work.name << " before " << gaps.before();
    for (const int stop_at : {1, gaps.reports() / test::repeated(2, 4)}) {
      int reports = 0;
      const Progress stop([&](std::string_view, double) { return ++reports < stop_at; });
      EXPECT_THROW(work.run(stop), Cancelled) << work.name << " at " << stop_at;
      EXPECT_EQ(reports, stop_at) << work.name;
    }
  }
}

}  // namespace
}  // namespace batten
