// Interpolatory subdivision of quad meshes with a knot interval per edge, after [beccari2008] and
// [beccari2013]: four-point rules along rows of vertices and of edge points. H 6.3.1 cites it without its
// rules; those written here stand in docs/subdivide.md with the source of each.
#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/parallel.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/subdivision/interpolatory_detail.hpp"

namespace batten::detail {

namespace {

using Row = Eigen::RowVector3d;

/// The polynomial through `n` points over their knots, at t (Lagrange).
Row interpolated(const double* knots, const Row* points, int n, double t) {
  Row sum = Row::Zero();
  for (int i = 0; i < n; ++i) {
    double weight = 1;
    for (int j = 0; j < n; ++j)
      if (j != i) weight *= (t - knots[j]) / (knots[i] - knots[j]);
    sum += weight * points[i];
  }
  return sum;
}

/// A point further along a row, and the knot interval that leads to it.
struct Further {
  bool exists = false;
  Row point = Row::Zero();
  double interval = 0;
};

/// The point halfway between p and q of a row: the cubic through four points, one beyond each end; at the end
/// of a row through the two beyond the other one; the parabola or the straight line where there are fewer.
/// `beyond(side, k)` gives the k-th point beyond p (side 0) or q (side 1), k = 0 or 1.
template <typename Beyond>
Row four_point(const Row& p, const Row& q, double interval, const Beyond& beyond) {
  const Further before = beyond(0, 0), after = beyond(1, 0);
  double knots[4] = {0, interval, 0, 0};
  Row points[4] = {p, q, Row::Zero(), Row::Zero()};
  int n = 2;
  const auto add = [&](double knot, const Row& point) {
    knots[n] = knot;
    points[n++] = point;
  };
  if (before.exists) add(-before.interval, before.point);
  if (after.exists) add(interval + after.interval, after.point);
  if (before.exists != after.exists) {
    const Further second = beyond(before.exists ? 0 : 1, 1);
    if (second.exists && before.exists) add(-before.interval - second.interval, second.point);
    if (second.exists && after.exists) add(interval + after.interval + second.interval, second.point);
  }
  return interpolated(knots, points, n, interval / 2);
}

/// The length of a polyline up to each of its points.
std::vector<double> lengths_along(const Points& points) {
  std::vector<double> lengths(static_cast<size_t>(points.rows()), 0.0);
  for (Eigen::Index k = 1; k < points.rows(); ++k)
    lengths[static_cast<size_t>(k)] =
        lengths[static_cast<size_t>(k) - 1] + (points.row(k) - points.row(k - 1)).norm();
  return lengths;
}

/// The point of a polyline at a fraction of its length.
Row point_along(const Points& points, double fraction) {
  const std::vector<double> lengths = lengths_along(points);
  const double wanted = fraction * lengths.back();
  for (Eigen::Index k = 1; k < points.rows(); ++k) {
    const double begin = lengths[static_cast<size_t>(k) - 1], end = lengths[static_cast<size_t>(k)];
    if (wanted <= end && end > begin)
      return points.row(k - 1) + (wanted - begin) / (end - begin) * (points.row(k) - points.row(k - 1));
  }
  return points.row(points.rows() - 1);
}

/// Where on a polyline, as a fraction of its length, the point nearest to `query` lies.
double nearest_fraction(const Points& points, const Row& query) {
  const std::vector<double> lengths = lengths_along(points);
  double best = -1, fraction = 0.5;
  for (Eigen::Index k = 1; k < points.rows(); ++k) {
    const Row along = points.row(k) - points.row(k - 1);
    const double squared = along.squaredNorm();
    const double t =
        squared > 0 ? std::clamp((query - points.row(k - 1)).dot(along) / squared, 0.0, 1.0) : 0.0;
    const double distance = (points.row(k - 1) + t * along - query).squaredNorm();
    if (best < 0 || distance < best) {
      best = distance;
      if (lengths.back() > 0)
        fraction = (lengths[static_cast<size_t>(k) - 1] + t * std::sqrt(squared)) / lengths.back();
    }
  }
  return fraction;
}

/// The two parts of a polyline, cut at a fraction of its length.
std::pair<Points, Points> cut(const Points& points, double fraction) {
  const std::vector<double> lengths = lengths_along(points);
  const double wanted = fraction * lengths.back();
  const Row middle = point_along(points, fraction);
  Eigen::Index n_before = 1;
  while (n_before + 1 < points.rows() && lengths[static_cast<size_t>(n_before)] < wanted) ++n_before;
  Eigen::Index n_after = points.rows() - n_before;
  // A point of the polyline at the cut itself is not kept twice.
  if (n_after > 1 && lengths[static_cast<size_t>(n_before)] <= wanted) --n_after;
  Points first(n_before + 1, 3), second(n_after + 1, 3);
  first.topRows(n_before) = points.topRows(n_before);
  first.row(n_before) = middle;
  second.row(0) = middle;
  second.bottomRows(n_after) = points.bottomRows(n_after);
  return {std::move(first), std::move(second)};
}

/// The cage at one level, with what the rules need.
struct Level {
  PolygonMesh mesh;
  CageTopology topology;
  std::vector<double> interval;        // knot interval per edge
  std::vector<double> edge_sharpness;  // per edge, what is left
  std::vector<double> vertex_sharpness;
  std::vector<int> polyline;      // per edge an index into `polylines`, or −1
  std::vector<Points> polylines;  // as the edge runs
  std::vector<VertexKind> kind;   // per vertex

