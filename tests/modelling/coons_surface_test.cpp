#include "batten/modelling/coons_surface.hpp"

#include "sanitizers.hpp"
#include "sketch/models.hpp"
#include "sketch/strokes.hpp"
#include "subdivision/cages.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/subdivision/subdivide.hpp"

namespace batten {
namespace {

using namespace strokes;
using Eigen::Index;
using Eigen::Vector3d;

constexpr FinalScheme kAllSchemes[] = {FinalScheme::CatmullClark, FinalScheme::Nuliss, FinalScheme::NulissMod,
                                       FinalScheme::NulissModCatmullClark};

const char* name(FinalScheme scheme) {
  static const char* const kNames[] = {"catmull-clark", "nuliss", "nulissmod", "nulissmod+catmull-clark"};
  return kNames[static_cast<int>(scheme)];
}

/// Mean and largest of |f| over the vertices.
struct Deviation {
  double mean = 0, largest = 0;
};
template <typename F>
Deviation deviation(const Points& points, const F& f) {
  Deviation d;
  for (Index v = 0; v < points.rows(); ++v) {
    const double here = std::abs(f(Vector3d(points.row(v))));
    d.mean += here / static_cast<double>(points.rows());
    d.largest = std::max(d.largest, here);
  }
  return d;
}

/// The largest distance of the drawn curves from the surface's vertices on them, taken as a test that the
/// surface goes through the curves: vertices of edges against their polylines.
double distance_from_curves(const PolylineMesh& mesh, const CoonsSurface& surface) {
  double worst = 0;
  for (size_t e = 0; e < mesh.edges().size(); ++e) {
    if (!mesh.edges()[e].alive || !mesh.edges()[e].drawn) continue;
    const Polyline& polyline = *mesh.edges()[e].polyline;
    Segments segments(polyline.n_points() - 1, 2);
    for (Index i = 0; i < segments.rows(); ++i)
      segments.row(i) << static_cast<int>(i), static_cast<int>(i) + 1;
    const SegmentTree tree(polyline.points(), segments);
    for (const int v : surface.vertices_of_edge[e])
      worst =
          std::max(worst, std::sqrt(tree.closest(Vector3d(surface.fine.positions.row(v))).squared_distance));
  }
  return worst;
}

/// A cage whose edges follow a map from its own vertices: straight lines through the map.
PolylineMesh mapped(const ControlCage& cage, const std::function<Vector3d(const Vector3d&)>& map,
                    int n = 32) {
  return models::model_of_cage(cage.mesh, [&](int from, int to) {
    Points points(n + 1, 3);
    for (int i = 0; i <= n; ++i) {
      const double t = static_cast<double>(i) / n;
      const Vector3d p = (1 - t) * cage.mesh.positions.row(from) + t * cage.mesh.positions.row(to);
      points.row(i) = map(p).transpose();
    }
    return points;
  });
}

/// A torus of radii 2 and 0.7, n × m patches, its curves circles.
PolylineMesh round_torus(int n, int m) {
  const ControlCage cage = cages::torus(n, m);
  return models::model_of_cage(cage.mesh, [&](int from, int to) {
    constexpr int kPoints = 32;
    const auto angles = [&](int v) { return Eigen::Vector2d(2 * kPi * (v % n) / n, 2 * kPi * (v / n) / m); };
    Eigen::Vector2d a = angles(from), b = angles(to);
    for (int k = 0; k < 2; ++k) {
      if (b(k) - a(k) > kPi) b(k) -= 2 * kPi;
      if (b(k) - a(k) < -kPi) b(k) += 2 * kPi;
    }
    Points points(kPoints + 1, 3);
    for (int i = 0; i <= kPoints; ++i) {
      const Eigen::Vector2d p = a + (b - a) * i / kPoints;
      const double r = 2 + 0.7 * std::cos(p(1));
      points.row(i) << r * std::cos(p(0)), r * std::sin(p(0)), 0.7 * std::sin(p(1));
    }
    return points;
  });
}

TEST(CoonsSurface, TestNetworksLieWithinTheFiguresOfTheDocs) {
  // Largest and mean distance from the truth ÷ the diameter of its box. Curves lie on the truth; what is
  // between them is the Coons patch's own: at the centre of an octant of the sphere, for instance,
  // (sqrt(1/2) - 1/4, sqrt(1/2) - 1/4, sqrt(1/2)) has the radius 0.959.
  struct Network {
    const char* name;
    PolylineMesh mesh;
    std::function<double(const Vector3d&)> distance;
    double size, largest, mean;
  };
  const Vector3d axes(1.5, 1, 0.7);
  const auto ellipsoid = [&](const Vector3d& p) -> Vector3d { return axes.cwiseProduct(p.normalized()); };
  // To first order: F / |grad F|.
  const auto from_ellipsoid = [&](const Vector3d& p) {
    const Vector3d q = p.cwiseQuotient(axes);
    return (q.squaredNorm() - 1) / (2 * q.cwiseQuotient(axes).norm());
  };
  ControlCage refined_cube =
      subdivide(cages::cube(), {.scheme = SubdivisionScheme::Linear, .levels = 1}).cage;
  std::vector<Network> networks;
  networks.push_back({"sphere, three circles", three_great_circles(),
                      [](const Vector3d& p) { return p.norm() - 1; }, 2 * std::sqrt(3.0), 0.0205, 0.0073});
  networks.push_back({"sphere, 24 patches",
                      mapped(refined_cube, [](const Vector3d& p) { return Vector3d(p.normalized()); }),
                      [](const Vector3d& p) { return p.norm() - 1; }, 2 * std::sqrt(3.0), 0.0034, 0.00145});
  networks.push_back({"ellipsoid, 24 patches", mapped(refined_cube, ellipsoid), from_ellipsoid,
                      2 * axes.norm(), 0.0032, 0.0012});
  networks.push_back({"torus, 8 x 4 patches", round_torus(8, 4),
                      [](const Vector3d& p) { return std::hypot(std::hypot(p.x(), p.y()) - 2, p.z()) - 0.7; },
                      std::hypot(5.4, 5.4, 1.4), 0.0014, 0.0005});
  // An open tube of 4 x 2 patches: surfaces of translation, so the patches are exact.
  ControlCage tube = cages::grid(5, 3, [](int i, int j) { return Eigen::RowVector3d(i, j, 0); });
  for (int& c : tube.mesh.corners) c = c % 5 == 4 ? c - 4 : c;
  std::map<int, int> kept;
  for (int& c : tube.mesh.corners) c = kept.insert({c, static_cast<int>(kept.size())}).first->second;
  Points where(static_cast<Index>(kept.size()), 3);
  for (const auto& [old, now] : kept) where.row(now) << old % 5, old / 5, 0;
  tube.mesh.positions = where;
  networks.push_back({"cylinder, 4 x 2 patches",
                      models::model_of_cage(tube.mesh,
                                            [&](int from, int to) {
                                              Eigen::RowVector3d a = where.row(from), b = where.row(to);
                                              if (b.x() - a.x() > 2) a.x() += 4;
                                              if (a.x() - b.x() > 2) b.x() += 4;
                                              Points points(33, 3);
                                              for (int i = 0; i <= 32; ++i) {
                                                const Eigen::RowVector3d p = a + (b - a) * i / 32.0;
                                                const double t = kPi / 2 * p.x();
                                                points.row(i) << std::cos(t), std::sin(t), p.y();
                                              }
                                              return points;
                                            }),
                      [](const Vector3d& p) { return std::hypot(p.x(), p.y()) - 1; }, std::sqrt(12.0),
                      0.00018, 0.0001});
  for (const Network& network : networks)
    for (const FinalScheme scheme : kAllSchemes) {
      const CoonsSurface surface = coons_surface(network.mesh, {.scheme = scheme, .levels = 2});
      const Deviation d = deviation(surface.fine.positions, network.distance);
      std::cout << network.name << ", " << name(scheme) << ": " << 100 * d.largest / network.size
                << " % at most, " << 100 * d.mean / network.size << " % in the mean\n";
      EXPECT_LT(d.largest, network.largest * network.size) << network.name << ' ' << name(scheme);
      EXPECT_LT(d.mean, network.mean * network.size) << network.name << ' ' << name(scheme);
      // Vertices on the curves stay there; NULISS and the fitted cage interpolate them.
      EXPECT_LT(distance_from_curves(network.mesh, surface), 1e-6 * network.size) << network.name;
    }
}

/// H 7.2: the polylines are the refined edges of a coarse mesh; the surface is compared with the refinement.
Deviation against_its_refinement(const ControlCage& cage, const CoonsOptions& options) {
  const SubdividedSurface truth = subdivide(cage, {.levels = 5, .limit = true});
  std::map<std::pair<int, int>, Index> row_of_edge;
  for (size_t e = 0; e < truth.cage_edges.size(); ++e)
    row_of_edge[std::minmax(truth.cage_edges[e][0], truth.cage_edges[e][1])] = static_cast<Index>(e);
  PolylineMesh mesh = models::model_of_cage(cage.mesh, [&](int from, int to) {
    const Index e = row_of_edge.at(std::minmax(from, to));
    const Index n = truth.edge_chains.cols();
    Points points(n, 3);
    for (Index i = 0; i < n; ++i)
      points.row(i) = truth.limit_positions.row(
          truth.edge_chains(e, truth.cage_edges[static_cast<size_t>(e)][0] == from ? i : n - 1 - i));
    return points;
  });
  mesh.begin();
  for (size_t e = 0; e < mesh.edges().size(); ++e)
    for (const SharpEdge& sharp : cage.sharp_edges)
      if (std::minmax(sharp.from, sharp.to) ==
          std::minmax(mesh.edges()[e].vertices[0], mesh.edges()[e].vertices[1]))
        mesh.set_sharpness(static_cast<int>(e), 1);
  mesh.commit();
  const CoonsSurface surface = coons_surface(mesh, options);
  const TriangleMesh fine = triangulated(truth.cage.mesh);
  const TriangleTree tree(truth.limit_positions, fine.triangles);
  const double size = bounding_box_diagonal(truth.limit_positions);
  Deviation d;
  for (const ClosestPoint& closest : tree.closest(surface.fine.positions)) {
    const double here = std::sqrt(closest.squared_distance) / size;
    d.mean += here / static_cast<double>(surface.fine.positions.rows());
    d.largest = std::max(d.largest, here);
  }
  return d;
}

/// No symmetry at all.
ControlCage dented_torus() {
  ControlCage cage = cages::torus(6, 5);
  for (Index v = 0; v < cage.mesh.positions.rows(); ++v)
    cage.mesh.positions.row(v) *= 1 + 0.15 * std::sin(2.3 * static_cast<double>(v));
  return cage;
}

TEST(CoonsSurface, ComesBackFromTheRefinementOfACoarseMesh) {
  struct Case {
    const char* name;
    ControlCage cage;
    double largest, mean;
  };
  // Bounds a tenth above what the patches themselves leave; that falls with the fourth power of their size,
  // see below. Cubes, prisms and the tetrahedron have patches of 90 degrees and more.
  for (const Case& c : {Case{"cube", cages::cube(), 0.046, 0.02},
                        Case{"cube with sharp edges", cages::cube_with_sharp_edges(), 0.039, 0.0062},
                        Case{"torus", cages::torus(6, 5), 0.002, 0.0005},
                        Case{"dented torus", dented_torus(), 0.0027, 0.00054},
                        Case{"five-sided prism", cages::prism(5), 0.044, 0.0162},
                        Case{"eight-sided prism", cages::prism(8), 0.037, 0.0125},
                        Case{"tetrahedron", cages::tetrahedron(), 0.091, 0.035}})
    for (const FinalScheme scheme : kAllSchemes) {
      if (test::kSanitized && std::string(c.name) != "dented torus") continue;
      const Deviation d = against_its_refinement(c.cage, {.scheme = scheme, .levels = 2});
      std::cout << c.name << ", " << name(scheme) << ": " << 100 * d.largest << " % of the diameter at most, "
                << 100 * d.mean << " % in the mean\n";
      EXPECT_LT(d.largest, c.largest) << c.name << ' ' << name(scheme);
      EXPECT_LT(d.mean, c.mean) << c.name << ' ' << name(scheme);
    }
}

// What a Coons patch leaves out is the part of the surface with d4x/du2dv2: the error falls with the fourth
// power of the size of the patches.
TEST(CoonsSurface, ConvergesAtFourthOrderUnderRefinementOfTheMesh) {
  const auto error = [](int n) {
    return against_its_refinement(cages::torus(n, n), {.scheme = FinalScheme::Nuliss, .levels = 1}).mean;
  };
  const double order = std::log2(error(6) / error(12));
  std::cout << "order of convergence: " << order << '\n';
  EXPECT_GT(order, 3.5);
}

/// The unit cube with sharp edges around its top and two sharp uprights (H fig. 7.6).
PolylineMesh sharp_cube() {
  const ControlCage cage = cages::cube_with_sharp_edges();
  PolylineMesh mesh = mapped(cage, [](const Vector3d& p) { return p; });
  mesh.begin();
  for (size_t e = 0; e < mesh.edges().size(); ++e)
    for (const SharpEdge& sharp : cage.sharp_edges)
      if (std::minmax(sharp.from, sharp.to) ==
          std::minmax(mesh.edges()[e].vertices[0], mesh.edges()[e].vertices[1]))
        mesh.set_sharpness(static_cast<int>(e), 1);
  mesh.commit();
  return mesh;
}

// H fig. 7.6: between four sharp edges the top stays a plane, its edges straight and its corners exact.
TEST(CoonsSurface, CarriesSharpEdgesIntoTheSubdivision) {
  const PolylineMesh mesh = sharp_cube();
  for (const FinalScheme scheme : kAllSchemes) {
    const CoonsSurface surface = coons_surface(mesh, {.scheme = scheme, .levels = 2});
    double height = 0, edge = 0;
    for (size_t f = 0; f < surface.face_of_fine.size(); ++f)
      if (surface.face_of_fine[f] == 1)
        for (size_t c = 4 * f; c < 4 * f + 4; ++c)
          height = std::max(height, std::abs(surface.fine.positions(surface.fine.corners[c], 2) - 1));
    EXPECT_LT(height, 1e-8) << name(scheme);
    for (const int v : {4, 5, 6, 7})
      EXPECT_LT((surface.fine.positions.row(v) - cages::cube().mesh.positions.row(v)).norm(), 1e-8)
          << name(scheme);
    for (size_t e = 0; e < mesh.edges().size(); ++e) {
      if (mesh.edges()[e].sharpness == 0) continue;
      const Points& line = mesh.edges()[e].polyline->points();
      for (const int v : surface.vertices_of_edge[e])
        edge = std::max(edge, Vector3d(surface.fine.positions.row(v) - line.row(0))
                                  .cross(Vector3d(line.row(line.rows() - 1) - line.row(0)))
                                  .norm());
    }
    EXPECT_LT(edge, 1e-8) << name(scheme);
    // Nothing is round where nothing is sharp, but the surface is not the cube itself: it bulges elsewhere
    // only where curves do, so a cube of straight edges keeps its box.
    EXPECT_LE(surface.fine.positions.cwiseAbs().maxCoeff(), 1.1);
  }
}

TEST(CoonsSurface, NulissModKeepsToThePolylinesAtEveryLevel) {
  // A quad of arches; drawn edges are followed at all levels, so every vertex on them lies on the arch.
  ControlCage cage = cages::grid(2, 2, [](int i, int j) { return Eigen::RowVector3d(i, j, 0); });
  const auto arch = [](const Vector3d& p) {
    return Vector3d(p.x(), p.y(), p.x() * (1 - p.x()) + p.y() * (1 - p.y()));
  };
  const PolylineMesh mesh = mapped(cage, arch, 40);
  const CoonsSurface surface =
      coons_surface(mesh, {.steps = 1, .scheme = FinalScheme::NulissMod, .levels = 3});
  double border = 0, inside = 0;
  for (Index v = 0; v < surface.fine.positions.rows(); ++v) {
    const Vector3d p = surface.fine.positions.row(v);
    const bool on_border = std::min({p.x(), p.y(), 1 - p.x(), 1 - p.y()}) < 1e-9;
    double& error = on_border ? border : inside;
    error = std::max(error, std::abs(p.z() - arch(p).z()));
  }
  EXPECT_LT(border, 1e-3);  // the arch has 40 segments: 1/8 40^-2 of its second derivative
  EXPECT_LT(inside, 5e-3);  // and is a surface of translation
}

TEST(CoonsSurface, FarFromConvexFacesAreSound) {
  // The cross of H fig. 3.2 as a prism: two faces of twelve sides.
  const std::vector<Eigen::Vector2d> outline{{1, -1}, {3, -1}, {3, 1},   {1, 1},   {1, 3},   {-1, 3},
                                             {-1, 1}, {-3, 1}, {-3, -1}, {-1, -1}, {-1, -3}, {1, -3}};
  ControlCage cage = cages::prism(12);
  for (int k = 0; k < 12; ++k)
    for (const int top : {0, 1})
      cage.mesh.positions.row(12 * top + k) << outline[static_cast<size_t>(k)].transpose(), 1.5 * top;
  const PolylineMesh mesh = mapped(cage, [](const Vector3d& p) { return p; });
  for (const FinalScheme scheme : kAllSchemes) {
    const CoonsSurface surface = coons_surface(mesh, {.scheme = scheme, .levels = 2});
    EXPECT_EQ(surface.base.faces.size(), 22u);
    EXPECT_EQ(surface.base.cost.flaws, 0);
    // The flat faces stay flat but for what the smooth edges around them round off.
    EXPECT_LT(surface.fine.positions.col(2).maxCoeff(), 1.8);
  }
}

// A foot closed by a line whose ends divide the lower rim of each half of a flaring tube: seen along their
// mean normal these halves are discs, but their walls run out of sight there. The wall lies on the cone, and
// nothing hangs below the foot. (The cone's edge bends along the rim; Catmull-Clark through it overshoots.)
TEST(CoonsSurface, SidesOfTubesMayHaveJoints) {
  PolylineMesh mesh;
  const double low = 1.7, high = 2.3;
  edit(mesh, [&](PolylineMesh& m) {
    return skin_profiles(m, {circle(kO, low * kX, low * kY), circle(1.2 * kZ, high * kX, high * kY)},
                         {DrawnStroke{polygon({low * kX, high * kX + 1.2 * kZ}), false},
                          DrawnStroke{polygon({-low * kX, -high * kX + 1.2 * kZ}), false}},
                         {});
  });
  InsertOptions foot;
  foot.into = Into::Opening;
  edit(mesh, [&](PolylineMesh& m) { return insert_curve(m, {polygon({low * kY, -low * kY}), false}, foot); });
  edit(mesh, [](PolylineMesh& m) { return set_curve_sharpness(m, 0, 1, std::nullopt); });
  CoonsOptions options;
  options.through_curves = false;
  const CoonsSurface surface = coons_surface(mesh, options);
  const auto off = [&](const Vector3d& p) {
    const double radius = std::hypot(p.x(), p.y());
    const double wall = std::abs(radius - low - (high - low) * p.z() / 1.2);
    return radius < low ? std::min(wall, std::abs(p.z())) : wall;
  };
  EXPECT_LT(deviation(surface.refined.mesh.positions, off).largest, 0.06);  // 1.2 % of the diameter
  EXPECT_GT(surface.fine.positions.col(2).minCoeff(), -0.02);
}

TEST(CoonsSurface, FoldedSurfacesAreRefusedNamingTheFaces) {
  // A sheet whose outline crosses itself: an eight.
  ControlCage cage = cages::grid(2, 2, [](int i, int j) { return Eigen::RowVector3d(i, j, 0); });
  cage.mesh.positions.row(2).swap(cage.mesh.positions.row(3));
  try {
    coons_surface(mapped(cage, [](const Vector3d& p) { return p; }));
    ADD_FAILURE() << "accepted";
  } catch (const InvalidInput& refusal) {
    EXPECT_NE(std::string(refusal.what()).find("f0"), std::string::npos) << refusal.what();
  }
}

TEST(CoonsSurface, DiscsOfTwoSidesAndOpenSheetsKeepTheirBorder) {
  const CoonsSurface disc = coons_surface(model({{circle(kO, kX, kY), {}}}));
  EXPECT_EQ(disc.base.faces.size(), 1u);
  EXPECT_EQ(disc.base.faces[0].sides.size(), 4u);
  EXPECT_LT(disc.fine.positions.col(2).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT(disc.fine.positions.rowwise().norm().maxCoeff(), 1 + 2e-3);
  EXPECT_GT((disc.normals.col(2).cwiseAbs().array()).minCoeff(), 1 - 1e-9);
}

TEST(CoonsSurface, FollowsRotationAndScale) {
  PolylineMesh mesh = three_great_circles();
  const CoonsSurface before =
      coons_surface(mesh, {.scheme = FinalScheme::NulissModCatmullClark, .levels = 1});
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() << 0, -300, 0, 0, 0, 300, -300, 0, 0;
  matrix.topRightCorner<3, 1>() << 5, 6, 7;
  edit(mesh, [&](PolylineMesh& m) { return transform_model(m, matrix); });
  const CoonsSurface after = coons_surface(mesh, {.scheme = FinalScheme::NulissModCatmullClark, .levels = 1});
  const Points moved = (before.fine.positions * matrix.topLeftCorner<3, 3>().transpose()).rowwise() +
                       matrix.topRightCorner<3, 1>().transpose();
  EXPECT_LT((moved - after.fine.positions).rowwise().norm().maxCoeff(), 300 * 1e-6);
}

TEST(CoonsSurface, ApproximatesTheCurvesWhereAsked) {
  // On a great circle with 16 vertices the limit of cubic B-splines lies (1 - cos 22.5 degrees)/3 = 2.5 %
  // inside; the surface bends the other way too, which adds as much again and more where triangles meet.
  const PolylineMesh mesh = three_great_circles();
  const CoonsSurface surface = coons_surface(mesh, {.levels = 1, .through_curves = false});
  EXPECT_GT(distance_from_curves(mesh, surface), 0.025);
  EXPECT_LT(distance_from_curves(mesh, surface), 0.08);
  EXPECT_LT(distance_from_curves(mesh, coons_surface(mesh, {.levels = 1})), 1e-6);
}

TEST(CoonsSurface, BadOptionsAndEmptyModelsAreNamed) {
  EXPECT_THROW(coons_surface(PolylineMesh()), InvalidInput);
  EXPECT_THROW(coons_surface(three_great_circles(), {.steps = 0}), InvalidInput);
  EXPECT_THROW(coons_surface(three_great_circles(), {.levels = 7}), InvalidInput);
  EXPECT_THROW(coons_surface(three_great_circles(), {.steps = 6, .levels = 6}), InvalidInput);
  EXPECT_THROW(
      coons_surface(three_great_circles(), {.scheme = FinalScheme::NulissModCatmullClark, .levels = 0}),
      InvalidInput);
  EXPECT_THROW(
      coons_surface(three_great_circles(), {}, Progress([](std::string_view, double) { return false; })),
      Cancelled);
}

// A hole within a face of a tube: straight ties would cut through the tube.
TEST(TriquadrifiedModel, LaysTheTiesOfHolesOverTheFace) {
  PolylineMesh mesh;
  const auto ring = [](double z) { return circle(z * kZ, kX, kY); };
  const auto spine = [](double sign) {
    Points points(21, 3);
    for (int i = 0; i <= 20; ++i) points.row(i) << sign, 0, i * 0.1;
    return DrawnStroke{points, false};
  };
  edit(mesh, [&](PolylineMesh& m) {
    return skin_profiles(m, {ring(0), ring(2)}, {spine(1), spine(-1)}, {.snap = 0.05});
  });
  Points hole(49, 3);
  for (int i = 0; i < 49; ++i) {
    const double x = 0.3 * std::cos(2 * kPi * i / 49), z = 1 + 0.3 * std::sin(2 * kPi * i / 49);
    hole.row(i) << x, std::sqrt(1 - x * x), z;
  }
  edit(mesh, [&](PolylineMesh& m) { return cut_hole(m, {hole, true}, {.snap = 0.05}); });
  const BaseMesh base = triquadrified(mesh);
  double straight = 0, laid = 0;
  int n_ties = 0;
  for (const BaseEdge& edge : base.edges) {
    if (edge.drawn) continue;
    ++n_ties;
    const auto depth = [](const Vector3d& p) { return std::abs(std::hypot(p.x(), p.y()) - 1); };
    straight = std::max(straight, depth(0.5 * (edge.polyline->front() + edge.polyline->back())));
    for (Index i = 0; i < edge.polyline->n_points(); ++i)
      laid = std::max(laid, depth(edge.polyline->points().row(i)));
  }
  EXPECT_EQ(n_ties, 4);
  EXPECT_GT(straight, 0.1);
  EXPECT_LT(laid, 0.005);
  const CoonsSurface surface = coons_surface(mesh);
  EXPECT_LT(deviation(surface.fine.positions, [](const Vector3d& p) { return std::hypot(p.x(), p.y()) - 1; })
                .largest,
            0.16);  // what patches between half a circle and a small hole leave
}

}  // namespace
}  // namespace batten
