#include "batten/io/network_io.hpp"

#include "io/bad_files.hpp"
#include "scratch.hpp"

#include <cmath>
#include <filesystem>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/core/text.hpp"
#include "batten/io/file.hpp"

namespace batten {
namespace {

using namespace test;

namespace fs = std::filesystem;

/// Two curves that meet, one closed, with everything that a network can carry.
CurveNetwork full_network(double scale = 1) {
  Random random(3);
  CurveNetwork network;
  network.positions.resize(6, 3);
  network.normals.resize(6, 3);
  for (int v = 0; v < 6; ++v) {
    network.positions.row(v) = scale * random.normal3().transpose();
    network.normals.row(v) = random.direction().transpose();
  }
  network.curves.push_back({"the rim, \"outer\" č", true, {0, 1, 2, 3, 0}});
  network.curves.push_back({"", false, {2, 4}});
  network.curves.push_back({"keel", false, {4, 5, 0}, true});
  network.tagged_nodes = {1, 5};
  network.unit = "mm";
  return network;
}

void expect_equal(const CurveNetwork& a, const CurveNetwork& b) {
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.normals, b.normals);
  EXPECT_EQ(a.tagged_nodes, b.tagged_nodes);
  EXPECT_EQ(a.unit, b.unit);
  ASSERT_EQ(a.curves.size(), b.curves.size());
  for (size_t c = 0; c < a.curves.size(); ++c) {
    EXPECT_EQ(a.curves[c].name, b.curves[c].name);
    EXPECT_EQ(a.curves[c].boundary, b.curves[c].boundary);
    EXPECT_EQ(a.curves[c].sharp, b.curves[c].sharp);
    EXPECT_EQ(a.curves[c].vertices, b.curves[c].vertices);
    EXPECT_EQ(a.curves[c].left_normals, b.curves[c].left_normals);
    EXPECT_EQ(a.curves[c].right_normals, b.curves[c].right_normals);
  }
}

TEST(NetworkIo, NormalsOnBothSidesOfASharpCurveAreKeptByJsonAndTheirLossIsToldElsewhere) {
  CurveNetwork network = full_network();
  network.curves[2].left_normals = network.normals.topRows(3);
  network.curves[2].right_normals = network.normals.bottomRows(3);
  expect_equal(parse_network(format_network(network, NetworkFormat::Json), "a.json"), network);
  EXPECT_TRUE(losses_in_format(network, NetworkFormat::Json).empty());
  EXPECT_EQ(losses_in_format(network, NetworkFormat::Obj).size(), 1u);
  network.curves[2].right_normals = network.normals.topRows(2);
  EXPECT_THROW(parse_network(format_network(network, NetworkFormat::Json), "a.json"), FileError);
}

TEST(NetworkIo, ObjAndJsonKeepEverythingBitForBit) {
  for (const double scale : {1.0, 1e-3, 1e3, 1e-200}) {
    const CurveNetwork network = full_network(scale);
    for (const auto& [format, name] :
         {std::pair{NetworkFormat::Obj, "a.obj"}, std::pair{NetworkFormat::Json, "a.json"}}) {
      std::vector<std::string> warnings;
      expect_equal(parse_network(format_network(network, format), name, &warnings), network);
      EXPECT_TRUE(warnings.empty());
      EXPECT_TRUE(losses_in_format(network, format).empty());
    }
  }
}

TEST(NetworkIo, NetKeepsNumbersAndFlagsAndTellsWhatItLoses) {
  const CurveNetwork network = full_network();
  CurveNetwork expected = network;
  for (NetworkCurve& curve : expected.curves) curve.name.clear();
  expected.tagged_nodes.clear();
  expected.unit.clear();
  expect_equal(parse_network(format_network(network, NetworkFormat::Net), "a.net"), expected);
  EXPECT_EQ(losses_in_format(network, NetworkFormat::Net).size(), 3u);
  EXPECT_TRUE(losses_in_format(expected, NetworkFormat::Net).empty());
}

TEST(NetworkIo, NetworksWithoutNormalsStayWithoutNormals) {
  CurveNetwork network = full_network();
  network.normals.resize(0, 3);
  for (const auto& [format, name] :
       {std::pair{NetworkFormat::Obj, "a.obj"}, std::pair{NetworkFormat::Json, "a.json"}})
    expect_equal(parse_network(format_network(network, format), name), network);
  EXPECT_FALSE(parse_network(format_network(network, NetworkFormat::Net), "a.net").has_normals());
}

// A name may hold what would end a line of OBJ; nothing behind it may be lost.
TEST(NetworkIo, HostileNamesDoNotBreakTheFiles) {
  CurveNetwork network = full_network();
  network.curves[0].name = "l 1 2\nv 0 0 0\r\n# batten nodes 1";
  const CurveNetwork obj = parse_network(format_network(network, NetworkFormat::Obj), "a.obj");
  EXPECT_EQ(obj.positions, network.positions);
  EXPECT_EQ(obj.curves.size(), 3u);
  expect_equal(parse_network(format_network(network, NetworkFormat::Json), "a.json"), network);
}

TEST(NetworkIo, NormalsAreBroughtToUnitLength) {
  const CurveNetwork network = parse_network("2\n0 0 0 0 0 2\n1 0 0 0 3 4\n1\n0\n0 1\n", "a.net");
  EXPECT_EQ(network.normals, (Points(2, 3) << 0, 0, 1, 0, 0.6, 0.8).finished());
  EXPECT_EQ(parse_network("2\n0 0 0 0 0 1.02\n1 0 0 0 0 0.98\n1\n0\n0 1\n", "a.net").normals,
            (Points(2, 3) << 0, 0, 1, 0, 0, 1).finished());
}

// A cross of four arms and a separate triangle, drawn as two-point lines in any order: four arms that end at
// the crossing and one closed curve.
TEST(NetworkIo, TwoPointLinesAreJoinedUpToTheNextCrossing) {
  std::vector<std::string> warnings;
  const CurveNetwork network = parse_network(
      "v 0 0 0\nv 1 0 0\nv 2 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 5 0 0\nv 6 0 0\nv 6 1 0\n"
      "l 3 2\nl 1 2\nl 4 1\nl 1 5\nl 6 1\nl 7 8\nl 9 7\nl 8 9\n",
      "a.obj", &warnings);
  ASSERT_EQ(network.curves.size(), 5u);
  EXPECT_EQ(network.curves[0].vertices, (std::vector<int>{2, 1, 0}));
  EXPECT_TRUE(network.curves[4].closed());
  EXPECT_EQ(network.curves[4].vertices.size(), 4u);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("5 curves"), std::string::npos);
}

