#include "batten/surfacing/surface.hpp"

#include "network/sample_networks.hpp"

#include <algorithm>
#include <filesystem>
#include <numeric>
#include <ostream>
#include <set>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"
#include "batten/io/network_io.hpp"
#include "batten/linalg/sparse_cholesky.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/operators/intrinsic.hpp"

namespace batten {
namespace {

using samples::add_circle;
using samples::NetworkBuilder;
using samples::octahedral_sphere;
using samples::square_graph;
using Function = std::function<double(const Eigen::Vector3d&)>;

struct Distances {
  double mean = 0, max = 0;
};
/// Distances of the vertices to the surface f = 0, to first order |f|/|∇f|, in % of the diameter.
Distances distances(const TriangleMesh& mesh, const Function& f, double diameter) {
  Distances d;
  for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v) {
    const Eigen::Vector3d p = mesh.positions.row(v);
    Eigen::Vector3d gradient;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d e = 1e-6 * Eigen::Vector3d::Unit(k);
      gradient[k] = (f(p + e) - f(p - e)) / 2e-6;
    }
    const double distance = 100 * std::abs(f(p)) / gradient.norm() / diameter;
    d.mean += distance / static_cast<double>(mesh.n_vertices());
    d.max = std::max(d.max, distance);
  }
  return d;
}

long euler_characteristic(const TriangleMesh& mesh) {
  std::set<int> vertices(mesh.triangles.data(), mesh.triangles.data() + mesh.triangles.size());
  const std::vector<int> opposite = opposite_half_edges(mesh.triangles);
  long edges = 0;
  for (std::size_t h = 0; h < opposite.size(); ++h) edges += opposite[h] < static_cast<int>(h);
  return static_cast<long>(vertices.size()) - edges + static_cast<long>(mesh.n_triangles());
}

long border_edges(const TriangleMesh& mesh) {
  const std::vector<int> opposite = opposite_half_edges(mesh.triangles);
  return std::count(opposite.begin(), opposite.end(), -1);
}

void expect_sound(const SurfaceResult& surface) {
  EXPECT_EQ(surface.folded_triangles, 0);
  EXPECT_EQ(surface.degenerate_triangles, 0);
  EXPECT_TRUE(folded_triangles(surface.mesh.positions, surface.mesh.triangles, surface.mesh.normals).empty());
  EXPECT_TRUE(self_intersections(surface.mesh.positions, surface.mesh.triangles).empty());
}

// The surfaces are defined at the end of data/README.md. `target` is the mean distance in % of the diameter,
// half as much again as was measured; it is 2 to 30 times less than with normals of the least ∫|ΔN|².
struct ExactNetwork {
  const char* name;
  Function surface;
  double target;
  long euler;
};
void PrintTo(const ExactNetwork& test, std::ostream* out) {
  *out << test.name;
}
class SurfaceOfExactNetwork : public testing::TestWithParam<ExactNetwork> {};

TEST_P(SurfaceOfExactNetwork, LiesWithinTheTargetOfTheTrueSurfaceAndIsSound) {
  const ExactNetwork& test = GetParam();
  const std::string path = std::string(BATTEN_SHARED_DATA) + "/networks/" + test.name + ".net";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  const CurveNetwork network = read_network(path);
  const SurfaceResult surface = surface_network(network);
  EXPECT_LE(distances(surface.mesh, test.surface, bounding_box_diagonal(network.positions)).mean,
            test.target);
  expect_sound(surface);
  EXPECT_EQ(euler_characteristic(surface.mesh), test.euler);
  if (test.euler != 1) {
    EXPECT_EQ(border_edges(surface.mesh), 0);
  }
  EXPECT_EQ(surface.mesh.positions.topRows(network.positions.rows()), network.positions);
}

double sphere(const Eigen::Vector3d& p) {
  return p.norm() - 1;
}

