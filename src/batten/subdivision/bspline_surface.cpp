// Catmull–Clark limit surfaces as bicubic B-splines. A control point of a B-spline with simple inner knots a
// ≤ b ≤ c is the polar form (blossom) of the polynomial of a nearby cell at (a, b, c) [ramshaw1989]; the
// cells are the uniform B-splines that adaptive refinement leaves, so nothing is fitted where the surface is
// regular.
#include "batten/subdivision/bspline_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "batten/core/disjoint_sets.hpp"
#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/subdivision/cage_topology_detail.hpp"
#include "batten/subdivision/catmull_clark_detail.hpp"
#include "batten/subdivision/subdivide.hpp"

namespace batten {

namespace {

using detail::CageTopology;
using detail::LimitCell;
using Row = Eigen::RowVector3d;
using Weights = Eigen::RowVector4d;
using Arguments = std::array<double, 3>;

constexpr int kMostPatches = 200000;
/// Two halvings part the cells at the two ends of an edge.
constexpr int kLeastIsolation = 2;
/// Halvings beyond the isolation down to which the limit surface is sampled.
constexpr int kSampledHalvings = 4;

/// Weights of the four control points of a uniform cubic over [0, 1] in its polar form at three arguments.
Weights polar_weights(const Arguments& t) {
  Eigen::Matrix4d points = Eigen::Matrix4d::Identity();
  for (int step = 0; step < 3; ++step)
    for (int i = 0; i + step < 3; ++i) {
      const int begin = i - 2 + step, width = 3 - step;
      const double w = (t[at(step)] - begin) / width;
      points.row(i) = (1 - w) * points.row(i) + w * points.row(i + 1);
    }
  return points.row(0);
}

/// Polar form of a cell at arguments of the face it lies in.
Row polar_form(const LimitCell& cell, const Arguments& u, const Arguments& v) {
  const double scale = std::ldexp(1.0, cell.depth);
  const auto local = [scale](const Arguments& t, int offset) {
    return Arguments{t[0] * scale - offset, t[1] * scale - offset, t[2] * scale - offset};
  };
  const Weights wu = polar_weights(local(u, cell.u)), wv = polar_weights(local(v, cell.v));
  Row sum = Row::Zero();
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) sum += wu(i) * wv(j) * cell.control_points.row(4 * j + i);
  return sum;
}

/// The exact cells of each face.
class Cells {
 public:
  Cells(const detail::LimitCells& cells, Eigen::Index n_faces) : of_face_(static_cast<size_t>(n_faces)) {
    for (const LimitCell& cell : cells.cells) of_face_[at(cell.face)].push_back(&cell);
  }

  /// The cell of depth at most `depth` that covers the middle of [u0, u1] × [v0, v1], or null.
  const LimitCell* covering(int face, double u, double v, int depth) const {
    for (const LimitCell* cell : of_face_[at(face)]) {
      if (cell->depth > depth) continue;
      const double scale = std::ldexp(1.0, cell->depth), x = u * scale - cell->u, y = v * scale - cell->v;
      if (x >= 0 && x <= 1 && y >= 0 && y <= 1) return cell;
    }
    return nullptr;
  }

  /// Corners (0, 0), (1, 0), (1, 1), (0, 1) at which no cell of use ends: the extraordinary ones. Where the
  /// other side of a crease is extraordinary, a regular side comes out as a cell of the deepest level; it is
  /// treated likewise, and the fit then meets it exactly.
  std::array<bool, 4> irregular_corners(int face) const {
    std::array<bool, 4> irregular{true, true, true, true};
    for (const LimitCell* cell : of_face_[at(face)]) {
      if (cell->depth > kLeastIsolation) continue;
      const int last = (1 << cell->depth) - 1;
      const bool left = cell->u == 0, right = cell->u == last, low = cell->v == 0, high = cell->v == last;
      if (left && low) irregular[0] = false;
      if (right && low) irregular[1] = false;
      if (right && high) irregular[2] = false;
      if (left && high) irregular[3] = false;
    }
    return irregular;
  }

