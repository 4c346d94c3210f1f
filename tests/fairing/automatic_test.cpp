#include "batten/fairing/automatic.hpp"

#include "fairing/shapes.hpp"
#include "report_gaps.hpp"
#include "sanitizers.hpp"
#include "threads.hpp"

#include <filesystem>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/progress.hpp"
#include "batten/fairing/noise.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/mesh/areas.hpp"
#include "batten/mesh/self_intersections.hpp"

namespace batten {
namespace {

using fixtures::closed_sphere;
using fixtures::cube;
using fixtures::Mesh;
using fixtures::normal_error_deg;

// The true normals are those of the clean mesh; the noise alone turns them by some 20°. A cube is the easiest
// sharp shape, a sphere the easiest round one: well below what the peers leave on parts (2°) and on organic
// shapes (6°) at this noise.
TEST(FairAutomatically, BringsBackCubesAndSpheres) {
  AutomaticFairingReport report;
  Mesh mesh = cube(24);
  Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.2, 1);
  Points faired = fair_automatically(noisy, mesh.triangles, {}, &report);
  EXPECT_GT(normal_error_deg(noisy, mesh.positions, mesh.triangles), 15);
  EXPECT_LT(normal_error_deg(faired, mesh.positions, mesh.triangles), 1.5);
  EXPECT_EQ(report.strategy, FairingStrategy::Sharp);
  EXPECT_NEAR(report.noise, 0.2, 0.02);

  mesh = closed_sphere(24);
  noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.2, 1);
  faired = fair_automatically(noisy, mesh.triangles);
  EXPECT_LT(normal_error_deg(faired, mesh.positions, mesh.triangles), 4.0);
}

TEST(FairAutomatically, KeepsTheVolumeOfClosedMeshes) {
  const Mesh mesh = cube(16);
  const Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.3, 4);
  const Points faired = fair_automatically(noisy, mesh.triangles);
  EXPECT_NEAR(enclosed_volume(faired, mesh.triangles) / enclosed_volume(noisy, mesh.triangles), 1, 1e-6);
}

TEST(FairAutomatically, LeavesCleanMeshesAlone) {
  for (const Mesh& mesh : {cube(16), closed_sphere(16)}) {
    AutomaticFairingReport report;
    EXPECT_EQ(fair_automatically(mesh.positions, mesh.triangles, {}, &report), mesh.positions);
    EXPECT_EQ(report.strategy, FairingStrategy::None);
  }
}

// Noise that shape can look like by its size alone. Its own errors of 1.3 to 3.3 degrees must not stay;
// without it the same meshes are left alone (above).
TEST(FairAutomatically, RemovesFaintNoise) {
  for (const double level : {0.02, 0.05})
    for (const Mesh& mesh : {cube(16), closed_sphere(16)}) {
      const Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, level, 31);
      AutomaticFairingReport report;
      const Points faired = fair_automatically(noisy, mesh.triangles, {}, &report);
      EXPECT_LT(normal_error_deg(faired, mesh.positions, mesh.triangles),
                0.4 * normal_error_deg(noisy, mesh.positions, mesh.triangles))
          << level << ' ' << mesh.positions.rows();
      EXPECT_NEAR(report.noise, level, 0.2 * level);
      EXPECT_EQ(report.significance, 1);
    }
}

// Moving, turning and scaling the input moves, turns and scales the result: only rounding differs, in the
// single precision of the weights. Here and there it may flip which strategy a vertex takes, hence the second
// bound.
TEST(FairAutomatically, FollowsRigidMotionsAndScale) {
  const Mesh mesh = cube(12);
  const Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.2, 9);
  const Points faired = fair_automatically(noisy, mesh.triangles);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  for (const double scale : {1e-3, 1e3}) {
    const auto moved = [&](const Points& points) {
      return Points((scale * points * turn.transpose()).rowwise() + scale * Eigen::RowVector3d(5, -7, 2));
    };
    const Points again = fair_automatically(moved(noisy), mesh.triangles);
    const Eigen::VectorXd difference = (again - moved(faired)).rowwise().norm() / scale;
    EXPECT_LT(difference.mean(), 3e-4);
    EXPECT_LT(difference.maxCoeff(), 0.02);
  }
}

