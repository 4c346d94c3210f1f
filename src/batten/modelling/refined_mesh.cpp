#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/modelling/face_split_detail.hpp"
#include "batten/modelling/refined_mesh_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Share of the size by which drawn curves may move. With fidelity 0, the default, they do not move at all;
/// with 1 they move by per mille.
constexpr double kFarthestFromCurves = 0.05;

}  // namespace

Triangles cut_quads(const PolygonMesh& mesh) {
  Triangles triangles(2 * mesh.n_faces(), 3);
  for (Index f = 0; f < mesh.n_faces(); ++f) {
    const int* c = &mesh.corners[at(mesh.offsets[static_cast<size_t>(f)])];
    const auto both = cut_along_corners({c[0], c[1], c[2], c[3]});
    for (size_t k = 0; k < 2; ++k)
      triangles.row(2 * f + static_cast<Index>(k)) << both[k][0], both[k][1], both[k][2];
  }
  return triangles;
}

double crease_sharpness(double drawn) {
  return drawn >= 1 ? kInfinitelySharp : 4 * drawn;
}

// The flow has no bound on what the curves ask of it: what comes out folded is refused.
void require_sound(const PolygonMesh& mesh, const std::vector<int>& face_of_quad,
                   const std::vector<char>& on_curve, const Points& start) {
  const Points& positions = mesh.positions;
  const auto face_of = [&](int triangle) { return face_of_quad[at(triangle) / 2]; };
  for (size_t c = 0; c < mesh.corners.size(); ++c)
    if (!positions.row(mesh.corners[c]).allFinite())
      throw InvalidInput(concat("the surface leaves the finite numbers in the face f", face_of_quad[c / 4],
                                "; divide it by another curve, or draw its curves farther apart"));
  const auto crossing = self_intersections(positions, cut_quads(mesh), 1);
  if (!crossing.empty()) {
    const int first = face_of(crossing[0].first), second = face_of(crossing[0].second);
    throw InvalidInput(
        first == second
            ? concat("the surface folds or crosses itself in the face f", first,
                     "; divide it by another curve, best where it is not convex or is long and thin")
            : concat("the surface folds or crosses itself in the faces f", first, " and f", second,
                     "; divide them by another curve, best where they are not convex or are long and thin"));
  }
  const double size = bounding_box_diagonal(start);
  for (Index v = 0; v < positions.rows(); ++v)
    if (on_curve[static_cast<size_t>(v)] &&
        !((positions.row(v) - start.row(v)).norm() <= kFarthestFromCurves * size))
      throw InvalidInput(
          concat("the surface leaves its curves by more than ", 100 * kFarthestFromCurves,
                 " % of the size; divide the faces by another curve, best where they are not convex"));
}

void turn_outwards(const PolylineMesh& model, PolygonMesh& mesh, const std::vector<int>& face_of_quad) {
  std::vector<int> component(model.faces().size(), -1);
  std::vector<char> is_open;
  for (size_t f = 0; f < model.faces().size(); ++f) {
    if (!model.faces()[f].alive || component[f] >= 0) continue;
    const int own = static_cast<int>(is_open.size());
    is_open.push_back(0);
    std::vector<int> stack{static_cast<int>(f)};
    component[f] = own;
    while (!stack.empty()) {
      const int face = stack.back();
      stack.pop_back();
      for (const int side : model.face(face).sides) {
        const int next = model.face_of(opposite_side(side));
        if (next < 0) is_open.back() = 1;
        if (next < 0 || component[at(next)] >= 0) continue;
        component[at(next)] = own;
        stack.push_back(next);
      }
    }
  }
  std::vector<double> volume(is_open.size(), 0);
  const auto quad = [&](Index f) { return &mesh.corners[at(mesh.offsets[static_cast<size_t>(f)])]; };
  for (Index f = 0; f < mesh.n_faces(); ++f) {
    const int* c = quad(f);
    const auto p = [&](int k) -> Vector3d { return mesh.positions.row(c[k]); };
    const int own = component[at(face_of_quad[static_cast<size_t>(f)])];
    volume[at(own)] += p(0).cross(p(1)).dot(p(2)) + p(0).cross(p(2)).dot(p(3));
  }
  for (Index f = 0; f < mesh.n_faces(); ++f) {
    const int own = component[at(face_of_quad[static_cast<size_t>(f)])];
    if (is_open[at(own)] || volume[at(own)] >= 0) continue;
    int* c = quad(f);
    std::swap(c[1], c[3]);
  }
}

}  // namespace batten::detail
