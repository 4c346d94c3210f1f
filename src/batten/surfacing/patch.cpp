#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include <Eigen/Dense>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/surfacing/fill_loop_detail.hpp"
#include "batten/surfacing/patch_detail.hpp"
#include "batten/surfacing/tessellation_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::RowVector3d;
using Eigen::Vector3d;

/// Plane coordinates are rounded to this grid, so that translated, scaled and renumbered input gives the very
/// same points: ties of the Delaunay triangulation, frequent on symmetric networks, then break the same way.
constexpr double kGrid = 0.7548776662466927e-9;
double on_grid(double x) {
  return std::round(x / kGrid) * kGrid;
}

double mean_edge(const ScaledNetwork& network, const NetworkCycle& cycle) {
  double sum = 0;
  std::size_t count = 0;
  for (const NetworkCycle::Loop& loop : cycle.loops)
    for (std::size_t i = 0; i < loop.vertices.size(); ++i, ++count)
      sum += (network.positions.row(loop.vertices[i]) -
              network.positions.row(loop.vertices[(i + 1) % loop.vertices.size()]))
                 .norm();
  return sum / static_cast<double>(count);
}

/// Where a loop begins, from its shape alone, so that a rotated network is laid out alike: the vertex
/// farthest from the centre, then the one with the most distant neighbours; ties (symmetric patches) by the
/// given order.
std::size_t intrinsic_start(const ScaledNetwork& network, const std::vector<int>& loop,
                            const RowVector3d& centre) {
  const auto n = static_cast<std::ptrdiff_t>(loop.size());
  const auto key = [&](std::ptrdiff_t i, std::ptrdiff_t reach) {
    const auto distance = [&](std::ptrdiff_t j) {
      return (network.positions.row(loop[static_cast<std::size_t>(((j % n) + n) % n)]) - centre).norm();
    };
    return std::llround((distance(i - reach) + distance(i + reach)) / 0.7548776662466927e-7);
  };
  std::ptrdiff_t best = 0;
  for (std::ptrdiff_t i = 1; i < n; ++i)
    for (const std::ptrdiff_t reach :
         {std::ptrdiff_t{0}, std::ptrdiff_t{1}, std::ptrdiff_t{2}, n / 5, n / 3}) {
      const long long a = key(i, reach), b = key(best, reach);
      if (a > b) best = i;
      if (a != b) break;
    }
  return static_cast<std::size_t>(best);
}

/// A region of the plane whose corners are network vertices.
struct LaidOut {
  PlaneRegion region;
  std::vector<int> network_vertices;
};

LaidOut lay_out_in_plane(const ScaledNetwork& network, const NetworkCycle& cycle) {
  RowVector3d centre = RowVector3d::Zero(), normal = RowVector3d::Zero();
  std::size_t count = 0;
  for (const NetworkCycle::Loop& loop : cycle.loops)
    for (const int v : loop.vertices) {
      centre += network.positions.row(v);
      normal += network.normals.row(v);
      ++count;
    }
  centre /= static_cast<double>(count);
  if (normal.norm() < 0.05 * static_cast<double>(count)) {
    // The normals cancel: the plane nearest to the loops, on the side from which they run counter-clockwise.
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
    RowVector3d area = RowVector3d::Zero();
    for (const NetworkCycle::Loop& loop : cycle.loops)
      for (std::size_t i = 0; i < loop.vertices.size(); ++i) {
        const RowVector3d a = network.positions.row(loop.vertices[i]) - centre;
        const RowVector3d b = network.positions.row(loop.vertices[(i + 1) % loop.vertices.size()]) - centre;
        moments += a.transpose() * a;
        area += a.cross(b);
      }
    normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(moments).eigenvectors().col(0).transpose();
    if (normal.dot(area) < 0) normal = -normal;
  }
  normal.normalize();

  LaidOut laid_out;
  std::map<int, int> local;
  const std::size_t start = intrinsic_start(network, cycle.loops.front().vertices, centre);
  RowVector3d x_axis = network.positions.row(cycle.loops.front().vertices[start]) - centre;
  x_axis -= normal * normal.dot(x_axis);
  if (x_axis.norm() < 1e-9) x_axis = normal.unitOrthogonal();
  x_axis.normalize();
  const RowVector3d y_axis = normal.cross(x_axis);
  std::vector<Eigen::RowVector2d> corners;
  for (std::size_t l = 0; l < cycle.loops.size(); ++l) {
    const std::vector<int>& vertices = cycle.loops[l].vertices;
    std::vector<int> loop;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const int v = vertices[(i + (l == 0 ? start : 0)) % vertices.size()];
      const auto [place, is_new] = local.emplace(v, static_cast<int>(corners.size()));
      if (is_new) {
        const RowVector3d d = network.positions.row(v) - centre;
        corners.emplace_back(on_grid(d.dot(x_axis)), on_grid(d.dot(y_axis)));
        laid_out.network_vertices.push_back(v);
      }
      loop.push_back(place->second);
    }
    laid_out.region.loops.push_back(std::move(loop));
  }
  laid_out.region.corners.resize(static_cast<Eigen::Index>(corners.size()), 2);
  for (std::size_t i = 0; i < corners.size(); ++i)
    laid_out.region.corners.row(static_cast<Eigen::Index>(i)) = corners[i];
  return laid_out;
}