 private:
  std::vector<std::vector<const LimitCell*>> of_face_;
};

/// Knots that halve towards an irregular end; double where the cell at that end begins, so that this cell
/// need only continue the next one with its first derivative.
std::vector<double> graded_knots(bool from_begin, bool from_end, int isolation) {
  std::vector<double> knots(4, 0.0);
  if (from_begin)
    for (int k = isolation; k >= 1; --k)
      knots.insert(knots.end(), k == isolation ? 2 : 1, std::ldexp(1.0, -k));
  if (from_end)
    for (int k = 1; k <= isolation; ++k)
      if (k > 1 || !from_begin) knots.insert(knots.end(), k == isolation ? 2 : 1, 1 - std::ldexp(1.0, -k));
  knots.insert(knots.end(), 4, 1.0);
  return knots;
}

/// Arguments of control point i, and a parameter inside the cell whose polynomial gives it.
struct Site {
  Arguments arguments;
  double inside = 0;
};
Site site(const std::vector<double>& knots, Eigen::Index i) {
  const size_t k = static_cast<size_t>(i);
  Site result{{knots[k + 1], knots[k + 2], knots[k + 3]}, 0};
  // The cell behind the middle argument in the first half, before it in the second: away from irregular ends.
  const double b = result.arguments[1];
  if (b <= 0.5 && b < 1) {
    const double next = *std::upper_bound(knots.begin(), knots.end(), b);
    result.inside = 0.5 * (b + next);
  } else {
    const double before = *(std::lower_bound(knots.begin(), knots.end(), b) - 1);
    result.inside = 0.5 * (b + before);
  }
  return result;
}

/// Side k of a face as u, v of its parameter t from corner k to corner k + 1.
std::array<double, 2> on_side(int k, double t) {
  switch (k) {
    case 0:
      return {t, 0};
    case 1:
      return {1, t};
    case 2:
      return {1 - t, 1};
    default:
      return {0, 1 - t};
  }
}

double bernstein(int i, double t) {
  const double s = 1 - t;
  return i == 0 ? s * s * s : i == 1 ? 3 * s * s * t : i == 2 ? 3 * s * t * t : t * t * t;
}

/// The span of the knots that holds t: the last i with knots[i] ≤ t < knots[i + 1].
int span_of(const std::vector<double>& knots, double t) {
  const int last = static_cast<int>(knots.size()) - 5;
  const int span = static_cast<int>(std::upper_bound(knots.begin(), knots.end(), t) - knots.begin()) - 1;
  return std::clamp(span, 3, last);
}

/// The four basis functions that are not zero on a span, and their derivatives (Cox and de Boor).
struct Basis {
  int first = 0;
  double value[4], derivative[4];
};
Basis basis(const std::vector<double>& knots, double t) {
  Basis result;
  const int span = span_of(knots, t);
  result.first = span - 3;
  double low[4] = {1, 0, 0, 0};
  double quadratic[4] = {0, 0, 0, 0};
  for (int degree = 1; degree <= 3; ++degree) {
    if (degree == 3) std::copy(low, low + 3, quadratic);
    double next[4] = {0, 0, 0, 0};
    for (int i = 0; i < degree; ++i) {
      const double a = knots[at(span - degree + 1 + i)], b = knots[at(span + 1 + i)];
      const double w = (t - a) / (b - a);
      next[i] += (1 - w) * low[i];
      next[i + 1] += w * low[i];
    }
    std::copy(next, next + 4, low);
  }
  std::copy(low, low + 4, result.value);
  for (int i = 0; i < 4; ++i) result.derivative[i] = 0;
  for (int i = 0; i < 3; ++i) {
    const double width = knots[at(span + 1 + i)] - knots[at(span - 2 + i)];
    result.derivative[i] -= 3 / width * quadratic[i];
    result.derivative[i + 1] += 3 / width * quadratic[i];
  }
  return result;
}

/// Builds the model at one isolation.
class Builder {
 public:
  Builder(const ControlCage& cage, const CageTopology& topology, const detail::LimitCells& limit,
          const std::vector<double>& sharpness, int isolation)
      : cage_(cage),
        topology_(topology),
        limit_(limit),
        sharpness_(sharpness),
        isolation_(isolation),
        cells_(limit, cage.mesh.n_faces()) {}

