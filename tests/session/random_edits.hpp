#pragma once
#include "../sketch/strokes.hpp"
#include "one_model.hpp"

#include <Eigen/Geometry>

#include "batten/core/random.hpp"
#include "batten/session/document.hpp"

// Edits without a plan, for tests of properties.
namespace batten::strokes {

using test::on_model;

using Eigen::Vector3d;

/// A stroke between random places of the network, over random others, or somewhere in space.
inline DrawnStroke random_stroke(const PolylineMesh& mesh, Random& random) {
  const auto place = [&]() -> Vector3d {
    if (mesh.empty() || random.uniform() < 0.05) return 2 * random.normal3();
    for (int tries = 0; tries < 50; ++tries) {
      const SketchEdge& edge = mesh.edges()[random.below(mesh.edges().size())];
      if (edge.alive) return edge.polyline->at(edge.polyline->length() * random.uniform());
    }
    return random.normal3();
  };
  const double kind = random.uniform();
  if (mesh.empty() || kind < 0.12) {
    const Vector3d centre = mesh.empty() ? kO : Vector3d(3 * random.normal3());
    const Vector3d a = random.direction();
    return circle(centre, a, a.unitOrthogonal() * random.uniform(0.5, 1.5), 48);
  }
  if (kind < 0.3) {  // a closed stroke around a place
    const Vector3d a = random.uniform(0.1, 0.5) * random.direction();
    return circle(place(), a, a.norm() * a.unitOrthogonal(), 48);
  }
  const Vector3d from = place(), to = place();
  return {polygon({from, (from + to) / 2 + 0.1 * random.normal3(), to}, 12), false};
}

/// Any tool, undo or redo, with arguments that now and then suit the model.
inline Edit random_edit(const PolylineMesh& mesh, Random& random) {
  const double kind = random.uniform();
  const auto curve = [&]() {
    return static_cast<int>(random.below(static_cast<std::uint64_t>(mesh.n_curves()) + 1));
  };
  if (kind < 0.4 || mesh.empty())
    return on_model(
        InsertEdit{random_stroke(mesh, random), {.sharpness = random.uniform() < 0.3 ? 1.0 : 0.0}});
  if (kind < 0.55) return on_model(DeleteEdit{curve()});
  if (kind < 0.58) return on_model(SharpnessEdit{curve(), random.uniform(-0.1, 1.1), {}});
  if (kind < 0.62) {
    MirrorEdit mirror;
    mirror.curve = curve();
    return on_model(mirror);
  }
  if (kind < 0.72) {
    const SketchEdge& edge = mesh.edges()[random.below(mesh.edges().size())];
    const Vector3d middle = edge.alive ? edge.polyline->at(edge.polyline->length() / 2) : kO;
    const Vector3d a = random.uniform(0.05, 0.3) * random.direction();
    return on_model(HoleEdit{circle(middle + (random.uniform() < 0.5 ? 0.0 : 0.3) * random.normal3(), a,
                                    a.norm() * a.unitOrthogonal(), 32),
                             {}});
  }
  if (kind < 0.8) {  // between two borders, where there are two
    std::vector<const SketchEdge*> border;
    for (const SketchEdge& edge : mesh.edges())
      if (edge.alive && (edge.faces[0] < 0 || edge.faces[1] < 0)) border.push_back(&edge);
    GlueEdit glue;
    if (border.empty()) return UndoEdit{};
    const auto end = [&](const SketchEdge* edge) {
      return edge->polyline->at(edge->polyline->length() * random.uniform());
    };
    const SketchEdge *a = border[random.below(border.size())], *b = border[random.below(border.size())];
    glue.first = {polygon({end(a), end(b)}), false};
    glue.second = {polygon({end(a), end(b)}), false};
    return on_model(glue);
  }
  if (kind < 0.84) {
    const Vector3d axis = random.direction(), x = axis.unitOrthogonal(), y = axis.cross(x),
                   at = 4 * random.normal3();
    return on_model(SkinEdit{{circle(at, x, y, 40), circle(at + axis, x, y, 40)},
                             {DrawnStroke{polygon({at + x, at + x + axis}), false},
                              DrawnStroke{polygon({at - x, at - x + axis}), false}},
                             {}});
  }
  if (kind < 0.86) {
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    matrix.topLeftCorner<3, 3>() =
        Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal())
            .normalized()
            .toRotationMatrix();
    matrix(0, 3) = random.normal();
    if (random.uniform() < 0.5) matrix.col(0) *= -1;
    return on_model(TransformEdit{matrix});
  }
  if (kind < 0.95) return UndoEdit{};
  return RedoEdit{};
}

}  // namespace batten::strokes