  Row point(int vertex) const { return mesh.positions.row(vertex); }
  int vertex(int corner) const { return mesh.corners[at(corner)]; }
  int end_vertex(int corner) const { return vertex(topology.next[at(corner)]); }
  int edge(int corner) const { return topology.edge_of_corner[at(corner)]; }
  int n_corners(int face) const { return mesh.offsets[at(face) + 1] - mesh.offsets[at(face)]; }
  bool is_sharp(int e) const { return topology.sides[at(e)][1] < 0 || edge_sharpness[at(e)] > 0; }
};

void find_kinds(Level& level, bool smooth_corners) {
  const size_t n = static_cast<size_t>(level.mesh.positions.rows());
  std::vector<int> n_sharp(n, 0), n_edges(n, 0);
  for (size_t e = 0; e < level.topology.edges.size(); ++e)
    for (const int v : level.topology.edges[e]) {
      ++n_edges[at(v)];
      n_sharp[at(v)] += level.is_sharp(static_cast<int>(e));
    }
  level.kind.resize(n);
  for (size_t v = 0; v < n; ++v) {
    const bool border_corner = level.topology.is_border[v] != 0 && n_edges[v] == 2 && !smooth_corners;
    if (level.vertex_sharpness[v] > 0 || n_sharp[v] > 2 || border_corner)
      level.kind[v] = VertexKind::Corner;
    else
      level.kind[v] = n_sharp[v] == 2   ? VertexKind::Crease
                      : n_sharp[v] == 1 ? VertexKind::Dart
                                        : VertexKind::Smooth;
  }
}

/// An edge as it leaves one of its vertices.
struct Spoke {
  int edge = -1;
  int to = -1;  ///< its other vertex
};

/// The edges around a vertex, counter-clockwise. At the border from border to border.
void spokes_around(const Level& level, int vertex, std::vector<Spoke>& spokes) {
  spokes.clear();
  const int first = level.topology.corner_of_vertex[at(vertex)];
  int c = first;
  do {
    spokes.push_back({level.edge(c), level.end_vertex(c)});
    const int before = level.topology.previous[at(c)];
    c = level.topology.opposite(before);
    if (c < 0) spokes.push_back({level.edge(before), level.vertex(before)});
  } while (c >= 0 && c != first);
}

/// A step along a row of vertices: the edge by which it came to `vertex`.
struct Arrival {
  int edge = -1, vertex = -1;
};

/// How the row that reaches a vertex goes on there. `next` is set where it goes on along an edge.
Further continued(const Level& level, const Arrival& arrival, std::vector<Spoke>& spokes, Arrival& next) {
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
    const Spoke& spoke = spokes[at(onward)];
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

Row nuliss_edge_point(const Level& level, int e, std::vector<Spoke>& spokes) {
  const std::array<int, 2>& ends = level.topology.edges[at(e)];
  return four_point(level.point(ends[0]), level.point(ends[1]), level.interval[at(e)],
                    [&](int side, int k) -> Further {
                      Arrival next;
                      const Further first = continued(level, {e, ends[at(side)]}, spokes, next);
                      if (k == 0 || next.edge < 0) return k == 0 ? first : Further();
                      Arrival last;
                      return continued(level, next, spokes, last);
                    });
}

/// Edge points of one level.
struct EdgePoints {
  Points points;                 // e × 3
  std::vector<double> fraction;  // where they cut the polylines
};

EdgePoints edge_points(const Level& level, SubdivisionScheme scheme) {
  const Eigen::Index n = static_cast<Eigen::Index>(level.topology.edges.size());
  EdgePoints result{Points(n, 3), std::vector<double>(static_cast<size_t>(n), 0.5)};
  parallel_for(n, 2048, [&](Eigen::Index begin, Eigen::Index end) {
    std::vector<Spoke> spokes;
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

/// The step of a strip of quads: into a face through one of its corners' sides.
Further continued_strip(const Level& level, const EdgePoints& edges, int corner, int& onward) {
  onward = -1;
  const int across = level.topology.opposite(corner);
  if (across < 0 || level.is_sharp(level.edge(corner))) return {};
  if (level.n_corners(level.topology.face_of_corner[at(across)]) != 4) return {};
  const int left = level.topology.previous[at(across)], right = level.topology.next[at(across)];
  onward = level.topology.next[at(right)];
  return {true, edges.points.row(level.edge(onward)),
          0.5 * (level.interval[at(level.edge(left))] + level.interval[at(level.edge(right))])};
}

bool is_regular_quad(const Level& level, int face) {
  if (level.n_corners(face) != 4) return false;
  for (int c = level.mesh.offsets[at(face)]; c < level.mesh.offsets[at(face) + 1]; ++c) {
    const int across = level.topology.opposite(c);
    if (across >= 0 && !level.is_sharp(level.edge(c)) &&
        level.n_corners(level.topology.face_of_corner[at(across)]) != 4)
      return false;
  }
  return true;
}

Row centroid(const Level& level, int face) {
  Row sum = Row::Zero();
  for (int c = level.mesh.offsets[at(face)]; c < level.mesh.offsets[at(face) + 1]; ++c)
    sum += level.point(level.vertex(c));
  return sum / level.n_corners(face);
}

/// The mean of the four-point rule on edge points along both strips; they agree where knots are those of a
/// tensor product.
Row strip_point(const Level& level, const EdgePoints& edges, int face) {
  const int first = level.mesh.offsets[at(face)];
  Row sum = Row::Zero();
  for (int direction = 0; direction < 2; ++direction) {
    const int c0 = first + direction, c2 = first + direction + 2;
    const int side_a = first + (direction + 1) % 4, side_b = first + (direction + 3) % 4;
    const double interval =
        0.5 * (level.interval[at(level.edge(side_a))] + level.interval[at(level.edge(side_b))]);
    sum += four_point(edges.points.row(level.edge(c0)), edges.points.row(level.edge(c2)), interval,
                      [&](int side, int k) -> Further {
                        int onward = -1;
                        const Further one = continued_strip(level, edges, side == 0 ? c0 : c2, onward);
                        if (k == 0 || onward < 0) return k == 0 ? one : Further();
                        int last = -1;
                        return continued_strip(level, edges, onward, last);
                      });
  }
  return sum / 2;
}

/// Of any polygon: exact for quadratic functions on a regular one, and the middle of the Coons patch of a
/// quad.
Row polygon_point(const Level& level, const EdgePoints& edges, int face) {
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
bool coons_point(const Level& level, const EdgePoints& edges, int face, Row& point) {
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

Points face_points(const Level& level, const EdgePoints& edges, SubdivisionScheme scheme, bool coons) {
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

/// One level finer. `halves` receives per edge the finer edges from its first and to its second vertex.
Level refined(const Level& level, const EdgePoints& edges, const Points& faces, bool keep_polylines,
              bool smooth_corners, std::vector<std::array<int, 2>>& halves) {
  const int n_vertices = static_cast<int>(level.mesh.positions.rows());
  const int n_edges = static_cast<int>(level.topology.edges.size());
  Level fine;
  fine.mesh.positions.resize(n_vertices + n_edges + faces.rows(), 3);
  fine.mesh.positions << level.mesh.positions, edges.points, faces;
  fine.mesh.corners.reserve(4 * level.mesh.corners.size());
  fine.mesh.offsets.reserve(level.mesh.corners.size() + 1);
  for (int c = 0; c < static_cast<int>(level.mesh.corners.size()); ++c) {
    const int face = level.topology.face_of_corner[at(c)];
    for (const int v : {level.vertex(c), n_vertices + level.edge(c), n_vertices + n_edges + face,
                        n_vertices + level.edge(level.topology.previous[at(c)])})
      fine.mesh.corners.push_back(v);
    fine.mesh.offsets.push_back(static_cast<int>(fine.mesh.corners.size()));
  }
  fine.topology = cage_topology(fine.mesh);
  const size_t n_fine = fine.topology.edges.size();
  fine.interval.assign(n_fine, 0);
  fine.edge_sharpness.assign(n_fine, 0);
  fine.polyline.assign(n_fine, -1);
  halves.assign(at(n_edges), {-1, -1});
  std::vector<std::pair<Points, Points>> pieces(at(n_edges));
  for (size_t e = 0; e < n_fine; ++e) {
    const std::array<int, 2>& ends = fine.topology.edges[e];
    const int low = std::min(ends[0], ends[1]), high = std::max(ends[0], ends[1]);
    if (low < n_vertices) {  // half of a coarser edge
      const int parent = high - n_vertices;
      const int half = level.topology.edges[at(parent)][0] == low ? 0 : 1;
      halves[at(parent)][at(half)] = static_cast<int>(e);
      fine.interval[e] = level.interval[at(parent)] / 2;
      fine.edge_sharpness[e] = sharpness_after(level.edge_sharpness[at(parent)], 1);
      if (keep_polylines && level.polyline[at(parent)] >= 0) {
        auto& [first, second] = pieces[at(parent)];
        if (first.rows() == 0)
          std::tie(first, second) =
              cut(level.polylines[at(level.polyline[at(parent)])], edges.fraction[at(parent)]);
        Points piece = half == 0 ? first : second;
        const bool from_vertex = half == 0;  // the piece runs as the coarser edge does
        if ((ends[0] == low) != from_vertex) piece = Points(piece.colwise().reverse());
        fine.polyline[e] = static_cast<int>(fine.polylines.size());
        fine.polylines.push_back(std::move(piece));
      }
    } else {  // from an edge point to a face point, between the two sides beside the edge
      const int parent = low - n_vertices, face = high - n_vertices - n_edges;
      for (const int c : level.topology.sides[at(parent)])
        if (c >= 0 && level.topology.face_of_corner[at(c)] == face)
          fine.interval[e] = 0.25 * (level.interval[at(level.edge(level.topology.previous[at(c)]))] +
                                     level.interval[at(level.edge(level.topology.next[at(c)]))]);
    }
  }
  fine.vertex_sharpness.assign(static_cast<size_t>(fine.mesh.positions.rows()), 0.0);
  for (int v = 0; v < n_vertices; ++v)
    fine.vertex_sharpness[at(v)] = sharpness_after(level.vertex_sharpness[at(v)], 1);
  find_kinds(fine, smooth_corners);
  return fine;
}

/// The normal of the limit surface at a smooth vertex: that of the part which is linear around it. Along each
/// row the odd cubic through the first two neighbours gives the limit slope of the four-point rule.
Points limit_normals(const Level& level) {
  Points normals = Points::Zero(level.mesh.positions.rows(), 3);
  Points areas = Points::Zero(level.mesh.positions.rows(), 3);
  for (int f = 0; f < level.mesh.n_faces(); ++f) {
    const Row middle = centroid(level, f);
    Row area = Row::Zero();
    const int begin = level.mesh.offsets[at(f)], end = level.mesh.offsets[at(f) + 1];
    for (int c = begin; c < end; ++c)
      area += (level.point(level.vertex(c)) - middle).cross(level.point(level.end_vertex(c)) - middle);
    for (int c = begin; c < end; ++c) areas.row(level.vertex(c)) += area;
  }
  parallel_for(normals.rows(), 2048, [&](Eigen::Index begin, Eigen::Index end) {
    std::vector<Spoke> spokes, scratch;
    for (int v = static_cast<int>(begin); v < end; ++v) {
      Row normal = areas.row(v);
      if (level.kind[at(v)] == VertexKind::Smooth || level.kind[at(v)] == VertexKind::Dart) {
        spokes_around(level, v, spokes);
        const int n = static_cast<int>(spokes.size());
        Row first = Row::Zero(), second = Row::Zero();
        for (int j = 0; j < n; ++j) {
          const Row near = level.point(spokes[at(j)].to) - level.point(v);
          const double d = level.interval[at(spokes[at(j)].edge)];
          Arrival next;
          const Further further = continued(level, {spokes[at(j)].edge, spokes[at(j)].to}, scratch, next);
          Row slope = near / d;
          if (further.exists) {
            const double far = d + further.interval;
            slope = (far * far * far * near - d * d * d * (further.point - level.point(v))) /
                    (d * far * far * far - far * d * d * d);
          }
          first += std::cos(2 * kPi * j / n) * slope;
          second += std::sin(2 * kPi * j / n) * slope;
        }
        const Row cross = first.cross(second);
        if (cross.norm() > 1e-12 * first.norm() * second.norm()) normal = cross;
      }
      const double length = normal.norm();
      normals.row(v) = length > 0 ? Row(normal / length) : Row(0, 0, 1);
    }
  });
  return normals;
}

Level base_level(const ControlCage& cage, const CageTopology& topology, const SubdivisionOptions& options) {
  Level level;
  level.mesh = cage.mesh;
  level.topology = topology;
  level.edge_sharpness = edge_sharpness(cage, topology);
  level.vertex_sharpness = vertex_sharpness(cage);
  const size_t n = topology.edges.size();
  level.polyline.assign(n, -1);
  const double diameter = bounding_box_diagonal(cage.mesh.positions);
  for (const EdgePolyline& polyline : cage.polylines) {
    const int e = edge_between(topology, cage.mesh, polyline.from, polyline.to, "the polyline");
    const auto name = [&] {
      return concat("the polyline between vertices ", polyline.from, " and ", polyline.to);
    };
    if (polyline.points.rows() < 2) throw InvalidInput(name() + " needs two points at least");
    if (!polyline.points.allFinite()) throw InvalidInput(name() + " has a point that is not finite");
    constexpr double kAtVertex = 1e-6;  // of the diameter; drawn curves are snapped to their vertices
    if ((polyline.points.row(0) - level.point(polyline.from)).norm() > kAtVertex * diameter ||
        (polyline.points.bottomRows(1) - level.point(polyline.to)).norm() > kAtVertex * diameter)
      throw InvalidInput(name() + " does not begin and end at these vertices; snap its ends to them");
    if (level.polyline[at(e)] >= 0) throw InvalidInput(name() + " is given twice; keep one of both");
    level.polyline[at(e)] = static_cast<int>(level.polylines.size());
    level.polylines.push_back(polyline.points);
    if (topology.edges[at(e)][0] != polyline.from)
      level.polylines.back() = Points(polyline.points.colwise().reverse());
  }
  level.interval.resize(n);
  double sum = 0;
  for (size_t e = 0; e < n; ++e) {
    const double length =
        level.polyline[e] >= 0
            ? lengths_along(level.polylines[at(level.polyline[e])]).back()
            : (level.point(topology.edges[e][1]) - level.point(topology.edges[e][0])).norm();
    level.interval[e] = std::pow(length, options.knot_exponent);
    sum += level.interval[e];
  }
  // Edges without length would put two points on one knot.
  constexpr double kLeast = 1e-4;
  const double least = sum > 0 ? kLeast * sum / static_cast<double>(n) : 1.0;
  for (double& interval : level.interval) interval = std::max(interval, least);
  find_kinds(level, options.smooth_corners);
  return level;
}

}  // namespace

void refine_interpolatory(const ControlCage& cage, const CageTopology& topology,
                          const SubdivisionOptions& options, SubdividedSurface& surface,
                          const Progress& progress) {
  Level level = base_level(cage, topology, options);
  const bool follow = options.scheme != SubdivisionScheme::Nuliss;
  const int n_edges = static_cast<int>(topology.edges.size());
  surface.cage_edges = topology.edges;
  surface.face_parent.resize(static_cast<size_t>(cage.mesh.n_faces()));
  for (size_t f = 0; f < surface.face_parent.size(); ++f) surface.face_parent[f] = static_cast<int>(f);
  // Per edge of the cage the edges into which it was refined, in order.
  std::vector<std::vector<int>> links(at(n_edges));
  for (int e = 0; e < n_edges; ++e) links[at(e)] = {e};
  for (int k = 0; k < options.levels; ++k) {
    // Level k of L costs 4ᵏ.
    progress.report("subdivide", std::pow(4.0, k - options.levels));
    const EdgePoints edges = edge_points(level, options.scheme);
    // Coons points where all four polylines are those of the cage: in the first level (H 6.3.1).
    const Points faces =
        face_points(level, edges, options.scheme, options.scheme == SubdivisionScheme::NulissMod && k == 0);
    std::vector<std::array<int, 2>> halves;
    std::vector<int> parents;
    parents.reserve(level.mesh.corners.size());
    for (const int face : level.topology.face_of_corner) parents.push_back(surface.face_parent[at(face)]);
    Level fine = refined(level, edges, faces, follow, options.smooth_corners, halves);
    for (int e = 0; e < n_edges; ++e) {
      std::vector<int> finer;
      int from = topology.edges[at(e)][0];
      for (const int link : links[at(e)]) {
        const std::array<int, 2>& ends = level.topology.edges[at(link)];
        const bool forward = ends[0] == from;
        finer.push_back(halves[at(link)][forward ? 0 : 1]);
        finer.push_back(halves[at(link)][forward ? 1 : 0]);
        from = forward ? ends[1] : ends[0];
      }
      links[at(e)] = std::move(finer);
    }
    surface.face_parent = std::move(parents);
    level = std::move(fine);
  }
  surface.edge_chains.resize(n_edges, (Eigen::Index(1) << options.levels) + 1);
  for (int e = 0; e < n_edges; ++e) {
    int v = topology.edges[at(e)][0];
    surface.edge_chains(e, 0) = v;
    for (size_t i = 0; i < links[at(e)].size(); ++i) {
      const std::array<int, 2>& ends = level.topology.edges[at(links[at(e)][i])];
      v = ends[0] == v ? ends[1] : ends[0];
      surface.edge_chains(e, static_cast<Eigen::Index>(i) + 1) = v;
    }
  }
  if (options.limit) {
    surface.limit_positions = level.mesh.positions;
    surface.limit_normals = limit_normals(level);
  }
  if (follow)
    for (size_t e = 0; e < level.polyline.size(); ++e)
      if (level.polyline[e] >= 0)
        surface.cage.polylines.push_back(
            {level.topology.edges[e][0], level.topology.edges[e][1], level.polylines[at(level.polyline[e])]});
  surface.cage.mesh = std::move(level.mesh);
}

}  // namespace batten::detail
