#include "batten/pipeline/surface_flaws.hpp"

#include <algorithm>
#include <set>

#include <Eigen/Dense>

#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/pipeline/mesh_input.hpp"

namespace batten {

namespace {

using Eigen::Index;
using Eigen::RowVector3d;

/// Places and patches named in one flaw; more are counted.
constexpr std::size_t kMostNamed = 5;
/// Where a patch has collapsed: this share of its area at more than 60° (cosine ½) to its normals.
constexpr double kCollapsedShare = 0.1;
constexpr double kCollapsedCosine = 0.5;

std::string in_patches(const std::set<int>& patches) {
  std::string names = patches.size() == 1 ? "in patch " : "in patches ";
  std::size_t named = 0;
  for (const int p : patches) {
    if (named == 2 * kMostNamed) return names + ", …";
    names += concat(named++ == 0 ? "" : ", ", p);
  }
  return names;
}

/// "at (x, y, z), (x, y, z), …" of the first triangles of a list.
std::string at_places(const TriangleMesh& mesh, const std::vector<int>& triangles) {
  std::string places = "at ";
  for (std::size_t k = 0; k < std::min(kMostNamed, triangles.size()); ++k)
    places += concat(k == 0 ? "" : ", ", place_in_words(mesh, triangles[k]));
  return triangles.size() > kMostNamed ? places + ", …" : places;
}

struct PatchShape {
  double area = 0, astray = 0, farthest = 0;
  int worst = -1;  ///< triangle of the patch that stands most against its normals
  Index farthest_vertex = -1;
  Eigen::AlignedBox3d curves;
};

/// Area, area across the normals, and the box of the curves of every patch.
std::vector<PatchShape> shapes_of(const TriangleMesh& mesh, const FilledPatches& patches) {
  int n_patches = 0;
  for (const int p : patches.patch_of_triangle) n_patches = std::max(n_patches, p + 1);
  std::vector<PatchShape> shapes(at(n_patches));
  std::vector<double> least(shapes.size(), 2);
  for (Index f = 0; f < mesh.n_triangles(); ++f) {
    const auto p = at(patches.patch_of_triangle[at(f)]);
    PatchShape& shape = shapes[p];
    RowVector3d normal = RowVector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      const int v = mesh.triangles(f, k);
      if (patches.on_network[at(v)])
        shape.curves.extend(mesh.positions.row(v).transpose());
      else
        normal += mesh.normals.row(v);
    }
    const RowVector3d a = mesh.positions.row(mesh.triangles(f, 0)),
                      b = mesh.positions.row(mesh.triangles(f, 1)),
                      c = mesh.positions.row(mesh.triangles(f, 2));
    const RowVector3d cross = (b - a).cross(c - a);
    const double size = cross.norm(), length = normal.norm();
    if (!(length > 0) || !(size > 0)) continue;
    const double cosine = cross.dot(normal) / (size * length);
    shape.area += size;
    if (cosine < kCollapsedCosine) shape.astray += size;
    if (cosine < least[p]) {
      least[p] = cosine;
      shape.worst = static_cast<int>(f);
    }
  }
  return shapes;
}

}  // namespace

std::vector<std::string> surface_flaws(const TriangleMesh& mesh, const FilledPatches& patches) {
  std::vector<std::string> flaws;
  if (const auto& pairs = patches.crossing_pairs; !pairs.empty()) {
    std::set<int> where;
    std::vector<int> first;
    for (const auto& [f, g] : pairs) {
      where.insert({patches.patch_of_triangle[at(f)], patches.patch_of_triangle[at(g)]});
      if (first.empty() || first.back() != f) first.push_back(f);  // one triangle may cross several
    }
    flaws.push_back(concat(pairs.size() >= kMostListedIntersections ? "at least " : "", pairs.size(),
                           pairs.size() == 1 ? " pair of triangles crosses " : " pairs of triangles cross ",
                           in_patches(where), ", ", at_places(mesh, first)));
  }
  if (const auto& folded = patches.folded; !folded.empty()) {
    std::set<int> where;
    for (const int f : folded) where.insert(patches.patch_of_triangle[at(f)]);
    flaws.push_back(concat(folded.size(), folded.size() == 1 ? " triangle is" : " triangles are",
                           " turned away from the normals of the curves ", in_patches(where), ", ",
                           at_places(mesh, folded)));
  }
  std::vector<PatchShape> shapes = shapes_of(mesh, patches);
  for (Index f = 0; f < mesh.n_triangles(); ++f) {
    PatchShape& shape = shapes[at(patches.patch_of_triangle[at(f)])];
    if (shape.curves.isEmpty()) continue;
    for (int k = 0; k < 3; ++k) {
      const Index v = mesh.triangles(f, k);
      const double distance = shape.curves.exteriorDistance(mesh.positions.row(v).transpose());
      if (distance <= shape.farthest) continue;
      shape.farthest = distance;
      shape.farthest_vertex = v;
    }
  }
  std::set<int> collapsed;
  std::vector<int> places;
  for (std::size_t p = 0; p < shapes.size(); ++p) {
    const PatchShape& shape = shapes[p];
    if (shape.astray > kCollapsedShare * shape.area) {
      collapsed.insert(static_cast<int>(p));
      places.push_back(shape.worst);
    }
    if (shape.farthest > shape.curves.diagonal().norm())
      flaws.push_back(concat("patch ", p, " leaves its curves by ", shape.farthest, " at ",
                             place_in_words(mesh.positions.row(shape.farthest_vertex))));
  }
  if (!collapsed.empty())
    flaws.push_back(concat("the surface has collapsed, across the normals of its curves, ",
                           in_patches(collapsed), ", ", at_places(mesh, places)));
  return flaws;
}

}  // namespace batten
