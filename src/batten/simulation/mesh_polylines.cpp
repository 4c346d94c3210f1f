#include <algorithm>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/simulation/mesh_polylines_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Vector3d;

MeshEdge edge_of(int a, int b) {
  return {std::min(a, b), std::max(a, b)};
}

/// Follows the zeros of a height over the mesh from face to face.
class Slicer {
 public:
  Slicer(const TriangleMesh& mesh, const Points& normals, const MeshEdgeFaces& faces, int axis, double offset)
      : mesh_(mesh),
        normals_(normals),
        faces_(faces),
        axis_(axis),
        offset_(offset),
        height_(mesh.positions.col(axis).array() - offset) {}

  std::vector<MeshPolyline> slice() const {
    std::vector<char> visited(static_cast<size_t>(mesh_.n_triangles()), 0);
    std::vector<MeshPolyline> lines;
    for (int f = 0; f < static_cast<int>(mesh_.n_triangles()); ++f) {
      MeshEdge in;
      MeshEdge out;
      if (visited[static_cast<size_t>(f)] == 0 && cut_edges(f, in, out))
        lines.push_back(follow(start_of(f, in), visited));
    }
    return lines;
  }

 private:
  /// Where a section begins: the face, and the edge by which it is entered.
  struct Start {
    int face;
    MeshEdge entry;
    bool closed;
  };

  /// Back from a face against the direction in which it is entered, to a border or once around.
  Start start_of(int first, const MeshEdge& in) const {
    int face = first;
    MeshEdge entry = in;
    while (true) {
      const int before = faces_.across(entry, face);
      if (before < 0) return {face, entry, false};
      entry = other_edge(before, entry);
      face = before;
      if (face == first) return {first, in, true};
    }
  }

  MeshPolyline follow(const Start& start, std::vector<char>& visited) const {
    MeshPolyline line;
    line.axis = axis_;
    line.offset = offset_;
    line.closed = start.closed;
    int face = start.face;
    MeshEdge entry = start.entry;
    add_point(line, entry);
    while (true) {
      visited[static_cast<size_t>(face)] = 1;
      line.faces.push_back(face);
      const MeshEdge exit = other_edge(face, entry);
      const int beyond = faces_.across(exit, face);
      if (beyond == start.face && line.closed) break;
      add_point(line, exit);
      if (beyond < 0) break;
      face = beyond;
      entry = exit;
    }
    return line;
  }

  /// Of the two edges of a face that the plane cuts, the one that is not `edge`.
  MeshEdge other_edge(int face, const MeshEdge& edge) const {
    MeshEdge a;
    MeshEdge b;
    cut_edges(face, a, b);
    return a == edge ? b : a;
  }

  /// The two edges of a face that the plane cuts. False when it misses the face.
  bool cut_edges(int face, MeshEdge& first, MeshEdge& second) const {
    int found = 0;
    for (int k = 0; k < 3; ++k) {
      const int a = mesh_.triangles(face, k);
      const int b = mesh_.triangles(face, (k + 1) % 3);
      if ((height_[a] < 0) == (height_[b] < 0)) continue;
      (found == 0 ? first : second) = edge_of(a, b);
      ++found;
    }
    return found == 2;
  }

  void add_point(MeshPolyline& line, const MeshEdge& edge) const {
    const double w = height_[edge.first] / (height_[edge.first] - height_[edge.second]);
    line.points.emplace_back((1 - w) * mesh_.positions.row(edge.first) +
                             w * mesh_.positions.row(edge.second));
    line.normals.emplace_back(
        ((1 - w) * normals_.row(edge.first) + w * normals_.row(edge.second)).normalized());
    line.edges.push_back(edge);
  }

  const TriangleMesh& mesh_;
  const Points& normals_;
  const MeshEdgeFaces& faces_;
  int axis_;
  double offset_;
  Eigen::VectorXd height_;  // of the vertices over the plane
};

}  // namespace

MeshEdgeFaces::MeshEdgeFaces(const TriangleMesh& mesh) {
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.triangles(f, k);
      const int b = mesh.triangles(f, (k + 1) % 3);
      if (a < 0 || a >= mesh.n_vertices() || a == b)
        throw InvalidInput(concat("face ", f + 1, " of the mesh is broken; repair the mesh"));
      auto& sides = faces_[edge_of(a, b)];
      const int side = a < b ? 0 : 1;
      if (sides[static_cast<size_t>(side)] >= 0)
        throw InvalidInput(concat("faces ", sides[static_cast<size_t>(side)] + 1, " and ", f + 1,
                                  " of the mesh run the same way along one edge: the mesh is no oriented "
                                  "manifold; batten repair IN -o OUT makes it one"));
      sides[static_cast<size_t>(side)] = static_cast<int>(f);
    }
}

int MeshEdgeFaces::across(const MeshEdge& edge, int face) const {
  const auto& sides = faces_.at(edge);
  return sides[0] == face ? sides[1] : sides[0];
}

std::vector<std::vector<int>> MeshEdgeFaces::border_loops() const {
  std::multimap<int, int> next;
  for (const auto& [edge, sides] : faces_) {
    if (sides[0] >= 0 && sides[1] < 0) next.emplace(edge.first, edge.second);
    if (sides[1] >= 0 && sides[0] < 0) next.emplace(edge.second, edge.first);
  }
  std::vector<std::vector<int>> loops;
  while (!next.empty()) {
    std::vector<int> loop;
    const int start = next.begin()->first;
    int v = start;
    while (true) {
      const auto step = next.find(v);
      if (step == next.end()) break;
      loop.push_back(v);
      v = step->second;
      next.erase(step);
      if (v == start) break;
    }
    if (v == start && loop.size() >= 3) loops.push_back(std::move(loop));
  }
  return loops;
}

std::vector<MeshPolyline> border_polylines(const TriangleMesh& mesh, const Points& normals,
                                           const MeshEdgeFaces& faces) {
  const std::vector<std::vector<int>> loops = faces.border_loops();
  std::vector<MeshPolyline> lines;
  for (size_t b = 0; b < loops.size(); ++b) {
    MeshPolyline line;
    line.name = loops.size() == 1 ? std::string("border") : concat("border ", b + 1);
    line.boundary = line.closed = true;
    for (size_t k = 0; k < loops[b].size(); ++k) {
      const int v = loops[b][k];
      line.points.emplace_back(mesh.positions.row(v));
      line.normals.emplace_back(normals.row(v));
      line.edges.push_back(edge_of(v, loops[b][(k + 1) % loops[b].size()]));
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

std::vector<MeshPolyline> plane_sections(const TriangleMesh& mesh, const Points& normals,
                                         const MeshEdgeFaces& faces, int axis, double offset) {
  return Slicer(mesh, normals, faces, axis, offset).slice();
}

double clear_offset(const Eigen::VectorXd& coordinates, double wanted, double size) {
  const double clearance = 1e-9 * size;
  double offset = wanted;
  for (int attempt = 1; attempt < 1000; ++attempt) {
    if ((coordinates.array() - offset).abs().minCoeff() > clearance) return offset;
    offset = wanted + 1e-6 * size * attempt;
  }
  return offset;
}

}  // namespace batten::detail
