// Based on H 6.1 to 6.3. Coons patches are kept by division: the part of a bilinearly blended patch over a
// rectangle is the patch of the four curves around that part. So the steps of H 6.2 are one grid per quad.
#include "batten/modelling/coons_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/modelling/cage_fit_detail.hpp"
#include "batten/modelling/coons.hpp"
#include "batten/modelling/refined_mesh_detail.hpp"
#include "batten/subdivision/subdivide.hpp"

namespace batten {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr double kMostQuads = 2e6;
/// Points on each edge of the refined mesh for the polylines that the schemes follow.
constexpr int kPointsOfEdge = 4;

bool follows_polylines(FinalScheme scheme) {
  return scheme != FinalScheme::CatmullClark;
}

/// A curve between two base vertices: every kPointsOfEdge-th of its samples is a vertex.
struct Line {
  std::vector<int> vertices;  ///< m + 1
  Points samples;             ///< kPointsOfEdge m + 1, at equal distances
};

/// What is blended over a part: columns 3 and 4 are parameters of the patch of the whole, columns 0 to 2 how
/// far the place is from that patch. Without a patch parameters are zero, and it is the place itself.
using Values = Eigen::Matrix<double, Eigen::Dynamic, 5, Eigen::RowMajor>;
using Value = Eigen::Matrix<double, 1, 5>;

/// A line as one of its faces sees it.
struct Side {
  std::vector<int> vertices;
  Values values;
};

Side reversed_side(const Side& side) {
  return {{side.vertices.rbegin(), side.vertices.rend()}, Values(side.values.colwise().reverse())};
}

Side first_half(const Side& side) {
  const size_t m = (side.vertices.size() - 1) / 2;
  return {{side.vertices.begin(), side.vertices.begin() + static_cast<std::ptrdiff_t>(m) + 1},
          side.values.topRows((side.values.rows() - 1) / 2 + 1)};
}

/// The points of a polyline between two arc lengths, both ends given.
Points part_of(const Polyline& polyline, double from, double to, const Eigen::RowVector3d& first,
               const Eigen::RowVector3d& last) {
  const double close = 1e-9 * polyline.length();
  std::vector<Index> inside;
  for (Index i = polyline.segment_at(from); i < polyline.n_points() && polyline.arc(i) < to - close; ++i)
    if (polyline.arc(i) > from + close) inside.push_back(i);
  Points points(static_cast<Index>(inside.size()) + 2, 3);
  points.row(0) = first;
  for (size_t k = 0; k < inside.size(); ++k)
    points.row(static_cast<Index>(k) + 1) = polyline.points().row(inside[k]);
  points.row(points.rows() - 1) = last;
  return points;
}

/// Builds the refined mesh over a base mesh.
class BasicRefinement {
 public:
  BasicRefinement(const CoonsOptions& options, CoonsSurface& surface)
      : surface_(surface), m_(1 << options.steps), with_polylines_(follows_polylines(options.scheme)) {}

  void run(const PolylineMesh& mesh, const Progress& progress) {
    const BaseMesh& base = surface_.base;
    for (const Vector3d& position : base.positions) add(position, true);
    lines_.reserve(base.edges.size());
    for (const BaseEdge& edge : base.edges) lines_.push_back(line_of(edge));
    surface_.vertices_of_edge.resize(mesh.edges().size());
    for (size_t e = 0; e < mesh.edges().size(); ++e)
      for (const int piece : base.edges_of_edge[e]) {
        std::vector<int>& chain = surface_.vertices_of_edge[e];
        if (!chain.empty()) chain.pop_back();
        chain.insert(chain.end(), lines_[at(piece)].vertices.begin(), lines_[at(piece)].vertices.end());
      }
    for (size_t f = 0; f < base.faces.size(); ++f) {
      if (f % 64 == 0)
        progress.report("refine", static_cast<double>(f) / static_cast<double>(base.faces.size()));
      const BaseFace& face = base.faces[f];
      std::vector<Side> sides;
      for (size_t k = 0; k < face.sides.size(); ++k) sides.push_back(side_of_face(face, k));
      if (sides.size() == 4)
        fill(sides[0], sides[1], reversed_side(sides[2]), reversed_side(sides[3]), face);
      else
        refine_triangle(face, sides);
    }
    Points positions(static_cast<Index>(positions_.size()), 3);
    for (size_t v = 0; v < positions_.size(); ++v)
      positions.row(static_cast<Index>(v)) = positions_[v].transpose();
    surface_.refined.mesh.positions = std::move(positions);
    surface_.on_curve = std::move(on_curve_);
  }

