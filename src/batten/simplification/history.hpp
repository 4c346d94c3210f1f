#pragma once
#include <cstdint>
#include <vector>

#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

/// The changes from a fine mesh to a coarse one, step by step, each of which can be undone: a collapse
/// (undone it is a vertex split), or a rearrangement of many vertices and edges (a fit, a flow).
class SimplificationHistory {
 public:
  bool empty() const { return steps_.size() <= 1; }
  std::size_t n_steps() const { return empty() ? 0 : steps_.size() - 1; }
  /// Steps done when each kept level was reached, from fine to coarse.
  const std::vector<std::size_t>& level_steps() const { return level_steps_; }

  // Recording.
  /// The corners of a face before and after a step.
  struct FaceChange {
    int face;
    int before[3], after[3];  ///< corners; −1 where the face does not exist
  };
  /// The place of a vertex before and after a step.
  struct VertexChange {
    int vertex;
    double before[3], after[3];
  };
  /// Begins at the input.
  void start(Points positions, Triangles triangles);
  void add(const FaceChange& change) { faces_.push_back(change); }
  void add(const VertexChange& change) { vertices_.push_back(change); }
  /// Ends the step that the changes since the last call make up; nothing happens when there are none.
  void end_step();
  void end_level() { level_steps_.push_back(n_steps()); }

  /// The mesh after some steps, replayed from either end. Numbers of vertices and faces are those of the
  /// input (split vertices at the end).
  class Replay {
   public:
    /// Starts at the input. @pre the history outlives the replay.
    explicit Replay(const SimplificationHistory& history);
    std::size_t step() const { return step_; }
    Eigen::Index n_faces() const { return n_faces_; }
    /// Goes to the mesh after `step` steps, forth or back, in time proportional to the steps between.
    /// @throws InvalidInput when there are fewer steps.
    void go_to(std::size_t step);
    /// Goes to the first step, from the fine end, with at most `faces` faces.
    void go_to_faces(Eigen::Index faces);
    /// The present mesh without unused vertices. @param vertices receives their numbers in the input.
    TriangleMesh mesh(std::vector<int>* vertices = nullptr) const;

   private:
    void redo();
    void undo();
    const SimplificationHistory& history_;
    Points positions_;
    Triangles triangles_;
    std::size_t step_ = 0;
    Eigen::Index n_faces_ = 0;
  };

 private:
  struct Step {
    std::size_t faces, vertices;  ///< where the changes of the next step begin
  };
  Points positions_;
  Triangles triangles_;
  std::vector<FaceChange> faces_;
  std::vector<VertexChange> vertices_;
  std::vector<Step> steps_;
  std::vector<std::size_t> level_steps_;
};

}  // namespace batten
