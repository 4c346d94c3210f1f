#include "batten/deformation/multiresolution.hpp"

#include "deformation/tube.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

using fixtures::bent;
using fixtures::bumpy_tube;
using fixtures::flipped_faces;
using fixtures::mean_normal_angle_deg;
using fixtures::rows_of;
using fixtures::Tube;
using fixtures::twisted;

MultiresolutionOptions small_base() {
  MultiresolutionOptions options;
  options.base_vertices = 800;
  return options;
}

// Handles that stay leave the base, and with it everything, at rest. The base is found again as iterations
// end: within their tolerance and that of the vectors in face normals.
TEST(MultiresolutionDeformer, LeavesTheShapeWhereItIsWhenHandlesStay) {
  const Tube tube = bumpy_tube(48, 5, 0.08, 0.15);
  const MultiresolutionDeformer deformer(tube.positions, tube.triangles, tube.ends, small_base());
  // Faces are what is counted; an open surface has half its border edges more vertices than half of them.
  EXPECT_EQ(deformer.base().n_triangles(), 1600);
  const Points result = deformer.deform(rows_of(tube.positions, tube.ends)).positions;
  EXPECT_LT((result - tube.positions).rowwise().norm().maxCoeff(), 2e-2);
}

// A rigid motion of all handles: the base moves rigidly, and frames of the base carry the detail along
// exactly.
TEST(MultiresolutionDeformer, FollowsARigidMotion) {
  const Tube tube = bumpy_tube(48, 5, 0.08, 0.15);
  const Eigen::Matrix3d R = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const Points expected = (tube.positions * R.transpose()).rowwise() + Eigen::RowVector3d(1, -2, 3);
  MultiresolutionOptions options = small_base();
  options.deform.energy = DeformationEnergy::Stretch;
  options.deform.detail = DetailPreservation::ShapeMatching;
  options.deform.max_iterations = 2000;
  options.deform.tolerance = 1e-9;
  const MultiresolutionDeformer deformer(tube.positions, tube.triangles, tube.ends, options);
  const Points result = deformer.deform(rows_of(expected, tube.ends)).positions;
  EXPECT_LT((result - expected).rowwise().norm().maxCoeff(), 1e-4);
}

// The acceptance of one resolution, in two: the same bumps on the tube twisted and bent by formula. Handles
// are met exactly.
TEST(MultiresolutionDeformer, KeepsBumpsUnderTwistAndBend) {
  const Tube tube = bumpy_tube(64, 6, 0.08, 0.1);
  const MultiresolutionDeformer deformer(tube.positions, tube.triangles, tube.ends, small_base());
  const auto check = [&](const auto& shape, double angle) {
    std::vector<Points> stages;
    for (const double share : {1 / 3.0, 2 / 3.0}) stages.push_back(rows_of(shape(share * angle), tube.ends));
    const Points truth = shape(angle);
    const Points targets = rows_of(truth, tube.ends);
    const Deformer::Result result = deformer.deform(targets, stages);
    EXPECT_TRUE(result.report.converged);
    EXPECT_EQ(rows_of(result.positions, tube.ends), targets);
    EXPECT_LE(mean_normal_angle_deg(result.positions, truth, tube.triangles), 6.0) << angle;
    EXPECT_EQ(flipped_faces(result.positions, truth, tube.triangles), 0);
  };
  check([&](double angle) { return twisted(tube, angle); }, radians(90.0));
  check([&](double angle) { return bent(tube, angle); }, radians(120.0));
}

// A mesh of fewer vertices than a base has is its own base: the result is that of Deformer, bit for bit.
TEST(MultiresolutionDeformer, IsADeformerOnSmallMeshes) {
  const Tube tube = bumpy_tube(20, 3, 0.08, 0.2);
  const Points targets = rows_of(twisted(tube, 0.5), tube.ends);
  const Deformer plain(tube.positions, tube.triangles, tube.ends);
  const MultiresolutionDeformer deformer(tube.positions, tube.triangles, tube.ends);
  EXPECT_EQ(deformer.deform(targets).positions, plain.deform(targets).positions);
}

TEST(MultiresolutionDeformer, RefusesBadInput) {
  const Tube tube = bumpy_tube(48, 5, 0.08, 0.15);
  MultiresolutionOptions options;
  options.base_vertices = 10;
  EXPECT_THROW(MultiresolutionDeformer(tube.positions, tube.triangles, tube.ends, options), InvalidInput);
  options = small_base();
  options.fine_iterations = 0;
  EXPECT_THROW(MultiresolutionDeformer(tube.positions, tube.triangles, tube.ends, options), InvalidInput);
  EXPECT_THROW(MultiresolutionDeformer(tube.positions, tube.triangles, {}, small_base()), InvalidInput);
  const MultiresolutionDeformer deformer(tube.positions, tube.triangles, tube.ends, small_base());
  EXPECT_THROW(deformer.deform(Points::Zero(1, 3)), InvalidInput);
  EXPECT_THROW(deformer.deform(rows_of(tube.positions, tube.ends), {Points::Zero(2, 3)}), InvalidInput);
}

}  // namespace
}  // namespace batten