  BsplineSurface build(const Progress& progress) {
    BsplineSurface surface;
    surface.isolation = isolation_;
    surface.vertices = limit_.vertex_positions;
    const int n_faces = static_cast<int>(cage_.mesh.n_faces());
    irregular_.resize(at(n_faces));
    for (int f = 0; f < n_faces; ++f) irregular_[at(f)] = cells_.irregular_corners(f);
    find_tangent_planes();
    build_edges(surface);
    surface.patches.resize(at(n_faces));
    for (int f = 0; f < n_faces; ++f) {
      if (f % 256 == 0) progress.report("patches", static_cast<double>(f) / n_faces);
      build_patch(surface, f);
    }
    for (int f = 0; f < n_faces; ++f) measure_deviation(surface, f);
    measure_normals(surface);
    return surface;
  }

 private:
  bool is_sharp(int edge) const { return topology_.sides[at(edge)][1] >= 0 && sharpness_[at(edge)] > 0; }
  int corner(int face, int k) const { return cage_.mesh.offsets[at(face)] + (k & 3); }
  double cell_side() const { return std::ldexp(1.0, -isolation_); }

  /// Vertices with a tangent plane that all edges share: smooth ones and darts inside.
  void find_tangent_planes() {
    const size_t n = static_cast<size_t>(cage_.mesh.positions.rows());
    std::vector<int> n_sharp(n, 0);
    for (int e = 0; e < static_cast<int>(topology_.edges.size()); ++e)
      if (is_sharp(e))
        for (const int v : topology_.edges[at(e)]) ++n_sharp[at(v)];
    has_plane_.assign(n, 0);
    for (size_t v = 0; v < n; ++v) has_plane_[v] = topology_.is_border[v] == 0 && n_sharp[v] < 2;
    for (const SharpVertex& sharp : cage_.sharp_vertices)
      if (sharp.sharpness > 0) has_plane_[at(sharp.vertex)] = 0;
  }

  Row exact(int face, double u, double v) const {
    const LimitCell* cell = cells_.covering(face, u, v, isolation_ + kSampledHalvings);
    return polar_form(*cell, {u, u, u}, {v, v, v});
  }

  /// Side k of a face at three polar arguments of its parameter from corner k, by a cell of at most the
  /// isolation that covers `inside`; false where there is none.
  bool side_polar(int face, int k, const Arguments& t, double inside, Row& point) const {
    const auto middle = on_side(k, inside);
    const LimitCell* cell = cells_.covering(face, middle[0], middle[1], isolation_);
    if (cell == nullptr) return false;
    Arguments u, v;
    for (size_t i = 0; i < 3; ++i) {
      const auto uv = on_side(k, t[i]);
      u[i] = uv[0];
      v[i] = uv[1];
    }
    point = polar_form(*cell, u, v);
    return true;
  }

  /// A corner of a face and the sense in which an edge runs along one of its sides.
  struct SideOf {
    int face = -1, side = 0;
    bool forward = true;
  };
  SideOf side_of(int edge, int which) const {
    const int c = topology_.sides[at(edge)][at(which)];
    if (c < 0) return {};
    const int face = topology_.face_of_corner[at(c)];
    const int k = c - cage_.mesh.offsets[at(face)];
    return {face, k, cage_.mesh.corners[at(c)] == topology_.edges[at(edge)][0]};
  }
  bool irregular_end(const SideOf& side, int end) const {
    const int k = (end == 0) == side.forward ? side.side : (side.side + 1) & 3;
    return irregular_[at(side.face)][at(k)];
  }

