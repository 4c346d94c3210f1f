#include "batten/pipeline/mesh_input.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

TriangleMesh triangle(double size = 1) {
  TriangleMesh mesh;
  mesh.positions.resize(3, 3);
  mesh.positions << 0, 0, 0, size, 0, 0, 0, size, 0;
  mesh.triangles.resize(1, 3);
  mesh.triangles << 0, 1, 2;
  return mesh;
}

TEST(MeshProblem, NamesWhatCannotBeProcessed) {
  const auto problem_after = [](const auto& change) {
    TriangleMesh mesh = triangle();
    change(mesh);
    return mesh_problem(mesh).value_or("");
  };
  EXPECT_EQ(problem_after([](TriangleMesh&) {}), "");
  EXPECT_NE(problem_after([](TriangleMesh& m) { m.triangles.resize(0, 3); }).find("no faces"),
            std::string::npos);
  EXPECT_NE(problem_after([](TriangleMesh& m) {
              m.positions(1, 2) = std::numeric_limits<double>::quiet_NaN();
            }).find("finite"),
            std::string::npos);
  for (const int outside : {-1, 3})
    EXPECT_NE(problem_after([=](TriangleMesh& m) { m.triangles(0, 1) = outside; }).find("outside 0 to 2"),
              std::string::npos);
  EXPECT_NE(problem_after([](TriangleMesh& m) { m.positions.row(2) = m.positions.row(1); }).find("area"),
            std::string::npos);
}

// The sixth power of 1e45 is 1e270, that of 1e-45 is 1e-270: both still normal numbers.
TEST(MeshProblem, SizesWhoseSixthPowerIsANumberPass) {
  for (const double size : {1e-44, 1.0, 1e44}) EXPECT_FALSE(mesh_problem(triangle(size)).has_value()) << size;
  for (const double size : {1e-46, 1e46})
    EXPECT_NE(mesh_problem(triangle(size)).value_or("").find("unit"), std::string::npos) << size;
}

TEST(RequireProcessable, ThrowsWhatIsWrong) {
  EXPECT_NO_THROW(require_processable(triangle()));
  EXPECT_THROW(require_processable({}), InvalidInput);
}

}  // namespace
}  // namespace batten
