#include "batten/pipeline/surface_uncertainty.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/linalg/held_unknowns.hpp"
#include "batten/mesh/shape.hpp"
#include "batten/operators/laplacian.hpp"

namespace batten {

namespace {

/// Measured on exact networks of the shapes of batten simulate, whole and with one curve left out: the error
/// between the curves is 0.03 to 0.25 κ' u^(3/2), on the round ones 0.005 κ u.
constexpr double kChangeShare = 0.15, kCurvatureShare = 0.005;
/// Over this part of the diameter the change of the curvature is taken.
constexpr double kChangeSpan = 0.1;

/// Which vertices nothing is solved for: on the curves, or in no triangle.
HeldUnknowns held_on_curves(const std::vector<char>& on_curves, const Eigen::VectorXd& mass) {
  std::vector<char> held = on_curves;
  for (Eigen::Index v = 0; v < mass.size(); ++v)
    if (!(mass[v] > 0)) held[at(v)] = 1;
  return HeldUnknowns(held);
}

Eigen::VectorXd spread_by_draws(SurfaceSolver& solver, const CurveNetwork& network,
                                const std::vector<NetworkVariation>& draws, const Progress& progress) {
  const Points built = solver.result().mesh.positions, across = solver.result().mesh.normals;
  SurfaceMoveOptions options;
  options.reach = SurfaceReach::All;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(built.rows());
  for (std::size_t i = 0; i < draws.size(); ++i) {
    progress.report("uncertainty", static_cast<double>(i) / static_cast<double>(draws.size()));
    const NetworkVariation& draw = draws[i];
    Points normals = network.normals;
    for (Eigen::Index v = 0; v < normals.rows(); ++v) {
      const Eigen::Vector3d normal = normals.row(v), turn = draw.turns.row(v);
      normals.row(v) = (normal + turn.cross(normal)).normalized().transpose();
    }
    solver.move(network.positions + draw.moves, normals, options);
    const Points moves = solver.result().mesh.positions - built;
    squares += (moves.array() * across.array()).rowwise().sum().square().matrix();
  }
  solver.move(network.positions, network.normals, options);
  return (squares / static_cast<double>(draws.size())).cwiseSqrt();
}

Eigen::VectorXd spread_harmonically(const SurfaceResult& surface, const Eigen::VectorXd& deviations) {
  const TriangleMesh& mesh = surface.mesh;
  HeldSolver solver("deviations between curves",
                    held_on_curves(surface.on_network, lumped_mass(mesh.positions, mesh.triangles)));
  solver.factorize(cotangent_stiffness(mesh.positions, mesh.triangles));
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(mesh.n_vertices(), 1);
  values.topRows(deviations.size()).col(0) = deviations;
  // Obtuse triangles can take a harmonic function beyond its ends.
  return solver.solve_homogeneous(values).col(0).cwiseMax(0).cwiseMin(deviations.maxCoeff());
}

}  // namespace

CurvatureChange curvature_change(const CurveNetwork& network) {
  const double span = kChangeSpan * bounding_box_diagonal(network.positions);
  double squares = 0, length = 0, changes = 0, spans = 0;
  for (const NetworkCurve& curve : network.curves) {
    std::vector<double> curvatures, places;
    double place = 0;
    for (std::size_t i = 0; i + 1 < curve.vertices.size(); ++i) {
      const int a = curve.vertices[i], b = curve.vertices[i + 1];
      const Eigen::RowVector3d step = network.positions.row(b) - network.positions.row(a);
      const double h = step.norm();
      if (!(h > 0)) continue;
      curvatures.push_back((network.normals.row(b) - network.normals.row(a)).dot(step) / (h * h));
      places.push_back(place + 0.5 * h);
      place += h;
      squares += curvatures.back() * curvatures.back() * h;
      length += h;
    }
    for (std::size_t i = 0, j = 0; i < places.size(); ++i) {
      while (j < places.size() && places[j] - places[i] < span) ++j;
      if (j == places.size()) break;
      const double change = (curvatures[j] - curvatures[i]) / (places[j] - places[i]);
      changes += change * change;
      ++spans;
    }
  }
  return {std::sqrt(squares / std::max(length, 1e-300)), std::sqrt(changes / std::max(spans, 1.0))};
}

Eigen::VectorXd deviation_between_curves(const TriangleMesh& mesh, const std::vector<char>& on_curves,
                                         const CurvatureChange& curvature) {
  const Eigen::VectorXd mass = lumped_mass(mesh.positions, mesh.triangles);
  HeldSolver solver("torsion between curves", held_on_curves(on_curves, mass));
  if (solver.unknowns().n_free() == 0) return Eigen::VectorXd::Zero(mesh.n_vertices());
  solver.factorize(cotangent_stiffness(mesh.positions, mesh.triangles));
  const Eigen::VectorXd u =
      solver.solve(mass, Eigen::MatrixXd::Zero(mesh.n_vertices(), 1)).col(0).cwiseMax(0);
  return kChangeShare * curvature.change * u.array().pow(1.5) +
         kCurvatureShare * curvature.curvature * u.array();
}

SurfaceUncertainty surface_uncertainty(SurfaceSolver& solver, const CurveNetwork& network,
                                       const NetworkUncertainty& of_network, const Progress& progress) {
  if (of_network.deviations.size() != network.positions.rows())
    throw InvalidInput(concat("there are ", of_network.deviations.size(), " deviations for ",
                              network.positions.rows(), " vertices of the network"));
  SurfaceUncertainty result;
  const SurfaceResult& surface = solver.result();
  result.between_curves =
      deviation_between_curves(surface.mesh, surface.on_network, curvature_change(network));
  result.from_curves = of_network.draws.empty()
                           ? spread_harmonically(surface, of_network.deviations)
                           : spread_by_draws(solver, network, of_network.draws, progress);
  result.deviations = (result.from_curves.array().square() + result.between_curves.array().square()).sqrt();
  return result;
}

}  // namespace batten
