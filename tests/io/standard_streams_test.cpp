#include "batten/io/standard_streams.hpp"

#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "batten/io/file.hpp"
#include "batten/io/mesh_io.hpp"

namespace batten {
namespace {

TEST(StandardStreams, AreADashOrAFormatWithOne) {
  for (const char* path : {"-", "ply:-", "OBJ:-", "3mf:-"}) EXPECT_TRUE(is_standard_stream(path)) << path;
  for (const char* path : {"", "--", ":-", "a/b:-", "-.ply", "c:-d", "my file:-"})
    EXPECT_FALSE(is_standard_stream(path)) << path;
  EXPECT_EQ(file_extension("PLY:-"), "ply");
  EXPECT_EQ(file_extension("-"), "");
  EXPECT_EQ(output_extension("-", "json"), "json");
  EXPECT_EQ(output_extension("net:-", "json"), "net");
  EXPECT_EQ(output_extension("a.obj", "json"), "obj");
  EXPECT_EQ(input_extension("net:-"), "net");
}

TEST(ExtensionOfContent, IsThatOfTheFormatItBeginsAs) {
  const std::pair<const char*, std::string> contents[] = {
      {"ply", "ply\r\nformat ascii 1.0\n"},
      {"off", "OFF\n3 1 0\n"},
      {"off", "\n\nNOFF 3 1 0\n"},
      {"stl", "solid part\n  facet normal 0 0 1\n"},
      {"stl", "SOLID PART\n  FACET NORMAL 0 0 1\n"},
      {"obj", "# Blender 3.4\nmtllib a.mtl\no Cube\nv 1 2 3\n"},
      {"obj", "# batten curve network\nv 0 0 0\n"},
      {"obj", "\xEF\xBB\xBFv 1 2 3\n"},
      {"json", "{ \"format\": \"batten-network\" }"},
      {"jsonl", "{\"batten_session\":2}\n"},
      {"batten", std::string("PK\x03\x04") + "rest"},
      {"net", "2\n0 0 0\n1 0 0\n1\n0\n0 1\n"},
      {"net", "# a network\n2\n0 0 0 0 0 1\n"},
      {"rawnet", "# number of curves\n1\n1 # 1=boundary, 0=interior\n1 # closed\n"},
      {"rawnet", "1\n1\n1\n"},
      {"csv", "time_s,acc_x,acc_y\n0,1,2\n"},
      {"txt", "CURVE 1\n0 0 0\n"},
      {"", ""},
      {"", "hello world\n"},
      {"", "# only a comment\n"},
  };
  for (const auto& [extension, content] : contents)
    EXPECT_EQ(extension_of_content(content), extension) << content;
}

// A binary STL may begin with any 80 bytes, "solid" too.
TEST(ExtensionOfContent, KnowsBinaryStlByItsLength) {
  TriangleMesh mesh;
  mesh.positions = Points::Random(3, 3);
  mesh.triangles.resize(1, 3);
  mesh.triangles << 0, 1, 2;
  std::string stl = format_mesh(mesh, MeshFormat::Stl);
  EXPECT_EQ(extension_of_content(stl), "stl");
  stl.replace(0, 5, "solid");
  EXPECT_EQ(extension_of_content(stl), "stl");
  EXPECT_EQ(extension_of_content(stl.substr(0, 100)), "");
}

}  // namespace
}  // namespace batten
