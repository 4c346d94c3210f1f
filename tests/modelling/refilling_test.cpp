#include <cmath>

#include <gtest/gtest.h>

#include "batten/mesh/normals.hpp"
#include "batten/modelling/refilling_detail.hpp"

namespace batten::detail {
namespace {

/// A sheet of n × n squares over [0, 1]², at the height of a function; its middle third is face 1, the rest
/// face 0.
struct Sheet {
  TriangleMesh mesh;
  std::vector<int> face;
  std::vector<char> on_crease;
};
template <typename Height>
Sheet sheet(int n, Height height) {
  Sheet sheet;
  sheet.mesh.positions.resize((n + 1) * (n + 1), 3);
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double x = static_cast<double>(i) / n, y = static_cast<double>(j) / n;
      sheet.mesh.positions.row(j * (n + 1) + i) << x, y, height(x, y);
    }
  sheet.mesh.triangles.resize(2 * n * n, 3);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int v = j * (n + 1) + i;
      sheet.mesh.triangles.row(2 * (j * n + i)) << v, v + 1, v + n + 2;
      sheet.mesh.triangles.row(2 * (j * n + i) + 1) << v, v + n + 2, v + n + 1;
      const bool middle = 3 * i >= n && 3 * i < 2 * n && 3 * j >= n && 3 * j < 2 * n;
      sheet.face.insert(sheet.face.end(), 2, middle);
    }
  sheet.mesh.normals = vertex_normals(sheet.mesh.positions, sheet.mesh.triangles);
  sheet.on_crease.assign(static_cast<size_t>(sheet.mesh.positions.rows()), 0);
  return sheet;
}

/// Vertices inside face 1 are thrown about.
void crumple(Sheet& crumpled, int n) {
  for (int j = n / 3 + 1; j < 2 * n / 3; ++j)
    for (int i = n / 3 + 1; i < 2 * n / 3; ++i)
      crumpled.mesh.positions.row(j * (n + 1) + i) +=
          Eigen::RowVector3d(0.3 * std::sin(7.0 * i), 0.3 * std::cos(5.0 * j), 0.4 * std::sin(3.0 * i + j));
}

// A plane is both a plate and a membrane; nothing outside moves, and a crumpled face comes back to it.
TEST(RefillFaces, GivesBackAPlane) {
  const int n = 24;
  for (const Refill how : {Refill::Plate, Refill::Membrane}) {
    const Sheet plane = sheet(n, [](double x, double y) { return 0.3 * x - 0.2 * y; });
    Sheet crumpled = plane;
    crumple(crumpled, n);
    refill_faces(crumpled.mesh, crumpled.face, {1}, crumpled.on_crease, how);
    EXPECT_LT((crumpled.mesh.positions.col(2) - 0.3 * crumpled.mesh.positions.col(0) +
               0.2 * crumpled.mesh.positions.col(1))
                  .cwiseAbs()
                  .maxCoeff(),
              1e-9);
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i)
        if (3 * i <= n || 3 * i >= 2 * n || 3 * j <= n || 3 * j >= 2 * n) {
          EXPECT_EQ(crumpled.mesh.positions.row(j * (n + 1) + i), plane.mesh.positions.row(j * (n + 1) + i));
        }
    const double cosine = (crumpled.mesh.normals * plane.mesh.normals.row(0).transpose()).minCoeff();
    EXPECT_GT(cosine, 1 - 1e-9);
  }
}

// Over a bowl z = x² + y² a plate leaves its outline as the bowl arrives there, a membrane does not: it is
// flatter in the middle, where the bowl is lowest.
TEST(RefillFaces, PlatesGoOnSmoothly) {
  const int n = 36;
  const auto bowl = [](double x, double y) { return (x - 0.5) * (x - 0.5) + (y - 0.5) * (y - 0.5); };
  Sheet plate = sheet(n, bowl), membrane = plate;
  const int middle = n / 2 * (n + 1) + n / 2;
  refill_faces(plate.mesh, plate.face, {1}, plate.on_crease, Refill::Plate);
  refill_faces(membrane.mesh, membrane.face, {1}, membrane.on_crease, Refill::Membrane);
  EXPECT_NEAR(plate.mesh.positions(middle, 2), 0, 0.004);
  EXPECT_GT(membrane.mesh.positions(middle, 2), 0.02);
}

}  // namespace
}  // namespace batten::detail