TEST(FairAutomatically, GivesTheSameResultTwice) {
  const Mesh mesh = cube(12);
  const Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.2, 9);
  EXPECT_EQ(fair_automatically(noisy, mesh.triangles), fair_automatically(noisy, mesh.triangles));
}

TEST(FairAutomatically, KeepsTheBorderWhenAsked) {
  const Mesh mesh = fixtures::sheet(20, 20, 1, 1);
  const Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.2, 2);
  AutomaticFairingOptions options;
  options.keep_boundary = true;
  const Points faired = fair_automatically(noisy, mesh.triangles, options);
  for (int i = 0; i <= 20; ++i)
    for (const int v : {i, 20 * 21 + i, i * 21, i * 21 + 20}) EXPECT_EQ(faired.row(v), noisy.row(v));
  EXPECT_LT(normal_error_deg(faired, mesh.positions, mesh.triangles),
            0.5 * normal_error_deg(noisy, mesh.positions, mesh.triangles));
}

TEST(FairAutomatically, CanBeCancelled) {
  const Mesh mesh = cube(8);
  const Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.2, 2);
  int calls = 0;
  const Progress stop([&](std::string_view, double) { return ++calls < 5; });
  EXPECT_THROW(fair_automatically(noisy, mesh.triangles, {}, nullptr, stop), Cancelled);
  EXPECT_EQ(calls, 5);
}

TEST(FairAutomatically, NamesWhatIsWrongWithBadInput) {
  Mesh mesh = cube(4);
  const Points good = mesh.positions;
  mesh.positions(7, 1) = std::nan("");
  try {
    fair_automatically(mesh.positions, mesh.triangles);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("vertex 7"), std::string::npos) << error.what();
  }
  Triangles bad = mesh.triangles;
  bad(3, 0) = 4000;
  EXPECT_THROW(fair_automatically(good, bad), InvalidInput);
  bad = mesh.triangles;
  std::swap(bad(5, 0), bad(5, 1));  // one triangle inside out
  EXPECT_THROW(fair_automatically(good, bad), InvalidInput);
  AutomaticFairingOptions options;
  options.iterations = -1;
  EXPECT_THROW(fair_automatically(good, mesh.triangles, options), InvalidInput);
  EXPECT_EQ(fair_automatically(Points(0, 3), Triangles(0, 3)).rows(), 0);
}

/// What the best default of all peers reaches, per noise of 0.1, 0.2, 0.3 mean edges (mean angle in degrees).
struct Peers {
  const char* file;
  double best_default[3];
};

class FairAutomaticallyOnMeshes : public testing::TestWithParam<Peers> {};

// Same noise model as the peers were measured with; see docs/fair.md for the figures reached.
TEST_P(FairAutomaticallyOnMeshes, BeatsTheBestDefaultOfThePeersAtEveryLevelOfNoise) {
  const Peers peers = GetParam();
  const std::string path = std::string(BATTEN_SHARED_DATA) + "/meshes/" + peers.file;
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing";
  const TriangleMesh mesh = read_mesh(path);
  if (test::kSanitized && mesh.n_vertices() > 8000) GTEST_SKIP() << "too slow under the sanitizers";
  const Points clean_result = fair_automatically(mesh.positions, mesh.triangles);
  EXPECT_LE(normal_error_deg(clean_result, mesh.positions, mesh.triangles), 0.2);
  for (int i = 0; i < 3; ++i) {
    const Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.1 * (i + 1), 20 + i);
    const Points faired = fair_automatically(noisy, mesh.triangles);
    EXPECT_LT(normal_error_deg(faired, mesh.positions, mesh.triangles), peers.best_default[i])
        << peers.file << " noise " << 0.1 * (i + 1);
    EXPECT_NEAR(enclosed_volume(faired, mesh.triangles) / enclosed_volume(noisy, mesh.triangles), 1, 1e-3);
    EXPECT_LE(self_intersections(faired, mesh.triangles).size(),
              self_intersections(noisy, mesh.triangles).size())
        << peers.file << " noise " << 0.1 * (i + 1);
  }
}

