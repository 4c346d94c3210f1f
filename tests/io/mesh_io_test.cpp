#include "batten/io/mesh_io.hpp"

#include "io/bad_files.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/core/text.hpp"
#include "batten/io/file.hpp"

namespace batten {
namespace {

using namespace test;

namespace fs = std::filesystem;

/// A random closed-looking fan with normals and values: numbers with all their bits used.
TriangleMesh random_mesh(double scale = 1) {
  Random random(11);
  TriangleMesh mesh;
  mesh.positions.resize(7, 3);
  mesh.normals.resize(7, 3);
  mesh.vertex_values["quality"] = Eigen::VectorXd(7);
  for (int v = 0; v < 7; ++v) {
    mesh.positions.row(v) = scale * random.normal3().transpose();
    mesh.normals.row(v) = random.direction().transpose();
    mesh.vertex_values["quality"](v) = random.normal();
  }
  mesh.triangles.resize(6, 3);
  for (int f = 0; f < 6; ++f) mesh.triangles.row(f) << 0, f + 1, (f + 1) % 6 + 1;
  return mesh;
}

TriangleMesh through(const TriangleMesh& mesh, MeshFormat format, const std::string& name,
                     bool ascii = false) {
  MeshWriteOptions options;
  options.ascii = ascii;
  std::vector<std::string> warnings;
  TriangleMesh back = parse_mesh(format_mesh(mesh, format, options), name, &warnings);
  EXPECT_TRUE(warnings.empty()) << warnings.front();
  return back;
}

// The writers promise numbers that read back exactly, at any scale; STL stores no sharing, normals or values.
TEST(MeshIo, EveryFormatReadsBackBitForBitWhatItCanHold) {
  for (const double scale : {1.0, 1e-3, 1e3, 1e-200}) {
    const TriangleMesh mesh = random_mesh(scale);
    for (const bool ascii : {false, true}) {
      const TriangleMesh ply = through(mesh, MeshFormat::Ply, "a.ply", ascii);
      EXPECT_EQ(ply.positions, mesh.positions);
      EXPECT_EQ(ply.normals, mesh.normals);
      EXPECT_EQ(ply.triangles, mesh.triangles);
      ASSERT_EQ(ply.vertex_values.size(), 1u);
      EXPECT_EQ(ply.vertex_values.at("quality"), mesh.vertex_values.at("quality"));
    }
    for (const auto& [format, name] :
         {std::pair{MeshFormat::Obj, "a.obj"}, std::pair{MeshFormat::Off, "a.off"}}) {
      const TriangleMesh back = through(mesh, format, name);
      EXPECT_EQ(back.positions, mesh.positions);
      EXPECT_EQ(back.normals, mesh.normals);
      EXPECT_EQ(back.triangles, mesh.triangles);
    }
    const TriangleMesh stl = through(mesh, MeshFormat::Stl, "a.stl", true);
    ASSERT_EQ(stl.n_triangles(), mesh.n_triangles());
    EXPECT_EQ(stl.n_vertices(), mesh.n_vertices());
    for (int f = 0; f < 6; ++f)
      for (int k = 0; k < 3; ++k)
        EXPECT_EQ(stl.positions.row(stl.triangles(f, k)), mesh.positions.row(mesh.triangles(f, k)));
  }
}

// A float has 24 bits, so single precision errs by at most 2^-24 of each coordinate.
TEST(MeshIo, BinaryStlErrsByTheRoundingOfSinglePrecisionOnly) {
  const TriangleMesh mesh = random_mesh();
  const TriangleMesh back = through(mesh, MeshFormat::Stl, "a.stl");
  ASSERT_EQ(back.n_triangles(), 6);
  for (int f = 0; f < 6; ++f)
    for (int k = 0; k < 3; ++k)
      for (int axis = 0; axis < 3; ++axis) {
        const double exact = mesh.positions(mesh.triangles(f, k), axis);
        EXPECT_NEAR(back.positions(back.triangles(f, k), axis), exact, std::abs(exact) * std::pow(2.0, -24));
      }
}

TEST(MeshIo, LossesAreNamedBeforeTheyHappen) {
  const TriangleMesh mesh = random_mesh();
  EXPECT_TRUE(losses_in_format(mesh, MeshFormat::Ply).empty());
  ASSERT_EQ(losses_in_format(mesh, MeshFormat::Obj).size(), 1u);
  EXPECT_NE(losses_in_format(mesh, MeshFormat::Obj)[0].find("quality"), std::string::npos);
  EXPECT_EQ(losses_in_format(mesh, MeshFormat::Stl).size(), 3u);
}

/// A PLY file of one triangle and one unknown element, written here byte by byte in the given order.
std::string hand_made_ply(bool big) {
  std::string bytes =
      concat("ply\r\nformat binary_", big ? "big" : "little",
             "_endian 1.0\r\ncomment by hand\r\nelement camera 1\r\nproperty list ushort short view\r\n"
             "element vertex 3\r\nproperty float x\r\nproperty double y\r\nproperty short z\r\n"
             "property uchar red\r\nelement face 1\r\nproperty float area\r\n"
             "property list uint ushort vertex_index\r\nend_header\r\n");
  const auto put = [&](auto value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);  // the tests run on little-endian machines
    if (big) std::reverse(raw, raw + sizeof value);
    bytes.append(raw, sizeof value);
  };
  put(std::uint16_t{2}), put(std::int16_t{-1}), put(std::int16_t{7});
  for (int v = 0; v < 3; ++v)
    put(0.25f * static_cast<float>(v)), put(v * v / 3.0), put(static_cast<std::int16_t>(-300 * v)),
        put(static_cast<std::uint8_t>(200 + v));
  put(1.5f), put(std::uint32_t{3});
  for (const int v : {0, 1, 2}) put(static_cast<std::uint16_t>(v));
  return bytes;
}

// Other programs look for bytes. What bytes cannot hold exactly stays as it is: fractions, and values of 0
// and 1 that may be fractions.
TEST(MeshIo, PlyWritesColoursAsBytesWhereTheyAre) {
  TriangleMesh mesh = random_mesh();
  const auto set = [&](const std::string& name, double step) {
    mesh.vertex_values[name] = step * Eigen::VectorXd::LinSpaced(7, 0, 6);
  };
  set("red", 42), set("green", 1), set("blue", 0), set("alpha", 1 / 6.0), set("label", 3);
  for (const bool ascii : {false, true}) {
    MeshWriteOptions options;
    options.ascii = ascii;
    const std::string text = format_mesh(mesh, MeshFormat::Ply, options);
    EXPECT_NE(text.find("property uchar red\nproperty uchar green\nproperty uchar blue\n"
                        "property double alpha\nproperty double label\n"),
              std::string::npos);
    EXPECT_EQ(through(mesh, MeshFormat::Ply, "a.ply", ascii).vertex_values, mesh.vertex_values);
  }
  for (const auto& [most, type] : {std::pair{255.0, "uchar"}, {256.0, "double"}, {1.0, "double"}}) {
    mesh.vertex_values["red"] = Eigen::VectorXd::Zero(7);
    mesh.vertex_values["red"](3) = most;
    EXPECT_NE(format_mesh(mesh, MeshFormat::Ply).find(std::string("property ") + type + " red\n"),
              std::string::npos)
        << most;
  }
}

TEST(MeshIo, PlyReadsBothByteOrdersAndSkipsWhatItDoesNotKnow) {
  for (const bool big : {false, true}) {
    std::vector<std::string> warnings;
    const TriangleMesh mesh = parse_mesh(hand_made_ply(big), "a.ply", &warnings);
    ASSERT_EQ(mesh.n_vertices(), 3);
    EXPECT_EQ(mesh.positions(2, 0), 0.5);
    EXPECT_EQ(mesh.positions(2, 1), 4 / 3.0);
    EXPECT_EQ(mesh.positions(2, 2), -600);
    EXPECT_EQ(mesh.vertex_values.at("red")(1), 201);
    EXPECT_EQ(mesh.triangles, (Triangles(1, 3) << 0, 1, 2).finished());
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_NE(warnings[0].find("camera"), std::string::npos);
  }
}

TEST(MeshIo, ObjTakesEveryFormOfACorner) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0 # a comment\nv 0 1 0\nvt 0 0\nvn 0 0 2\n";
  for (const char* face :
       {"f 1 2 3", "f 1/1 2/1 3/1", "f 1//1 2//1 3//1", "f 1/1/1 2/1/1 3/1/1", "f -4 -3 -2", "f 1 \\\n2 3"}) {
    const TriangleMesh mesh = parse_mesh(vertices + face + "\n", "a.obj");
    EXPECT_EQ(mesh.triangles, (Triangles(1, 3) << 0, 1, 2).finished()) << face;
  }
  const TriangleMesh quad = parse_mesh(vertices + "f 1//1 2//1 3//1 4//1", "a.obj");
  EXPECT_EQ(quad.n_triangles(), 2);
  EXPECT_EQ(quad.normals, (Points(4, 3) << 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1).finished());
}