TEST(NetworkIo, CurveTextClosesCurvesThatReturnToTheirFirstPoint) {
  const CurveNetwork network =
      parse_network("CURVE 0\n0 0 0\n1 0 0\n1 1 0\n0 0 0\nCURVE 1\n5 0 0\n6 0 0\n", "a.txt");
  ASSERT_EQ(network.curves.size(), 2u);
  EXPECT_TRUE(network.curves[0].closed());
  EXPECT_EQ(network.positions.rows(), 5);
  EXPECT_EQ(network.curves[1].vertices, (std::vector<int>{3, 4}));
  EXPECT_EQ(network.curves[1].name, "CURVE 1");
  // There and back on the same way is no closed curve.
  const CurveNetwork back = parse_network("CURVE 0\n0 0 0\n1 0 0\n0 0 0\n", "a.txt");
  EXPECT_EQ(back.curves[0].vertices, (std::vector<int>{0, 1, 2}));
}

// A cubic Bézier curve is the B-spline with its knots at both ends; its point at 1/2 is (a + 3b + 3c + d)/8.
TEST(NetworkIo, CurvesAreToldFromFaces) {
  for (const char* extension : {"net", "json", "txt", "lop"})
    EXPECT_TRUE(holds_network(extension, "")) << extension;
  for (const char* extension : {"ply", "stl", "rawnet", "csv", ""})
    EXPECT_FALSE(holds_network(extension, "")) << extension;
  EXPECT_TRUE(holds_network("obj", "v 0 0 0\nv 1 0 0\nl 1 2\nfurther 1\n"));
  EXPECT_FALSE(holds_network("obj", "v 0 0 0\n \tf\t1 2 3"));
  EXPECT_FALSE(holds_network("obj", "l 1 2\nf 1 2 3\n"));
}

