#include "batten/sketch/polyline_mesh.hpp"

#include <memory>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

SharedPolyline arch(const PolylineMesh& mesh, int from, int to, double height) {
  Points points(3, 3);
  points.row(0) = mesh.vertex(from).position.transpose();
  points.row(2) = mesh.vertex(to).position.transpose();
  points.row(1) = (points.row(0) + points.row(2)) / 2 + Eigen::RowVector3d(0, height, 0);
  return std::make_shared<Polyline>(points);
}

/// A face between two arches over one chord.
struct Lens {
  PolylineMesh mesh;
  PolylineMesh::Change change;
  int face = -1, edge = -1;

  Lens() {
    mesh.begin();
    const int a = mesh.add_vertex({0, 0, 0}), b = mesh.add_vertex({2, 0, 0});
    const int curve = mesh.add_curve();
    edge = mesh.add_edge(a, b, arch(mesh, a, b, -1), curve, 0, true);
    const int back = mesh.add_edge(b, a, arch(mesh, b, a, 1), mesh.add_curve(), 0, true);
    face = mesh.add_face({side_of(edge, false), side_of(back, false)});
    change = mesh.commit();
  }
};

// A disc: V − E + F = 2 − 2 + 1.
TEST(PolylineMesh, CountsALensAsADisc) {
  const Lens lens;
  EXPECT_EQ(lens.mesh.broken_invariant(), "");
  const SketchCounts counts = lens.mesh.counts();
  EXPECT_EQ(counts.euler_characteristic(), 1);
  EXPECT_EQ(counts.components, 1);
  EXPECT_EQ(counts.boundary_loops, 1);
  EXPECT_EQ(counts.genus, 0);
  EXPECT_EQ(counts.curves, 2);
}

TEST(PolylineMesh, RefusesEveryChangeOutsideAnEditAndStaysAsItWas) {
  Lens lens;
  const PolylineMesh before = lens.mesh;
  PolylineMesh& mesh = lens.mesh;
  EXPECT_THROW(mesh.add_curve(), InvalidInput);
  EXPECT_THROW(mesh.add_vertex({1, 1, 1}), InvalidInput);
  EXPECT_THROW(mesh.add_edge(0, 1, mesh.edge(0).polyline, 0, 0, true), InvalidInput);
  EXPECT_THROW(mesh.add_face({0, 1}), InvalidInput);
  EXPECT_THROW(mesh.remove_face(lens.face), InvalidInput);
  EXPECT_THROW(mesh.remove_edge(lens.edge), InvalidInput);
  EXPECT_THROW(mesh.remove_vertex(0), InvalidInput);
  EXPECT_THROW(mesh.split_edge(lens.edge, 0.5, {0.5, -0.5, 0}), InvalidInput);
  EXPECT_THROW(mesh.set_sharpness(lens.edge, 1), InvalidInput);
  EXPECT_THROW(mesh.set_seam(0, true), InvalidInput);
  EXPECT_THROW(mesh.move_everything(Eigen::Matrix4d::Identity()), InvalidInput);
  EXPECT_THROW(mesh.flip_component(lens.face), InvalidInput);
  EXPECT_THROW(mesh.commit(), InvalidInput);
  EXPECT_THROW(mesh.roll_back(), InvalidInput);
  EXPECT_EQ(mesh, before);
  EXPECT_EQ(mesh.broken_invariant(), "");
}

TEST(PolylineMesh, RefusesToBeginUndoOrRedoWithinAnEdit) {
  Lens lens;
  lens.mesh.begin();
  lens.mesh.set_sharpness(lens.edge, 1);
  EXPECT_THROW(lens.mesh.begin(), InvalidInput);
  EXPECT_THROW(lens.mesh.undo(lens.change), InvalidInput);
  EXPECT_THROW(lens.mesh.redo(lens.change), InvalidInput);
  const PolylineMesh::Change sharpened = lens.mesh.commit();
  EXPECT_EQ(sharpened.edges.before.size(), 1U);
  EXPECT_EQ(lens.mesh.edge(lens.edge).sharpness, 1);
}

TEST(PolylineMesh, UndoAndRedoAndRollBackRestoreBitForBit) {
  Lens lens;
  const PolylineMesh before = lens.mesh;
  lens.mesh.begin();
  lens.mesh.split_edge(lens.edge, 0.25, lens.mesh.edge(lens.edge).polyline->at(0.25));
  lens.mesh.roll_back();
  EXPECT_EQ(lens.mesh, before);
  lens.mesh.begin();
  lens.mesh.split_edge(lens.edge, 0.25, lens.mesh.edge(lens.edge).polyline->at(0.25));
  const PolylineMesh::Change split = lens.mesh.commit();
  const PolylineMesh after = lens.mesh;
  EXPECT_NE(after.counts(), before.counts());
  lens.mesh.undo(split);
  EXPECT_EQ(lens.mesh, before);
  lens.mesh.redo(split);
  EXPECT_EQ(lens.mesh, after);
  lens.mesh.undo(split);
  lens.mesh.undo(lens.change);
  EXPECT_TRUE(lens.mesh.empty());
}

}  // namespace
}  // namespace batten