// The second corner of the second face carries another normal than the first face gave it.
TEST(MeshIo, ObjTellsWhenNormalsDifferAtAVertex) {
  std::vector<std::string> warnings;
  const TriangleMesh mesh = parse_mesh(
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1\nvn 0 0 1\nvn 1 0 0\nf 1//1 2//1 3//1\nf 1//1 3//2 4//2\n", "a.obj",
      &warnings);
  EXPECT_EQ(mesh.normals.rows(), 0);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("differ"), std::string::npos);
}

TEST(MeshIo, OffKnowsItsKeywordsCommentsAndColours) {
  const char* plain =
      "OFF 3 1 0 # counts on the first line\n0 0 0\n# between\n1 0 0\n\n0 1 0 \n3 0 1 2 255 0 0\n";
  const char* coloured = "COFF\n3 1 3\n0 0 0 1 1 1 1\n1 0 0 1 1 1 1\n0 1 0 1 1 1 1\n3 0 1 2\n";
  const char* normals = "NOFF\n3 1 3\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n";
  // The normal stands before the colour, whichever letter comes first.
  const char* both = "CNOFF\n3 1 3\n0 0 0 0 0 1 9 9 9 9\n1 0 0 0 0 1 9 9 9 9\n0 1 0 0 0 1 9 9 9 9\n3 0 1 2\n";
  for (const char* text : {plain, coloured, normals, both, "3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"}) {
    const TriangleMesh mesh = parse_mesh(text, "a.off");
    EXPECT_EQ(mesh.positions, (Points(3, 3) << 0, 0, 0, 1, 0, 0, 0, 1, 0).finished()) << text;
    EXPECT_EQ(mesh.n_triangles(), 1);
    ASSERT_EQ(mesh.normals.rows(), text == normals || text == both ? 3 : 0);
    if (mesh.normals.rows() > 0) {
      EXPECT_EQ(mesh.normals.row(2), Eigen::RowVector3d(0, 0, 1));
    }
  }
}

