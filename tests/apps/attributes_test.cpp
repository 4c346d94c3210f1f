#include "apps/run_batten.hpp"
#include "mesh/shapes.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/io/mesh_attributes.hpp"

namespace batten::test {
namespace {

/// A square of 12 × 12 cells, labelled left and right of x = 1/2, with colours, a heat of 4 x, and texture
/// coordinates (x, y).
MeshFile labelled_square() {
  MeshFile file;
  file.mesh = fixtures::as_mesh(
      fixtures::grid(12, 12, false, false, [](double u, double v) { return Eigen::Vector3d(u, v, 0); }));
  const Points& X = file.mesh.positions;
  const Triangles& T = file.mesh.triangles;
  file.mesh.vertex_values["red"] = (255 * X.col(0)).array().round();
  file.mesh.vertex_values["green"] = Eigen::VectorXd::Constant(X.rows(), 40);
  file.mesh.vertex_values["blue"] = Eigen::VectorXd::Constant(X.rows(), 250);
  file.mesh.vertex_values["heat"] = 4 * X.col(0);
  MeshAttributes& a = file.attributes;
  a.groups.words = {"left", "right"};
  a.materials.words = {"oak", "elm"};
  a.libraries = {"wood.mtl"};
  a.face_properties = {{"part", "ushort"}};
  a.face_values = {Eigen::VectorXd(T.rows())};
  for (Eigen::Index f = 0; f < T.rows(); ++f) {
    const int side = X(T(f, 0), 0) + X(T(f, 1), 0) + X(T(f, 2), 0) > 1.5 ? 1 : 0;
    a.groups.of_face.push_back(side);
    a.materials.of_face.push_back(side);
    a.face_values[0](f) = 300 + side;
  }
  a.texture = X.leftCols(2);
  a.texture_corners = T;
  return file;
}

bool is_left(const TriangleMesh& mesh, Eigen::Index f, double margin, bool& is_clear) {
  const double x = (mesh.positions(mesh.triangles(f, 0), 0) + mesh.positions(mesh.triangles(f, 1), 0) +
                    mesh.positions(mesh.triangles(f, 2), 0)) /
                   3;
  is_clear = std::abs(x - 0.5) > margin;
  return x < 0.5;
}

/// Every face away from the line between has its group, material or part; every vertex its colour and heat.
void expect_labelled(const MeshFile& file, bool is_obj, const std::string& how) {
  ASSERT_GT(file.mesh.n_triangles(), 20) << how;
  for (Eigen::Index f = 0; f < file.mesh.n_triangles(); ++f) {
    bool is_clear = false;
    const bool left = is_left(file.mesh, f, 0.05, is_clear);
    if (!is_clear) continue;
    const MeshAttributes& a = file.attributes;
    const auto word = [&](const MeshAttributes::Labels& labels) {
      return labels.words.at(static_cast<std::size_t>(labels.of_face.at(static_cast<std::size_t>(f))));
    };
    if (is_obj) {
      EXPECT_EQ(word(a.groups), left ? "left" : "right") << how;
      EXPECT_EQ(word(a.materials), left ? "oak" : "elm") << how;
    } else {
      EXPECT_EQ(a.face_values.at(0)(f), left ? 300 : 301) << how;
      EXPECT_EQ(a.face_properties.at(0).type, "ushort") << how;
    }
  }
  for (Eigen::Index v = 0; v < file.mesh.n_vertices(); ++v) {
    EXPECT_NEAR(file.mesh.vertex_values.at("red")(v), 255 * file.mesh.positions(v, 0), 1.5) << how;
    EXPECT_EQ(file.mesh.vertex_values.at("blue")(v), 250) << how;
    if (!is_obj) {
      EXPECT_NEAR(file.mesh.vertex_values.at("heat")(v), 4 * file.mesh.positions(v, 0), 1e-3) << how;
    }
  }
}

TEST(Attributes, LiveOnThroughEveryCommand) {
  MeshFile input = labelled_square();
  input.attributes.folder = scratch();
  write_mesh_file(scratch_file("in.obj"), input);
  write_mesh_file(scratch_file("in.ply"), input);
  write_file("still.json", R"({"fixed": {"box": [[-1, -1, -1], [0.2, 2, 1]]},
      "handles": [{"select": {"box": [[0.8, -1, -1], [2, 2, 1]]}, "translate": [0, 0, 0]}]})");
  const struct {
    const char* command;
    bool keeps_faces;
  } kCommands[] = {{"fair in.@ -o out.@ --noise 0", true},
                   {"deform in.@ -o out.@ --handles still.json", true},
                   {"convert in.@ out.@", true},
                   {"compare in.@ in.@ --distances out.@", true},
                   {"repair in.@ -o out.@", true},
                   {"fair in.@ -o out.@ --noise 0 --repair", true},
                   {"simplify in.@ -o out.@ --remove 50% --keep-border exact", false},
                   {"remesh in.@ -o out.@ --edge 0.11", false}};
  for (const auto& [command, keeps_faces] : kCommands)
    for (const std::string extension : {"obj", "ply"}) {
      if (extension == "obj" && std::string(command).rfind("compare", 0) == 0) continue;  // writes PLY only
      std::string line;
      for (const char* c = command; *c != 0; ++c) line += *c == '@' ? extension : std::string(1, *c);
      const auto run = run_batten(line);
      ASSERT_EQ(run.exit_code, 0) << line << run.err;
      const MeshFile out = read_mesh_file(scratch_file("out." + extension));
      expect_labelled(out, extension == "obj", line);
      if (extension == "obj") {
        EXPECT_EQ(out.attributes.libraries, input.attributes.libraries);
      }
      if (!keeps_faces) {
        EXPECT_NE(run.err.find("texture coordinates of"), std::string::npos) << run.err;
        continue;
      }
      ASSERT_EQ(out.attributes.texture_corners.rows(), input.mesh.n_triangles()) << line;
      for (Eigen::Index c = 0; c < 3 * out.mesh.n_triangles(); ++c) {
        const Eigen::RowVector2d uv = out.attributes.texture.row(out.attributes.texture_corners.data()[c]),
                                 xy = out.mesh.positions.row(out.mesh.triangles.data()[c]).leftCols(2);
        EXPECT_LT((uv - xy).norm(), 1e-6) << line;
      }
    }
  // What the other format cannot hold is said in one line each.
  const auto run = run_batten("convert in.obj out.ply");
  EXPECT_NE(run.err.find("objects, groups and materials are dropped"), std::string::npos) << run.err;
  EXPECT_NE(run_batten("fair in.ply -o out.obj").err.find("values per face (part) are dropped"),
            std::string::npos);
}

}  // namespace
}  // namespace batten::test
