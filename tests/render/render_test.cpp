#include "batten/render/render.hpp"

#include "mesh/shapes.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"

namespace batten {
namespace {

/// Three great circles of the unit sphere with outward normals, n edges each, sharing their six crossings.
CurveNetwork great_circles(int n) {
  CurveNetwork network;
  network.positions.resize(3 * n, 3);
  for (int c = 0; c < 3; ++c) {
    NetworkCurve curve;
    for (int i = 0; i <= n; ++i) {
      Eigen::Vector3d p = Eigen::Vector3d::Zero();
      p[c] = std::cos(2 * kPi * i / n);
      p[(c + 1) % 3] = std::sin(2 * kPi * i / n);
      if (i < n) network.positions.row(c * n + i) = p;
      curve.vertices.push_back(c * n + i % n);
    }
    network.curves.push_back(curve);
  }
  network.normals = network.positions;
  return network;
}

RenderOptions small(Shading shading) {
  RenderOptions options;
  options.shading = shading;
  options.width = 200;
  options.height = 160;
  options.view.perspective = false;
  return options;
}

/// Share of the pixels that differ from the background of their row (taken at its left end).
double covered(const Image& image) {
  int n = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const std::uint8_t* p = image.at(x, y);
      const std::uint8_t* q = image.at(0, y);
      if (p[0] != q[0] || p[1] != q[1] || p[2] != q[2]) ++n;
    }
  return n / static_cast<double>(image.width) / image.height;
}

// In parallel projection the unit sphere fills the frame: a disc of diameter height − 2 · 5 % of it. Pixels
// that are covered in part count whole, half a pixel around the circumference on average; the facets lose 0.1
// %.
TEST(Render, SilhouetteOfASphereIsADiscOfTheRightArea) {
  const TriangleMesh mesh = fixtures::as_mesh(fixtures::sphere(40));
  for (const View view : {View{-55, 28, false}, View{0, 90, false}, View{123, -40, false}}) {
    RenderOptions options = small(Shading::Shaded);
    options.view = view;
    options.width = 400;
    options.height = 400;
    const double r = 180;
    const double expected = (kPi * r * r + kPi * r) / 160000;
    EXPECT_NEAR(covered(render({&mesh}, options)), expected, 0.004);
  }
}

// The picture of a sphere in the middle does not change with its size or place.
TEST(Render, ScaleAndPositionDoNotMatter) {
  const TriangleMesh mesh = fixtures::as_mesh(fixtures::blob(12));
  const Image unit = render({&mesh}, small(Shading::Shaded));
  for (const double scale : {1e-3, 1e3}) {
    TriangleMesh scaled = mesh;
    scaled.positions = (scale * mesh.positions).rowwise() + scale * Eigen::RowVector3d(3, -2, 1);
    const Image other = render({&scaled}, small(Shading::Shaded));
    int differing = 0;
    for (std::size_t i = 0; i < unit.pixels.size(); ++i)
      if (std::abs(unit.pixels[i] - other.pixels[i]) > 2) ++differing;
    EXPECT_LT(differing, 20) << scale;
  }
}

TEST(Render, GivesTheSamePictureEveryTime) {
  const TriangleMesh mesh = fixtures::as_mesh(fixtures::blob(20));
  const CurveNetwork network = great_circles(60);
  for (const Shading shading : {Shading::Isophotes, Shading::Porcupine}) {
    const Subject subject{&mesh, &network};
    EXPECT_EQ(encode_png(render(subject, small(shading))), encode_png(render(subject, small(shading))));
  }
}

// On a smooth surface, finer triangles change the stripes ever less: they converge.
TEST(Render, IsophotesConvergeWithTheMesh) {
  const auto picture = [](int n) {
    const TriangleMesh mesh = fixtures::as_mesh(fixtures::sphere(n));
    return render({&mesh}, small(Shading::Isophotes));
  };
  const Image fine = picture(96);
  const auto difference = [&](const Image& image) {
    double sum = 0;
    for (std::size_t i = 0; i < fine.pixels.size(); ++i) sum += std::abs(image.pixels[i] - fine.pixels[i]);
    return sum / static_cast<double>(fine.pixels.size());
  };
  const double coarse = difference(picture(12)), middle = difference(picture(24)),
               close = difference(picture(48));
  EXPECT_LT(middle, 0.6 * coarse);
  EXPECT_LT(close, 0.6 * middle);
}

// Seen from above, the circles of the normal map on a sphere are rings about the middle of the picture: a
// quarter turn of the model leaves them, and they alternate between red and blue.
TEST(Render, NormalMapOfASphereIsRings) {
  const TriangleMesh mesh = fixtures::as_mesh(fixtures::sphere(60));
  RenderOptions options = small(Shading::NormalMap);
  options.width = options.height = 400;
  options.view.azimuth_deg = -90;
  options.view.elevation_deg = 90;
  const Image image = render({&mesh}, options);
  const auto red = [&](int x, int y) { return image.at(x, y)[0] > image.at(x, y)[2]; };
  // Ring k of 18 has its middle at angle (k + ½)·5°, that is at radius 180 sin of it.
  for (int k = 0; k < 14; ++k) {
    const double r = 180 * std::sin(radians(5 * (k + 0.5)));
    for (int turn = 0; turn < 8; ++turn) {
      const double a = 2 * kPi * turn / 8 + 0.1;
      const int x = static_cast<int>(200 + r * std::cos(a)), y = static_cast<int>(200 + r * std::sin(a));
      EXPECT_EQ(red(x, y), k % 2 == 0) << k << " " << turn;
    }
  }
}

// The mean curvature of a sphere is constant: one colour, the diverging map's red half; inside out it is
// blue.
TEST(Render, CurvatureHasItsSign) {
  TriangleMesh mesh = fixtures::as_mesh(fixtures::grid(48, 24, true, false, [](double u, double v) {
    const double a = 2 * kPi * u, b = kPi * (0.05 + 0.9 * v);
    return Eigen::Vector3d(std::sin(b) * std::cos(a), std::sin(b) * std::sin(a), -std::cos(b));
  }));
  RenderOptions options = small(Shading::MeanCurvature);
  options.view.elevation_deg = 0;
  options.range = 2;
  const auto middle = [&] {
    const Image image = render({&mesh}, options);
    const std::uint8_t* p = image.at(70, 80);
    return static_cast<int>(p[0]) - p[2];
  };
  EXPECT_GT(middle(), 30);
  mesh.triangles.col(1).swap(mesh.triangles.col(2));
  EXPECT_LT(middle(), -30);
}

// A unit sphere with two holes: H = K = 1, on the borders as well, where the neighbours inside stand in.
// Measured, not exact: within 5 % at 7.5 degrees between vertices.
TEST(ShownValues, AreTheCurvaturesOfASphereAndTheErrorsAsScaled) {
  const TriangleMesh mesh = fixtures::as_mesh(fixtures::grid(48, 24, true, false, [](double u, double v) {
    const double a = 2 * kPi * u, b = kPi * (0.05 + 0.9 * v);
    return Eigen::Vector3d(std::sin(b) * std::cos(a), std::sin(b) * std::sin(a), -std::cos(b));
  }));
  for (const Shading shading : {Shading::MeanCurvature, Shading::GaussianCurvature}) {
    const auto shown = shown_values({&mesh}, small(shading));
    ASSERT_TRUE(shown.has_value());
    ASSERT_EQ(shown->values.size(), mesh.n_vertices());
    EXPECT_LT((shown->values.array() - 1).abs().maxCoeff(), 0.05);
    EXPECT_EQ(shown->low, -shown->high);  // even about 0
  }
  Subject subject{&mesh};
  subject.errors = Eigen::VectorXd::LinSpaced(mesh.n_vertices(), 0, 0.5);
  subject.error_scale = 100;
  RenderOptions options = small(Shading::Error);
  options.range = 40;
  const auto errors = shown_values(subject, options);
  ASSERT_TRUE(errors.has_value());
  EXPECT_EQ(errors->values, 100 * subject.errors);
  EXPECT_EQ(errors->low, 0);
  EXPECT_EQ(errors->high, 40);
  EXPECT_FALSE(shown_values({&mesh}, small(Shading::Shaded)).has_value());
  EXPECT_THROW(shown_values({}, small(Shading::MeanCurvature)), InvalidInput);
}

// The deviations of a file are shown as they are, in its unit; those that are given come before them.
TEST(Render, UncertaintyIsAValueOfTheMesh) {
  TriangleMesh mesh = fixtures::as_mesh(
      fixtures::grid(3, 3, false, false, [](double u, double v) { return Eigen::Vector3d(u, v, 0); }));
  EXPECT_THROW(render({&mesh}, small(Shading::Uncertainty)), InvalidInput);
  mesh.vertex_values["uncertainty"] = Eigen::VectorXd::LinSpaced(mesh.n_vertices(), 0, 0.5);
  const auto shown = shown_values({&mesh}, small(Shading::Uncertainty));
  ASSERT_TRUE(shown.has_value());
  EXPECT_EQ(shown->values, mesh.vertex_values["uncertainty"]);
  EXPECT_EQ(shown->low, 0);
  Subject given{&mesh};
  given.uncertainty = Eigen::VectorXd::Constant(mesh.n_vertices(), 0.25);
  EXPECT_EQ(shown_values(given, small(Shading::Uncertainty))->values, given.uncertainty);
}

// A square before a larger one hides exactly its part; the lines behind it are hidden as well.
TEST(Render, NearThingsHideFarThings) {
  TriangleMesh mesh = fixtures::as_mesh(fixtures::grid(
      1, 1, false, false, [](double u, double v) { return Eigen::Vector3d(2 * u - 1, 2 * v - 1, 0); }));
  CurveNetwork behind;
  behind.positions.resize(2, 3);
  behind.positions << -0.9, 0.3, -0.5, 0.9, 0.3, -0.5;
  behind.curves.push_back({"", false, {0, 1}});
  CurveNetwork before = behind;
  before.positions.col(2).setConstant(0.5);
  RenderOptions options = small(Shading::Shaded);
  options.view.azimuth_deg = -90;
  options.view.elevation_deg = 90;
  const Image plain = render({&mesh}, options);
  EXPECT_EQ(render({&mesh, &behind}, options).pixels, plain.pixels);
  EXPECT_NE(render({&mesh, &before}, options).pixels, plain.pixels);
}

TEST(Render, EveryShadingDrawsSomethingOfItsOwn) {
  const TriangleMesh mesh = fixtures::as_mesh(fixtures::blob(16));
  const CurveNetwork network = great_circles(40);
  Subject subject{&mesh, &network};
  subject.errors = mesh.positions.col(0).cwiseAbs();
  subject.uncertainty = mesh.positions.col(1).cwiseAbs();
  std::vector<Image> images;
  for (const Shading shading : choice_values<Shading>()) {
    EXPECT_EQ(parse_choice<Shading>(word_of(shading)), shading);
    images.push_back(render(subject, small(shading)));
    for (std::size_t i = 0; i + 1 < images.size(); ++i)
      EXPECT_NE(images[i].pixels, images.back().pixels) << word_of(shading);
  }
  const Image sheet = contact_sheet(subject, choice_values<Shading>(), small(Shading::Shaded));
  EXPECT_EQ(sheet.width, 200);
  EXPECT_EQ(sheet.height, 160);
}

TEST(Render, SaysWhatAShadingLacks) {
  const TriangleMesh mesh = fixtures::as_mesh(fixtures::sphere(3));
  const CurveNetwork network = great_circles(20);
  EXPECT_THROW(render({}, {}), InvalidInput);
  EXPECT_THROW(render({nullptr, &network}, small(Shading::Isophotes)), InvalidInput);
  EXPECT_THROW(render({&mesh}, small(Shading::Porcupine)), InvalidInput);
  EXPECT_THROW(render({&mesh}, small(Shading::Error)), InvalidInput);
  Subject wrong{&mesh};
  wrong.errors = Eigen::VectorXd::Zero(3);
  EXPECT_THROW(render(wrong, small(Shading::Error)), InvalidInput);
  RenderOptions options = small(Shading::Shaded);
  options.given_normals = true;
  EXPECT_THROW(render({&mesh}, options), InvalidInput);
  options = small(Shading::Shaded);
  options.width = 0;
  EXPECT_THROW(render({&mesh}, options), InvalidInput);
  options = small(Shading::Shaded);
  options.samples = 0;
  EXPECT_THROW(render({&mesh}, options), InvalidInput);
  TriangleMesh broken = mesh;
  broken.triangles(0, 0) = 1000000;
  EXPECT_THROW(render({&broken}, {}), InvalidInput);
  broken = mesh;
  broken.positions(0, 0) = NAN;
  EXPECT_THROW(render({&broken}, {}), InvalidInput);
  CurveNetwork astray = network;
  astray.curves[0].vertices[3] = -1;
  EXPECT_THROW(render({nullptr, &astray}, {}), InvalidInput);
  EXPECT_THROW(parse_choice<Shading>("shiny"), InvalidInput);
}

// All errors zero, one triangle without area, all points in one: drawn without a fuss.
TEST(Render, SurvivesDegenerateSubjects) {
  TriangleMesh mesh = fixtures::as_mesh(fixtures::sphere(2));
  Subject subject{&mesh};
  subject.errors = Eigen::VectorXd::Zero(mesh.n_vertices());
  subject.uncertainty = subject.errors;
  render(subject, small(Shading::Error));
  mesh.positions.setZero();
  for (const Shading shading : choice_values<Shading>()) {
    if (shading == Shading::Porcupine) continue;
    render(subject, small(shading));
  }
}

}  // namespace
}  // namespace batten