TEST(MeshIo, StlMergesVerticesOfTheSameBitsAndMinusZero) {
  const TriangleMesh mesh = parse_mesh(
      "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
      "facet normal 0 0 1\nouter loop\nvertex 1 -0.0 0\nvertex 1 1 0\nvertex 0 1 "
      "0\nendloop\nendfacet\nendsolid a\n",
      "a.stl");
  EXPECT_EQ(mesh.n_vertices(), 4);
  EXPECT_EQ(mesh.n_triangles(), 2);
}

// Capitals, line ends of two characters, names with blanks and bytes behind the last facet: all seen in files
// that programs export. Whole facets behind the number announced are no such bytes: one of the two is wrong.
TEST(MeshIo, StlIsReadAsProgramsExportIt) {
  const TriangleMesh mesh = random_mesh();
  MeshWriteOptions text_options;
  text_options.ascii = true;
  const std::string text = format_mesh(mesh, MeshFormat::Stl, text_options);
  std::string capitals;
  for (const char c : text) {
    if (c == '\n') capitals += '\r';
    capitals += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  capitals.replace(0, capitals.find('\r'), "SOLID THING WITH SPACES");
  const TriangleMesh loud = parse_mesh(capitals, "a.stl"), plain = parse_mesh(text, "a.stl");
  EXPECT_EQ(loud.positions, plain.positions);
  EXPECT_EQ(loud.triangles, plain.triangles);
  const std::string binary = format_mesh(mesh, MeshFormat::Stl);
  for (const std::size_t behind : {1, 7, 49, 51, 128}) {
    const TriangleMesh back = parse_mesh(binary + std::string(behind, '\1'), "a.stl");
    EXPECT_EQ(back.positions, parse_mesh(binary, "a.stl").positions) << behind;
    EXPECT_EQ(back.n_triangles(), mesh.n_triangles()) << behind;
  }
  for (const std::size_t behind : {50, 100})
    EXPECT_THROW(parse_mesh(binary + std::string(behind, '\1'), "a.stl"), FileError) << behind;
}

TEST(MeshIo, ContentDecidesWhereTheExtensionLies) {
  std::vector<std::string> warnings;
  const TriangleMesh mesh = parse_mesh(format_mesh(random_mesh(), MeshFormat::Ply), "liar.obj", &warnings);
  EXPECT_EQ(mesh.n_vertices(), 7);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("PLY"), std::string::npos);
}

TEST(MeshIo, NormalsWithoutADirectionComeFromTheFaces) {
  std::vector<std::string> warnings;
  const TriangleMesh mesh = parse_mesh(
      "NOFF\n4 1 0\n0 0 0 0 0 0\n1 0 0 0 0 3\n0 1 0 0 0 1\n5 5 5 0 0 0\n3 0 1 2\n", "a.off", &warnings);
  EXPECT_EQ(mesh.normals, (Points(4, 3) << 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1).finished());
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("vertex 0"), std::string::npos);
}

