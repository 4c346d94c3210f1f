#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include <Eigen/Dense>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/surfacing/fill_loop_detail.hpp"
#include "batten/surfacing/layout_detail.hpp"
#include "batten/surfacing/patch_detail.hpp"
#include "batten/surfacing/tessellation_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::RowVector3d;
using Eigen::Vector3d;

/// Edges inside a patch ÷ mean edge of its loops. S 4.4.2 bounds areas by h²/2, which this makes h²/4:
/// vertices keep their distance to the true surface, while the flat triangles between them come half as far
/// from it.
constexpr double kInnerEdge = 0.7071067811865476;

/// A plane that shows some edge of the outline at less than this part of its length crowds the triangles
/// there, which stand in space as needles: at an angle of 60° to the plane they are twice as long.
constexpr double kLeastShown = 0.5;

/// Triangles of a large patch per square of its inner edge length, seen on tori and spheres: 2.4 to 2.7.
constexpr double kTrianglesPerSquare = 2.5;

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

LaidOut lay_out_in_plane(const ScaledNetwork& network, const NetworkCycle& cycle, double unit) {
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
  const std::size_t start = intrinsic_start(network, cycle.loops.front().vertices, centre, unit);
  RowVector3d x_axis = network.positions.row(cycle.loops.front().vertices[start]) - centre;
  x_axis -= normal * normal.dot(x_axis);
  if (x_axis.norm() < 1e-9) x_axis = normal.unitOrthogonal();
  x_axis.normalize();
  const RowVector3d y_axis = normal.cross(x_axis);
  const auto in_plane = [&](int v, bool mirrored) {
    const RowVector3d d = network.positions.row(v) - centre;
    const double y = on_grid(d.dot(y_axis) / unit);
    return Eigen::RowVector2d(on_grid(d.dot(x_axis) / unit), mirrored ? -y : y);
  };
  // Vertex i of a loop, counted from where it begins, forwards or (in the mirror image) backwards.
  const auto vertex_of = [&](std::size_t l, std::size_t i, bool mirrored) {
    const std::vector<int>& vertices = cycle.loops[l].vertices;
    const std::size_t n = vertices.size(), begin = l == 0 ? start : 0;
    return vertices[(mirrored ? begin + n - i : begin + i) % n];
  };
  // A patch and its mirror image are laid out alike, whichever of the two has the lesser outline, so that the
  // mesher makes mirror images of one another.
  for (std::size_t i = 1; i < cycle.loops.front().vertices.size(); ++i) {
    const Eigen::RowVector2d p = in_plane(vertex_of(0, i, false), false),
                             q = in_plane(vertex_of(0, i, true), true);
    if (p == q) continue;
    laid_out.mirrored = q.x() != p.x() ? q.x() < p.x() : q.y() < p.y();
    break;
  }
  std::vector<Eigen::RowVector2d> corners;
  for (std::size_t l = 0; l < cycle.loops.size(); ++l) {
    std::vector<int> loop;
    for (std::size_t i = 0; i < cycle.loops[l].vertices.size(); ++i) {
      const int v = vertex_of(l, i, laid_out.mirrored);
      const auto [place, is_new] = local.emplace(v, static_cast<int>(corners.size()));
      if (is_new) {
        corners.push_back(in_plane(v, laid_out.mirrored));
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
LaidOut lay_out_by_length(const ScaledNetwork& network, const NetworkCycle& cycle, bool polygon,
                          double unit) {
  const std::vector<int>& vertices = cycle.loops.front().vertices;
  const std::size_t n = vertices.size();
  RowVector3d centre = RowVector3d::Zero();
  for (const int v : vertices) centre += network.positions.row(v) / static_cast<double>(n);
  const std::size_t start = intrinsic_start(network, vertices, centre, unit);
  std::vector<double> length(n);
  for (std::size_t i = 0; i < n; ++i)
    length[i] = (network.positions.row(vertices[(start + i + 1) % n]) -
                 network.positions.row(vertices[(start + i) % n]))
                    .norm() /
                unit;
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

/// Two loops that face each other, as the ends of a tube: cut open along the shortest line between them and
/// laid out as a trapezoid, whose slanted sides are one line in space.
LaidOut lay_out_strip(const ScaledNetwork& network, const NetworkCycle& cycle, double edge, double unit) {
  const std::vector<int>& lower = cycle.loops[0].vertices;
  const std::vector<int>& upper = cycle.loops[1].vertices;
  const std::size_t na = lower.size(), nb = upper.size();
  // The cut runs between the nearest pair; a margin decides ties by order, so that rounding does not.
  std::size_t a0 = 0, b0 = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < na; ++i)
    for (std::size_t j = 0; j < nb; ++j) {
      const double d = (network.positions.row(lower[i]) - network.positions.row(upper[j])).norm();
      if (d < nearest * (1 - 1e-7)) {
        nearest = d;
        a0 = i;
        b0 = j;
      }
    }
  const auto lengths_from = [&](const std::vector<int>& loop, std::size_t start, bool forwards) {
    std::vector<double> along = {0};
    const std::size_t n = loop.size();
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t from = forwards ? (start + i) % n : (start + n - i % n) % n;
      const std::size_t to = forwards ? (from + 1) % n : (from + n - 1) % n;
      along.push_back(along.back() +
                      (network.positions.row(loop[to]) - network.positions.row(loop[from])).norm());
    }
    return along;
  };
  // Seen from the strip the lower loop runs to the right and the upper one to the left: read it backwards.
  const std::vector<double> below = lengths_from(lower, a0, true), above = lengths_from(upper, b0, false);
  double height = 0;
  for (std::size_t i = 0; i < na; ++i) {
    const double t = below[i] / below.back() * above.back();
    const std::size_t j =
        static_cast<std::size_t>(std::lower_bound(above.begin(), above.end(), t) - above.begin());
    height +=
        (network.positions.row(lower[(a0 + i) % na]) - network.positions.row(upper[(b0 + nb - j % nb) % nb]))
            .norm();
  }
  height /= static_cast<double>(na);
  LaidOut laid_out;
  std::vector<Eigen::RowVector2d> corners;
  const auto add = [&](double x, double y, int vertex) {
    corners.emplace_back(on_grid(x / unit), on_grid(y / unit));
    laid_out.vertex_of_corner.push_back(vertex);
  };
  laid_out.network_vertices = lower;
  laid_out.network_vertices.insert(laid_out.network_vertices.end(), upper.begin(), upper.end());
  const double half_below = 0.5 * below.back(), half_above = 0.5 * above.back();
  for (std::size_t i = 0; i <= na; ++i) add(below[i] - half_below, 0, static_cast<int>((a0 + i) % na));
  const int pieces = std::max(1, static_cast<int>(std::lround(height / edge)));
  const int n_network = static_cast<int>(na + nb);
  laid_out.n_inner = pieces - 1;
  for (int k = 1; k < pieces; ++k) {
    const double t = static_cast<double>(k) / pieces;
    add(half_below + t * (half_above - half_below), t * height, n_network + k - 1);
  }
  for (std::size_t i = nb + 1; i-- > 0;)
    add(above[i] - half_above, height, static_cast<int>(na + (b0 + nb - i % nb) % nb));
  for (int k = pieces - 1; k > 0; --k) {
    const double t = static_cast<double>(k) / pieces;
    add(-half_below - t * (half_above - half_below), t * height, n_network + k - 1);
  }
  laid_out.region.loops.emplace_back(corners.size());
  std::iota(laid_out.region.loops.front().begin(), laid_out.region.loops.front().end(), 0);
  laid_out.region.corners.resize(static_cast<Eigen::Index>(corners.size()), 2);
  for (std::size_t i = 0; i < corners.size(); ++i)
    laid_out.region.corners.row(static_cast<Eigen::Index>(i)) = corners[i];
  return laid_out;
}

bool fill_plane(const LaidOut& laid_out, double edge, double unit, PatchMesh& mesh, std::string& problem) {
  TessellationOptions options;
  options.max_area = 0.5 * (edge / unit) * (edge / unit);
  const Tessellation tessellation = tessellate(laid_out.region, options);
  if (!tessellation.valid) {
    problem = tessellation.problem;
    return false;
  }
  mesh.network_vertices = laid_out.network_vertices;
  const auto n_corners = static_cast<int>(laid_out.region.corners.rows());
  const int n_fixed = static_cast<int>(laid_out.network_vertices.size()) + laid_out.n_inner;
  mesh.n_inner = static_cast<int>(tessellation.vertices.rows()) - n_corners + laid_out.n_inner;
  mesh.triangles = tessellation.triangles;
  if (laid_out.mirrored) mesh.triangles.col(1).swap(mesh.triangles.col(2));
  Points flat(tessellation.vertices.rows(), 3);
  flat << tessellation.vertices, Eigen::VectorXd::Zero(flat.rows());
  mesh.lengths = unit * edge_lengths(flat, mesh.triangles);
  if (laid_out.vertex_of_corner.empty()) return true;
  for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f) {
    for (int k = 0; k < 3; ++k) {
      int& v = mesh.triangles(f, k);
      v = v < n_corners ? laid_out.vertex_of_corner[static_cast<std::size_t>(v)] : n_fixed + v - n_corners;
    }
    if (mesh.triangles(f, 0) == mesh.triangles(f, 1) || mesh.triangles(f, 1) == mesh.triangles(f, 2) ||
        mesh.triangles(f, 2) == mesh.triangles(f, 0)) {
      problem = "its loops are too short for the distance between them";
      return false;
    }
  }
  return true;
}

PatchMesh mesh_patch_in_space(const ScaledNetwork& network, const NetworkCycle& cycle, int patch,
                              double edge) {
  PatchMesh mesh;
  mesh.layout = PatchLayout::Space;
  std::string problem;
  if (!fill_loops(network.positions, network.normals, cycle,
                  edge > 0 ? edge : kInnerEdge * mean_edge(network, cycle), mesh, problem))
    throw InvalidInput(
        concat(patch_name(cycle, patch), " cannot be filled: ", problem, "; split it with another curve"));
  return mesh;
}

/// The normals of both loops together point into no common direction: the patch is a tube rather than a disc
/// with a hole.
bool is_tube(const ScaledNetwork& network, const NetworkCycle& cycle) {
  RowVector3d sum = RowVector3d::Zero();
  std::size_t count = 0;
  for (const NetworkCycle::Loop& loop : cycle.loops)
    for (const int v : loop.vertices) {
      sum += network.normals.row(v);
      ++count;
    }
  return sum.norm() < 0.5 * static_cast<double>(count);
}

/// The least part of its length that an edge of the outline shows in the plane.
double least_shown(const ScaledNetwork& network, const NetworkCycle& cycle, const LaidOut& laid_out,
                   double unit) {
  std::map<int, Eigen::RowVector2d> place;
  for (std::size_t i = 0; i < laid_out.network_vertices.size(); ++i)
    place[laid_out.network_vertices[i]] = laid_out.region.corners.row(static_cast<Eigen::Index>(i));
  const std::vector<int>& loop = cycle.loops.front().vertices;
  double least = 1;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const int a = loop[i], b = loop[(i + 1) % loop.size()];
    const double length = (network.positions.row(b) - network.positions.row(a)).norm() / unit;
    if (length > 0) least = std::min(least, (place[b] - place[a]).norm() / length);
  }
  return least;
}

}  // namespace

