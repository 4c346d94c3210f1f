#include "batten/session/object.hpp"

#include <gtest/gtest.h>

namespace batten {
namespace {

TEST(Object, KindsAreInTheOrderOfContents) {
  EXPECT_EQ(kind_of(Content(SharedScan())), ObjectKind::Scan);
  EXPECT_EQ(kind_of(Content(SharedNetwork())), ObjectKind::Network);
  EXPECT_EQ(kind_of(Content(SharedModel())), ObjectKind::Model);
  EXPECT_EQ(kind_of(Content(SharedMesh())), ObjectKind::Mesh);
  EXPECT_EQ(kind_of(Content(Calibration())), ObjectKind::Calibration);
  EXPECT_EQ(kind_of(Content(ViewState())), ObjectKind::View);
  const Object derived{"n", "", Derived{{1}, std::make_shared<const Request>(NetworkRequest{})}};
  EXPECT_EQ(derived.kind(), ObjectKind::Network);
}

TEST(Object, WhatDoesNotHoldTogetherIsNamed) {
  const auto told = [](const Content& content, const std::string& part) {
    const auto found = problem(content);
    EXPECT_NE(found.value_or("accepted").find(part), std::string::npos) << found.value_or("accepted");
  };
  told(SharedMesh(), "no mesh");
  TriangleMesh mesh;
  mesh.positions = Points::Zero(3, 3);
  EXPECT_EQ(problem(std::make_shared<const TriangleMesh>(mesh)), std::nullopt);
  mesh.vertex_values["q"] = Eigen::VectorXd::Zero(2);
  told(std::make_shared<const TriangleMesh>(mesh), "'q'");
  mesh.vertex_values.clear();
  mesh.vertex_values["\xff"] = Eigen::VectorXd::Zero(3);
  told(std::make_shared<const TriangleMesh>(mesh), "UTF-8");
  CurveNetwork network;
  network.positions = Points::Zero(3, 3);
  network.normals = Points::Zero(2, 3);
  told(std::make_shared<const CurveNetwork>(network), "normals");
  Scan scan;
  scan.curves.resize(2);
  scan.curves[1].distances = Eigen::VectorXd::Zero(4);
  scan.curves[1].tangents = scan.curves[1].normals = Points::Zero(3, 3);
  told(std::make_shared<const Scan>(scan), "curve 2");
  ViewState view;
  view.zoom = 0;
  told(view, "the zoom of the view must be above 0");
  view = {};
  view.elevation = 2;
  told(view, "elevation");
  Calibration calibration;
  calibration.gyroscope_bias.x() = std::numeric_limits<double>::quiet_NaN();
  told(calibration, "gyroscope");
}

TEST(Object, ContentsAreComparedBitForBit) {
  TriangleMesh mesh;
  mesh.positions = Points::Zero(2, 3);
  const auto a = std::make_shared<const TriangleMesh>(mesh), b = std::make_shared<const TriangleMesh>(mesh);
  EXPECT_TRUE(same_content(a, b));
  mesh.positions(1, 2) = -0.0;
  EXPECT_FALSE(same_content(a, std::make_shared<const TriangleMesh>(mesh)));
  ViewState view, other;
  EXPECT_TRUE(same_content(view, other));
  other.hidden = {ObjectId{2}};
  EXPECT_FALSE(same_content(view, other));
  EXPECT_FALSE(same_content(view, a));
}

}  // namespace
}  // namespace batten
