#include "studio/step_file.hpp"

#include <cmath>
#include <memory>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/network/curve_network.hpp"
#include "batten/subdivision/step.hpp"

namespace batten::test {
namespace {

/// The surface of a square in the plane z = 0, of two units.
RequestResult square() {
  CurveNetwork network;
  network.positions.resize(40, 3);
  network.normals = Eigen::RowVector3d::UnitZ().replicate(40, 1);
  constexpr double kCorners[5][2] = {{0, 0}, {2, 0}, {2, 2}, {0, 2}, {0, 0}};
  for (int side = 0; side < 4; ++side) {
    NetworkCurve& curve = network.curves.emplace_back();
    curve.boundary = true;
    for (int i = 0; i <= 10; ++i) curve.vertices.push_back((10 * side + i) % 40);
    for (int i = 0; i < 10; ++i)
      network.positions.row(10 * side + i)
          << kCorners[side][0] + i / 10.0 * (kCorners[side + 1][0] - kCorners[side][0]),
          kCorners[side][1] + i / 10.0 * (kCorners[side + 1][1] - kCorners[side][1]), 0;
  }
  return run(SurfaceRequest{}, std::make_shared<const CurveNetwork>(network));
}

TEST(StepFile, HoldsTheSurfaceInMillimetres) {
  if (!has_step()) GTEST_SKIP() << "built without Open Cascade";
  const StepModel read = read_step(studio::step_file(square(), "cm"));
  EXPECT_TRUE(read.is_valid);
  EXPECT_NEAR(read.area, 400, 0.01);
  EXPECT_NEAR(read_step(studio::step_file(square(), "")).area, 4e6, 100);  // metres
}

TEST(StepFile, RefusesInWords) {
  const auto message_of = [](const RequestResult& made, const char* unit) {
    try {
      studio::step_file(made, unit);
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  if (!has_step()) {
    EXPECT_NE(message_of(square(), "mm").find("Open Cascade"), std::string::npos);
    return;
  }
  EXPECT_NE(message_of(square(), "%").find("'%'"), std::string::npos);
  EXPECT_NE(message_of(FairedMesh{}, "mm").find("surfaces of curves"), std::string::npos);
}

}  // namespace
}  // namespace batten::test
