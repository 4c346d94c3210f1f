#include "scratch.hpp"

#include <cmath>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "batten/core/error.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/io/zip_archive.hpp"

namespace batten {
namespace {

using Json = nlohmann::json;

/// A tetrahedron with coordinates that single precision holds, normals and colours.
TriangleMesh tetrahedron() {
  TriangleMesh mesh;
  mesh.positions.resize(4, 3);
  mesh.positions << 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 0.5;
  mesh.triangles.resize(4, 3);
  mesh.triangles << 0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3;
  mesh.normals = mesh.positions.rowwise() - mesh.positions.colwise().mean();
  mesh.normals.rowwise().normalize();
  mesh.vertex_values["red"] = Eigen::Vector4d(0, 255, 17, 128);
  mesh.vertex_values["green"] = Eigen::Vector4d(255, 0, 3, 128);
  mesh.vertex_values["blue"] = Eigen::Vector4d(9, 8, 7, 6);
  return mesh;
}

TEST(Gltf, ReadsBackWhatItWrote) {
  const TriangleMesh mesh = tetrahedron();
  std::vector<std::string> warnings;
  const TriangleMesh back = parse_mesh(format_mesh(mesh, MeshFormat::Gltf), "a.glb", &warnings);
  EXPECT_TRUE(warnings.empty());
  EXPECT_EQ(back.positions, mesh.positions);
  EXPECT_EQ(back.triangles, mesh.triangles);
  EXPECT_LT((back.normals - mesh.normals).norm(), 1e-6);
  for (const char* name : {"red", "green", "blue"})
    EXPECT_LT((back.vertex_values.at(name) - mesh.vertex_values.at(name)).norm(), 1e-4) << name;
  // Metres, whatever the mesh is in.
  MeshWriteOptions options;
  options.metres_per_unit = 0.001;
  EXPECT_LT(
      (parse_mesh(format_mesh(mesh, MeshFormat::Gltf, options), "a.glb").positions - 0.001 * mesh.positions)
          .norm(),
      1e-9);
}

// What the specification asks of every file: lengths, alignment, and the range of the positions, with +Y up.
TEST(Gltf, WritesWhatTheSpecificationAsksFor) {
  const std::string bytes = format_mesh(tetrahedron(), MeshFormat::Gltf);
  const auto number = [&](size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, 4);
    return value;
  };
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(number(8), bytes.size());
  EXPECT_EQ(number(12) % 4, 0U);
  const Json json = Json::parse(bytes.substr(20, number(12)));
  EXPECT_EQ(json["accessors"][0]["min"], (std::vector<double>{0, 0, -2}));
  EXPECT_EQ(json["accessors"][0]["max"], (std::vector<double>{1, 0.5, 0}));
  // The range is that of the positions wherever they are.
  TriangleMesh away = tetrahedron();
  away.positions.array() -= 10;
  const std::string moved = format_mesh(away, MeshFormat::Gltf);
  std::uint32_t length = 0;
  std::memcpy(&length, moved.data() + 12, 4);
  const Json range = Json::parse(moved.substr(20, length))["accessors"][0];
  EXPECT_EQ(range["min"], (std::vector<double>{-10, -10, 8}));
  EXPECT_EQ(range["max"], (std::vector<double>{-9, -9.5, 10}));
  for (const Json& view : json["bufferViews"]) EXPECT_EQ(view["byteOffset"].get<int>() % 4, 0);
  EXPECT_EQ(json["buffers"][0]["byteLength"], number(20 + number(12)));
}

std::string as_text(const std::vector<float>& values) {
  static const char* const kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes(4 * values.size(), '\0'), text;
  std::memcpy(bytes.data(), values.data(), bytes.size());
  while (bytes.size() % 3 != 0) bytes += '\0';
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const auto bits = static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i])) << 16 |
                      static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i + 1])) << 8 |
                      static_cast<unsigned char>(bytes[i + 2]);
    for (int k = 18; k >= 0; k -= 6) text += kDigits[bits >> k & 63];
  }
  return text;
}

/// A .gltf whose buffer is in its text: one triangle in a node with this transform.
Json triangle_file(const Json& node) {
  const std::vector<float> corners{0, 0, 0, 1, 0, 0, 0, 1, 0};
  return {{"asset", {{"version", "2.0"}}},
          {"scenes", {{{"nodes", {0}}}}},
          {"nodes", {node}},
          {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}}}}}}},
          {"buffers",
           {{{"byteLength", 36}, {"uri", "data:application/octet-stream;base64," + as_text(corners)}}}},
          {"bufferViews", {{{"buffer", 0}, {"byteLength", 36}}}},
          {"accessors", {{{"bufferView", 0}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}}}}};
}

