// The patches of a curve network filled by CGAL: every polygon of an OFF file is triangulated as a hole
// ([liepa2003]), refined by itself, and all are faired together with the points of the curves held.
// usage: benchmark_cgal_fill PATCHES.off OUTPUT.ply
#include <array>
#include <fstream>
#include <iostream>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/fair.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/refine.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>

namespace {

using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;
namespace pmp = CGAL::Polygon_mesh_processing;

struct Patches {
  std::vector<Point> points;
  std::vector<std::vector<int>> loops;
};

Patches read(const std::string& path) {
  std::ifstream in(path);
  std::string word;
  std::size_t n_points = 0, n_loops = 0, n_edges = 0;
  in >> word >> n_points >> n_loops >> n_edges;
  Patches patches;
  patches.points.resize(n_points);
  for (Point& p : patches.points) in >> p;
  patches.loops.resize(n_loops);
  for (std::vector<int>& loop : patches.loops) {
    std::size_t size = 0;
    in >> size;
    loop.resize(size);
    for (int& v : loop) in >> v;
  }
  if (!in) throw std::runtime_error(path + " is no OFF file");
  return patches;
}

/// Triangles over one loop, with indices of vertices.
std::vector<std::array<int, 3>> triangulate(const Patches& patches, const std::vector<int>& loop) {
  if (std::set<int>(loop.begin(), loop.end()).size() != loop.size())
    throw std::runtime_error("a patch passes the same point twice");
  std::vector<Point> outline;
  for (const int v : loop) outline.push_back(patches.points[v]);
  std::vector<CGAL::Triple<int, int, int>> corners;
  pmp::triangulate_hole_polyline(outline, std::back_inserter(corners));
  if (corners.empty()) throw std::runtime_error("a patch cannot be triangulated");
  std::vector<std::array<int, 3>> triangles;
  for (const auto& t : corners) triangles.push_back({loop[t.first], loop[t.second], loop[t.third]});
  return triangles;
}

void fill(const std::string& input, const std::string& output) {
  const Patches patches = read(input);
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::size_t> first;  // of each patch
  for (const std::vector<int>& loop : patches.loops) {
    first.push_back(triangles.size());
    const auto of_patch = triangulate(patches, loop);
    triangles.insert(triangles.end(), of_patch.begin(), of_patch.end());
  }
  first.push_back(triangles.size());
  if (!pmp::is_polygon_soup_a_polygon_mesh(triangles))
    throw std::runtime_error("the patches do not fit together");

  Mesh mesh;
  std::vector<Mesh::Vertex_index> vertices;
  for (const Point& p : patches.points) vertices.push_back(mesh.add_vertex(p));
  std::vector<std::vector<Mesh::Face_index>> faces(patches.loops.size());
  for (std::size_t k = 0; k < faces.size(); ++k)
    for (std::size_t t = first[k]; t < first[k + 1]; ++t) {
      const auto& corner = triangles[t];
      faces[k].push_back(mesh.add_face(vertices[corner[0]], vertices[corner[1]], vertices[corner[2]]));
    }
  std::vector<Mesh::Vertex_index> inside;
  // Over the whole mesh long diagonals would count as edges that are wanted, and little be inserted.
  for (const auto& patch : faces) {
    std::vector<Mesh::Face_index> new_faces;
    pmp::refine(mesh, patch, std::back_inserter(new_faces), std::back_inserter(inside));
  }
  if (!pmp::fair(mesh, inside, pmp::parameters::fairing_continuity(2)))
    throw std::runtime_error("the linear system of the fairing cannot be solved");
  for (const Mesh::Vertex_index v : mesh.vertices())
    if (mesh.is_isolated(v)) mesh.remove_vertex(v);
  mesh.collect_garbage();

  std::ofstream out(output);
  out.precision(17);
  out << "ply\nformat ascii 1.0\nelement vertex " << mesh.number_of_vertices()
      << "\nproperty double x\nproperty double y\nproperty double z\nelement face " << mesh.number_of_faces()
      << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Mesh::Vertex_index v : mesh.vertices()) out << mesh.point(v) << '\n';
  for (const Mesh::Face_index f : mesh.faces()) {
    out << 3;
    for (const Mesh::Vertex_index v : mesh.vertices_around_face(mesh.halfedge(f)))
      out << ' ' << static_cast<std::size_t>(v);
    out << '\n';
  }
}

}  // namespace

int main(int n, char** words) {
  if (n != 3) {
    std::cerr << "usage: benchmark_cgal_fill PATCHES.off OUTPUT.ply\n";
    return 2;
  }
  try {
    fill(words[1], words[2]);
  } catch (const std::exception& problem) {
    std::cerr << problem.what() << '\n';
    return 1;
  }
}