INSTANTIATE_TEST_SUITE_P(Fairing, FairAutomaticallyOnMeshes,
                         testing::Values(Peers{"fandisk.obj", {1.47, 2.08, 2.89}},
                                         Peers{"cubehole.off.gz", {0.35, 0.98, 1.76}},
                                         Peers{"rocker-arm.obj", {5.49, 7.02, 8.90}},
                                         Peers{"bunny_34835.off.gz", {4.57, 6.20, 6.56}}),
                         [](const testing::TestParamInfo<Peers>& peers) {
                           const std::string file = peers.param.file;
                           std::string name;
                           for (const char c : file.substr(0, file.find('.')))
                             if (std::isalnum(static_cast<unsigned char>(c)) != 0) name += c;
                           return name;
                         });

// Meshes as they come, whatever their triangles: scans, parts, coarse organic shapes. None has noise.
TEST(FairAutomatically, LeavesMeshesAsTheyComeAlone) {
  int found = 0;
  for (const char* file :
       {"bunny.off", "cow.off", "camelhead.off", "casting.off", "cheburashka.off", "greek_helmet.obj",
        "lilium.obj", "mechpart_coarse.obj", "snail.obj", "wingnut.obj"}) {
    const std::string path = std::string(BATTEN_SHARED_DATA) + "/meshes/" + file;
    if (!std::filesystem::exists(path)) continue;
    ++found;
    const TriangleMesh mesh = read_mesh(path);
    EXPECT_EQ(fair_automatically(mesh.positions, mesh.triangles), mesh.positions) << file;
  }
  if (found == 0) GTEST_SKIP() << BATTEN_SHARED_DATA "/meshes has none of the meshes";
}

// At a noise of 0.03 edges, less than half of the error it makes is left (0.13 to 0.43 of it).
TEST(FairAutomatically, RemovesFaintNoiseFromPartsAndScans) {
  int found = 0;
  for (const char* file : {"wingnut.obj", "lilium.obj", "snail.obj"}) {
    const std::string path = std::string(BATTEN_SHARED_DATA) + "/meshes/" + file;
    if (!std::filesystem::exists(path)) continue;
    ++found;
    const TriangleMesh mesh = read_mesh(path);
    const Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.03, 7);
    EXPECT_LT(normal_error_deg(fair_automatically(noisy, mesh.triangles), mesh.positions, mesh.triangles),
              0.5 * normal_error_deg(noisy, mesh.positions, mesh.triangles))
        << file;
  }
  if (found == 0) GTEST_SKIP() << BATTEN_SHARED_DATA "/meshes has none of the meshes";
}

// Most vertices lie on edges, which the first estimate takes for noise; what the fit removes denies it.
TEST(FairAutomatically, LeavesPartsOfFewTrianglesAlone) {
  for (const int n : {1, 2, 4, 6}) {
    const Mesh mesh = cube(n);
    AutomaticFairingReport report;
    EXPECT_EQ(fair_automatically(mesh.positions, mesh.triangles, {}, &report), mesh.positions) << n;
    EXPECT_EQ(report.significance, 0);
  }
}

// Triangles of very different size: measured by moves instead of by turned normals, the sharp strategy looks
// better here by chance (this seed) and leaves half as much again.
TEST(FairAutomatically, KnowsAnOrganicShapeOfIrregularTrianglesUnderStrongNoise) {
  const std::string path = std::string(BATTEN_SHARED_DATA) + "/meshes/rocker-arm.obj";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing";
  const TriangleMesh mesh = read_mesh(path);
  const Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.3, 103);
  AutomaticFairingReport report;
  const Points faired = fair_automatically(noisy, mesh.triangles, {}, &report);
  EXPECT_EQ(report.strategy, FairingStrategy::Organic);
  EXPECT_LT(normal_error_deg(faired, mesh.positions, mesh.triangles), 7.08);  // the best tuned peer
}

