#pragma once
#include "strokes.hpp"

#include <functional>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/sketch/polyline_mesh.hpp"
#include "batten/sketch/tools.hpp"

// Models that tests of tools begin with, and what they hold the results against.
namespace batten::strokes {

inline EditReport insert(PolylineMesh& mesh, const DrawnStroke& stroke, const InsertOptions& options = {}) {
  return edit(mesh, [&](PolylineMesh& m) { return insert_curve(m, stroke, options); });
}

/// The message of a refusal; the model must be as it was.
inline std::string refusal(PolylineMesh& mesh, const std::function<EditReport(PolylineMesh&)>& tool) {
  const PolylineMesh before = mesh;
  try {
    edit(mesh, tool);
  } catch (const RefusedEdit& refused) {
    EXPECT_TRUE(mesh == before) << "a refused edit changed the model";
    EXPECT_FALSE(refused.reason().empty());
    EXPECT_FALSE(refused.remedy().empty());
    return refused.what();
  }
  return "not refused";
}

#define EXPECT_CONTAINS(text, part) EXPECT_NE(std::string(text).find(part), std::string::npos) << (text)

inline void expect_counts(const PolylineMesh& mesh, int vertices, int edges, int faces, int borders,
                          int genus) {
  EXPECT_EQ(mesh.broken_invariant(), "");
  const SketchCounts counts = mesh.counts();
  EXPECT_EQ(counts.vertices, vertices);
  EXPECT_EQ(counts.edges, edges);
  EXPECT_EQ(counts.faces, faces);
  EXPECT_EQ(counts.boundary_loops, borders);
  EXPECT_EQ(counts.genus, genus);
}

inline PolylineMesh disc() {
  PolylineMesh mesh;
  insert(mesh, circle(kO, kX, kY));
  return mesh;
}

/// Three great circles (H fig. 7.7).
inline PolylineMesh octahedral_sphere() {
  PolylineMesh mesh = disc();
  insert(mesh, circle(kO, kX, kZ));
  insert(mesh, circle(kO, kY, kZ));
  return mesh;
}

/// A tube of radius 1 along z.
inline PolylineMesh tube(int n_profiles = 2) {
  PolylineMesh mesh;
  std::vector<DrawnStroke> profiles;
  for (int k = 0; k < n_profiles; ++k) profiles.push_back(circle(k * kZ, kX, kY));
  const Eigen::Vector3d top = (n_profiles - 1) * kZ;
  edit(mesh, [&](PolylineMesh& m) {
    return skin_profiles(
        m, profiles,
        {DrawnStroke{polygon({kX, kX + top}), false}, DrawnStroke{polygon({-kX, top - kX}), false}});
  });
  return mesh;
}

}  // namespace batten::strokes
