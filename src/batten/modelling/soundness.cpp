#include "batten/modelling/soundness.hpp"

#include <algorithm>
#include <set>

#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/mesh/self_intersections.hpp"

namespace batten {

std::string SurfaceSoundness::sentence() const {
  std::string names;
  for (const int face : broken_faces) names += concat(names.empty() ? "f" : ", f", face);
  return concat("the finished surface is not sound in ", names, ": ",
                crossing_pairs == kMostCrossingPairs ? "at least " : "", crossing_pairs,
                " pairs of triangles cross and ", turned_triangles,
                " are turned over; divide these faces by another curve, or make curves sharp along which the "
                "surface is to turn");
}

SurfaceSoundness surface_soundness(const TriangleMesh& mesh, const std::vector<int>& turned,
                                   const std::vector<int>& face_of_triangle) {
  const auto crossing = self_intersections(mesh.positions, mesh.triangles, kMostCrossingPairs);
  std::set<int> faces;
  const auto note = [&](int triangle) { faces.insert(face_of_triangle[at(triangle)]); };
  for (const auto& [one, other] : crossing) note(one), note(other);
  for (const int triangle : turned) note(triangle);
  return {crossing.size(), turned.size(), {faces.begin(), faces.end()}};
}

std::vector<int> turned_triangles(const TriangleMesh& mesh, const std::vector<char>& on_crease) {
  Points normals = mesh.normals;
  for (size_t v = 0; v < on_crease.size(); ++v)
    if (on_crease[v]) normals.row(static_cast<Eigen::Index>(v)).setZero();
  std::vector<int> turned = folded_triangles(mesh.positions, mesh.triangles, normals);
  const auto all_on_crease = [&](int t) {
    const auto on = [&](int k) { return on_crease[at(mesh.triangles(t, k))] != 0; };
    return on(0) && on(1) && on(2);
  };
  turned.erase(std::remove_if(turned.begin(), turned.end(), all_on_crease), turned.end());
  return turned;
}

}  // namespace batten
