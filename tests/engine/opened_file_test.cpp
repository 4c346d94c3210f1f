#include "batten/engine/opened_file.hpp"

#include <string>
#include <variant>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/io/network_io.hpp"
#include "batten/io/scan_io.hpp"
#include "batten/simulation/shapes.hpp"
#include "batten/simulation/simulate.hpp"

namespace batten {
namespace {

constexpr const char* kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

TEST(OpenedFile, TellsWhatAFileHoldsByItsContent) {
  const OpenedFile mesh = open_file(std::string(kTriangle) + "f 1 2 3\n", "folder/one.obj");
  EXPECT_EQ(kind_of(mesh.content), ObjectKind::Mesh);
  EXPECT_EQ(mesh.name, "one");
  // The same suffix with lines in the place of faces is a network.
  const OpenedFile network = open_file(std::string(kTriangle) + "l 1 2 3 1\n", "one.obj");
  EXPECT_EQ(kind_of(network.content), ObjectKind::Network);
  const Scan scan = simulate_scan(trace_shape(AnalyticShape::Sphere), {}).scan;
  const OpenedFile rawnet = open_file(format_rawnet(scan), "C:\\scans\\ball.two.rawnet");
  ASSERT_EQ(kind_of(rawnet.content), ObjectKind::Scan);
  EXPECT_EQ(rawnet.name, "ball.two");
  EXPECT_EQ(std::get<SharedScan>(rawnet.content)->curves.size(), scan.curves.size());
}

TEST(OpenedFile, KeepsTheUnitThatTheFileNames) {
  CurveNetwork network;
  network.positions.resize(2, 3);
  network.positions << 0, 0, 0, 1, 0, 0;
  network.normals.resize(0, 3);
  network.curves.push_back({.name = "a", .vertices = {0, 1}});
  network.unit = "cm";
  EXPECT_EQ(open_file(format_network(network, NetworkFormat::Json), "a.json").unit, "cm");
}

TEST(OpenedFile, RefusesWhatIsNoneInWords) {
  for (const std::string& bytes : {std::string(), std::string("hello"), std::string(100, '\0')})
    for (const char* name : {"a.ply", "a.obj", "a.rawnet", "a.json", "a.stl", "a.unknown", "a"})
      EXPECT_THROW(open_file(bytes, name), InvalidInput) << name << " with " << bytes.size() << " bytes";
}

}  // namespace
}  // namespace batten