TEST(NetworkIo, BSplineLoopsAreSampledExactly) {
  const CurveNetwork network = parse_network(
      "2\n3\n8 0 0 0 0 1 1 1 1\n4 0 0 0 1 2 0 3 2 0 4 0 0\n1\n4 0 0 1 1\n2 4 0 0 0 0 0\n", "a.lop");
  ASSERT_EQ(network.curves.size(), 2u);
  EXPECT_TRUE(network.curves[0].boundary);
  const Eigen::RowVector3d middle = network.positions.row(network.curves[0].vertices[16]);
  EXPECT_LT((middle - Eigen::RowVector3d(2, 1.5, 0)).norm(), 1e-15);
  EXPECT_EQ(network.curves[0].vertices.back(), network.curves[1].vertices.front());
  EXPECT_EQ(network.curves[1].vertices.back(), network.curves[0].vertices.front());
}

TEST(NetworkIo, ContentDecidesWhereTheExtensionLies) {
  std::vector<std::string> warnings;
  expect_equal(parse_network(format_network(full_network(), NetworkFormat::Json), "liar.net", &warnings),
               full_network());
  ASSERT_EQ(warnings.size(), 1u);
}

class BadNetwork : public testing::TestWithParam<BadFile> {};

TEST_P(BadNetwork, IsRefusedWithFileLineAndReason) {
  const BadFile& bad = GetParam();
  expect_refused([&] { parse_network(bad.content, bad.name); }, bad.name, bad.line, bad.word);
}

const std::string kNet = "3\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n";
const std::string kJson =
    "{\"format\": \"batten-network\", \"version\": 1, \"positions\": [[0,0,0],[1,0,0]], ";