  void build_edges(BsplineSurface& surface) {
    const int n_edges = static_cast<int>(topology_.edges.size());
    surface.edges.resize(at(n_edges));
    for (int e = 0; e < n_edges; ++e) {
      BsplineEdge& edge = surface.edges[at(e)];
      edge.vertices = topology_.edges[at(e)];
      edge.is_sharp = is_sharp(e);
      const SideOf sides[2] = {side_of(e, 0), side_of(e, 1)};
      edge.patches = {sides[0].face, sides[1].face};
      bool irregular[2] = {false, false};
      for (const SideOf& side : sides)
        for (int end = 0; end < 2; ++end)
          if (side.face >= 0 && irregular_end(side, end)) irregular[end] = true;
      edge.curve.knots = graded_knots(irregular[0], irregular[1], isolation_);
      const Eigen::Index n = static_cast<Eigen::Index>(edge.curve.knots.size()) - 4;
      edge.curve.control_points.resize(n, 3);
      std::vector<char> known(static_cast<size_t>(n), 0);
      for (Eigen::Index i = 0; i < n; ++i) {
        const Site where = site(edge.curve.knots, i);
        for (const SideOf& side : sides) {
          if (side.face < 0 || known[static_cast<size_t>(i)] != 0) continue;
          Arguments t = where.arguments;
          double inside = where.inside;
          if (!side.forward) {
            for (double& x : t) x = 1 - x;
            inside = 1 - inside;
          }
          Row point;
          if (!side_polar(side.face, side.side, t, inside, point)) continue;
          edge.curve.control_points.row(i) = point;
          known[static_cast<size_t>(i)] = 1;
        }
      }
      edge.curve.control_points.row(0) = surface.vertices.row(edge.vertices[0]);
      edge.curve.control_points.row(n - 1) = surface.vertices.row(edge.vertices[1]);
      for (int end = 0; end < 2; ++end)
        if (known[static_cast<size_t>(end == 0 ? 1 : n - 2)] == 0) fit_end(edge, sides[0], end);
    }
  }

  /// The control point next to an extraordinary end: the curve nearest to samples of the limit curve among
  /// those that continue it, in the tangent plane where there is one.
  void fit_end(BsplineEdge& edge, const SideOf& side, int end) {
    const Eigen::Index n = edge.curve.control_points.rows();
    const auto point = [&](Eigen::Index i) {
      return Row(edge.curve.control_points.row(end == 0 ? i : n - 1 - i));
    };
    // In Bernstein form: the double knot ends the cell, and b3 divides b2 and the next point as the knots do.
    const std::vector<double>& knots = edge.curve.knots;
    const auto knot = [&](size_t i) { return end == 0 ? knots[i] : 1 - knots[knots.size() - 1 - i]; };
    const double side_length = knot(4), beyond = knot(6);
    const double w = side_length / beyond;
    const Row b0 = point(0), b2 = point(2), b3 = (1 - w) * point(2) + w * point(3);
    Row sum = Row::Zero();
    double squares = 0;
    constexpr int kSamples = 1 << kSampledHalvings;
    for (int k = 1; k < kSamples; ++k) {
      const double x = static_cast<double>(k) / kSamples;
      const double t = end == 0 ? x * side_length : 1 - x * side_length;
      const auto uv = on_side(side.side, side.forward ? t : 1 - t);
      const Row rest =
          exact(side.face, uv[0], uv[1]) - bernstein(0, x) * b0 - bernstein(2, x) * b2 - bernstein(3, x) * b3;
      sum += bernstein(1, x) * rest;
      squares += bernstein(1, x) * bernstein(1, x);
    }
    Row b1 = sum / squares;
    const int v = edge.vertices[at(end)];
    if (has_plane_[at(v)] != 0) {
      const Row normal = limit_.vertex_normals.row(v);
      b1 -= (b1 - b0).dot(normal) * normal;
    }
    edge.curve.control_points.row(end == 0 ? 1 : n - 2) = b1;
  }