Eigen::RowVector3d turned_up(double x, double y, double z) {
  return {x, -z, y};
}

TEST(Gltf, NodesPutMeshesInTheirPlaces) {
  const double half = std::sqrt(0.5);
  const Json node = {
      {"mesh", 0}, {"translation", {10, 20, 30}}, {"rotation", {0, 0, half, half}}, {"scale", {2, 3, 4}}};
  const TriangleMesh mesh = parse_mesh(triangle_file(node).dump(), "a.gltf");
  // x is doubled and turned to y; y is tripled and turned to −x.
  EXPECT_LT((mesh.positions.row(0) - turned_up(10, 20, 30)).norm(), 1e-12);
  EXPECT_LT((mesh.positions.row(1) - turned_up(10, 22, 30)).norm(), 1e-12);
  EXPECT_LT((mesh.positions.row(2) - turned_up(7, 20, 30)).norm(), 1e-12);
  // A mirror turns faces, so that they look out as before.
  const TriangleMesh plain = parse_mesh(triangle_file({{"mesh", 0}}).dump(), "a.gltf"),
                     mirrored =
                         parse_mesh(triangle_file({{"mesh", 0}, {"scale", {1, 1, -1}}}).dump(), "a.gltf");
  EXPECT_EQ(plain.triangles.row(0), Eigen::RowVector3i(0, 1, 2));
  EXPECT_EQ(mirrored.triangles.row(0), Eigen::RowVector3i(0, 2, 1));
}