INSTANTIATE_TEST_SUITE_P(
    Files, BadNetwork,
    testing::Values(
        BadFile{"a.net", "", 0, "empty"}, BadFile{"a.bin", "1 2 3", 0, "not recognised"},
        BadFile{"a.xyz", "0 0 0\n1 0 0\n", 0, "without order"}, BadFile{"a.net", kGarbage, 1, "not a text"},
        BadFile{"a.obj", kGarbage, 1, "not a text"}, BadFile{"a.txt", kGarbage, 1, "not a text"},
        BadFile{"a.lop", kGarbage, 1, "not a text"}, BadFile{"a.json", kGarbage, 1, "JSON"},
        // .net
        BadFile{"a.net", "three\n", 1, "integer"}, BadFile{"a.net", "0\n0\n", 1, "expected 1"},
        BadFile{"a.net", "3 1\n", 1, "alone"}, BadFile{"a.net", "1000000\n0 0 0\n", 1, "do not fit"},
        BadFile{"a.net", "3\n0 0 0 0 0 1\n1 0 0 0 0 1\n", 3, "after 2 of 3"},
        BadFile{"a.net", "2\n0 0 0 0 0 1\n1 0 0\n", 3, "expected x y z nx"},
        BadFile{"a.net", "1\n0 0 0 1\n", 2, "4 numbers"},
        BadFile{"a.net", "2\n0 0 0 0 0 1\n1 nan 0 0 0 1\n", 3, "not finite"},
        BadFile{"a.net", kNet, 4, "number of curves"}, BadFile{"a.net", kNet + "1 2 3 4 5 6\n", 5, "alone"},
        BadFile{"a.net", kNet + "0\n", 0, "no curves"},
        BadFile{"a.net", kNet + "2\n0\n0 1\n", 7, "after 1 of 2"},
        BadFile{"a.net", kNet + "1\n3\n0 1\n", 6, "expected 0 to 2"},
        BadFile{"a.net", kNet + "1\n0 1\n", 6, "alone"},
        BadFile{"a.net", kNet + "1\n0\n", 6, "before the vertices"},
        BadFile{"a.net", kNet + "1\n0\n0 3\n", 7, "expected 0 to 2"},
        BadFile{"a.net", kNet + "1\n0\n0 -1\n", 7, "expected 0 to 2"},
        BadFile{"a.net", kNet + "1\n0\n0\n", 7, "fewer than two"},
        BadFile{"a.net", kNet + "1\n0\n0 1\n0\n1 2\n", 8, "more lines"},
        BadFile{"a.net", kNet + "1\n0\n0 0 1\n", 0, "follows on itself"},
        BadFile{"a.net", "2\n0 0 0 0 0 0\n1 0 0 0 0 1\n1\n0\n0 1\n", 0, "length 0"},
        // OBJ
        BadFile{"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", 0, "mesh"},
        BadFile{"a.obj", "v 0 0 0\n", 0, "no curves"}, BadFile{"a.obj", "v 0 0 0\nl 1\n", 2, "two points"},
        BadFile{"a.obj", "v 0 0 0\nl 1 2\n", 2, "vertex 2"},
        BadFile{"a.obj", "v 0 0 0\nv 1 0 0\nl 1 1 2\n", 3, "follows on itself"},
        BadFile{"a.obj", "v 0 0 0\nv 1 0 0\nl 1 b\n", 3, "no integer"},
        BadFile{"a.obj", "# batten curve network\n# batten nodes 3\nv 0 0 0\nv 1 0 0\nl 1 2\n", 0,
                "expected 1 to 2"},
        // JSON
        BadFile{"a.json", "{", 1, "truncated"}, BadFile{"a.json", "{\n\"a\": ,}", 2, "no valid JSON"},
        BadFile{"a.json", "[1, 2]", 0, "no curve network"}, BadFile{"a.json", "{\"format\": 3}", 0, "text"},
        BadFile{"a.json", "{\"format\": \"batten-network\", \"version\": 9}", 0, "newer"},
        BadFile{"a.json", kJson + "\"normals\": []}", 0, "no 'curves'"},
        BadFile{"a.json", kJson + "\"curves\": []}", 0, "no curves"},
        BadFile{"a.json", kJson + "\"curves\": [{\"vertices\": [0]}]}", 0, "curves[0].vertices"},
        BadFile{"a.json", kJson + "\"curves\": [{\"vertices\": [0, 2]}]}", 0, "curves[0].vertices[1]"},
        BadFile{"a.json", kJson + "\"curves\": [{\"vertices\": [0, 99999999999999999999]}]}", 0,
                "curves[0].vertices[1]"},
        BadFile{"a.json", kJson + "\"curves\": [{\"vertices\": [0, 0.5]}]}", 0, "integer"},
        BadFile{"a.json", kJson + "\"normals\": [[0,0,1]], \"curves\": []}", 0, "1 rows for 2"},
        BadFile{"a.json", "{\"format\": \"batten-network\", \"version\": 1, \"positions\": [[0,0,0],[1,0]]}",
                0, "positions[1]"},
        BadFile{"a.json", "{\"format\": \"batten-network\", \"version\": 1, \"positions\": [[0,0,1e999]]}", 0,
                "range"},
        BadFile{"a.json", "{\"shape\": \"none\", \"SS\": []}", 0, "must stand beside"},
        // curve text
        BadFile{"a.txt", "0 0 0\n", 1, "CURVE"}, BadFile{"a.txt", "CURVE 0\n0 0\n", 2, "missing"},
        BadFile{"a.txt", "CURVE 0\n0 0 0 0\n", 2, "three"},
        BadFile{"a.txt", "CURVE 0\n0 0 0\nCURVE 1\n", 3, "fewer than two"},
        BadFile{"a.txt", "# only\n", 0, "no curves"},
        // .lop
        BadFile{"a.lop", "1\n3\n5 0 0 0 1 1\n4 0 0 0\n", 4, "expected 8"},
        BadFile{"a.lop", "1\n1\n4 0 0 1 1\n2 0 0 0 1 0", 4, "ends before"},
        BadFile{"a.lop", "1\n1\n4 0 1 0 1\n", 3, "decrease"},
        BadFile{"a.lop", "2000000000\n", 1, "expected 1 to"},
        BadFile{"a.lop", "1\n1\n4 0 0 1 1\n2 0 0 0 1 0 0\n", 4, "follow each other"},
        BadFile{"a.lop", "2\n1\n4 0 0 1 1\n2 0 0 0 4 0 0\n1\n4 0 0 1 1\n2 4 0 0 0.01 0 0\n", 4,
                "begins 0.01 away"},
        BadFile{"a.lop", "1\n1\n4 0 0 0 0\n2 0 0 0 1 0 0\n", 4, "is a point"}));

TEST(NetworkIo, UnwritablePlacesAndFormatsAreRefused) {
  EXPECT_THROW(write_network("no/such/folder/a.net", full_network()), FileError);
  EXPECT_THROW(write_network("a.txt", full_network()), FileError);
  CurveNetwork network = full_network();
  network.curves[1].vertices[0] = 6;
  EXPECT_THROW(format_network(network, NetworkFormat::Net), InvalidInput);
}