  void build_patch(BsplineSurface& surface, int f) {
    BsplinePatch& patch = surface.patches[at(f)];
    const std::array<bool, 4>& irregular = irregular_[at(f)];
    patch.face = f;
    patch.is_exact = !irregular[0] && !irregular[1] && !irregular[2] && !irregular[3];
    for (int k = 0; k < 4; ++k) {
      patch.vertices[at(k)] = cage_.mesh.corners[at(corner(f, k))];
      patch.edges[at(k)] = topology_.edge_of_corner[at(corner(f, k))];
    }
    patch.knots_u = graded_knots(irregular[0] || irregular[3], irregular[1] || irregular[2], isolation_);
    patch.knots_v = graded_knots(irregular[0] || irregular[1], irregular[2] || irregular[3], isolation_);
    const Eigen::Index n_u = patch.n_u(), n_v = patch.n_v();
    patch.control_points.setConstant(n_u * n_v, 3, std::numeric_limits<double>::quiet_NaN());
    for (Eigen::Index j = 0; j < n_v; ++j)
      for (Eigen::Index i = 0; i < n_u; ++i) {
        const Site u = site(patch.knots_u, i), v = site(patch.knots_v, j);
        const LimitCell* cell = cells_.covering(f, u.inside, v.inside, isolation_);
        if (cell != nullptr)
          patch.control_points.row(j * n_u + i) = polar_form(*cell, u.arguments, v.arguments);
      }
    // The vertices and, where they were fitted, the points next to them are those of the edges.
    for (int k = 0; k < 4; ++k) {
      const bool right = k == 1 || k == 2, high = k >= 2;
      const auto index = [&](Eigen::Index i, Eigen::Index j) {
        return (high ? n_v - 1 - j : j) * n_u + (right ? n_u - 1 - i : i);
      };
      patch.control_points.row(index(0, 0)) = surface.vertices.row(patch.vertices[at(k)]);
      if (!irregular[at(k)]) continue;
      patch.control_points.row(index(1, 0)) =
          next_on_edge(surface, patch.edges[high ? 2 : 0], patch.vertices[at(k)]);
      patch.control_points.row(index(0, 1)) =
          next_on_edge(surface, patch.edges[right ? 1 : 3], patch.vertices[at(k)]);
      fit_corner(patch, k);
    }
    if (!patch.control_points.allFinite())
      throw Error(concat("the limit surface over face ", f,
                         " has an irregular place that is no corner of it; ", "please report the cage"));
  }

  static Row next_on_edge(const BsplineSurface& surface, int edge, int vertex) {
    const BsplineEdge& along = surface.edges[at(edge)];
    const Eigen::Index n = along.curve.control_points.rows();
    return along.curve.control_points.row(along.vertices[0] == vertex ? 1 : n - 2);
  }

  /// u and v of a place in the irregular cell at corner k, x and y from that corner along u and v, 0 to 1.
  std::array<double, 2> in_corner(int k, double x, double y) const {
    const double s = x * cell_side(), t = y * cell_side();
    return {k == 1 || k == 2 ? 1 - s : s, k >= 2 ? 1 - t : t};
  }

  /// The inner control point at an extraordinary corner, by least squares on samples of the limit surface.
  void fit_corner(BsplinePatch& patch, int k) {
    const Eigen::Index n_u = patch.n_u(), n_v = patch.n_v();
    const Eigen::Index inner = (k >= 2 ? n_v - 2 : 1) * n_u + (k == 1 || k == 2 ? n_u - 2 : 1);
    patch.control_points.row(inner).setZero();
    Row sum = Row::Zero();
    double squares = 0;
    constexpr int kSamples = 1 << kSampledHalvings;
    for (int j = 1; j < kSamples; j += 2)
      for (int i = 1; i < kSamples; i += 2) {
        const double x = static_cast<double>(i) / kSamples, y = static_cast<double>(j) / kSamples;
        const auto uv = in_corner(k, x, y);
        const double weight = bernstein(1, x) * bernstein(1, y);
        sum += weight *
               (exact(patch.face, uv[0], uv[1]) - Row(evaluate(patch, uv[0], uv[1]).position.transpose()));
        squares += weight * weight;
      }
    patch.control_points.row(inner) = sum / squares;
  }