INSTANTIATE_TEST_SUITE_P(
    Data, SurfaceOfExactNetwork,
    testing::Values(
        ExactNetwork{"sphere3", sphere, 0.0004, 2}, ExactNetwork{"sphere6", sphere, 0.0004, 2},
        ExactNetwork{"ellipsoid5",
                     [](const Eigen::Vector3d& p) {
                       return p.x() * p.x() / 2.25 + p.y() * p.y() + p.z() * p.z() / 0.49 - 1;
                     },
                     0.025, 2},
        ExactNetwork{"torus",
                     [](const Eigen::Vector3d& p) { return std::hypot(p.head<2>().norm() - 4, p.z()) - 2; },
                     0.0007, 0},
        ExactNetwork{"bumpycube",
                     [](const Eigen::Vector3d& p) {
                       return p.array().pow(4).sum() - 1 +
                              0.12 * std::cos(3 * p.x()) * std::cos(3 * p.y()) * std::cos(3 * p.z());
                     },
                     0.006, 2},
        ExactNetwork{"dish",
                     [](const Eigen::Vector3d& p) {
                       const double r = p.head<2>().norm(), a = std::atan2(p.y(), p.x());
                       return p.z() - 0.18 * std::cos(3 * a) * r * r * r - 0.12 * r * r;
                     },
                     0.0014, 1},
        ExactNetwork{"saddle",
                     [](const Eigen::Vector3d& p) { return p.z() - 0.35 * (p.x() * p.x() - p.y() * p.y()); },
                     0.0002, 1},
        ExactNetwork{"waves",
                     [](const Eigen::Vector3d& p) {
                       return p.z() - 0.12 * std::sin(3 * p.x()) * std::cos(2.5 * p.y()) -
                              0.2 * p.x() * p.x();
                     },
                     0.0048, 1}),
    [](const auto& instance) { return std::string(instance.param.name); });

// A sphere has constant mean curvature: the normals are exact in the limit, the curvature along edges exact
// on an inscribed mesh. The vertices must therefore lie far closer than the 0.008 % of that trial.
TEST(SurfaceNetwork, ReproducesASphere) {
  const CurveNetwork network = octahedral_sphere(18);
  const SurfaceResult surface = surface_network(network);
  EXPECT_LT(distances(surface.mesh, sphere, std::sqrt(12.0)).max, 0.01);
  expect_sound(surface);
  EXPECT_GE(surface.rebuilds, 1);
}

// A saddle over its outline and one cross, whose mean curvature changes evenly: 0.0009 % off, and 0.0045
// where the normals are of the least ∫|ΔN|².
TEST(SurfaceNetwork, LetsMeanCurvatureBend) {
  const auto saddle = [](double x, double y) { return 0.35 * (x * x - y * y); };
  const CurveNetwork network = square_graph(16, true, saddle);
  const SurfaceResult surface = surface_network(network);
  const auto off = [&](const Eigen::Vector3d& p) { return p.z() - saddle(p.x(), p.y()); };
  EXPECT_LT(distances(surface.mesh, off, bounding_box_diagonal(network.positions)).mean, 1.5e-3);
  expect_sound(surface);
}

// Without rebuilds this is the thesis's method; with them it must be ahead of it at every step.
TEST(SurfaceNetwork, IsAheadOfThePlainMethodAtEveryStep) {
  for (const int n : {9, 18, 36}) {
    const CurveNetwork network = octahedral_sphere(n);
    SurfaceOptions plain;
    plain.rebuilds = 0;
    const double without = distances(surface_network(network, plain).mesh, sphere, std::sqrt(12.0)).mean;
    EXPECT_LT(distances(surface_network(network).mesh, sphere, std::sqrt(12.0)).mean, 0.2 * without) << n;
  }
}

TEST(SurfaceNetwork, FillsAPlaneWithAPlane) {
  const auto plane = [](double x, double y) { return 0.3 * x - 0.2 * y + 1; };
  for (const SurfaceMethod method :
       {SurfaceMethod::Curvature, SurfaceMethod::Harmonic, SurfaceMethod::Biharmonic,
        SurfaceMethod::Triharmonic, SurfaceMethod::BiharmonicNormals}) {
    SurfaceOptions options;
    options.method = method;
    const SurfaceResult surface = surface_network(square_graph(8, true, plane), options);
    for (Eigen::Index v = 0; v < surface.mesh.n_vertices(); ++v) {
      const Eigen::RowVector3d p = surface.mesh.positions.row(v);
      EXPECT_NEAR(p.z(), plane(p.x(), p.y()), 1e-7) << "method " << static_cast<int>(method);
    }
    EXPECT_EQ(surface.folded_triangles, 0);
  }
}

// S 4.6.3 and figs. 4.12, 4.22: without normals the sphere sinks in between the curves.
TEST(SurfaceNetwork, BeatsItsBaselinesOnASphere) {
  const CurveNetwork network = octahedral_sphere(12);
  const double ours = distances(surface_network(network).mesh, sphere, std::sqrt(12.0)).mean;
  double previous = 1e9;
  for (const SurfaceMethod method :
       {SurfaceMethod::Harmonic, SurfaceMethod::BiharmonicNormals, SurfaceMethod::Biharmonic}) {
    SurfaceOptions options;
    options.method = method;
    const double baseline = distances(surface_network(network, options).mesh, sphere, std::sqrt(12.0)).mean;
    EXPECT_GT(baseline, 10 * ours);
    EXPECT_LT(baseline, previous);
    previous = baseline;
  }
}