// A third of the vertices moved by half an edge; guided filtering reaches 3.84° on such a pair.
TEST(FairAutomatically, RemovesImpulsiveNoise) {
  const std::string path = std::string(BATTEN_SHARED_DATA) + "/meshes/fandisk.obj";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing";
  const TriangleMesh mesh = read_mesh(path);
  for (const ImpulseKind kind :
       {ImpulseKind::AlongNormal, ImpulseKind::NormalGaussian, ImpulseKind::RandomDirection}) {
    const Points noisy = add_impulsive_noise(mesh.positions, mesh.triangles, 1.0 / 3, 0.5, kind, 6);
    const Points faired = fair_automatically(noisy, mesh.triangles);
    EXPECT_LT(normal_error_deg(faired, mesh.positions, mesh.triangles), 2.8) << static_cast<int>(kind);
  }
}

// Vertices that noise moves within a flat face bend nothing but fold triangles over, 180° each, which no
// filter of normals can mend: the true normals are those of the clean cube.
TEST(FairAutomatically, TurnsBackFoldedTriangles) {
  const Mesh mesh = cube(20);
  const Points noisy =
      add_impulsive_noise(mesh.positions, mesh.triangles, 1.0 / 3, 0.6, ImpulseKind::RandomDirection, 4);
  const auto share_folded = [&](const Points& points) {
    const Points truth = face_normals(mesh.positions, mesh.triangles),
                 normals = face_normals(points, mesh.triangles);
    return (truth.cwiseProduct(normals).rowwise().sum().array() < 0).cast<double>().mean();
  };
  const Points faired = fair_automatically(noisy, mesh.triangles);
  EXPECT_GT(share_folded(noisy), 0.008);
  EXPECT_LT(share_folded(faired), 0.1 * share_folded(noisy));
}

// A mesh of 10,000 vertices takes some 0.8 s, one of 100,000 ten times that, in the same shares: 100 ms there
// are 1.2 %, and a tenth of the work leaves room for what a loaded machine does to a single measurement.
TEST(FairAutomatically, ReportsOftenAndStopsWhereItIsTold) {
  const Mesh mesh = cube(40);
  const Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.2, 1);
  const test::Threads one_thread(1);  // all the work is on the thread whose time is measured
  const test::ReportGaps gaps(
      [&](const Progress& progress) { fair_automatically(noisy, mesh.triangles, {}, nullptr, progress); });
  EXPECT_LT(gaps.largest_share(), 0.1) << "before " << gaps.before();
  EXPECT_GT(gaps.reports(), 200);
  for (const int stop_at : {1, 10, gaps.reports() / 2, gaps.reports()}) {
    int reports = 0;
    const Progress stop([&](std::string_view, double) { return ++reports < stop_at; });
    EXPECT_THROW(fair_automatically(noisy, mesh.triangles, {}, nullptr, stop), Cancelled) << stop_at;
    EXPECT_EQ(reports, stop_at);
  }
}

TEST(FairAutomatically, GivesTheSameBitsOnAnyNumberOfThreads) {
  const Mesh mesh = cube(32);
  const Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.2, 1);
  const auto faired = [&](int threads) {
    const test::Threads here(threads);
    return fair_automatically(noisy, mesh.triangles);
  };
  const Points one = faired(1);
  for (const int threads : {2, 3}) EXPECT_EQ(faired(threads), one) << threads;
}

TEST(FairAutomatically, SaysHowFarItsSolvesCame) {
  const Mesh mesh = cube(16);
  const Points noisy = add_gaussian_noise(mesh.positions, mesh.triangles, 0.2, 1);
  AutomaticFairingReport report;
  fair_automatically(noisy, mesh.triangles, {}, &report);
  EXPECT_EQ(report.solves.unconverged, 0);
  EXPECT_GT(report.solves.residual, 0);
  EXPECT_LE(report.solves.residual, 1e-3);  // the looser of the two tolerances
}

}  // namespace
}  // namespace batten