std::string patch_name(const NetworkCycle& cycle, int patch) {
  if (!cycle.name.empty()) return cycle.name;
  return concat("patch ", patch, " (at vertex ", cycle.loops.front().vertices.front(), ")");
}

double estimated_triangles(const ScaledNetwork& network, const NetworkCycle& cycle, double edge) {
  if (!(edge > 0)) edge = kInnerEdge * mean_edge(network, cycle);
  Eigen::RowVector3d middle = Eigen::RowVector3d::Zero();
  double count = 0;
  for (const NetworkCycle::Loop& loop : cycle.loops)
    for (const int v : loop.vertices) {
      middle += network.positions.row(v);
      ++count;
    }
  middle /= count;
  double area = 0;
  for (const NetworkCycle::Loop& loop : cycle.loops)
    for (std::size_t i = 0; i < loop.vertices.size(); ++i) {
      const Eigen::RowVector3d a = network.positions.row(loop.vertices[i]) - middle,
                               b = network.positions.row(loop.vertices[(i + 1) % loop.vertices.size()]) -
                                   middle;
      area += 0.5 * a.cross(b).norm();
    }
  return count + kTrianglesPerSquare * area / (edge * edge);
}

PatchMesh mesh_patch(const ScaledNetwork& network, const NetworkCycle& cycle, int patch,
                     const PatchFilling& filling, std::string& warning) {
  const double unit = mean_edge(network, cycle), edge = filling.edge > 0 ? filling.edge : kInnerEdge * unit;
  for (const NetworkCycle::Loop& loop : cycle.loops)
    if (loop.vertices.size() < 3)
      throw InvalidInput(
          concat(patch_name(cycle, patch), " has ", loop.vertices.size(),
                 " vertices; a patch needs at least three, so sample its curves more densely"));
  PatchMesh mesh;
  std::string problem;
  const bool one_loop = cycle.loops.size() == 1;
  const auto fill = [&](PatchLayout layout, const LaidOut& laid_out) {
    mesh.layout = layout;
    return fill_plane(laid_out, edge, unit, mesh, problem);
  };
  const auto fill_unrolled = [&] {
    const auto laid_out = one_loop ? lay_out_unrolled(network, cycle, unit) : std::nullopt;
    return laid_out && fill(PatchLayout::Unrolled, *laid_out);
  };
  if (filling.attempt == 2) {
    warning =
        concat(patch_name(cycle, patch), " folded over from its plane layout; it was triangulated in space");
    return mesh_patch_in_space(network, cycle, patch, edge);
  }
  if (cycle.loops.size() == 2 && is_tube(network, cycle)) {
    if (fill(PatchLayout::Strip, lay_out_strip(network, cycle, edge, unit))) return mesh;
  } else if (filling.map == PatchMap::Plane) {
    const LaidOut plane = lay_out_in_plane(network, cycle, unit);
    const bool is_steep =
        filling.normals_are_measured && one_loop && least_shown(network, cycle, plane, unit) < kLeastShown;
    const bool unrolled_first = is_steep == (filling.attempt == 0);
    if (unrolled_first && fill_unrolled()) return mesh;
    if (fill(PatchLayout::Plane, plane)) return mesh;
    if (!unrolled_first && filling.normals_are_measured && fill_unrolled()) return mesh;
  } else if (one_loop) {
    if (filling.attempt > 0 && fill_unrolled()) return mesh;
    if (fill(filling.map == PatchMap::Circle ? PatchLayout::Circle : PatchLayout::Polygon,
             lay_out_by_length(network, cycle, filling.map == PatchMap::Polygon, unit)))
      return mesh;
  } else {
    problem = "it has several boundary loops";
  }
  warning = concat(patch_name(cycle, patch), " cannot be laid out in the plane, as ", problem,
                   "; it was triangulated in space");
  return mesh_patch_in_space(network, cycle, patch, edge);
}

}  // namespace batten::detail