  /// The distance of a point of the limit surface from a patch, by Newton steps from its own parameters. The
  /// patch is parametrised otherwise near the vertex, so that places of equal parameters say little.
  static double distance_from(const BsplinePatch& patch, double u, double v, const Eigen::Vector3d& point) {
    double best = (evaluate(patch, u, v).position - point).norm();
    for (int step = 0; step < 8; ++step) {
      const PatchPoint here = evaluate(patch, u, v);
      Eigen::Matrix<double, 3, 2> tangents;
      tangents << here.along_u, here.along_v;
      const Eigen::Matrix2d normal = tangents.transpose() * tangents;
      if (!(normal.determinant() > 1e-14 * normal.squaredNorm())) break;
      const Eigen::Vector2d move = normal.inverse() * (tangents.transpose() * (point - here.position));
      u = std::clamp(u + move(0), 0.0, 1.0);
      v = std::clamp(v + move(1), 0.0, 1.0);
      best = std::min(best, (evaluate(patch, u, v).position - point).norm());
    }
    return best;
  }

  void measure_deviation(BsplineSurface& surface, int f) const {
    constexpr int kSamples = 1 << kSampledHalvings;
    for (int k = 0; k < 4; ++k) {
      if (!irregular_[at(f)][at(k)]) continue;
      for (int j = 0; j <= kSamples; j += 2)
        for (int i = 0; i <= kSamples; i += 2) {
          if (i <= 1 && j <= 1) continue;  // not covered: the vertex itself, where both meet
          const auto uv = in_corner(k, static_cast<double>(i) / kSamples, static_cast<double>(j) / kSamples);
          surface.deviation = std::max(surface.deviation, distance_from(surface.patches[at(f)], uv[0], uv[1],
                                                                        exact(f, uv[0], uv[1]).transpose()));
        }
    }
  }

  void measure_normals(BsplineSurface& surface) const {
    for (int e = 0; e < static_cast<int>(topology_.edges.size()); ++e) {
      const SideOf sides[2] = {side_of(e, 0), side_of(e, 1)};
      if (sides[1].face < 0 || is_sharp(e)) continue;
      if (surface.patches[at(sides[0].face)].is_exact && surface.patches[at(sides[1].face)].is_exact)
        continue;
      for (int end = 0; end < 2; ++end) {
        if (has_plane_[at(topology_.edges[at(e)][at(end)])] == 0) continue;  // a cone has no tangent plane
        for (int k = 1; k <= 16; ++k) {
          const double t = std::abs(end - cell_side() * k / 16);
          Eigen::Vector3d normals[2];
          for (size_t s = 0; s < 2; ++s) {
            const auto uv = on_side(sides[s].side, sides[s].forward ? t : 1 - t);
            const PatchPoint point = evaluate(surface.patches[at(sides[s].face)], uv[0], uv[1]);
            normals[s] = point.along_u.cross(point.along_v);
          }
          if (normals[0].norm() == 0 || normals[1].norm() == 0) continue;
          const double angle = std::atan2(normals[0].cross(normals[1]).norm(), normals[0].dot(normals[1]));
          surface.normal_jump = std::max(surface.normal_jump, angle);
        }
      }
    }
  }

  const ControlCage& cage_;
  const CageTopology& topology_;
  const detail::LimitCells& limit_;
  const std::vector<double>& sharpness_;
  int isolation_;
  Cells cells_;
  std::vector<std::array<bool, 4>> irregular_;
  std::vector<char> has_plane_;
};

int count_components(const CageTopology& topology, Eigen::Index n_faces) {
  DisjointSets parts(static_cast<int>(n_faces));
  for (const std::array<int, 2>& sides : topology.sides)
    if (sides[1] >= 0)
      parts.unite(topology.face_of_corner[at(sides[0])], topology.face_of_corner[at(sides[1])]);
  return parts.n_sets();
}

/// How often a cage must be refined until it is all quads and nothing is semi-sharp.
int levels_to_resolve(const ControlCage& cage) {
  int levels = 0;
  for (size_t f = 0; f + 1 < cage.mesh.offsets.size(); ++f)
    if (cage.mesh.offsets[f + 1] - cage.mesh.offsets[f] != 4) levels = 1;
  const auto outlast = [&levels](double sharpness) {
    if (std::isfinite(detail::sharpness_after(sharpness, 0)))
      levels = std::max(levels, static_cast<int>(std::ceil(sharpness)));
  };
  for (const SharpEdge& edge : cage.sharp_edges) outlast(edge.sharpness);
  for (const SharpVertex& vertex : cage.sharp_vertices) outlast(vertex.sharpness);
  return levels;
}

}  // namespace

