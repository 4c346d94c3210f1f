#include "batten/io/handles_io.hpp"

#include "scratch.hpp"

#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"

namespace batten {
namespace {

/// Four vertices on the x axis, at 0, 1, 2 and 3.
Points four() {
  Points points = Points::Zero(4, 3);
  points.col(0) << 0, 1, 2, 3;
  return points;
}

Handles read(const std::string& text) {
  const std::string path = test::scratch_file("handles.json");
  std::ofstream(path) << text;
  return read_handles(path, four());
}

// All three ways to select; a quarter turn about z through (2, 0, 0), then up: 3 → (2, 1, 5).
TEST(ReadHandles, SelectsAndMoves) {
  const Handles handles = read(R"({"fixed": {"box": [[0.5, -1, -1], [-1, 1, 1]]}, "handles": [
    {"select": {"sphere": [3, 0, 0, 0.5]}, "rotate_deg": [0, 0, 2, 90], "about": [2, 0, 0], "translate": [0, 0, 5]},
    {"select": {"vertices": [2, 1]}, "targets": [[7, 8, 9], [4, 5, 6]]}]})");
  EXPECT_EQ(handles.vertices(), (std::vector<int>{0, 3, 2, 1}));
  EXPECT_NEAR(handles.largest_angle(), radians(90.0), 1e-15);
  Points expected(4, 3);
  expected << 0, 0, 0, 2, 1, 5, 7, 8, 9, 4, 5, 6;
  EXPECT_LT((handles.targets(four()) - expected).norm(), 1e-14);
  // No share of the motion leaves everything where it is; half of it turns by half the angle, on the arc.
  EXPECT_EQ(handles.targets(four(), 0).row(1), four().row(3));
  const Points half = handles.targets(four(), 0.5);
  EXPECT_NEAR((half.row(1) - Eigen::RowVector3d(2, 0, 2.5)).norm(), 1, 1e-14);
  EXPECT_EQ(half.row(2), Eigen::RowVector3d(4.5, 4, 4.5));
}

// The surface of a sphere and of a box belongs to it.
TEST(ReadHandles, SelectsUpToTheSurface) {
  const Handles handles = read(R"({"fixed": {"sphere": [1, 0, 0, 1]}, "handles": [
    {"select": {"box": [[3, 0, 0], [4, 0, 0]]}, "translate": [0, 0, 1]}]})");
  EXPECT_EQ(handles.vertices(), (std::vector<int>{0, 1, 2, 3}));
}

// Every refusal names what is wrong.
TEST(ReadHandles, RefusesWithThePlace) {
  const auto expect_refused = [](const std::string& text, const std::string& words) {
    try {
      read(text);
      FAIL() << text;
    } catch (const FileError& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  };
  expect_refused("{", "not JSON");
  expect_refused("[]", "must be an object");
  expect_refused(R"({"fixed": {"vertices": [0]}})", "'handles' must be a list");
  expect_refused(R"({"handels": []})", "unknown member 'handels'");
  expect_refused(R"({"handles": [{"translate": [0, 0, 1]}]})", "no 'select'");
  expect_refused(R"({"handles": [{"select": {"vertices": [4]}}]})", "0 to 3");
  expect_refused(R"({"handles": [{"select": {"vertices": [-1]}}]})", "0 to 3");
  expect_refused(R"({"handles": [{"select": {"vertices": [1.5]}}]})", "0 to 3");
  expect_refused(R"({"handles": [{"select": {"vertices": []}}]})", "selects no vertex");
  expect_refused(R"({"handles": [{"select": {"sphere": [9, 9, 9, 1]}}]})", "selects no vertex");
  expect_refused(R"({"handles": [{"select": {"sphere": [0, 0, 0, -1]}}]})", "radius");
  expect_refused(R"({"handles": [{"select": {"box": [[0, 0, 0]]}}]})", "two corners");
  expect_refused(R"({"handles": [{"select": {"vertices": [0], "box": [[0, 0, 0], [1, 1, 1]]}}]})",
                 "exactly one");
  expect_refused(R"({"handles": [{"select": {"vertices": [1, 1]}}]})", "vertex 1 is selected by");
  expect_refused(R"({"fixed": {"vertices": [1]}, "handles": [{"select": {"vertices": [1]}}]})",
                 "vertex 1 is selected by fixed and by handles[0].select");
  expect_refused(R"({"handles": [{"select": {"vertices": [1]}, "rotate_deg": [0, 0, 0, 30]}]})", "no axis");
  expect_refused(R"({"handles": [{"select": {"vertices": [1]}, "rotate_deg": [0, 0, 30]}]})", "4 numbers");
  expect_refused(R"({"handles": [{"select": {"vertices": [1]}, "targets": [[0, 0, 0], [1, 1, 1]]}]})",
                 "list of 1 points");
  expect_refused(
      R"({"handles": [{"select": {"vertices": [1]}, "targets": [[0, 0, 0]], "translate": [1, 1, 1]}]})",
      "give one of them");
  expect_refused(R"({"handles": [{"select": {"vertices": [1]}, "translate": [0, 0, "up"]}]})",
                 "finite numbers");
  EXPECT_THROW(read_handles(test::scratch_file("no_such_handles.json"), four()), FileError);
}

}  // namespace
}  // namespace batten
