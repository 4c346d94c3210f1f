#include "batten/session/results.hpp"

#include "../sketch/strokes.hpp"
#include "one_model.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/units.hpp"
#include "batten/session/journal.hpp"
#include "batten/simulation/shapes.hpp"
#include "batten/simulation/simulate.hpp"

namespace batten {
namespace {

using namespace strokes;
using namespace test;

template <typename Result>
const Result& as(const std::shared_ptr<const RequestResult>& result) {
  return std::get<Result>(*result);
}

const TriangleMesh& mesh_of(const Content& content) {
  return *std::get<SharedMesh>(content);
}

/// A sphere of three circles; its surface by Coons patches, and that surface after two steps of Taubin.
struct Sphere {
  Document document = one_model();
  ModelSurfaceRequest coons;
  FairRequest taubin;
  ObjectId surface, smooth;

  Sphere() {
    for (const auto& stroke : {circle(kO, kX, kY), circle(kO, kX, kZ), circle(kO, kY, kZ)})
      document.apply(on_model(InsertEdit{stroke, {}}));
    coons.options.method = ModelSurfaceMethod::Coons;
    coons.options.levels = 1;
    surface = document.apply(DeriveEdit{{}, "surface", kModel, coons}).object;
    taubin.options.method = FairingMethod::Taubin;
    taubin.options.iterations = 2;
    smooth = document.apply(DeriveEdit{{}, "smooth", surface, taubin}).object;
  }
};

TEST(Results, AreMadeWhereTheyAreOutOfDateAndNowhereElse) {
  Sphere sphere;
  Document& document = sphere.document;
  Results kept;
  EXPECT_EQ(document.out_of_date(kept.versions()), (std::vector{sphere.surface, sphere.smooth}));
  const auto smooth = kept.get(document, sphere.smooth);
  const auto surface = kept.get(document, sphere.surface);
  EXPECT_TRUE(document.out_of_date(kept.versions()).empty());
  // What a request makes is what its function makes.
  const ModelSurface model = model_surface(document.model(kModel), sphere.coons.options);
  EXPECT_TRUE(as<ModelSurface>(surface).mesh.positions == model.mesh.positions);
  EXPECT_TRUE(as<FairedMesh>(smooth).mesh.positions ==
              faired_mesh(model.mesh, sphere.taubin.options).mesh.positions);

  document.apply(RenameEdit{sphere.surface, "sphere"});
  EXPECT_EQ(kept.get(document, sphere.smooth), smooth);
  sphere.taubin.options.iterations = 3;
  document.apply(RequestEdit{sphere.smooth, sphere.taubin, 0});
  EXPECT_NE(kept.get(document, sphere.smooth), smooth);
  EXPECT_EQ(kept.get(document, sphere.surface), surface);
  EXPECT_TRUE(document.out_of_date(kept.versions()).empty());
  EXPECT_EQ(kept.get(document, sphere.smooth), kept.get(document, sphere.smooth));
  document.apply(on_model(TransformEdit{Eigen::Vector4d(2, 1, 1, 1).asDiagonal().toDenseMatrix()}));
  EXPECT_NE(kept.get(document, sphere.surface), surface);
  // A result outlives what replaces it.
  EXPECT_TRUE(as<ModelSurface>(surface).mesh.positions == model.mesh.positions);
}

TEST(Results, AreTheSameFromTheJournalBitForBit) {
  Sphere sphere;
  Results kept;
  kept.get(sphere.document, sphere.smooth);
  sphere.document.apply(on_model(TransformEdit{Eigen::Vector4d(2, 1, 1, 1).asDiagonal().toDenseMatrix()}));
  Document again;
  for (const SessionEdit& edit : parse_session(format_session(sphere.document.log()), "journal").edits)
    again.apply(edit.edit);
  Results fresh;
  const Content a = kept.content(sphere.document, sphere.smooth), b = fresh.content(again, sphere.smooth);
  EXPECT_EQ(mesh_of(a).triangles, mesh_of(b).triangles);
  EXPECT_TRUE(mesh_of(a).positions == mesh_of(b).positions);
}

// From readings to a cage that is bent: every kind of request but that of models, each from what the one
// before made.
TEST(Results, FollowEveryKindOfRequest) {
  SimulateOptions device;
  device.step = 0.05;
  Document document;
  const auto derive = [&](const char* name, ObjectId source, const Request& request) {
    return document.apply(DeriveEdit{{}, name, source, request}).object;
  };
  const ObjectId scan =
      document
          .apply(AddEdit{
              {},
              "scan",
              "m",
              std::make_shared<const Scan>(simulate_scan(trace_shape(AnalyticShape::Sphere), device).scan)})
          .object;
  const ObjectId network = derive("network", scan, NetworkRequest{});
  SurfaceRequest coarse;
  coarse.surface.edge_length = Length{0.1, Length::Kind::Relative};
  const ObjectId surface = derive("surface", network, coarse);
  RemeshRequest remesh;
  remesh.options.edge_length = Length{0.08, Length::Kind::Relative};
  const ObjectId even = derive("even", surface, remesh);
  const ObjectId fair = derive("fair", even, FairRequest{});
  SimplifyRequest half;
  half.options.simplify.remove = 0.5;
  const ObjectId small = derive("small", fair, half);
  SubdivideRequest twice;
  twice.options.subdivision.scheme = SubdivisionScheme::CatmullClark;
  twice.options.subdivision.levels = 2;
  twice.options.first_schemes = {SubdivisionScheme::Linear};
  const ObjectId fine = derive("fine", small, twice);
  DeformRequest bend;
  bend.fixed = std::make_shared<const std::vector<int>>(std::vector<int>{0, 1, 2});
  bend.moved.resize(1);
  bend.moved[0].vertices = std::make_shared<const std::vector<int>>(std::vector<int>{20});
  bend.moved[0].translation = {0.1, 0, 0};
  const ObjectId bent = derive("bent", fine, bend);

  Results results;
  const TriangleMesh& end = mesh_of(results.content(document, bent));
  EXPECT_TRUE(document.out_of_date(results.versions()).empty());
  const TriangleMesh& cage = as<SimplifiedMesh>(results.get(document, small)).simplified.mesh;
  EXPECT_EQ(end.n_triangles(), 6 * 4 * cage.n_triangles());  // three quads a triangle, each made four, halved
  const TriangleMesh& start = mesh_of(results.content(document, fine));
  EXPECT_LT((end.positions.row(20) - start.positions.row(20) - Eigen::RowVector3d(0.1, 0, 0)).norm(), 1e-9);
  EXPECT_TRUE(end.positions.topRows(3) == start.positions.topRows(3));
  // All on the sphere of radius 1 about its mean but for the bend, and as a chord is inside.
  const Eigen::VectorXd radii = mesh_of(results.content(document, even)).positions.rowwise().norm();
  EXPECT_NEAR(radii.mean(), 1, 0.02);
  EXPECT_GT(times_of(*results.get(document, surface)).total(), 0);
  EXPECT_FALSE(times_of(*results.get(document, network)).stages().empty());
}

TEST(Results, AMendedMeshSaysWhatCouldNotBeMended) {
  // Two squares that cross in the middle: nothing takes that away.
  TriangleMesh crossed;
  crossed.positions.resize(6, 3);
  crossed.positions << -1, -1, 0, 1, -1, 0, 0, 1, 0, 0, -1, -1, 0, -1, 1, 0, 1, 0.1;
  crossed.triangles.resize(2, 3);
  crossed.triangles << 0, 1, 2, 3, 4, 5;
  const RequestResult result = run(RepairRequest{}, std::make_shared<const TriangleMesh>(crossed));
  const RepairedMesh& mended = std::get<RepairedMesh>(result);
  ASSERT_FALSE(mended.flaws.empty());
  EXPECT_EQ(warnings_of(result).size(), mended.warnings.size() + mended.flaws.size());
}

TEST(Results, FailuresNameTheObjectAndKeepWhatWasFinished) {
  Sphere sphere;
  RemeshRequest sizes;
  sizes.sizes = "density";
  const ObjectId even = sphere.document.apply(DeriveEdit{{}, "even", sphere.smooth, sizes}).object;
  Results results;
  try {
    results.get(sphere.document, even);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_EQ(std::string(error.what()), "'even': the mesh has no value 'density' per vertex");
  }
  EXPECT_EQ(sphere.document.out_of_date(results.versions()), std::vector{even});
  EXPECT_THROW(results.get(sphere.document, kModel), InvalidInput);
  EXPECT_THROW(results.get(sphere.document, {99}), InvalidInput);

  Results stopped;
  const Progress stop([](std::string_view, double) { return false; });
  EXPECT_THROW(stopped.get(sphere.document, sphere.surface, stop), Cancelled);
  EXPECT_TRUE(stopped.versions().empty());
}

TEST(Run, RefusesASourceOfAnotherKindAndBadOptions) {
  const Content mesh = std::make_shared<const TriangleMesh>();
  EXPECT_THROW(run(NetworkRequest{}, mesh), InvalidInput);
  SimplifyRequest none;
  EXPECT_THROW(run(none, mesh), InvalidInput);
}

TEST(Run, WarningsOfAllStepsComeAlong) {
  // Strokes without normals whose ends miss each other: what was mended is told by their own step.
  CurveNetwork gap;
  gap.positions.resize(8, 3);
  for (int i = 0; i < 8; ++i) {
    const double t = std::numbers::pi / 4 * i;
    gap.positions.row(i) << std::cos(t), std::sin(t), 0;
  }
  for (int k = 0; k < 4; ++k) {
    NetworkCurve& curve = gap.curves.emplace_back();
    curve.vertices = {2 * k, 2 * k + 1, (2 * k + 2) % 8};
  }
  const RequestResult result = run(SurfaceRequest{}, std::make_shared<const CurveNetwork>(gap));
  const CurvesSurface& surface = std::get<CurvesSurface>(result);
  ASSERT_TRUE(surface.strokes);
  EXPECT_EQ(warnings_of(result).size(), surface.strokes->warnings.size() + surface.surface.warnings.size());
  EXPECT_GT(times_of(result).total(), surface.surface.times.total());
}

}  // namespace
}  // namespace batten