// Fig. 4.11: the other two maps make valid meshes; after the rebuilds the sphere is as good as by the plane.
TEST(SurfaceNetwork, FillsPatchesByAllThreeMaps) {
  for (const PatchMap map : {PatchMap::Circle, PatchMap::Polygon}) {
    SurfaceOptions options;
    options.map = map;
    const SurfaceResult surface = surface_network(octahedral_sphere(12), options);
    EXPECT_LT(distances(surface.mesh, sphere, std::sqrt(12.0)).mean, 0.01);
    expect_sound(surface);
  }
}

/// Radius at half height of the tube between two circles whose normals are tilted outwards by `tilt` radians.
double waist(double tilt) {
  NetworkBuilder builder;
  add_circle(builder, 60, 1, 0, -tilt, true);
  add_circle(builder, 60, 1, 2, tilt, true);
  const SurfaceResult surface = surface_network(builder.build());
  expect_sound(surface);
  EXPECT_EQ(euler_characteristic(surface.mesh), 0);
  double sum = 0;
  int count = 0;
  for (Eigen::Index v = 0; v < surface.mesh.n_vertices(); ++v)
    if (std::abs(surface.mesh.positions(v, 2) - 1) < 0.1) {
      sum += surface.mesh.positions.row(v).head<2>().norm();
      ++count;
    }
  return sum / count;
}

// S fig. 4.18. The cylinder is exact; a barrel with rims tilted by 0.5 bulges, a bottleneck narrows by a like
// amount: an arc of half width 1 with slope tan 0.5 at its ends has the height 0.26.
TEST(SurfaceNetwork, FollowsTheNormalsOfTwoCircles) {
  EXPECT_NEAR(waist(0), 1, 2e-4);
  EXPECT_NEAR(waist(0.5), 1.26, 0.05);
  EXPECT_NEAR(waist(-0.5), 0.72, 0.06);
}

// Positions and normals with 5 % noise (fig. 4.15): soft constraints come nearer to the sphere than hard
// ones.
TEST(SurfaceNetwork, IsSmootherWithSoftConstraintsOnNoisyCurves) {
  CurveNetwork network = octahedral_sphere(20);
  Random random(3);
  for (Eigen::Index v = 0; v < network.positions.rows(); ++v) {
    network.positions.row(v) += 0.01 * random.normal3().transpose();
    network.normals.row(v) = (network.normals.row(v) + 0.05 * random.normal3().transpose()).normalized();
  }
  SurfaceOptions soft;
  soft.soft_constraints = true;
  const double hard = distances(surface_network(network).mesh, sphere, std::sqrt(12.0)).mean;
  const double smooth = distances(surface_network(network, soft).mesh, sphere, std::sqrt(12.0)).mean;
  EXPECT_LT(smooth, 0.9 * hard);
  EXPECT_LT(smooth, 0.3);  // the noise itself is 0.23 % along the normal
}

// A very large weight leaves nothing soft.
TEST(SurfaceNetwork, TendsToHardConstraintsAsTheWeightGrows) {
  const CurveNetwork network =
      square_graph(8, true, [](double x, double y) { return 0.3 * x * x - 0.2 * x * y; });
  SurfaceOptions soft, hard;
  soft.soft_constraints = true;
  soft.soft_weight = 1e9;
  soft.rebuilds = hard.rebuilds = 0;
  EXPECT_LT(
      (surface_network(network, soft).mesh.positions - surface_network(network, hard).mesh.positions).norm(),
      1e-3);
}

CurveNetwork test_network() {
  return square_graph(10, true, [](double x, double y) { return 0.2 * std::sin(2 * x) + 0.3 * x * y * y; });
}

CurveNetwork moved(CurveNetwork network, const Eigen::Matrix3d& R, double scale,
                   const Eigen::RowVector3d& t) {
  network.positions = (scale * (network.positions * R.transpose())).rowwise() + t;
  network.normals = network.normals * R.transpose();
  return network;
}

/// Largest distance from a vertex of one mesh to the nearest vertex of the other.
double farthest(const Points& a, const Points& b) {
  double far = 0;
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    far = std::max(far, (b.rowwise() - a.row(i)).rowwise().norm().minCoeff());
  return far;
}