class BadMesh : public testing::TestWithParam<BadFile> {};

TEST_P(BadMesh, IsRefusedWithFileLineAndReason) {
  const BadFile& bad = GetParam();
  expect_refused([&] { parse_mesh(bad.content, bad.name); }, bad.name, bad.line, bad.word);
}

const std::string kPly =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
const std::string kVertices = "0 0 0\n1 0 0\n0 1 0\n";

INSTANTIATE_TEST_SUITE_P(
    Files, BadMesh,
    testing::Values(
        BadFile{"a.ply", "", 0, "empty"}, BadFile{"a.obj", "", 0, "empty"}, BadFile{"a.off", "", 0, "empty"},
        BadFile{"a.stl", "", 0, "empty"}, BadFile{"a.xyz", "1 2 3\n", 0, "not recognised"},
        BadFile{"a.ply", kGarbage, 1, "header"}, BadFile{"a.obj", kGarbage, 1, "not a text"},
        BadFile{"a.off", kGarbage, 1, "not a text"}, BadFile{"a.stl", kGarbage, 0, "too short"},
        // PLY
        BadFile{"a.ply", "ply\nformat ascii 1.0\nelement vertex 3\n", 4, "end_header"},
        BadFile{"a.ply", "ply\nformat ebcdic 1.0\nend_header\n", 2, "expected 'format"},
        BadFile{"a.ply", "ply\nformat ascii 1.0\nelement vertex -3\nend_header\n", 3, "at least 0"},
        BadFile{"a.ply", "ply\nformat ascii 1.0\nproperty float x\nend_header\n", 3,
                "before the first element"},
        BadFile{"a.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty quad x\nend_header\n", 4,
                "types"},
        BadFile{"a.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nend_header\n1\n2\n3\n",
                0, "property 'y'"},
        BadFile{"a.ply", kPly + "0 0 0\n1 0 0\n", 0, "truncated"},
        BadFile{"a.ply", kPly + "0 0 0\n1 0 0\n0 1 nan\n3 0 1 2\n", 12, "not finite"},
        BadFile{"a.ply", kPly + "0 0 0\n1 0\n0 1 0\n3 0 1 2\n", 11, "too few"},
        BadFile{"a.ply", kPly + "0 0 0\n1 0 zero\n0 1 0\n3 0 1 2\n", 11, "no number"},
        BadFile{"a.ply", kPly + kVertices + "3 0 1 3\n", 13, "expected 0 to 2"},
        BadFile{"a.ply", kPly + kVertices + "3 0 1 -1\n", 13, "expected 0 to 2"},
        BadFile{"a.ply", kPly + kVertices + "3 0 1 1.5\n", 13, "expected 0 to 2"},
        BadFile{"a.ply", kPly + kVertices + "99999999 0 1 2\n", 13, "longer than"},
        BadFile{"a.ply", kPly + kVertices + "-3 0 1 2\n", 13, "at least 0"},
        BadFile{"a.ply", kPly + kVertices + "3 0 1 2\n3 2 1 0\n", 14, "more lines"},
        BadFile{"a.ply",
                "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000000\nproperty float "
                "x\nproperty float y\nproperty float z\nend_header\n0123456789",
                0, "truncated"},
        BadFile{"a.ply", hand_made_ply(false).substr(0, hand_made_ply(false).size() - 1), 0, "longer than"},
        BadFile{"a.ply", hand_made_ply(true).substr(0, hand_made_ply(true).size() - 30), 0, "truncated"},
        // OBJ
        BadFile{"a.obj", "# nothing\n", 0, "no vertices"}, BadFile{"a.obj", "v 0 0 0\nv 1 0\n", 2, "missing"},
        BadFile{"a.obj", "v 0 0 0\nv 1 0 inf\n", 2, "not finite"},
        BadFile{"a.obj", "v 0 0 0\nv 1 0 x\n", 2, "number"},
        BadFile{"a.obj", "v 0 0 0\nf 1 2 3\nv 1 1 1\n", 2, "vertex 3"},
        BadFile{"a.obj", "v 0 0 0\nf 1 1 0\n", 2, "out of range"},
        BadFile{"a.obj", "v 0 0 0\nf 1 1 -2\n", 2, "out of range"},
        BadFile{"a.obj", "v 0 0 0\nf 1 1 99999999999\n", 2, "out of range"},
        BadFile{"a.obj", "v 0 0 0\nf a b c\n", 2, "no integer"},
        BadFile{"a.obj", "v 0 0 0\nf 1//5 1//5 1//5\n", 2, "normal 5"},
        BadFile{"a.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n", 3, "curve network"},
        BadFile{"a.obj", "{\"a\": 1}\n", 1, "no OBJ statement"},
        // OFF
        BadFile{"a.off", "4OFF\n3 1 0\n", 1, "keyword"}, BadFile{"a.off", "OFF BINARY\n3 1 0\n", 1, "binary"},
        BadFile{"a.off", "OFF\n", 1, "counts"}, BadFile{"a.off", "OFF\n3 x 0\n", 2, "faces"},
        BadFile{"a.off", "OFF\n3 1 0\n" + kVertices, 5, "face 0"},
        BadFile{"a.off", "OFF\n2000000 1 0\n" + kVertices, 2, "do not fit"},
        BadFile{"a.off", "OFF\n3 1 0\n" + kVertices + "3 0 1 3\n", 6, "expected 0 to 2"},
        BadFile{"a.off", "OFF\n3 1 0\n" + kVertices + "4 0 1 2\n", 6, "missing"},
        BadFile{"a.off", "OFF\n3 1 0\n" + kVertices + "3 0 1 2\n3 0 1 2\n", 7, "more lines"},
        BadFile{"a.off", "OFF\n3 1 0\n0 0 0\n1 NaN 0\n0 1 0\n3 0 1 2\n", 4, "not finite"},
        // STL
        BadFile{"a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", 4, "truncated"},
        BadFile{"a.stl", "solid a\nouter loop\nvertex 0 0\n", 3, "missing"},
        BadFile{"a.stl", "solid a\nvertex 0 0 0\n", 2, "outside"},
        BadFile{"a.stl", "solid a\nhello\n", 2, "expected solid"},
        BadFile{"a.stl", "solid a\nouter loop\nvertex 0 0 0\nendloop\n", 4, "expected 3"},
        BadFile{"a.stl", std::string(80, ' ') + std::string("\x05\0\0\0", 4) + std::string(60, 'x'), 0,
                "announces 5"}));

