#include "batten/engine/saved_file.hpp"

#include <memory>
#include <string>
#include <variant>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/engine/opened_file.hpp"

namespace batten {
namespace {

Content triangle() {
  TriangleMesh mesh;
  mesh.positions.resize(3, 3);
  mesh.positions << 0, 0, 0, 2, 0, 0, 0, 3, 0;
  mesh.triangles.resize(1, 3);
  mesh.triangles << 0, 1, 2;
  mesh.normals.resize(0, 3);
  return std::make_shared<const TriangleMesh>(mesh);
}

TEST(SavedFile, ReadsBackInEveryFormatThatItOffers) {
  for (const std::string& format : formats_of(ObjectKind::Mesh)) {
    const SavedFile file = save_file(triangle(), format, "m");
    const OpenedFile read = open_file(file.bytes, "triangle." + format);
    ASSERT_EQ(kind_of(read.content), ObjectKind::Mesh) << format;
    const TriangleMesh& mesh = *std::get<SharedMesh>(read.content);
    EXPECT_EQ(mesh.n_triangles(), 1) << format;
    EXPECT_NEAR(mesh.positions.maxCoeff(), 3, 1e-5) << format;
  }
}

TEST(SavedFile, WritesLengthsInTheUnitOfTheFormat) {
  // glTF is in metres: 3 mm are 0.003.
  const SavedFile file = save_file(triangle(), "glb", "mm");
  const OpenedFile read = open_file(file.bytes, "triangle.glb");
  EXPECT_NEAR(std::get<SharedMesh>(read.content)->positions.maxCoeff(), 0.003, 1e-8);
}

TEST(SavedFile, NamesTheFormatsWhereThisIsNone) {
  try {
    save_file(triangle(), "rawnet", "");
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_STREQ(error.what(),
                 "a mesh cannot be saved as 'rawnet'; it can be saved as ply, obj, stl, 3mf, glb, off");
  }
  EXPECT_THROW(save_file(ViewState{}, "ply", ""), InvalidInput);
}

}  // namespace
}  // namespace batten
