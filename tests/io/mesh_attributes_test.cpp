#include "batten/io/mesh_attributes.hpp"

#include "scratch.hpp"

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "batten/io/file.hpp"

namespace batten {
namespace {

/// Two squares in one plane: the first a quad, the second two triangles.
const char kLabelledObj[] =
    "mtllib paint.mtl\n"
    "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 1 1 1\nv 2 0 0 0.2 0.4 0.6\nv 2 1 0 0 0 0\n"
    "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.25 0.75\n"
    "o plate\ng left\nusemtl red paint\n"
    "f 1/1 2/2 3/3 4/4\n"
    "g right\nusemtl blue\nf 2/1 5/5 6/3\nusemtl red paint\nf 2 6 3\n";

const char kTypedPly[] =
    "ply\nformat ascii 1.0\ncomment TextureFile wood.png\nelement vertex 4\nproperty uchar blue\n"
    "property float x\nproperty float y\nproperty float z\nproperty short depth\nproperty int label\n"
    "element face 2\nproperty uchar part\nproperty list uchar int vertex_indices\nproperty float weight\n"
    "property list uchar float texcoord\nend_header\n"
    "1 0 0 0.5 -3 70000\n2 1 0 0 4 1\n3 1 1 0 5 2\n4 0 1 0 6 3\n"
    "7 3 0 1 2 0.25 6 0 0 1 0 1 1\n200 3 0 2 3 -1.5 0\n";

MeshFile parsed(const std::string& content, const std::string& name) {
  std::vector<std::string> warnings;
  MeshFile file = parse_mesh_file(content, name, &warnings);
  for (const std::string& warning : warnings)
    EXPECT_NE(warning.find("split into triangles"), std::string::npos) << warning;
  return file;
}

std::string label_of(const MeshAttributes::Labels& labels, int face) {
  const int word = labels.of_face.at(static_cast<std::size_t>(face));
  return word < 0 ? "" : labels.words.at(static_cast<std::size_t>(word));
}

void expect_same_obj(const MeshFile& file) {
  const MeshAttributes& a = file.attributes;
  ASSERT_EQ(file.mesh.n_triangles(), 4);
  for (int f = 0; f < 4; ++f) {
    EXPECT_EQ(label_of(a.objects, f), "plate");
    EXPECT_EQ(label_of(a.groups, f), f < 2 ? "left" : "right");
    EXPECT_EQ(label_of(a.materials, f), f == 2 ? "blue" : "red paint");
    for (int k = 0; k < 3; ++k) {
      const int t = a.texture_corners(f, k);
      if (f == 3) {
        EXPECT_EQ(t, -1);
        continue;
      }
      // On the first square texture and position are the same.
      const Eigen::RowVector2d expected =
          f < 2 ? Eigen::RowVector2d(file.mesh.positions.row(file.mesh.triangles(f, k)).head<2>())
                : Eigen::RowVector2d(k == 0   ? 0
                                     : k == 1 ? 0.25
                                              : 1,
                                     k == 0   ? 0
                                     : k == 1 ? 0.75
                                              : 1);
      EXPECT_EQ(a.texture.row(t), expected);
    }
  }
  EXPECT_EQ(a.libraries, std::vector<std::string>{"paint.mtl"});
  EXPECT_EQ(file.mesh.vertex_values.at("green")(4), 102);  // 0.4 · 255
}

TEST(MeshAttributes, ObjKeepsGroupsMaterialsTextureAndColours) {
  const MeshFile file = parsed(kLabelledObj, "a.obj");
  expect_same_obj(file);
  const std::string written = format_mesh_file(file, MeshFormat::Obj);
  expect_same_obj(parsed(written, "b.obj"));
  int changes = 0;  // red, blue and red again; what stays is not said again
  for (std::size_t at = written.find("usemtl"); at != std::string::npos; at = written.find("usemtl", at + 1))
    ++changes;
  EXPECT_EQ(changes, 3);
  EXPECT_TRUE(losses_in_format(file.attributes, MeshFormat::Obj).empty());
  EXPECT_EQ(losses_in_format(file.attributes, MeshFormat::Ply).size(), 1u);
  EXPECT_EQ(losses_in_format(file.attributes, MeshFormat::Stl).size(), 2u);
  // PLY takes over the texture coordinates, and OBJ takes them back.
  const MeshFile ply = parsed(format_mesh_file(file, MeshFormat::Ply), "a.ply");
  const MeshFile back = parsed(format_mesh_file(ply, MeshFormat::Obj), "c.obj");
  EXPECT_EQ(back.attributes.texture_corners.row(3).maxCoeff(), -1);
  EXPECT_EQ(back.attributes.texture.row(back.attributes.texture_corners(2, 1)),
            Eigen::RowVector2d(0.25, 0.75));
  // Who does not ask for them is told.
  std::vector<std::string> warnings;
  parse_mesh(kLabelledObj, "a.obj", &warnings);
  EXPECT_NE(warnings.back().find("5 texture coordinates were left out"), std::string::npos);
}

TEST(MeshAttributes, PlyKeepsTypesOrderAndValuesOfFaces) {
  MeshFile file = parsed(kTypedPly, "a.ply");
  for (const bool ascii : {true, false}) {
    MeshWriteOptions options;
    options.ascii = ascii;
    const std::string text = format_mesh_file(file, MeshFormat::Ply, options);
    EXPECT_NE(
        text.find("comment TextureFile wood.png\nelement vertex 4\nproperty uchar blue\nproperty float x\n"
                  "property float y\nproperty float z\nproperty short depth\nproperty int label\n"
                  "element face 2\nproperty list uchar int vertex_indices\nproperty uchar part\n"
                  "property float weight\nproperty list uchar double texcoord\n"),
        std::string::npos)
        << text;
    const MeshFile back = parsed(text, "b.ply");
    EXPECT_EQ(back.mesh.positions, file.mesh.positions);
    EXPECT_EQ(back.mesh.vertex_values, file.mesh.vertex_values);
    EXPECT_EQ(back.attributes.face_values, file.attributes.face_values);
    EXPECT_EQ(back.attributes.texture_corners, file.attributes.texture_corners);
    EXPECT_EQ(back.attributes.texture, file.attributes.texture);
    EXPECT_EQ(back.mesh.vertex_values.at("depth")(0), -3);
    EXPECT_EQ(back.attributes.face_values[0], Eigen::Vector2d(7, 200));
  }
  // What no longer fits its type is written as double, what does keeps it.
  file.mesh.positions(0, 0) = 0.1;
  file.mesh.vertex_values["depth"](1) = 40000;
  const std::string text = format_mesh_file(file, MeshFormat::Ply);
  EXPECT_NE(text.find("property double x\nproperty float y\nproperty float z\nproperty double depth\n"
                      "property int label\n"),
            std::string::npos);
  EXPECT_EQ(losses_in_format(file.attributes, MeshFormat::Obj).size(), 1u);
}

// The square cut the other way: its triangles have corners of both old ones, so labels go by where they lie
// and texture is lost; the part that is the same keeps it.
TEST(MeshAttributes, AreCarriedByPlace) {
  const MeshFile file = parsed(kLabelledObj, "a.obj");
  std::vector<std::string> dropped;
  EXPECT_EQ(carried_attributes(file, file.mesh, dropped).texture_corners, file.attributes.texture_corners);
  EXPECT_TRUE(dropped.empty());
  TriangleMesh turned = file.mesh;
  turned.triangles.row(2) << 1, 4, 2;
  turned.triangles.row(3) << 4, 5, 2;
  turned.triangles.row(0).swap(turned.triangles.row(1));
  const MeshAttributes carried = carried_attributes(file, turned, dropped);
  EXPECT_EQ(dropped.size(), 1u);
  EXPECT_NE(dropped[0].find("of 2 of 4"), std::string::npos);
  EXPECT_EQ(carried.texture_corners.row(0), file.attributes.texture_corners.row(1));
  EXPECT_EQ(label_of(carried.groups, 0), "left");
  EXPECT_EQ(label_of(carried.groups, 3), "right");
  // Where no triangle is as before, no texture is left.
  turned.triangles.row(0) << 0, 1, 2;
  turned.triangles.row(1) << 0, 2, 3;
  dropped.clear();
  EXPECT_EQ(carried_attributes(file, turned, dropped).texture_corners.rows(), 0);
  ASSERT_EQ(dropped.size(), 1u);
  EXPECT_NE(dropped[0].find("of 4 of 4"), std::string::npos);
}

TEST(MeshAttributes, LibrariesAreFoundFromAnotherFolder) {
  const std::string folder = test::scratch_file("attributes");
  std::filesystem::create_directories(folder + "/in");
  std::filesystem::create_directories(folder + "/out");
  write_file(folder + "/in/a.obj", kLabelledObj);
  const MeshFile file = read_mesh_file(folder + "/in/a.obj");
  for (const auto& [path, library] :
       {std::pair{"/in/b.obj", "paint.mtl"}, {"/out/b.obj", "../in/paint.mtl"}, {"/b.obj", "in/paint.mtl"}}) {
    write_mesh_file(folder + path, file);
    EXPECT_EQ(read_mesh_file(folder + path).attributes.libraries.at(0), library);
  }
  MeshFile fixed = file;  // a name from the root is the same everywhere
  fixed.attributes.libraries = {"/paints/paint.mtl"};
  write_mesh_file(folder + "/out/c.obj", fixed);
  EXPECT_EQ(read_mesh_file(folder + "/out/c.obj").attributes.libraries.at(0), "/paints/paint.mtl");
}

}  // namespace
}  // namespace batten