/// Radius of the circle in which a polygon with these sides is inscribed, or 0 where there is none with the
/// centre inside or a side is as long as all others together.
double circumradius(const std::vector<double>& sides) {
  const double longest = *std::max_element(sides.begin(), sides.end());
  const auto angle = [&](double r) {
    double sum = 0;
    for (const double s : sides) sum += 2 * std::asin(std::min(1.0, s / (2 * r)));
    return sum;
  };
  double low = longest / 2, high = low;
  if (angle(low) < 2 * kPi) return 0;
  while (angle(high) > 2 * kPi) high *= 2;
  for (int i = 0; i < 200 && low < high; ++i) {
    const double middle = 0.5 * (low + high);
    (angle(middle) > 2 * kPi ? low : high) = middle;
  }
  return high;
}

/// Maps of S fig. 4.11 that keep the lengths along the loop: to a circle, or to a polygon with one straight
/// side per segment of the network.
LaidOut lay_out_by_length(const ScaledNetwork& network, const NetworkCycle& cycle, bool polygon) {
  const std::vector<int>& vertices = cycle.loops.front().vertices;
  const std::size_t n = vertices.size();
  RowVector3d centre = RowVector3d::Zero();
  for (const int v : vertices) centre += network.positions.row(v) / static_cast<double>(n);
  const std::size_t start = intrinsic_start(network, vertices, centre);
  std::vector<double> length(n);
  for (std::size_t i = 0; i < n; ++i)
    length[i] = (network.positions.row(vertices[(start + i + 1) % n]) -
                 network.positions.row(vertices[(start + i) % n]))
                    .norm();
  LaidOut laid_out;
  std::vector<int> loop(n);
  std::iota(loop.begin(), loop.end(), 0);
  for (std::size_t i = 0; i < n; ++i) laid_out.network_vertices.push_back(vertices[(start + i) % n]);
  laid_out.region.loops.push_back(loop);
  laid_out.region.corners.resize(static_cast<Eigen::Index>(n), 2);
  const double total = std::accumulate(length.begin(), length.end(), 0.0);
  if (polygon) {
    // Sides between vertices where the loop turns: the ends of its segments.
    std::vector<std::size_t> corners;
    for (std::size_t i = 0; i < n; ++i) {
      const RowVector3d in = (network.positions.row(laid_out.network_vertices[i]) -
                              network.positions.row(laid_out.network_vertices[(i + n - 1) % n]))
                                 .normalized();
      const RowVector3d out = (network.positions.row(laid_out.network_vertices[(i + 1) % n]) -
                               network.positions.row(laid_out.network_vertices[i]))
                                  .normalized();
      if (in.dot(out) < std::cos(radians(30))) corners.push_back(i);
    }
    std::vector<double> sides;
    for (std::size_t c = 0; c < corners.size(); ++c) {
      double side = 0;
      for (std::size_t i = corners[c]; i % n != corners[(c + 1) % corners.size()] || i == corners[c]; ++i)
        side += length[i % n];
      sides.push_back(side);
    }
    const double radius = corners.size() >= 3 ? circumradius(sides) : 0;
    if (radius > 0) {
      double angle = 0;
      for (std::size_t c = 0; c < corners.size(); ++c) {
        const double turn = 2 * std::asin(std::min(1.0, sides[c] / (2 * radius)));
        const Eigen::RowVector2d a(radius * std::cos(angle), radius * std::sin(angle));
        const Eigen::RowVector2d b(radius * std::cos(angle + turn), radius * std::sin(angle + turn));
        double along = 0;
        for (std::size_t i = corners[c]; i % n != corners[(c + 1) % corners.size()] || i == corners[c]; ++i) {
          const Eigen::RowVector2d p = a + (b - a) * (along / sides[c]);
          laid_out.region.corners.row(static_cast<Eigen::Index>(i % n)) << on_grid(p.x()), on_grid(p.y());
          along += length[i % n];
        }
        angle += turn;
      }
      return laid_out;
    }
  }
  double along = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double angle = 2 * kPi * along / total, radius = total / (2 * kPi);
    laid_out.region.corners.row(static_cast<Eigen::Index>(i)) << on_grid(radius * std::cos(angle)),
        on_grid(radius * std::sin(angle));
    along += length[i];
  }
  return laid_out;
}

