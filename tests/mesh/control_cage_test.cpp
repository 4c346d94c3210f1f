#include "batten/mesh/control_cage.hpp"

#include <gtest/gtest.h>

namespace batten {
namespace {

// What is named sharp and says no more stays sharp for ever: no number of levels uses it up.
TEST(ControlCage, WhatIsNamedSharpIsSharpForEver) {
  ControlCage cage;
  cage.sharp_edges.push_back({.from = 0, .to = 1});
  cage.sharp_vertices.push_back({.vertex = 0});
  EXPECT_EQ(cage.sharp_edges[0].sharpness - 1000, cage.sharp_edges[0].sharpness);
  EXPECT_EQ(cage.sharp_vertices[0].sharpness, kInfinitelySharp);
  EXPECT_EQ(cage.mesh.n_faces(), 0);
}

}  // namespace
}  // namespace batten