TEST(Gltf, StripsAndFansBecomeTriangles) {
  Json file = triangle_file({{"mesh", 0}});
  const std::vector<float> corners{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
  file["buffers"][0] = {{"byteLength", 48}, {"uri", "data:;base64," + as_text(corners)}};
  file["bufferViews"][0]["byteLength"] = 48;
  file["accessors"][0]["count"] = 4;
  file["meshes"][0]["primitives"][0]["mode"] = 5;
  Triangles strip(2, 3), fan(2, 3);
  strip << 0, 1, 2, 2, 1, 3;
  fan << 0, 1, 2, 0, 2, 3;
  EXPECT_EQ(parse_mesh(file.dump(), "a.gltf").triangles, strip);
  file["meshes"][0]["primitives"][0]["mode"] = 6;
  EXPECT_EQ(parse_mesh(file.dump(), "a.gltf").triangles, fan);
  // Two primitives with a corner in common share it.
  file["meshes"][0]["primitives"].push_back(file["meshes"][0]["primitives"][0]);
  EXPECT_EQ(parse_mesh(file.dump(), "a.gltf").n_vertices(), 4);
}

// Positions and normals in turns, as many programs write them: each accessor begins at its own offset within
// the view, whose stride leads to the next vertex.
TEST(Gltf, ReadsInterleavedAttributes) {
  Json file = triangle_file({{"mesh", 0}});
  const std::vector<float> corners{0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0};
  file["buffers"][0] = {{"byteLength", 72}, {"uri", "data:;base64," + as_text(corners)}};
  file["bufferViews"][0] = {{"buffer", 0}, {"byteLength", 72}, {"byteStride", 24}};
  file["accessors"].push_back(file["accessors"][0]);
  file["accessors"][1]["byteOffset"] = 12;
  file["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = 1;
  const TriangleMesh mesh = parse_mesh(file.dump(), "a.gltf");
  EXPECT_EQ(mesh.positions.row(1), turned_up(1, 0, 0));
  EXPECT_EQ(mesh.positions.row(2), turned_up(0, 0, 1));
  ASSERT_EQ(mesh.normals.rows(), 3);
  for (int v = 0; v < 3; ++v) EXPECT_EQ(mesh.normals.row(v), turned_up(0, 1, 0));
}

// Of several scenes the one that the file names, without a name the first.
TEST(Gltf, ShowsTheSceneThatTheFileNames) {
  Json file = triangle_file({{"mesh", 0}});
  file["nodes"].push_back({{"mesh", 0}, {"translation", {5, 0, 0}}});
  file["scenes"].push_back({{"nodes", {1}}});
  EXPECT_EQ(parse_mesh(file.dump(), "a.gltf").positions.row(0), turned_up(0, 0, 0));
  file["scene"] = 1;
  EXPECT_EQ(parse_mesh(file.dump(), "a.gltf").positions.row(0), turned_up(5, 0, 0));
}

TEST(Gltf, BrokenFilesAreRefusedInWords) {
  const Json good = triangle_file({{"mesh", 0}});
  const auto with = [&](const char* place, const Json& value) {
    Json file = good;
    file[Json::json_pointer(place)] = value;
    return file.dump();
  };
  const std::string glb = format_mesh(tetrahedron(), MeshFormat::Gltf);
  const std::pair<std::string, const char*> kFiles[] = {
      {glb.substr(0, 15), "cut off"},
      {glb.substr(0, glb.size() - 30), "cut off"},
      {std::string("glTF\1\0\0\0", 8) + glb.substr(8), "version 1"},
      {with("/accessors/0/count", 1000000000), "beyond the end"},
      {with("/accessors/0/count", 18446744073709551615ull), "too large"},
      {with("/accessors/0/bufferView", 7), "which has 1"},
      {with("/accessors/0/componentType", 99), "does not know"},
      {with("/accessors/0/count", -1), "whole number"},
      {with("/accessors/0/sparse", Json::object()), "sparse"},
      {with("/nodes/0/children", Json{0}), "without end"},
      {with("/nodes/0/mesh", "first"), "whole number"},
      {with("/nodes/0/scale", Json{1, 2}), "wrong size"},
      {with("/buffers/0/byteLength", 99), "shorter than it says"},
      {with("/buffers/0/uri", "missing.bin"), "missing.bin"},
      {with("/extensionsRequired", Json{"KHR_draco_mesh_compression"}), "without compression"},
      {with("/meshes/0/primitives/0/indices", 0), "type"},
      {with("/asset", 3), ""},
  };
  for (const auto& [file, words] : kFiles) {
    try {
      parse_mesh(file, "a.gltf");
      EXPECT_STREQ(words, "") << file.substr(0, 200);
    } catch (const FileError& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  }
}

TEST(Gltf, ReadsBuffersBesideTheFile) {
  Json file = triangle_file({{"mesh", 0}});
  file["buffers"][0]["uri"] = "beside.bin";
  const std::vector<float> corners{0, 0, 0, 1, 0, 0, 0, 1, 0};
  std::ofstream(test::scratch_file("beside.bin"), std::ios::binary)
      .write(reinterpret_cast<const char*>(corners.data()), 36);
  std::ofstream(test::scratch_file("a.gltf")) << file.dump();
  EXPECT_EQ(read_mesh(test::scratch_file("a.gltf")).n_triangles(), 1);
}

TEST(MeshWriteOptions, NameAUnitWithoutLength) {
  for (const double unit : {0.0, -1.0, std::nan("")}) {
    MeshWriteOptions options;
    options.metres_per_unit = unit;
    EXPECT_NE(options.problem().value_or("").find("metres_per_unit must"), std::string::npos) << unit;
    EXPECT_THROW(format_mesh(tetrahedron(), MeshFormat::Gltf, options), InvalidInput);
  }
  EXPECT_EQ(MeshWriteOptions().problem(), std::nullopt);
}

TEST(ThreeMf, HoldsMillimetresExactly) {
  TriangleMesh mesh = tetrahedron();
  mesh.positions(1, 0) = 1.0 / 3;
  MeshWriteOptions options;
  options.metres_per_unit = 0.0254;
  const auto entries = parse_archive(format_mesh(mesh, MeshFormat::ThreeMf, options));
  EXPECT_EQ(entries.size(), 3U);
  const std::string& model = entries.at("3D/3dmodel.model");
  EXPECT_NE(model.find("unit=\"millimeter\""), std::string::npos);
  const size_t second = model.find("<vertex", model.find("<vertex x") + 1);
  EXPECT_DOUBLE_EQ(std::stod(model.substr(model.find("x=\"", second) + 3)), 25.4 / 3);
  EXPECT_NE(model.find("<triangle v1=\"0\" v2=\"2\" v3=\"1\"/>"), std::string::npos);
  EXPECT_NE(entries.at("_rels/.rels").find("/3D/3dmodel.model"), std::string::npos);
  mesh.triangles(0, 1) = 0;
  EXPECT_THROW(format_mesh(mesh, MeshFormat::ThreeMf), InvalidInput);
  EXPECT_THROW(parse_mesh("PK\x03\x04", "a.3mf"), FileError);
}

TEST(ThreeMf, ReadsBackWhatItWrites) {
  TriangleMesh mesh = tetrahedron();
  mesh.positions(1, 0) = 0.1;
  std::vector<std::string> warnings;
  const TriangleMesh back = parse_mesh(format_mesh(mesh, MeshFormat::ThreeMf), "a.3mf", &warnings);
  EXPECT_EQ(back.positions, mesh.positions);
  EXPECT_EQ(back.triangles, mesh.triangles);
  EXPECT_TRUE(warnings.empty());
}

/// A model of one triangle (0 0 0, 1 0 0, 0 2 0) as object 1.
std::string threemf_model(const std::string& unit, const std::string& more, const std::string& build) {
  return "<?xml version='1.0'?><!-- <vertex> --><m:model unit=\"" + unit +
         "\" xmlns:m='x'>\n<m:resources><m:object id='1'><m:mesh><m:vertices>"
         "<m:vertex x='0' y='0' z='0'/><m:vertex x='1' y='0' z='0'/><m:vertex x='0' y='2' z='0' />"
         "</m:vertices><m:triangles><m:triangle v1='0' v2='1' v3='2' "
         "p1='0'/></m:triangles></m:mesh></m:object>" +
         more + "</m:resources><m:build>" + build + "</m:build></m:model>";
}

// Item and component transforms act on rows, the inner one first: (1 0 0) → (0 1 0) by the component's
// quarter turn → (10 1 0) by the item. The mirror image is turned over, so that its normal stays +z.
TEST(ThreeMf, PutsObjectsIntoTheirPlacesInMetres) {
  const std::string model =
      threemf_model("inch",
                    "<object id='2'><components><component objectid='1' transform='0 1 0 -1 0 0 0 0 1 0 0 "
                    "0'/></components></object>"
                    "<object id='3'><mesh/></object>",
                    "<item objectid='2' transform='1 0 0 0 1 0 0 0 1 10 0 0'/>"
                    "<item objectid='1' transform='-1 0 0 0 1 0 0 0 1 0 0 0'/><item objectid='3'/>");
  std::vector<std::string> warnings;
  const TriangleMesh mesh = parse_mesh(format_archive({{"3D/3dmodel.model", model}}), "a.3mf", &warnings);
  ASSERT_EQ(mesh.n_triangles(), 2);
  const Points inches = mesh.positions / 0.0254;
  Points expected(6, 3);
  expected << 10, 0, 0, 10, 1, 0, 8, 0, 0, 0, 0, 0, -1, 0, 0, 0, 2, 0;
  EXPECT_LT((inches - expected).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(mesh.triangles, (Triangles(2, 3) << 0, 1, 2, 5, 4, 3).finished());
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("0.0254 m"), std::string::npos);
}

TEST(ThreeMf, FollowsPathsToOtherModels) {
  const std::string root =
      "<model><resources/><build><item objectid='1' p:path='/3D/Objects/a.model'/></build></model>";
  const auto archive = format_archive(
      {{"_rels/.rels",
        "<Relationships><Relationship Type='http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel' "
        "Target='/other/root.model'/></Relationships>"},
       {"other/root.model", root},
       {"3D/Objects/a.model", threemf_model("meter", "", "<item objectid='1'/>")}});
  const TriangleMesh mesh = parse_mesh(archive, "a.3mf");
  EXPECT_EQ(mesh.positions(2, 1), 0.002);  // millimetres, as the root does not say
  EXPECT_EQ(mesh.n_triangles(), 1) << "what another model would build is not asked for";
}

// 3MF Core Specification 1.3, 3.2.
TEST(ThreeMf, KnowsEveryUnit) {
  for (const auto& [unit, metres] :
       {std::pair{"micron", 1e-6}, std::pair{"millimeter", 1e-3}, std::pair{"centimeter", 1e-2},
        std::pair{"inch", 0.0254}, std::pair{"foot", 0.3048}, std::pair{"meter", 1.0}}) {
    const std::string model = threemf_model(unit, "", "<item objectid='1'/>");
    EXPECT_DOUBLE_EQ(parse_mesh(format_archive({{"3D/3dmodel.model", model}}), "a.3mf").positions(1, 0),
                     metres);
  }
}

TEST(ThreeMf, RefusesWhatIsDamaged) {
  const auto says = [](const std::string& model, const std::string& words) {
    try {
      parse_mesh(format_archive({{"3D/3dmodel.model", model}}), "a.3mf");
      ADD_FAILURE() << words;
    } catch (const FileError& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  };
  const std::string item = "<item objectid='1'/>";
  says(threemf_model("furlong", "", item), "furlong");
  says(threemf_model("inch", "", ""), "no items");
  says(threemf_model("inch", "", "<item objectid='7'/>"), "'7'");
  says(threemf_model("inch", "", "<item objectid='1' transform='1 0 0'/>"), "12 numbers");
  says(threemf_model("inch", "<object id='2'><component objectid='2'/></object>", "<item objectid='2'/>"),
       "contain each other");
  says(threemf_model("inch", "<object id='2'><triangle v1='0' v2='1' v3='2'/></object>", item), "vertex '0'");
  says(threemf_model("inch", "<object id='2'><vertex x='1' y='nan' z='0'/></object>", item), "number 'y'");
  says(threemf_model("inch", "<!-- ", item), "cut off");
}

}  // namespace
}  // namespace batten
