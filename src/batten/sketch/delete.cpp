#include <algorithm>

#include "batten/core/text.hpp"
#include "batten/sketch/tools_detail.hpp"

namespace batten {

namespace {

/// In how many pieces (arcs or single vertices) the outline of a face at the border meets the other faces.
int shared_pieces(const PolylineMesh& mesh, const std::vector<int>& sides) {
  int runs = 0;
  for (size_t k = 0; k < sides.size(); ++k) {
    const bool here = mesh.face_of(opposite_side(sides[k])) >= 0;
    const bool before = mesh.face_of(opposite_side(sides[(k + sides.size() - 1) % sides.size()])) >= 0;
    const bool touches = mesh.vertex(mesh.start_of(sides[k])).edges.size() > 2;
    if (here ? !before : !before && touches) ++runs;
  }
  return runs;
}

void sort_out(std::vector<int>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

/// Other curves that end on this one would be left hanging.
void refuse_hanging_curves(const PolylineMesh& mesh, int curve, const std::vector<int>& vertices) {
  for (const int v : vertices) {
    int others = 0, hanging = -1;
    for (const int e : mesh.vertex(v).edges)
      if (mesh.edge(e).curve != curve) {
        ++others;
        hanging = mesh.edge(e).curve;
      }
    if (others == 1)
      throw RefusedEdit(concat("c", hanging, " ends on c", curve, " at v", v),
                        concat("delete c", hanging, " first"));
  }
}

/// At the border a face goes with its border; what it leaves without a face goes too.
/// @param vertices receives those that lost an edge. @return the change of the Euler characteristic.
int remove_border_faces(PolylineMesh& mesh, const std::vector<int>& edges, std::vector<int>& vertices) {
  int euler_change = 0;
  for (const int e : edges) {
    if (!mesh.edge(e).alive) continue;
    const auto [left, right] = mesh.edge(e).faces;
    if (left >= 0 && right >= 0) continue;
    const int face = left >= 0 ? left : right;
    if (face < 0) continue;
    const std::vector<int> sides = mesh.face(face).sides;
    // χ(M) = χ(rest) + χ(disc) − χ(common arcs); a face that stands alone shares nothing, not even points.
    euler_change -= 1 - shared_pieces(mesh, sides);
    mesh.remove_face(face);
    for (const int side : sides) {
      const int bare = edge_of(side);
      if (mesh.edge(bare).faces[0] >= 0 || mesh.edge(bare).faces[1] >= 0) continue;
      const auto ends = mesh.edge(bare).vertices;
      mesh.remove_edge(bare);
      for (const int v : ends)
        if (mesh.vertex(v).edges.empty())
          mesh.remove_vertex(v);
        else
          vertices.push_back(v);
    }
  }
  return euler_change;
}

/// The two faces at an edge of the curve become one, and the run of edges between them goes.
void join_faces(PolylineMesh& mesh, int curve, int e) {
  const auto [left, right] = mesh.edge(e).faces;
  if (left == right)
    throw RefusedEdit(concat("without c", curve, " the face f", left, " would not be a disc any more"),
                      concat("keep c", curve, ", or delete other curves around f", left, " first"));
  const int kept = std::min(left, right), gone = std::max(left, right);
  // Rotate both walks so that the common run of this curve is at their ends.
  std::vector<int> a = mesh.face(kept).sides, b = mesh.face(gone).sides;
  const auto common = [&](int side) {
    const int other = mesh.face_of(opposite_side(side));
    return mesh.edge(edge_of(side)).curve == curve && (other == kept || other == gone);
  };
  const auto here = [&](int side) { return edge_of(side) == e; };
  const auto rotate_run_to_end = [&](std::vector<int>& walk) {
    std::rotate(walk.begin(), std::find_if(walk.begin(), walk.end(), here), walk.end());
    size_t length = 1, before = 0;
    while (length < walk.size() && common(walk[length])) ++length;
    while (before + length < walk.size() && common(walk[walk.size() - 1 - before])) ++before;
    std::rotate(walk.begin(), walk.begin() + static_cast<std::ptrdiff_t>(length), walk.end());
    return length + before;
  };
  const size_t run = rotate_run_to_end(a);
  rotate_run_to_end(b);
  if (run == a.size() || run == b.size())
    throw RefusedEdit(concat("c", curve, " is all there is around f", run == a.size() ? kept : gone),
                      "undo its insertion, or cut a hole instead");
  std::vector<int> gone_edges;
  for (size_t k = a.size() - run; k < a.size(); ++k) gone_edges.push_back(edge_of(a[k]));
  a.resize(a.size() - run);
  b.resize(b.size() - run);
  // a ends where the run begins in its sense, which is where b, walked on, starts.
  a.insert(a.end(), b.begin(), b.end());
  mesh.remove_face(kept);
  mesh.remove_face(gone);
  for (const int old : gone_edges) mesh.remove_edge(old);
  mesh.add_face(std::move(a));
}

/// Vertices that only this curve needed: without edges they go, on one smooth curve they are dissolved.
void remove_needless_vertices(PolylineMesh& mesh, const std::vector<int>& vertices) {
  std::vector<int> rest;
  for (const int v : vertices) {
    if (!mesh.vertex(v).alive) continue;
    if (mesh.vertex(v).edges.empty()) {
      mesh.remove_vertex(v);
      continue;
    }
    rest.push_back(v);
  }
  for (const int v : rest) {
    const SketchVertex& vertex = mesh.vertex(v);
    if (vertex.edges.size() != 2) continue;
    const SketchEdge &first = mesh.edge(vertex.edges[0]), &second = mesh.edge(vertex.edges[1]);
    if (first.curve != second.curve || first.sharpness != second.sharpness) continue;
    const Eigen::Vector3d d1 =
        first.vertices[0] == v ? first.polyline->direction_at_front() : first.polyline->direction_at_back();
    const Eigen::Vector3d d2 = second.vertices[0] == v ? second.polyline->direction_at_front()
                                                       : second.polyline->direction_at_back();
    constexpr double kStraight = -0.6;  // a corner of the curve (53°) stays a vertex
    if (d1.dot(d2) > kStraight) continue;
    if (!mesh.dissolve_vertex(v)) mesh.set_seam(v, true);
  }
}

}  // namespace

EditReport delete_curve(PolylineMesh& mesh, int curve) {
  detail::require_curve(mesh, curve);
  const std::vector<int> edges = mesh.edges_of_curve(curve);
  std::vector<int> vertices;
  for (const int e : edges)
    vertices.insert(vertices.end(), mesh.edge(e).vertices.begin(), mesh.edge(e).vertices.end());
  sort_out(vertices);
  refuse_hanging_curves(mesh, curve, vertices);
  EditReport report;
  report.euler_change = remove_border_faces(mesh, edges, vertices);
  sort_out(vertices);
  for (const int e : edges)
    if (mesh.edge(e).alive) join_faces(mesh, curve, e);
  remove_needless_vertices(mesh, vertices);
  if (const std::string problem = mesh.broken_by_edit(); !problem.empty())
    throw RefusedEdit(concat("without c", curve, " the model would fall apart: ", problem),
                      concat("delete the curves that meet c", curve, " first"));
  return report;
}

}  // namespace batten