bool fill_plane(const LaidOut& laid_out, double edge, PatchMesh& mesh, std::string& problem) {
  TessellationOptions options;
  options.max_area = 0.5 * edge * edge;
  const Tessellation tessellation = tessellate(laid_out.region, options);
  if (!tessellation.valid) {
    problem = tessellation.problem;
    return false;
  }
  mesh.network_vertices = laid_out.network_vertices;
  mesh.n_inner = static_cast<int>(tessellation.vertices.rows() - laid_out.region.corners.rows());
  mesh.triangles = tessellation.triangles;
  Points flat(tessellation.vertices.rows(), 3);
  flat << tessellation.vertices, Eigen::VectorXd::Zero(flat.rows());
  mesh.lengths = edge_lengths(flat, mesh.triangles);
  return true;
}

std::string patch_name(const NetworkCycle& cycle, int patch) {
  return concat("patch ", patch, " (at vertex ", cycle.loops.front().vertices.front(), ")");
}

}  // namespace

PatchMesh mesh_patch_in_space(const ScaledNetwork& network, const NetworkCycle& cycle, int patch,
                              double edge) {
  PatchMesh mesh;
  mesh.layout = PatchLayout::Space;
  std::string problem;
  if (!fill_loops(network.positions, network.normals, cycle, edge > 0 ? edge : mean_edge(network, cycle),
                  mesh, problem))
    throw InvalidInput(
        concat(patch_name(cycle, patch), " cannot be filled: ", problem, "; split it with another curve"));
  return mesh;
}

PatchMesh mesh_patch(const ScaledNetwork& network, const NetworkCycle& cycle, int patch, PatchMap map,
                     double edge, std::string& warning) {
  if (!(edge > 0)) edge = mean_edge(network, cycle);
  for (const NetworkCycle::Loop& loop : cycle.loops)
    if (loop.vertices.size() < 3)
      throw InvalidInput(
          concat(patch_name(cycle, patch), " has ", loop.vertices.size(),
                 " vertices; a patch needs at least three, so sample its curves more densely"));
  PatchMesh mesh;
  std::string problem;
  if (map == PatchMap::Plane) {
    mesh.layout = PatchLayout::Plane;
    if (fill_plane(lay_out_in_plane(network, cycle), edge, mesh, problem)) return mesh;
  } else if (cycle.loops.size() == 1) {
    mesh.layout = map == PatchMap::Circle ? PatchLayout::Circle : PatchLayout::Polygon;
    if (fill_plane(lay_out_by_length(network, cycle, map == PatchMap::Polygon), edge, mesh, problem))
      return mesh;
  } else {
    problem = "it has several boundary loops";
  }
  warning = concat(patch_name(cycle, patch), " cannot be laid out in the plane, as ", problem,
                   "; it was triangulated in space");
  return mesh_patch_in_space(network, cycle, patch, edge);
}

}  // namespace batten::detail