 private:
  int add(const Vector3d& position, bool on_curve) {
    positions_.push_back(position);
    on_curve_.push_back(on_curve ? 1 : 0);
    return static_cast<int>(positions_.size()) - 1;
  }

  Line line_of(const BaseEdge& edge) {
    Line line;
    line.samples = edge.polyline->sampled(kPointsOfEdge * m_);
    line.vertices.push_back(edge.from);
    for (int k = 1; k < m_; ++k)
      line.vertices.push_back(add(line.samples.row(kPointsOfEdge * k), edge.drawn));
    line.vertices.push_back(edge.to);
    const double length = edge.polyline->length();
    for (int k = 0; k < m_; ++k) {
      const int from = line.vertices[at(k)], to = line.vertices[at(k + 1)];
      if (edge.sharpness > 0)
        surface_.refined.sharp_edges.push_back({from, to, detail::crease_sharpness(edge.sharpness)});
      if (with_polylines_)
        surface_.refined.polylines.push_back(
            {from, to,
             part_of(*edge.polyline, length * k / m_, length * (k + 1) / m_, positions_[at(from)].transpose(),
                     positions_[at(to)].transpose())});
    }
    return line;
  }

  /// A side with what is blended from it.
  Side side_of_face(const BaseFace& face, size_t k) const {
    const Line& line = lines_[at(edge_of(face.sides[k]))];
    const bool backwards = (face.sides[k] & 1) != 0;
    Side side{line.vertices, Values::Zero(line.samples.rows(), 5)};
    side.values.leftCols<3>() = line.samples;
    if (backwards) side = reversed_side(side);
    if (!face.patch) return side;
    const Index n = side.values.rows() - 1;
    const Eigen::Vector2d &from = face.parameters[k], &to = face.parameters[(k + 1) % face.parameters.size()];
    for (Index i = 0; i <= n; ++i) {
      const double t = static_cast<double>(i) / static_cast<double>(n);
      const Vector3d place = side.values.row(i).head<3>();
      const Eigen::Vector2d parameters = i == 0            ? from
                                         : i == n          ? to
                                         : face.is_line[k] ? Eigen::Vector2d((1 - t) * from + t * to)
                                                           : face.patch->nearest(place);
      side.values.row(i) << (place - face.patch->at(parameters.x(), parameters.y())).transpose(),
          parameters.transpose();
    }
    return side;
  }

  static Eigen::RowVector3d place_of(const Value& value, const BaseFace& face) {
    Eigen::RowVector3d place = value.head<3>();
    if (face.patch)
      place += face.patch->at(std::clamp(value(3), 0.0, 1.0), std::clamp(value(4), 0.0, 1.0)).transpose();
    return place;
  }

  /// A line of new vertices inside a face, between two that are there.
  Side inner_side(int from, int to, Values values, const BaseFace& face) {
    const auto m = static_cast<int>(values.rows() - 1) / kPointsOfEdge;
    Side side{{from}, std::move(values)};
    for (int k = 1; k < m; ++k)
      side.vertices.push_back(add(place_of(side.values.row(kPointsOfEdge * k), face).transpose(), false));
    side.vertices.push_back(to);
    add_polylines(side, face);
    return side;
  }

  void add_polylines(const Side& side, const BaseFace& face) {
    if (!with_polylines_) return;
    for (size_t k = 0; k + 1 < side.vertices.size(); ++k) {
      const int from = side.vertices[k], to = side.vertices[k + 1];
      Points points(kPointsOfEdge + 1, 3);
      for (int i = 1; i < kPointsOfEdge; ++i)
        points.row(i) = place_of(side.values.row(kPointsOfEdge * static_cast<Index>(k) + i), face);
      points.row(0) = positions_[at(from)].transpose();
      points.row(kPointsOfEdge) = positions_[at(to)].transpose();
      surface_.refined.polylines.push_back({from, to, std::move(points)});
    }
  }

