#include "batten/session/request.hpp"

#include "random_project.hpp"

#include <gtest/gtest.h>

namespace batten {
namespace {

TEST(Request, EveryKindHasDefaultsThatAreItsOwn) {
  for (const RequestKind kind : choice_values<RequestKind>()) {
    const Request request = default_request(kind);
    EXPECT_EQ(kind_of(request), kind);
    EXPECT_TRUE(same_request(request, default_request(kind)));
    // Simplification needs a criterion; all others run as they are.
    EXPECT_EQ(problem(request).has_value(), kind == RequestKind::Simplify) << word_of(kind);
  }
}

TEST(Request, ProblemsOfOptionsAreToldInTheWordsOfTheirStructs) {
  NetworkRequest request;
  request.options.sigma = 3;
  EXPECT_EQ(problem(request), request.options.problem());
  RemeshRequest sizes;
  sizes.options.remesh.sizes = Eigen::VectorXd::Ones(3);
  EXPECT_NE(problem(sizes)->find("named"), std::string::npos);
  RemeshRequest length;
  length.options.edge_length = Length{0, Length::Kind::Relative};
  EXPECT_NE(problem(length)->find("edge_length must be positive"), std::string::npos);
  SubdivideRequest patches;
  patches.options.patches.emplace();
  EXPECT_NE(problem(patches)->find("no patches"), std::string::npos);
  DeformRequest handles;
  handles.moved.resize(1);
  handles.moved[0].vertices = std::make_shared<const std::vector<int>>(std::vector<int>{1, 2});
  EXPECT_EQ(problem(handles), std::nullopt);
  handles.moved[0].targets = std::make_shared<const Points>(Points::Zero(3, 3));
  EXPECT_NE(problem(handles)->find("2 vertices and 3 targets"), std::string::npos);
}

TEST(Request, ChangedOptionsAreNamed) {
  SurfaceRequest before, after;
  EXPECT_TRUE(changed_options(before, after).empty());
  after.surface.surface.soft_weight = 2;
  after.strokes.reach = 0.04;
  EXPECT_EQ(changed_options(before, after),
            (std::vector<std::string>{"strokes.reach", "surface.surface.soft_weight"}));
  EXPECT_EQ(changed_options(before, FairRequest{}), std::vector<std::string>{"request"});
  // Bit for bit.
  FairRequest zero, minus_zero;
  zero.options.noise = 0;
  minus_zero.options.noise = -0.0;
  EXPECT_EQ(changed_options(zero, minus_zero), std::vector<std::string>{"noise"});
}

TEST(Request, HandlesAreThoseOfDeformations) {
  DeformRequest request;
  request.fixed = std::make_shared<const std::vector<int>>(std::vector<int>{4, 2});
  MovedVertices& moved = request.moved.emplace_back();
  moved.vertices = std::make_shared<const std::vector<int>>(std::vector<int>{7});
  moved.translation = {1, 2, 3};
  const Handles handles = request.handles();
  EXPECT_EQ(handles.vertices(), (std::vector<int>{4, 2, 7}));
  EXPECT_EQ(handles.moved[0].translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(handles.moved[0].targets.rows(), 0);
}

TEST(Request, EqualListsAreShared) {
  DeformRequest a, b;
  a.fixed = std::make_shared<const std::vector<int>>(std::vector<int>{4, 2});
  b.fixed = std::make_shared<const std::vector<int>>(std::vector<int>{4, 2});
  Request request = b;
  share_lists(request, a);
  EXPECT_EQ(std::get<DeformRequest>(request).fixed, a.fixed);
  a.moved.resize(1);
  b.moved.resize(1);
  a.moved[0].targets = std::make_shared<const Points>(Points::Zero(2, 3));
  b.moved[0].targets = std::make_shared<const Points>(Points::Zero(3, 3));
  request = b;
  share_lists(request, a);
  EXPECT_EQ(std::get<DeformRequest>(request).moved[0].targets, b.moved[0].targets);
  b.fixed = std::make_shared<const std::vector<int>>(std::vector<int>{4, 3});
  request = b;
  share_lists(request, a);
  EXPECT_EQ(std::get<DeformRequest>(request).fixed, b.fixed);
}

}  // namespace
}  // namespace batten
