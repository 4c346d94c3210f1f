#include "batten/simplification/history.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

/// A square of four triangles about its middle, vertex 4, which is first moved and then collapsed into
/// vertex 0.
SimplificationHistory square_without_middle() {
  SimplificationHistory history;
  history.start((Points(5, 3) << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.5, 0.5, 0).finished(),
                (Triangles(4, 3) << 0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4).finished());
  history.add(SimplificationHistory::VertexChange{4, {0.5, 0.5, 0}, {0.5, 0.5, 1}});
  history.end_step();
  history.end_step();  // nothing has changed: no step
  history.add(SimplificationHistory::FaceChange{0, {0, 1, 4}, {-1, -1, -1}});
  history.add(SimplificationHistory::FaceChange{3, {3, 0, 4}, {-1, -1, -1}});
  history.add(SimplificationHistory::FaceChange{1, {1, 2, 4}, {1, 2, 0}});
  history.add(SimplificationHistory::FaceChange{2, {2, 3, 4}, {2, 3, 0}});
  history.end_step();
  history.end_level();
  return history;
}

TEST(SimplificationHistory, CountsWhatWasRecorded) {
  EXPECT_TRUE(SimplificationHistory().empty());
  EXPECT_EQ(SimplificationHistory().n_steps(), 0u);
  const SimplificationHistory history = square_without_middle();
  EXPECT_FALSE(history.empty());
  EXPECT_EQ(history.n_steps(), 2u);
  EXPECT_EQ(history.level_steps(), std::vector<std::size_t>{2});
}

// Every mesh between is the same, from whichever end it is reached.
TEST(SimplificationHistory, ReplaysForthAndBack) {
  const SimplificationHistory history = square_without_middle();
  SimplificationHistory::Replay replay(history);
  const TriangleMesh input = replay.mesh();
  EXPECT_EQ(replay.n_faces(), 4);
  EXPECT_EQ(input.positions.row(4), Eigen::RowVector3d(0.5, 0.5, 0));
  replay.go_to(1);
  const TriangleMesh moved = replay.mesh();
  EXPECT_EQ(moved.positions.row(4), Eigen::RowVector3d(0.5, 0.5, 1));
  EXPECT_EQ(moved.triangles, input.triangles);
  replay.go_to(2);
  EXPECT_EQ(replay.step(), 2u);
  EXPECT_EQ(replay.n_faces(), 2);
  std::vector<int> vertices;
  const TriangleMesh coarse = replay.mesh(&vertices);
  EXPECT_EQ(vertices, (std::vector<int>{0, 1, 2, 3})) << "the middle is used no more";
  EXPECT_EQ(coarse.positions, input.positions.topRows(4));
  EXPECT_EQ(coarse.triangles, (Triangles(2, 3) << 1, 2, 0, 2, 3, 0).finished());
  replay.go_to(1);
  EXPECT_EQ(replay.mesh().positions, moved.positions);
  EXPECT_EQ(replay.mesh().triangles, moved.triangles);
  replay.go_to(0);
  EXPECT_EQ(replay.mesh().positions, input.positions);
  EXPECT_EQ(replay.n_faces(), 4);
  EXPECT_THROW(replay.go_to(3), InvalidInput);
}

// The first step with at most so many faces, from the fine end; where there is none, the last.
TEST(SimplificationHistory, FindsTheStepOfANumberOfFaces) {
  const SimplificationHistory history = square_without_middle();
  SimplificationHistory::Replay replay(history);
  replay.go_to(2);
  replay.go_to_faces(4);
  EXPECT_EQ(replay.step(), 0u);
  replay.go_to_faces(3);
  EXPECT_EQ(replay.step(), 2u);
  replay.go_to_faces(2);
  EXPECT_EQ(replay.step(), 2u);
}

}  // namespace
}  // namespace batten