  /// H 6.2: a triangle is a patch with a side without length; three lines run from its centre to the middles
  /// of its sides.
  void refine_triangle(const BaseFace& face, const std::vector<Side>& sides) {
    std::array<double, 3> lengths{};
    for (size_t k = 0; k < 3; ++k)
      lengths[k] = surface_.base.edges[at(edge_of(face.sides[k]))].polyline->length();
    const auto pole = static_cast<size_t>(pole_of_triangle(lengths));
    // From the pole on the sides lie along u = 1, v = 1 and u = 0.
    const Values& right = sides[pole].values;
    const Values high = sides[(pole + 1) % 3].values.colwise().reverse();
    const Values left = sides[(pole + 2) % 3].values.colwise().reverse();
    const Index n = right.rows() - 1;
    const auto patch = [&](Index i, Index j) -> Value {
      const double u = static_cast<double>(i) / static_cast<double>(n),
                   v = static_cast<double>(j) / static_cast<double>(n);
      return v * high.row(i) + (1 - u) * left.row(j) + u * right.row(j) - (1 - u) * v * left.row(n) -
             u * v * right.row(n);
    };
    const Index half = n / 2;
    const int centre = add(place_of(patch(half, half), face).transpose(), false);
    std::array<Side, 3> spokes;  // from the middle of side k to the centre
    for (size_t k = 0; k < 3; ++k) {
      Values values(half + 1, 5);
      for (Index i = 0; i <= half; ++i)
        values.row(i) = k == 0 ? patch(n - i, half) : k == 1 ? patch(half, n - i) : patch(i, half);
      const size_t side = (pole + k) % 3;
      spokes[side] = inner_side(sides[side].vertices[at(m_ / 2)], centre, std::move(values), face);
    }
    for (size_t k = 0; k < 3; ++k) {  // the quad at the corner where side k begins
      const size_t before = (k + 2) % 3;
      fill(first_half(sides[k]), spokes[k], spokes[before], first_half(reversed_side(sides[before])), face);
    }
  }

  /// The grid over a quad from its lower, right, upper and left side, the upper one and the left one against
  /// the sense of the walk around the quad.
  void fill(const Side& low, const Side& right, const Side& high, const Side& left, const BaseFace& face) {
    const int m = static_cast<int>(low.vertices.size()) - 1, n = kPointsOfEdge * m;
    const Value p00 = low.values.row(0), p10 = low.values.row(n), p01 = high.values.row(0),
                p11 = high.values.row(n);
    const auto patch = [&](int i, int j) -> Value {
      const double u = static_cast<double>(i) / n, v = static_cast<double>(j) / n;
      return (1 - v) * low.values.row(i) + v * high.values.row(i) + (1 - u) * left.values.row(j) +
             u * right.values.row(j) - (1 - u) * (1 - v) * p00 - u * (1 - v) * p10 - (1 - u) * v * p01 -
             u * v * p11;
    };
    Eigen::MatrixXi grid(m + 1, m + 1);
    for (int k = 0; k <= m; ++k) {
      grid(k, 0) = low.vertices[at(k)];
      grid(k, m) = high.vertices[at(k)];
      grid(0, k) = left.vertices[at(k)];
      grid(m, k) = right.vertices[at(k)];
    }
    for (int j = 1; j < m; ++j)
      for (int i = 1; i < m; ++i)
        grid(i, j) = add(place_of(patch(kPointsOfEdge * i, kPointsOfEdge * j), face).transpose(), false);
    if (with_polylines_)
      for (const bool across : {false, true})
        for (int j = 1; j < m; ++j) {
          Side side;
          side.values.resize(n + 1, 5);
          for (int i = 0; i <= n; ++i)
            side.values.row(i) = across ? patch(kPointsOfEdge * j, i) : patch(i, kPointsOfEdge * j);
          for (int i = 0; i <= m; ++i) side.vertices.push_back(across ? grid(j, i) : grid(i, j));
          add_polylines(side, face);
        }
    PolygonMesh& mesh = surface_.refined.mesh;
    for (int j = 0; j < m; ++j)
      for (int i = 0; i < m; ++i) {
        const int walk[4] = {grid(i, j), grid(i + 1, j), grid(i + 1, j + 1), grid(i, j + 1)};
        // Quads begin on the side of the corner of their part, and are cut into triangles from there: the
        // patch touches the plane of its sides at a corner, and so would a triangle that cuts it off.
        const bool right_half = 2 * i >= m && m > 1, upper_half = 2 * j >= m && m > 1;
        const int first = upper_half ? (right_half ? 2 : 3) : (right_half ? 1 : 0);
        for (int k = 0; k < 4; ++k) mesh.corners.push_back(walk[(first + k) % 4]);
        mesh.offsets.push_back(static_cast<int>(mesh.corners.size()));
        surface_.face_of_quad.push_back(face.face);
      }
  }

