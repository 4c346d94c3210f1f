#include "batten/simplification/history.hpp"

#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten {

void SimplificationHistory::start(Points positions, Triangles triangles) {
  *this = {};
  positions_ = std::move(positions);
  triangles_ = std::move(triangles);
  steps_.push_back({0, 0});
}

void SimplificationHistory::end_step() {
  if (faces_.size() == steps_.back().faces && vertices_.size() == steps_.back().vertices) return;
  steps_.push_back({faces_.size(), vertices_.size()});
}

SimplificationHistory::Replay::Replay(const SimplificationHistory& history)
    : history_(history),
      positions_(history.positions_),
      triangles_(history.triangles_),
      n_faces_(history.triangles_.rows()) {}

void SimplificationHistory::Replay::redo() {
  const Step &from = history_.steps_[step_], &to = history_.steps_[step_ + 1];
  for (std::size_t i = from.faces; i < to.faces; ++i) {
    const FaceChange& change = history_.faces_[i];
    n_faces_ += (change.after[0] >= 0 ? 1 : 0) - (change.before[0] >= 0 ? 1 : 0);
    for (int k = 0; k < 3; ++k) triangles_(change.face, k) = change.after[k];
  }
  for (std::size_t i = from.vertices; i < to.vertices; ++i) {
    const VertexChange& change = history_.vertices_[i];
    for (int k = 0; k < 3; ++k) positions_(change.vertex, k) = change.after[k];
  }
  ++step_;
}

void SimplificationHistory::Replay::undo() {
  --step_;
  const Step &from = history_.steps_[step_], &to = history_.steps_[step_ + 1];
  for (std::size_t i = to.faces; i-- > from.faces;) {
    const FaceChange& change = history_.faces_[i];
    n_faces_ += (change.before[0] >= 0 ? 1 : 0) - (change.after[0] >= 0 ? 1 : 0);
    for (int k = 0; k < 3; ++k) triangles_(change.face, k) = change.before[k];
  }
  for (std::size_t i = to.vertices; i-- > from.vertices;) {
    const VertexChange& change = history_.vertices_[i];
    for (int k = 0; k < 3; ++k) positions_(change.vertex, k) = change.before[k];
  }
}

void SimplificationHistory::Replay::go_to(std::size_t step) {
  if (step > history_.n_steps())
    throw InvalidInput(concat("the history has ", history_.n_steps(), " steps, asked for step ", step));
  while (step_ < step) redo();
  while (step_ > step) undo();
}

void SimplificationHistory::Replay::go_to_faces(Eigen::Index faces) {
  while (step_ < history_.n_steps() && n_faces_ > faces) redo();
  while (step_ > 0) {
    undo();
    if (n_faces_ > faces) {
      redo();
      return;
    }
  }
}

TriangleMesh SimplificationHistory::Replay::mesh(std::vector<int>* vertices) const {
  std::vector<int> index(positions_.rows(), -1);
  for (Eigen::Index f = 0; f < triangles_.rows(); ++f)
    if (triangles_(f, 0) >= 0)
      for (int k = 0; k < 3; ++k) index[triangles_(f, k)] = 0;
  std::vector<int> used;
  for (std::size_t v = 0; v < index.size(); ++v)
    if (index[v] == 0) {
      index[v] = static_cast<int>(used.size());
      used.push_back(static_cast<int>(v));
    }
  TriangleMesh mesh;
  mesh.positions.resize(static_cast<Eigen::Index>(used.size()), 3);
  for (std::size_t v = 0; v < used.size(); ++v)
    mesh.positions.row(static_cast<Eigen::Index>(v)) = positions_.row(used[v]);
  mesh.triangles.resize(n_faces_, 3);
  Eigen::Index row = 0;
  for (Eigen::Index f = 0; f < triangles_.rows(); ++f) {
    if (triangles_(f, 0) < 0) continue;
    for (int k = 0; k < 3; ++k) mesh.triangles(row, k) = index[triangles_(f, k)];
    ++row;
  }
  if (vertices != nullptr) *vertices = std::move(used);
  return mesh;
}

}  // namespace batten