std::optional<std::string> BsplineOptions::problem() const {
  if (!(tolerance > 0)) return concat("tolerance must be > 0, got ", tolerance);
  if (most_isolation < kLeastIsolation || most_isolation > 6)
    return concat("most_isolation must be 2 to 6, got ", most_isolation);
  return std::nullopt;
}

BsplineSurface limit_bsplines(const ControlCage& cage, const BsplineOptions& options,
                              const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  ControlCage quads = cage;
  detail::CageTopology topology = detail::cage_topology(cage.mesh);
  detail::edge_sharpness(cage, topology);  // checks what the cage says of sharpness before it is believed
  detail::vertex_sharpness(cage);
  const int levels = levels_to_resolve(cage);
  std::vector<int> parents(static_cast<size_t>(cage.mesh.n_faces()));
  for (size_t f = 0; f < parents.size(); ++f) parents[f] = static_cast<int>(f);
  const double n_patches = levels == 0
                               ? static_cast<double>(cage.mesh.n_faces())
                               : static_cast<double>(cage.mesh.corners.size()) * std::pow(4, levels - 1);
  if (n_patches > kMostPatches)
    throw InvalidInput(
        levels > 1 ? concat("the semi-sharp features last ", levels, " levels; resolving them would make ",
                            n_patches, " patches, and at most ", kMostPatches,
                            " are made: lower the sharpness, or set it to 10, which is sharp for ever")
                   : concat("the cage would make ", n_patches, " patches, and at most ", kMostPatches,
                            " are made: simplify it first"));
  if (levels > 0) {
    SubdividedSurface refined =
        subdivide(cage, {.levels = levels, .smooth_corners = options.smooth_corners}, progress);
    quads = std::move(refined.cage);
    parents = std::move(refined.face_parent);
    topology = detail::cage_topology(quads.mesh);
  }
  const std::vector<double> sharpness = detail::edge_sharpness(quads, topology);
  const detail::LimitCells limit =
      detail::limit_cells(quads, topology, options.most_isolation + kSampledHalvings, options.smooth_corners);
  const double tolerance = options.tolerance * bounding_box_diagonal(cage.mesh.positions);
  BsplineSurface surface;
  for (int isolation = kLeastIsolation; isolation <= options.most_isolation; ++isolation) {
    surface = Builder(quads, topology, limit, sharpness, isolation).build(progress);
    if (surface.deviation <= tolerance) break;
  }
  surface.levels = levels;
  surface.n_components = count_components(topology, quads.mesh.n_faces());
  surface.is_closed = std::all_of(topology.sides.begin(), topology.sides.end(),
                                  [](const std::array<int, 2>& sides) { return sides[1] >= 0; });
  for (BsplinePatch& patch : surface.patches) patch.face = parents[at(patch.face)];
  return surface;
}

PatchPoint evaluate(const BsplinePatch& patch, double u, double v) {
  const Basis of_u = basis(patch.knots_u, u), of_v = basis(patch.knots_v, v);
  PatchPoint point{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector3d p =
          patch.control_points.row((of_v.first + j) * patch.n_u() + of_u.first + i).transpose();
      point.position += of_u.value[i] * of_v.value[j] * p;
      point.along_u += of_u.derivative[i] * of_v.value[j] * p;
      point.along_v += of_u.value[i] * of_v.derivative[j] * p;
    }
  return point;
}

Eigen::Vector3d evaluate(const BsplineCurve& curve, double t) {
  const Basis of_t = basis(curve.knots, t);
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  for (int i = 0; i < 4; ++i) point += of_t.value[i] * curve.control_points.row(of_t.first + i).transpose();
  return point;
}

}  // namespace batten