// Counts from the table of the public data; chains and closed loops were counted by its maker.
TEST(NetworkIo, ReadsThePublicCurveFiles) {
  if (!fs::exists(kSharedData)) GTEST_SKIP() << "the public data is not at " << kSharedData;
  struct Known {
    const char* file;
    long vertices;
    size_t curves, closed;
  };
  for (const Known& known :
       {Known{"curves/lilium.net", 401, 3, 0}, Known{"curves/hill_3.txt", 217, 3, 0},
        Known{"curves/sketch_box.obj", 2906, 12, 3}, Known{"curves/sketch_spherecylinder.obj", 1803, 7, 1},
        Known{"curves/sketch_car.obj", 3248, 68, 3}, Known{"curves/sketch_gamepad.obj", 4420, 108, 0},
        Known{"curves/pocket3sided.lop", -1, 3, 0}, Known{"curves/pocket6sided.lop", -1, 6, 0},
        Known{"networks/dish.net", 245, 20, 0}}) {
    const CurveNetwork network = read_network(kSharedData + "/" + known.file);
    std::vector<int> uses(static_cast<size_t>(network.positions.rows()), 0);
    for (const NetworkCurve& curve : network.curves)
      for (const int v : curve.vertices) ++uses[static_cast<size_t>(v)];
    size_t n_closed = 0;  // curves that return to their start and meet nothing there
    for (const NetworkCurve& curve : network.curves)
      n_closed += curve.closed() && uses[static_cast<size_t>(curve.vertices.front())] == 2;
    if (known.vertices >= 0) {
      EXPECT_EQ(network.positions.rows(), known.vertices) << known.file;
    }
    EXPECT_EQ(network.curves.size(), known.curves) << known.file;
    EXPECT_EQ(n_closed, known.closed) << known.file;
  }
}

// Two triangles of the plane, and a walk over both that rests at its second point and comes back to the
// first.
TEST(NetworkIo, CurvesOnAMeshCloseAndDoNotRest) {
  const std::string folder = scratch_file("on_mesh");
  fs::create_directories(folder + "/inner");
  write_file(folder + "/plate.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n");
  const std::string walk =
      "\"SS\": [{\"FI\": [1, 1, 1, 2, 1], "
      "\"B\": [[0.5, 0.25, 0.25], [0.25, 0.5, 0.25], [0.25, 0.5, 0.25], [0.25, 0.25, 0.5], [0.5, 0.25, "
      "0.25]]}]}";
  write_file(folder + "/plate_curves.json", "{" + walk);
  const CurveNetwork network = read_network(folder + "/plate_curves.json");
  ASSERT_EQ(network.curves.size(), 1u);
  EXPECT_EQ(network.curves[0].vertices, (std::vector<int>{0, 1, 2, 0}));
  EXPECT_EQ(network.positions, (Points(3, 3) << 0.5, 0.25, 0, 0.75, 0.25, 0, 0.25, 0.75, 0).finished());
  EXPECT_EQ(network.normals.col(2), Eigen::Vector3d::Ones());
  // The file may name its mesh, one beside it and no other.
  write_file(folder + "/walk.json", "{\"shape\": \"plate\", " + walk);
  EXPECT_EQ(read_network(folder + "/walk.json").positions, network.positions);
  write_file(folder + "/inner/walk.json", "{\"shape\": \"../plate\", " + walk);
  EXPECT_THROW(read_network(folder + "/inner/walk.json"), FileError);
}

// The mesh is a torus whose vertices all lie on it; interpolated points lie inside by at most the sagitta.
TEST(NetworkIo, CurvesOnAMeshGetTheirPointsAndNormalsFromIt) {
  if (!fs::exists(kSharedData)) GTEST_SKIP() << "the public data is not at " << kSharedData;
  const CurveNetwork network = read_network(kSharedData + "/curves/onmesh_torus_curves.json");
  EXPECT_EQ(network.curves.size(), 10u);
  ASSERT_TRUE(network.has_normals());
  EXPECT_LT((network.normals.rowwise().norm().array() - 1).abs().maxCoeff(), 1e-12);
  for (const NetworkCurve& curve : network.curves) EXPECT_GT(curve.vertices.size(), 480u);
  EXPECT_THROW(read_network(kSharedData + "/curves/wireframe_trebol.xyz"), FileError);
}

}  // namespace
}  // namespace batten
