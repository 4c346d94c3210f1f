#include "batten/implicit/stroke_field.hpp"

#include "implicit/strokes.hpp"
#include "sanitizers.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"
#include "batten/implicit/field_mesh.hpp"
#include "batten/mesh/adjacency.hpp"

namespace batten {
namespace {

TEST(StrokeSamples, AreEvenAndKnowTheirDirection) {
  CurveNetwork strokes;
  test::add_stroke(strokes, 7, [](double t) { return Eigen::Vector3d(t * t, 0, 0); });  // uneven points
  // An L: no direction at its corner.
  test::add_stroke(strokes, 2, [](double t) {
    return Eigen::Vector3d(std::min(2 * t, 1.0), std::max(0.0, 2 * t - 1), 1);
  });
  test::add_stroke(strokes, 2, [](double) { return Eigen::Vector3d(9, 9, 9); });  // a tap
  const StrokeSamples samples = stroke_samples(strokes, 0.1);
  ASSERT_EQ(samples.positions.rows(), 11 + 21);
  for (int i = 0; i <= 10; ++i) EXPECT_NEAR(samples.positions(i, 0), 0.1 * i, 1e-9);
  EXPECT_EQ(samples.directions.row(0).norm(), 0);  // an end
  EXPECT_NEAR(samples.directions(5, 0), 1, 1e-12);
  EXPECT_EQ(samples.directions.row(11 + 10).norm(), 0);  // the corner
  EXPECT_NEAR(samples.directions(11 + 15, 1), 1, 1e-12);
  EXPECT_EQ(samples.stroke[11], 1);
  EXPECT_THROW(stroke_samples(strokes, 0), InvalidInput);
}

TEST(FarthestPoints, SpreadOverThePoints) {
  Points line(101, 3);
  line.setZero();
  for (int i = 0; i <= 100; ++i) line(i, 0) = i;
  const std::vector<int> chosen = farthest_points(line, 5, 0);
  EXPECT_EQ(chosen, (std::vector<int>{0, 100, 50, 25, 75}));
  EXPECT_EQ(farthest_points(line, 1000, 20).size(), 5U);  // the next are 12.5 away
  EXPECT_TRUE(farthest_points(Points(0, 3), 4, 0).empty());
}

/// Arcs around a tube that is bent to a U, and two lines along it: what is between its legs is not drawn.
CurveNetwork u_strokes() {
  const auto middle = [](double t) {
    const double a = kPi * std::clamp((t - 0.3) / 0.4, 0.0, 1.0);
    const double leg = t < 0.3 ? 3 * (t - 0.3) : t > 0.7 ? 3 * (0.7 - t) : 0;
    return Eigen::Vector3d(-0.45 * std::cos(a), leg + 0.45 * std::sin(a), 0);
  };
  const auto tube = [&](double t, double angle) {
    const Eigen::Vector3d along = (middle(t + 1e-3) - middle(t - 1e-3)).normalized();
    const Eigen::Vector3d across(-along[1], along[0], 0);
    return Eigen::Vector3d(middle(t) +
                           0.3 * (std::cos(angle) * across + std::sin(angle) * Eigen::Vector3d::UnitZ()));
  };
  CurveNetwork strokes;
  for (const double angle : {1.0, 3.0})
    test::add_stroke(strokes, 60, [&](double s) { return tube(0.05 + 0.9 * s, angle); });
  for (int k = 0; k < 7; ++k)
    test::add_stroke(strokes, 40, [&](double s) { return tube(0.03 + 0.94 * k / 6, 0.9 * k + 1.8 * s); });
  return strokes;
}

// The smoothest field leaves a tunnel between them; filled, the strokes are met as well. The hole of a torus
// is a handle as well, and its strokes hold it.
TEST(StrokeField, HasHandlesOnlyWhereStrokesAskForThem) {
  StrokeFieldOptions options;
  options.most_sites = 100;
  const std::pair<CurveNetwork, int> cases[] = {{u_strokes(), 0}, {test::torus_strokes(), 1}};
  for (const auto& [strokes, genus] : cases) {
    const double diameter = bounding_box_diagonal(strokes.positions);
    const StrokeSamples samples = stroke_samples(strokes, 0.004 * diameter);
    const StrokeFieldResult result = stroke_field(samples, options);
    EXPECT_EQ(result.n_cuts, genus == 0 ? 1 : 0);
    EXPECT_LT(result.misfit_p95, 0.005);
    LevelSetOptions level;
    level.edge_length = 0.025 * diameter;
    const TriangleMesh mesh = field_mesh(result.field, samples, level);
    const MeshTopology topology = mesh_topology(mesh.triangles, mesh.n_vertices());
    EXPECT_TRUE(topology.is_watertight());
    EXPECT_EQ(topology.genus(), genus);
  }
}

/// f of strokes of the unit sphere, times a scale, is the distance from it.
TEST(StrokeField, OfStrokesOfASphereIsTheDistanceFromIt) {
  StrokeFieldOptions options;
  options.most_sites = test::repeated(200, 60);
  for (const double scale : {1.0, 1e-6}) {
    CurveNetwork strokes = test::sphere_strokes();
    strokes.positions *= scale;
    const StrokeSamples samples = stroke_samples(strokes, 0.02 * scale);
    const StrokeFieldResult result = stroke_field(samples, options);
    EXPECT_LE(result.n_sites, options.most_sites);
    EXPECT_LT(result.misfit_max, 0.003);
    Random random(8);
    for (int k = 0; k < 50; ++k) {
      const Eigen::Vector3d x = random.uniform(0.9, 1.1) * random.direction();
      Eigen::Vector3d gradient;
      EXPECT_NEAR(result.field.value(scale * x, gradient) / scale, x.norm() - 1, 0.03) << x.transpose();
      EXPECT_GT(gradient.normalized().dot(x.normalized()), 0.98);
    }
  }
}

TEST(StrokeField, RefusesWhatGoesAroundNothing) {
  CurveNetwork flat;
  for (int k = 0; k < 5; ++k)
    test::add_stroke(flat, 20, [&](double t) { return Eigen::Vector3d(t, 0.1 * k, 0); });
  const auto message = [](const CurveNetwork& strokes) -> std::string {
    try {
      stroke_field(stroke_samples(strokes, 0.05));
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return {};
  };
  EXPECT_NE(message(flat).find("in a plane"), std::string::npos);
  CurveNetwork dots;  // six short strokes without a direction
  for (int k = 0; k < 6; ++k)
    test::add_stroke(dots, 1,
                     [&](double t) { return Eigen::Vector3d(k % 2 + 1e-3 * t, (k / 2) % 2, k > 3 ? 1 : 0); });
  EXPECT_NE(message(dots).find("places with a direction"), std::string::npos);
  CurveNetwork point;
  test::add_stroke(point, 3, [](double) { return Eigen::Vector3d(1, 2, 3); });
  EXPECT_NE(message(point).find("one place"), std::string::npos);
  StrokeFieldOptions options;
  options.most_sites = 4;
  EXPECT_NE(options.problem()->find("most_sites"), std::string::npos);
  options = {};
  options.smoothing = -1;
  EXPECT_THROW(stroke_field(stroke_samples(test::sphere_strokes(), 0.1), options), InvalidInput);
}

}  // namespace
}  // namespace batten
