#include <algorithm>
#include <limits>

#include "batten/core/index.hpp"
#include "batten/modelling/surface_records_detail.hpp"

namespace batten::detail {

using Eigen::Vector3d;

FaceSet SurfaceRecords::set_of(const std::vector<int>& seeds, const PolylineMesh& mesh) const {
  FaceSet set;
  set.has.assign(faces.size(), 0);
  for (const int f : seeds) include(set, f, mesh);
  std::sort(set.list.begin(), set.list.end());
  return set;
}

void SurfaceRecords::include(FaceSet& set, int face, const PolylineMesh& mesh) const {
  if (set.has[at(face)]) return;
  set.has[at(face)] = 1;
  std::vector<int> stack{face};
  while (!stack.empty()) {
    const int f = stack.back();
    stack.pop_back();
    set.list.push_back(f);
    for (const int side : mesh.face(f).sides) {
      if (holds(edges[at(edge_of(side))])) continue;
      const int next = mesh.face_of(opposite_side(side));
      if (next < 0 || set.has[at(next)]) continue;
      set.has[at(next)] = 1;
      stack.push_back(next);
    }
  }
}

bool SurfaceRecords::grow(FaceSet& set, const PolylineMesh& mesh) const {
  const std::vector<int> before = set.list;
  for (const int f : before)
    for (const int side : mesh.face(f).sides)
      for (const int e : mesh.vertex(mesh.start_of(side)).edges)
        for (const int next : mesh.edge(e).faces)
          if (next >= 0) include(set, next, mesh);
  std::sort(set.list.begin(), set.list.end());
  return set.list.size() > before.size();
}

void SurfaceRecords::close_fans(FaceSet& set, const PolylineMesh& mesh) const {
  for (bool added = true; added;) {
    added = false;
    const std::vector<int> before = set.list;
    for (const int f : before)
      for (const int side : mesh.face(f).sides) {
        int sides_in = 0, inner = 0;
        bool all = true;
        const SketchVertex& vertex = mesh.vertex(mesh.start_of(side));
        for (const int e : vertex.edges) {
          int in = 0;
          for (const int next : mesh.edge(e).faces) {
            if (next < 0) continue;
            if (set.has[at(next)])
              ++in;
            else
              all = false;
          }
          sides_in += in;
          inner += in == 2;
        }
        // Every face has two edges at the vertex, so there are sides_in / 2 faces, joined at `inner` edges.
        if (all || sides_in / 2 - inner <= 1) continue;
        for (const int e : vertex.edges)
          for (const int next : mesh.edge(e).faces)
            if (next >= 0 && !set.has[at(next)]) {
              include(set, next, mesh);
              added = true;
            }
      }
  }
  std::sort(set.list.begin(), set.list.end());
}

FaceSet SurfaceRecords::near_to(const FaceSet& region) {
  Box all{Vector3d::Constant(std::numeric_limits<double>::infinity()),
          Vector3d::Constant(-std::numeric_limits<double>::infinity())};
  const Box nothing = all;
  for (const int f : region.list) {
    Box& box = faces[at(f)].box;
    box = nothing;
    for (const std::array<int, 4>& quad : faces[at(f)].quads)
      for (const int v : quad) box.include({positions[at(v)], positions[at(v)]});
    all.include(box);
  }
  FaceSet near;
  near.has.assign(faces.size(), 0);
  for (size_t f = 0; f < faces.size(); ++f) {
    if (!faces[f].alive || (!region.has[f] && !all.meets(faces[f].box))) continue;
    near.has[f] = region.has[f] || std::any_of(region.list.begin(), region.list.end(),
                                               [&](int g) { return faces[at(g)].box.meets(faces[f].box); });
    if (near.has[f]) near.list.push_back(static_cast<int>(f));
  }
  return near;
}

bool SurfaceRecords::is_finite(const FaceSet& region) const {
  for (const int f : region.list)
    for (const std::array<int, 4>& quad : faces[at(f)].quads)
      for (const int v : quad)
        if (!positions[at(v)].allFinite()) return false;
  return true;
}

}  // namespace batten::detail