  CoonsSurface& surface_;
  int m_;  ///< edges of the refined mesh along one of the base mesh
  bool with_polylines_;
  std::vector<Line> lines_;
  std::vector<Vector3d> positions_;
  std::vector<char> on_curve_;
};

/// Takes what a subdivision gives over to the finished surface.
void take(SubdividedSurface&& fine, const std::vector<int>& face_of_quad, bool limit, CoonsSurface& surface) {
  surface.fine = std::move(fine.cage.mesh);
  if (limit) surface.fine.positions = std::move(fine.limit_positions);
  surface.normals = std::move(fine.limit_normals);
  for (const int parent : fine.face_parent) surface.face_of_fine.push_back(face_of_quad[at(parent)]);
}

void finish(const CoonsOptions& options, CoonsSurface& surface, const Progress& progress) {
  if (!ends_in_catmull_clark(options.scheme)) {
    const ScopedStage stage(surface.times, "subdivision");
    take(subdivide(surface.refined,
                   {.scheme = options.scheme == FinalScheme::Nuliss ? SubdivisionScheme::Nuliss
                                                                    : SubdivisionScheme::NulissMod,
                    .levels = options.levels,
                    .limit = true},
                   progress),
         surface.face_of_quad, false, surface);
    return;
  }
  int levels = options.levels;
  std::vector<int> faces = surface.face_of_quad;
  {
    const ScopedStage stage(surface.times, "cage");
    if (options.scheme == FinalScheme::NulissModCatmullClark) {
      SubdividedSurface once =
          subdivide(surface.refined, {.scheme = SubdivisionScheme::NulissMod, .levels = 1}, progress);
      faces.clear();
      for (const int parent : once.face_parent) faces.push_back(surface.face_of_quad[at(parent)]);
      surface.cage = std::move(once.cage);
      --levels;
    } else {
      surface.cage = surface.refined;
    }
    surface.cage.polylines.clear();
    if (options.through_curves) {
      const Points target = surface.cage.mesh.positions;
      const std::vector<char> free(static_cast<size_t>(target.rows()), 1);
      std::vector<char> exact = surface.on_curve;
      exact.resize(free.size(), 1);  // what NULISSmod has added
      surface.cage_fit = detail::fit_limit(surface.cage, target, free, exact);
    }
  }
  const ScopedStage stage(surface.times, "subdivision");
  take(subdivide(surface.cage, {.levels = levels, .limit = true}, progress), faces, true, surface);
}

}  // namespace

std::optional<std::string> CoonsOptions::problem() const {
  if (steps < 1 || steps > 6) return concat("steps must be 1 to 6, got ", steps);
  if (levels < 0 || levels > 6) return concat("levels must be 0 to 6, got ", levels);
  if (scheme == FinalScheme::NulissModCatmullClark && levels < 1)
    return "levels must be 1 or more with a scheme whose first level is NULISSmod, got 0";
  return std::nullopt;
}

CoonsSurface coons_surface(const PolylineMesh& mesh, const CoonsOptions& options, const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  CoonsSurface surface;
  {
    const ScopedStage stage(surface.times, "triquadrification");
    surface.base = triquadrified(mesh, options.search);
  }
  double quads = 0;
  for (const BaseFace& face : surface.base.faces) quads += face.sides.size() == 4 ? 1 : 0.75;
  quads *= std::pow(4.0, options.steps + options.levels);
  if (quads > kMostQuads)
    throw InvalidInput(
        concat("the surface would have ", quads, " quads; use fewer steps of refinement or fewer levels"));
  {
    const ScopedStage stage(surface.times, "refine");
    BasicRefinement(options, surface).run(mesh, progress);
    detail::turn_outwards(mesh, surface.refined.mesh, surface.face_of_quad);
  }
  {
    const ScopedStage stage(surface.times, "check");
    detail::require_sound(surface.refined.mesh, surface.face_of_quad, surface.on_curve,
                          surface.refined.mesh.positions);
  }
  finish(options, surface, progress);
  // Interpolation overshoots where curves turn sharply: what is handed out is checked, not only its start.
  const ScopedStage stage(surface.times, "check");
  const Index n = surface.fine.positions.rows();
  std::vector<char> on_curve = surface.on_curve;
  on_curve.resize(static_cast<size_t>(n), 0);
  Points start = surface.fine.positions;
  start.topRows(surface.refined.mesh.positions.rows()) = surface.refined.mesh.positions;
  try {
    detail::require_sound(surface.fine, surface.face_of_fine, on_curve, start);
  } catch (const InvalidInput& refusal) {
    if (!ends_in_catmull_clark(options.scheme) || !options.through_curves) throw;
    throw InvalidInput(concat(refusal.what(), "; or let the surface pass its curves by (approximate)"));
  }
  return surface;
}

}  // namespace batten
