#include "batten/network/curve_network.hpp"

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

CurveNetwork with_vertices(int n) {
  CurveNetwork network;
  network.positions = Points::Zero(n, 3);
  for (int i = 0; i < n; ++i) network.positions(i, 0) = i;
  network.normals = Points::Zero(n, 3);
  network.normals.col(2).setOnes();
  return network;
}

// A cross of two curves through vertex 2: by hand, four segments and five nodes.
TEST(NetworkTopology, SplitsCurvesWhereTheyCross) {
  CurveNetwork network = with_vertices(9);
  network.curves = {{"", false, {0, 1, 2, 3, 4}}, {"", false, {5, 6, 2, 7, 8}}};
  const NetworkTopology topology = network_topology(network);
  EXPECT_EQ(topology.nodes, (std::vector<int>{0, 2, 4, 5, 8}));
  EXPECT_EQ(topology.segments.size(), 4u);
  EXPECT_EQ(topology.n_components, 1);
  for (const NetworkSegment& s : topology.segments) {
    EXPECT_EQ(topology.nodes[s.from], s.vertices.front());
    EXPECT_EQ(topology.nodes[s.to], s.vertices.back());
  }
}

// A closed curve that meets nothing still needs a place to begin: its first vertex, as one loop segment.
TEST(NetworkTopology, GivesALoneClosedCurveOneNodeAndOneSegment) {
  CurveNetwork network = with_vertices(4);
  network.curves = {{"", true, {1, 2, 3, 1}}};
  const NetworkTopology topology = network_topology(network);
  ASSERT_EQ(topology.segments.size(), 1u);
  EXPECT_EQ(topology.nodes, std::vector<int>{1});
  EXPECT_EQ(topology.segments[0].vertices, (std::vector<int>{1, 2, 3, 1}));
  EXPECT_TRUE(topology.segments[0].boundary);
}

// A closed curve crossed at its vertex 3 begins its segment there although its list begins elsewhere.
TEST(NetworkTopology, BeginsClosedCurvesAtANode) {
  CurveNetwork network = with_vertices(7);
  network.curves = {{"", false, {1, 2, 3, 4, 1}}, {"", false, {5, 3, 6}}};
  const NetworkTopology topology = network_topology(network);
  EXPECT_EQ(topology.segments[0].vertices, (std::vector<int>{3, 4, 1, 2, 3}));
}

TEST(NetworkTopology, CountsComponents) {
  CurveNetwork network = with_vertices(8);
  network.curves = {{"", false, {0, 1, 2, 0}}, {"", false, {3, 4, 5}}, {"", false, {5, 6, 7}}};
  EXPECT_EQ(network_topology(network).n_components, 2);
}

TEST(NetworkTopology, MakesTaggedVerticesNodes) {
  CurveNetwork network = with_vertices(5);
  network.curves = {{"", false, {0, 1, 2, 3, 4}}};
  network.tagged_nodes = {2};
  EXPECT_EQ(network_topology(network).segments.size(), 2u);
}

// A tag on a vertex that no curve has makes no node and no part of its own.
TEST(NetworkTopology, PassesOverTagsOfUnusedVertices) {
  CurveNetwork network = with_vertices(6);
  network.curves = {{"", false, {0, 1, 2, 3, 4}}};
  network.tagged_nodes = {5};
  const NetworkTopology topology = network_topology(network);
  EXPECT_EQ(topology.nodes, (std::vector<int>{0, 4}));
  EXPECT_EQ(topology.n_components, 1);
}

TEST(NetworkTopology, NamesTheCurveWithAWrongIndex) {
  CurveNetwork network = with_vertices(3);
  network.curves = {{"", false, {0, 1}}, {"rim", false, {1, 7}}};
  try {
    network_topology(network);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("curve 1 (rim)"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("7"), std::string::npos);
  }
  network.curves = {{"", false, {0}}};
  EXPECT_THROW(network_topology(network), InvalidInput);
  network.curves = {{"", false, {0, 0}}};
  EXPECT_THROW(network_topology(network), InvalidInput);
}

}  // namespace
}  // namespace batten
