#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/parallel.hpp"
#include "batten/core/units.hpp"
#include "batten/subdivision/cage_polylines_detail.hpp"
#include "batten/subdivision/four_point_detail.hpp"
#include "batten/subdivision/interpolatory_rules_detail.hpp"

namespace batten::detail {

namespace {

using Row = Eigen::RowVector3d;

/// A step along a row of vertices: the edge by which it came to `vertex`.
struct Arrival {
  int edge = -1, vertex = -1;
};

/// How the row that reaches a vertex goes on there. `next` is set where it goes on along an edge.
FurtherPoint continued(const CageLevel& level, const Arrival& arrival, std::vector<CageSpoke>& spokes,
                       Arrival& next) {
  next = {};
  const VertexKind kind = level.kind[at(arrival.vertex)];
  const bool along_sharp = level.is_sharp(arrival.edge);
  if (kind == VertexKind::Corner || (kind == VertexKind::Crease && !along_sharp)) return {};
  spokes_around(level, arrival.vertex, spokes);
  const int n = static_cast<int>(spokes.size());
  int i = 0;
  while (spokes[at(i)].edge != arrival.edge) ++i;
  int onward = -1;
  if (kind == VertexKind::Crease) {
    for (int k = 0; k < n; ++k)
      if (k != i && level.is_sharp(spokes[at(k)].edge)) onward = k;
  } else if (n == 4 || n == 2) {
    onward = (i + n / 2) % n;
  }
  if (onward >= 0) {
    const CageSpoke& spoke = spokes[at(onward)];
    next = {spoke.edge, spoke.to};
    return {true, level.point(spoke.to), level.interval[at(spoke.edge)]};
  }
  // An extraordinary vertex: the neighbour with its part that is linear around the vertex turned about. At
  // four edges this is the opposite neighbour.
  const Row centre = level.point(arrival.vertex);
  Row slope = Row::Zero();
  for (int j = 0; j < n; ++j)
    slope += std::cos(2 * kPi * (j - i) / n) / level.interval[at(spokes[at(j)].edge)] *
             (level.point(spokes[at(j)].to) - centre);
  slope *= 2.0 / n;
  const double interval = level.interval[at(arrival.edge)];
  return {true, level.point(spokes[at(i)].to) - 2 * interval * slope, interval};
}

Row nuliss_edge_point(const CageLevel& level, int e, std::vector<CageSpoke>& spokes) {
  const std::array<int, 2>& ends = level.topology.edges[at(e)];
  return four_point(level.point(ends[0]), level.point(ends[1]), level.interval[at(e)],
                    [&](int side, int k) -> FurtherPoint {
                      Arrival next;
                      const FurtherPoint first = continued(level, {e, ends[at(side)]}, spokes, next);
                      if (k == 0 || next.edge < 0) return k == 0 ? first : FurtherPoint();
                      Arrival last;
                      return continued(level, next, spokes, last);
                    });
}

/// The step of a strip of quads: into a face through one of its corners' sides.
FurtherPoint continued_strip(const CageLevel& level, const CageEdgePoints& edges, int corner, int& onward) {
  onward = -1;
  const int across = level.topology.opposite(corner);
  if (across < 0 || level.is_sharp(level.edge(corner))) return {};
  if (level.n_corners(level.topology.face_of_corner[at(across)]) != 4) return {};
  const int left = level.topology.previous[at(across)], right = level.topology.next[at(across)];
  onward = level.topology.next[at(right)];
  return {true, edges.points.row(level.edge(onward)),
          0.5 * (level.interval[at(level.edge(left))] + level.interval[at(level.edge(right))])};
}

bool is_regular_quad(const CageLevel& level, int face) {
  if (level.n_corners(face) != 4) return false;
  for (int c = level.mesh.offsets[at(face)]; c < level.mesh.offsets[at(face) + 1]; ++c) {
    const int across = level.topology.opposite(c);
    if (across >= 0 && !level.is_sharp(level.edge(c)) &&
        level.n_corners(level.topology.face_of_corner[at(across)]) != 4)
      return false;
  }
  return true;
}

/// The mean of the four-point rule on edge points along both strips; they agree where knots are those of a
/// tensor product.
Row strip_point(const CageLevel& level, const CageEdgePoints& edges, int face) {
  const int first = level.mesh.offsets[at(face)];
  Row sum = Row::Zero();
  for (int direction = 0; direction < 2; ++direction) {
    const int c0 = first + direction, c2 = first + direction + 2;
    const int side_a = first + (direction + 1) % 4, side_b = first + (direction + 3) % 4;
    const double interval =
        0.5 * (level.interval[at(level.edge(side_a))] + level.interval[at(level.edge(side_b))]);
    sum += four_point(edges.points.row(level.edge(c0)), edges.points.row(level.edge(c2)), interval,
                      [&](int side, int k) -> FurtherPoint {
                        int onward = -1;
                        const FurtherPoint one = continued_strip(level, edges, side == 0 ? c0 : c2, onward);
                        if (k == 0 || onward < 0) return k == 0 ? one : FurtherPoint();
                        int last = -1;
                        return continued_strip(level, edges, onward, last);
                      });
  }
  return sum / 2;
}

/// Of any polygon: exact for quadratic functions on a regular one, and the middle of the Coons patch of a
/// quad.
Row polygon_point(const CageLevel& level, const CageEdgePoints& edges, int face) {
  const int n = level.n_corners(face);
  Row bulge = Row::Zero();
  for (int c = level.mesh.offsets[at(face)]; c < level.mesh.offsets[at(face) + 1]; ++c)
    bulge += edges.points.row(level.edge(c)) -
             0.5 * (level.point(level.vertex(c)) + level.point(level.end_vertex(c)));
  const double sine = std::sin(kPi / n);
  return centroid(level, face) + bulge / (n * sine * sine);
}

/// The Coons patch of the polylines of a quad, at the means of the parameters of opposite edge points, both
/// read in the same sense (H 6.3.1, docs/errata.md#h-6-3-1). False when an edge has no polyline.
bool coons_point(const CageLevel& level, const CageEdgePoints& edges, int face, Row& point) {
  const int first = level.mesh.offsets[at(face)];
  const Points* curve[4];
  double parameter[4];  // of the edge point, counted from the side's first corner
  bool along[4];
  for (int k = 0; k < 4; ++k) {
    const int e = level.edge(first + k);
    if (level.polyline[at(e)] < 0) return false;
    curve[k] = &level.polylines[at(level.polyline[at(e)])];
    along[k] = level.topology.edges[at(e)][0] == level.vertex(first + k);
    parameter[k] = along[k] ? edges.fraction[at(e)] : 1 - edges.fraction[at(e)];
  }
  const auto on = [&](int k, double t) { return point_along(*curve[k], along[k] ? t : 1 - t); };
  const double u = 0.5 * (parameter[0] + 1 - parameter[2]), v = 0.5 * (parameter[1] + 1 - parameter[3]);
  const auto corner = [&](int k) { return level.point(level.vertex(first + k)); };
  point = (1 - v) * on(0, u) + v * on(2, 1 - u) + (1 - u) * on(3, 1 - v) + u * on(1, v) -
          (1 - u) * (1 - v) * corner(0) - u * (1 - v) * corner(1) - u * v * corner(2) -
          (1 - u) * v * corner(3);
  return true;
}

/// Per vertex the sum of the areas of its faces, as vectors.
Points face_areas(const CageLevel& level) {
  Points areas = Points::Zero(level.mesh.positions.rows(), 3);
  for (int f = 0; f < level.mesh.n_faces(); ++f) {
    const Row middle = centroid(level, f);
    Row area = Row::Zero();
    const int begin = level.mesh.offsets[at(f)], end = level.mesh.offsets[at(f) + 1];
    for (int c = begin; c < end; ++c)
      area += (level.point(level.vertex(c)) - middle).cross(level.point(level.end_vertex(c)) - middle);
    for (int c = begin; c < end; ++c) areas.row(level.vertex(c)) += area;
  }
  return areas;
}

/// The normal of the part of the surface that is linear around a vertex, not of unit length. False where its
/// two slopes are parallel.
bool linear_normal(const CageLevel& level, int v, std::vector<CageSpoke>& spokes,
                   std::vector<CageSpoke>& scratch, Row& normal) {
  spokes_around(level, v, spokes);
  const int n = static_cast<int>(spokes.size());
  Row first = Row::Zero(), second = Row::Zero();
  for (int j = 0; j < n; ++j) {
    const Row near = level.point(spokes[at(j)].to) - level.point(v);
    const double d = level.interval[at(spokes[at(j)].edge)];
    Arrival next;
    const FurtherPoint further = continued(level, {spokes[at(j)].edge, spokes[at(j)].to}, scratch, next);
    Row slope = near / d;
    if (further.exists) {
      const double far = d + further.interval;
      slope = (far * far * far * near - d * d * d * (further.point - level.point(v))) /
              (d * far * far * far - far * d * d * d);
    }
    first += std::cos(2 * kPi * j / n) * slope;
    second += std::sin(2 * kPi * j / n) * slope;
  }
  normal = first.cross(second);
  return normal.norm() > 1e-12 * first.norm() * second.norm();
}

}  // namespace

CageEdgePoints edge_points(const CageLevel& level, SubdivisionScheme scheme) {
  const Eigen::Index n = static_cast<Eigen::Index>(level.topology.edges.size());
  CageEdgePoints result{Points(n, 3), std::vector<double>(static_cast<size_t>(n), 0.5)};
  parallel_for(n, 2048, [&](Eigen::Index begin, Eigen::Index end) {
    std::vector<CageSpoke> spokes;
    for (int e = static_cast<int>(begin); e < end; ++e) {
      const std::array<int, 2>& ends = level.topology.edges[at(e)];
      Row point = scheme == SubdivisionScheme::Linear
                      ? Row(0.5 * (level.point(ends[0]) + level.point(ends[1])))
                      : nuliss_edge_point(level, e, spokes);
      const int polyline = level.polyline[at(e)];
      if (polyline >= 0 && scheme != SubdivisionScheme::Nuliss) {
        const Points& curve = level.polylines[at(polyline)];
        // A nearest point at an end of the polyline would leave an edge without length.
        constexpr double kFromEnd = 0.125;
        const double fraction = scheme == SubdivisionScheme::Linear
                                    ? 0.5
                                    : std::clamp(nearest_fraction(curve, point), kFromEnd, 1 - kFromEnd);
        result.fraction[at(e)] = fraction;
        point = point_along(curve, fraction);
      }
      result.points.row(e) = point;
    }
  });
  return result;
}

Points face_points(const CageLevel& level, const CageEdgePoints& edges, SubdivisionScheme scheme,
                   bool coons) {
  Points points(level.mesh.n_faces(), 3);
  parallel_for(points.rows(), 2048, [&](Eigen::Index begin, Eigen::Index end) {
    for (int f = static_cast<int>(begin); f < end; ++f) {
      Row point;
      if (scheme == SubdivisionScheme::Linear)
        points.row(f) = centroid(level, f);
      else if (coons && level.n_corners(f) == 4 && coons_point(level, edges, f, point))
        points.row(f) = point;
      else
        points.row(f) =
            is_regular_quad(level, f) ? strip_point(level, edges, f) : polygon_point(level, edges, f);
    }
  });
  return points;
}

Points limit_normals(const CageLevel& level) {
  Points normals = Points::Zero(level.mesh.positions.rows(), 3);
  const Points areas = face_areas(level);
  parallel_for(normals.rows(), 2048, [&](Eigen::Index begin, Eigen::Index end) {
    std::vector<CageSpoke> spokes, scratch;
    for (int v = static_cast<int>(begin); v < end; ++v) {
      Row normal = areas.row(v);
      if (level.kind[at(v)] == VertexKind::Smooth || level.kind[at(v)] == VertexKind::Dart) {
        Row linear;
        if (linear_normal(level, v, spokes, scratch, linear)) normal = linear;
      }
      const double length = normal.norm();
      normals.row(v) = length > 0 ? Row(normal / length) : Row(0, 0, 1);
    }
  });
  return normals;
}

}  // namespace batten::detail