// Translation and scale change nothing but rounding: the plane layouts are rounded to a grid of 1e-9.
TEST(SurfaceNetwork, MovesWithTranslationAndScale) {
  for (const CurveNetwork& network : {test_network(), octahedral_sphere(8)}) {
    const SurfaceResult a = surface_network(network);
    for (const double scale : {1e-3, 1.0, 1e3}) {
      const Eigen::RowVector3d t = scale * Eigen::RowVector3d(3.1, -17.3, 8.7);
      const SurfaceResult b = surface_network(moved(network, Eigen::Matrix3d::Identity(), scale, t));
      ASSERT_EQ(a.mesh.triangles, b.mesh.triangles) << scale;
      const Points back = (b.mesh.positions.rowwise() - t) / scale;
      EXPECT_LT((back - a.mesh.positions).rowwise().norm().maxCoeff(), 1e-8) << scale;
    }
  }
}

TEST(SurfaceNetwork, DoesNotDependOnTheOrderOfCurvesAndVertices) {
  for (const CurveNetwork& network : {test_network(), octahedral_sphere(8)}) {
    CurveNetwork other = network;
    const auto n = static_cast<int>(network.positions.rows());
    std::vector<int> place(n);
    std::iota(place.begin(), place.end(), 0);
    Random random(5);
    for (int i = n - 1; i > 0; --i)
      std::swap(place[i], place[random.below(static_cast<std::uint64_t>(i) + 1)]);
    for (int v = 0; v < n; ++v) {
      other.positions.row(place[v]) = network.positions.row(v);
      other.normals.row(place[v]) = network.normals.row(v);
    }
    for (NetworkCurve& curve : other.curves)
      for (int& v : curve.vertices) v = place[v];
    std::reverse(other.curves.begin(), other.curves.end());
    const SurfaceResult a = surface_network(network), b = surface_network(other);
    ASSERT_EQ(a.mesh.n_vertices(), b.mesh.n_vertices());
    EXPECT_LT(farthest(a.mesh.positions, b.mesh.positions), 1e-8);
  }
}

// The plane of a patch and the axes in it come from the patch alone, so that a turned network gets the very
// same triangles, and a mirrored one the same surface.
TEST(SurfaceNetwork, IsNearlyTheSameForRotatedMirroredAndReversedInput) {
  const CurveNetwork network = test_network();
  const double diameter = bounding_box_diagonal(network.positions);
  const SurfaceResult a = surface_network(network);
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -0.5).normalized()).toRotationMatrix();
  const SurfaceResult rotated = surface_network(moved(network, R, 1, Eigen::RowVector3d::Zero()));
  ASSERT_EQ(rotated.mesh.n_vertices(), a.mesh.n_vertices());
  EXPECT_LT(farthest(rotated.mesh.positions * R, a.mesh.positions), 1e-7 * diameter);
  const SurfaceResult mirrored = surface_network([&] {
    CurveNetwork image =
        network;  // a mirror turns the surface inside out, so its normals point the other way
    image.positions.col(0) *= -1;
    image.normals.col(0) *= -1;
    return image;
  }());
  Points back = mirrored.mesh.positions;
  back.col(0) *= -1;
  ASSERT_EQ(back.rows(), a.mesh.n_vertices());
  EXPECT_LT(farthest(back, a.mesh.positions), 1e-7 * diameter);
  CurveNetwork reversed = network;
  for (NetworkCurve& curve : reversed.curves) std::reverse(curve.vertices.begin(), curve.vertices.end());
  EXPECT_LT(farthest(surface_network(reversed).mesh.positions, a.mesh.positions), 1e-8);
}

// Moving nothing changes nothing, a moved network is followed, and moving back returns.
TEST(SurfaceSolver, FollowsItsCurvesAndReturns) {
  const CurveNetwork network = test_network();
  SurfaceSolver solver(network);
  const TriangleMesh built = solver.result().mesh;
  const SurfaceMove nothing = solver.move(network.positions, network.normals);
  EXPECT_EQ(nothing.patches_solved, 0);
  EXPECT_TRUE(nothing.positions.empty());
  EXPECT_TRUE(nothing.normals.empty());
  EXPECT_EQ(solver.result().mesh.positions, built.positions);
  Points lifted = network.positions;
  lifted.col(2).array() += 0.5;
  Points expected = built.positions;
  expected.col(2).array() += 0.5;
  solver.move(lifted, network.normals);
  EXPECT_LT(farthest(solver.result().mesh.positions, expected), 1e-9);
  solver.move(network.positions, network.normals);
  EXPECT_EQ(solver.result().mesh.positions, built.positions);
  EXPECT_EQ(solver.result().mesh.normals, built.normals);
  lifted(3, 1) = std::nan("");
  EXPECT_THROW(solver.move(lifted, network.normals), InvalidInput);
  EXPECT_THROW(solver.move(Points::Zero(2, 3), Points::Zero(2, 3)), InvalidInput);
  EXPECT_EQ(solver.result().mesh.positions, built.positions);
}