TEST(MeshIo, AMissingFileIsNamed) {
  EXPECT_THROW(read_mesh("no/such/file.ply"), FileError);
  EXPECT_THROW(write_mesh("no/such/folder/file.ply", random_mesh()), FileError);
  EXPECT_THROW(write_mesh("mesh.docx", random_mesh()), FileError);
}

TEST(MeshIo, ArraysThatDoNotFitAreNotWritten) {
  TriangleMesh mesh = random_mesh();
  mesh.triangles(3, 1) = 7;
  EXPECT_THROW(format_mesh(mesh, MeshFormat::Obj), InvalidInput);
  mesh = random_mesh();
  mesh.normals.conservativeResize(6, 3);
  EXPECT_THROW(format_mesh(mesh, MeshFormat::Ply), InvalidInput);
}

// Counts from the table of the public data.
TEST(MeshIo, ReadsThePublicMeshes) {
  if (!fs::exists(kSharedData)) GTEST_SKIP() << "the public data is not at " << kSharedData;
  struct Known {
    const char* file;
    long vertices, triangles;
    bool normals;
  };
  for (const Known& known :
       {Known{"meshes/bunny.off", 3485, 6966, false}, Known{"meshes/cubehole.off.gz", 10752, 21504, false},
        Known{"meshes/igea.ply.gz", 134345, 268686, false},
        Known{"meshes/many_small_holes.ply", 2004, 3524, false}, Known{"meshes/snail.obj", 871, -1, false},
        Known{"denoise/fandisk_0.3_original.obj", 6475, 12946, true},
        Known{"curves/onmesh_torus.obj", 1728, 3456, false}}) {
    const TriangleMesh mesh = read_mesh(kSharedData + "/" + known.file);
    EXPECT_EQ(mesh.n_vertices(), known.vertices) << known.file;
    if (known.triangles >= 0) {
      EXPECT_EQ(mesh.n_triangles(), known.triangles) << known.file;
    }
    EXPECT_EQ(mesh.normals.rows(), known.normals ? known.vertices : 0) << known.file;
    if (known.normals) {
      EXPECT_LT((mesh.normals.rowwise().norm().array() - 1).abs().maxCoeff(), 1e-12) << known.file;
    }
  }
  EXPECT_EQ(read_mesh(kSharedData + "/meshes/many_small_holes.ply").vertex_values.count("quality"), 1u);
}

}  // namespace
}  // namespace batten