// A helical ramp of more than a full turn: its outline covers itself in every plane projection.
TEST(SurfaceNetwork, TriangulatesInSpaceWhereEveryProjectionFoldsOver) {
  NetworkBuilder builder;
  const auto ramp = [](double r, double t) {
    const double a = 2.6 * kPi * t;
    return Eigen::Vector3d(r * std::cos(a), r * std::sin(a), 0.35 * a);
  };
  const auto normal = [](const Eigen::Vector3d& p) {
    // Helicoid: cross product of the radial and the winding direction.
    const Eigen::Vector3d radial = Eigen::Vector3d(p.x(), p.y(), 0).normalized();
    return Eigen::Vector3d(radial.cross(Eigen::Vector3d(-p.y(), p.x(), 0.35)));
  };
  builder.curve(
      60, true, [&](double t) { return ramp(0.5, t); }, normal);
  builder.curve(
      120, true, [&](double t) { return ramp(1.2, t); }, normal);
  builder.curve(
      10, true, [&](double t) { return ramp(0.5 + 0.7 * t, 0); }, normal);
  builder.curve(
      10, true, [&](double t) { return ramp(0.5 + 0.7 * t, 1); }, normal);
  const CurveNetwork network = builder.build();
  const SurfaceResult surface = surface_network(network);
  EXPECT_EQ(surface.patches_in_space, 1);
  ASSERT_FALSE(surface.warnings.empty());
  EXPECT_NE(surface.warnings.front().find("patch 0"), std::string::npos);
  EXPECT_EQ(euler_characteristic(surface.mesh), 1);
  expect_sound(surface);
  // The helicoid z = 0.35 atan2(y, x) (mod a turn) is a minimal surface: within half a percent of it.
  for (Eigen::Index v = 0; v < surface.mesh.n_vertices(); ++v) {
    const Eigen::RowVector3d p = surface.mesh.positions.row(v);
    EXPECT_NEAR(std::remainder(p.z() / 0.35 - std::atan2(p.y(), p.x()), 2 * kPi), 0, 0.05);
  }
}

TEST(SurfaceNetwork, NamesWhatIsWrongWithTheInput) {
  const auto error_of = [](const CurveNetwork& network, const SurfaceOptions& options = {}) -> std::string {
    try {
      surface_network(network, options);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(error_of(CurveNetwork{}).find("no curves"), std::string::npos);
  CurveNetwork network = test_network();
  network.normals.resize(0, 3);
  EXPECT_NE(error_of(network).find("no normals"), std::string::npos);
  network = test_network();
  network.positions(7, 0) = std::numeric_limits<double>::infinity();
  EXPECT_NE(error_of(network).find("vertex 7"), std::string::npos);
  network = test_network();
  network.positions.row(30) = network.positions.row(2);
  EXPECT_NE(error_of(network).find("the vertices 2 "), std::string::npos) << error_of(network);
  SurfaceOptions options;
  options.base_order = 4;
  EXPECT_NE(error_of(test_network(), options).find("base_order"), std::string::npos);
  options = {};
  options.soft_weight = -1;
  EXPECT_NE(error_of(test_network(), options).find("soft_weight"), std::string::npos);
}

TEST(SurfaceNetwork, StopsWhenAskedTo) {
  const Progress stop([](std::string_view, double) { return false; });
  EXPECT_THROW(surface_network(test_network(), {}, stop), Cancelled);
}

// S fig. 3.14: the reference of the thesis's method, border rows left out and one rebuild, is 2.4 % mean and
// 12 % max from the mesh that the three curves were traced on; lilium.net lies on it after this translation
// (README).
TEST(SurfaceNetwork, FillsLiliumWithoutFolds) {
  const std::string folder = std::string(BATTEN_SHARED_DATA) + "/curves/";
  if (!std::filesystem::exists(folder + "lilium.net")) GTEST_SKIP() << folder << "lilium.net is not there";
  const CurveNetwork network = read_network(folder + "lilium.net");
  const SurfaceResult surface = surface_network(network);
  expect_sound(surface);
  EXPECT_EQ(surface.n_cycles, 4);
  EXPECT_EQ(euler_characteristic(surface.mesh), 1);
}

}  // namespace
}  // namespace batten
