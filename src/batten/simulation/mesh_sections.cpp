#include "batten/simulation/mesh_sections.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/curves/cubic_spline.hpp"
#include "batten/curves/polyline.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/rotation/so3.hpp"

namespace batten {

namespace {

using Eigen::Vector3d;

// Two curves that cross at less than this make a poor node (radians).
const double kFlatCrossing = radians(15);
// Sections shorter than this are left out (diameters).
constexpr double kShortestCurve = 0.02;

// --- Splines -----------------------------------------------------------------------------------------------

/// A cubic spline with continuous second derivatives through points and normals, by arc length.
class SplineCurve : public ArcLengthCurve {
 public:
  /// @param knots points in order; of a closed curve without the first repeated at the end.
  SplineCurve(std::vector<Vector3d> knots, bool closed)
      : closed_(closed), spline_(through(std::move(knots), closed)) {
    distances_.push_back(0);
    for (Eigen::Index i = 0; i < spline_.n_pieces(); ++i)
      distances_.push_back(distances_.back() + spline_.length(i));
  }

  /// Normals at the knots, as many as `knots` (of a closed curve the first serves at the end too).
  void set_normals(std::vector<Vector3d> normals) {
    if (closed_) normals.push_back(normals.front());
    normals_.emplace(spline_.knots(), rows(normals), closed_);
  }

  bool closed() const { return closed_; }
  double length() const override { return distances_.back(); }
  double distance_of_knot(size_t i) const { return distances_[i]; }
  size_t n_knots() const { return closed_ ? distances_.size() - 1 : distances_.size(); }

  Vector3d tangent_at_knot(size_t i) const {
    const auto piece = static_cast<Eigen::Index>(i);
    return piece < spline_.n_pieces() ? spline_.derivative(piece, 0).normalized()
                                      : spline_.derivative(piece - 1, 1).normalized();
  }

  CurvePoint at(double distance) const override {
    const double s = std::clamp(distance, 0.0, length());
    const auto after = std::upper_bound(distances_.begin() + 1, distances_.end() - 1, s);
    const auto knot = static_cast<size_t>(after - distances_.begin()) - 1;
    const auto piece = static_cast<Eigen::Index>(knot);
    const double target = s - distances_[knot];
    double t = target / (distances_[knot + 1] - distances_[knot]);
    for (int iteration = 0; iteration < 20; ++iteration) {
      const double error = spline_.length(piece, t) - target;
      if (std::abs(error) <= 1e-14 * length()) break;
      t = std::clamp(t - error / spline_.speed(piece, t), 0.0, 1.0);
    }
    CurvePoint point;
    point.position = spline_.at(piece, t);
    point.tangent = spline_.derivative(piece, t).normalized();
    const Vector3d normal = normals_->at(piece, t);
    point.normal = (normal - normal.dot(point.tangent) * point.tangent).normalized();
    return point;
  }

 private:
  static Points rows(const std::vector<Vector3d>& vectors) {
    Points points(static_cast<Eigen::Index>(vectors.size()), 3);
    for (size_t i = 0; i < vectors.size(); ++i)
      points.row(static_cast<Eigen::Index>(i)) = vectors[i].transpose();
    return points;
  }
  static CubicSpline through(std::vector<Vector3d> knots, bool closed) {
    if (closed) knots.push_back(knots.front());
    Points points = rows(knots);
    std::vector<double> arcs = arc_lengths(points);
    return {std::move(arcs), std::move(points), closed};
  }

  bool closed_;
  CubicSpline spline_;
  std::optional<CubicSpline> normals_;
  std::vector<double> distances_;
};

// --- Sections ----------------------------------------------------------------------------------------------

using Edge = std::pair<int, int>;  // smaller vertex first

Edge edge_of(int a, int b) {
  return {std::min(a, b), std::max(a, b)};
}

struct EdgeHash {
  size_t operator()(const Edge& e) const {
    return std::hash<std::uint64_t>()((static_cast<std::uint64_t>(e.first) << 32) |
                                      static_cast<std::uint32_t>(e.second));
  }
};

/// A polyline on the mesh.
struct MeshPolyline {
  std::string name;
  bool boundary = false;
  bool closed = false;
  int axis = -1;  // of the plane; −1 for borders
  double offset = 0;
  std::vector<Vector3d> points;   // the first is not repeated
  std::vector<Vector3d> normals;  // from the vertex normals
  std::vector<Edge> edges;        // that the points lie on; for borders: the edge from this point to the next
  std::vector<int> faces;         // sections: of the piece from this point to the next

  size_t n_pieces() const { return closed ? points.size() : points.size() - 1; }
  const Vector3d& next(size_t piece) const { return points[(piece + 1) % points.size()]; }
  double length() const {
    double sum = 0;
    for (size_t k = 0; k < n_pieces(); ++k) sum += (next(k) - points[k]).norm();
    return sum;
  }
};

/// Faces on both sides of every edge.
class Topology {
 public:
  explicit Topology(const TriangleMesh& mesh) {
    for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f)
      for (int k = 0; k < 3; ++k) {
        const int a = mesh.triangles(f, k);
        const int b = mesh.triangles(f, (k + 1) % 3);
        if (a < 0 || a >= mesh.n_vertices() || a == b)
          throw InvalidInput(concat("face ", f + 1, " of the mesh is broken; repair the mesh"));
        auto& sides = faces_[edge_of(a, b)];
        const int side = a < b ? 0 : 1;
        if (sides[static_cast<size_t>(side)] >= 0)
          throw InvalidInput(concat("faces ", sides[static_cast<size_t>(side)] + 1, " and ", f + 1,
                                    " of the mesh run the same way along one edge: the mesh is no oriented "
                                    "manifold, repair it"));
        sides[static_cast<size_t>(side)] = static_cast<int>(f);
      }
  }

  /// The face beyond an edge, or −1 at a border.
  int across(const Edge& edge, int face) const {
    const auto& sides = faces_.at(edge);
    return sides[0] == face ? sides[1] : sides[0];
  }

  /// Border loops with the surface on their left, as vertices. At a vertex where several borders touch, the
  /// loops are separated one from the other by walking on from the border edge met first.
  std::vector<std::vector<int>> border_loops() const {
    std::multimap<int, int> next;
    for (const auto& [edge, sides] : faces_) {
      if (sides[0] >= 0 && sides[1] < 0) next.emplace(edge.first, edge.second);
      if (sides[1] >= 0 && sides[0] < 0) next.emplace(edge.second, edge.first);
    }
    std::vector<std::vector<int>> loops;
    while (!next.empty()) {
      std::vector<int> loop;
      const int start = next.begin()->first;
      int v = start;
      while (true) {
        const auto step = next.find(v);
        if (step == next.end()) break;
        loop.push_back(v);
        v = step->second;
        next.erase(step);
        if (v == start) break;
      }
      if (v == start && loop.size() >= 3) loops.push_back(std::move(loop));
    }
    return loops;
  }

 private:
  // By edge: the face that runs from the smaller vertex to the larger, and the other one. Ordered, so that
  // results do not depend on hashing.
  struct Sides : std::array<int, 2> {
    Sides() : std::array<int, 2>{-1, -1} {}
  };
  std::map<Edge, Sides> faces_;
};

/// Follows the zeros of a height over the mesh from face to face.
class Slicer {
 public:
  Slicer(const TriangleMesh& mesh, const Points& normals, const Topology& topology)
      : mesh_(mesh), normals_(normals), topology_(topology) {}

  std::vector<MeshPolyline> slice(int axis, double offset) const {
    const Eigen::VectorXd height = mesh_.positions.col(axis).array() - offset;
    std::vector<char> visited(static_cast<size_t>(mesh_.n_triangles()), 0);
    std::vector<MeshPolyline> lines;
    for (int f = 0; f < static_cast<int>(mesh_.n_triangles()); ++f) {
      if (visited[static_cast<size_t>(f)] != 0) continue;
      Edge in;
      Edge out;
      if (!cut_edges(f, height, in, out)) continue;
      MeshPolyline line;
      line.axis = axis;
      line.offset = offset;
      // Back to a border first, or once around.
      int start_face = f;
      Edge start_edge = in;
      int face = f;
      Edge entry = in;
      while (true) {
        const int before = topology_.across(entry, face);
        if (before < 0) {
          start_face = face;
          start_edge = entry;
          break;
        }
        Edge a;
        Edge b;
        cut_edges(before, height, a, b);
        entry = a == entry ? b : a;
        face = before;
        if (face == f) {
          line.closed = true;
          break;
        }
      }
      face = start_face;
      entry = start_edge;
      add_point(line, entry, height);
      while (true) {
        visited[static_cast<size_t>(face)] = 1;
        line.faces.push_back(face);
        Edge a;
        Edge b;
        cut_edges(face, height, a, b);
        const Edge exit = a == entry ? b : a;
        const int beyond = topology_.across(exit, face);
        if (beyond == start_face && line.closed) break;
        add_point(line, exit, height);
        if (beyond < 0) break;
        face = beyond;
        entry = exit;
      }
      lines.push_back(std::move(line));
    }
    return lines;
  }

 private:
  /// The two edges of a face that the plane cuts. False when it misses the face.
  bool cut_edges(int face, const Eigen::VectorXd& height, Edge& first, Edge& second) const {
    int found = 0;
    for (int k = 0; k < 3; ++k) {
      const int a = mesh_.triangles(face, k);
      const int b = mesh_.triangles(face, (k + 1) % 3);
      if ((height[a] < 0) == (height[b] < 0)) continue;
      (found == 0 ? first : second) = edge_of(a, b);
      ++found;
    }
    return found == 2;
  }

  void add_point(MeshPolyline& line, const Edge& edge, const Eigen::VectorXd& height) const {
    const double w = height[edge.first] / (height[edge.first] - height[edge.second]);
    line.points.emplace_back((1 - w) * mesh_.positions.row(edge.first) +
                             w * mesh_.positions.row(edge.second));
    line.normals.emplace_back(
        ((1 - w) * normals_.row(edge.first) + w * normals_.row(edge.second)).normalized());
    line.edges.push_back(edge);
  }

  const TriangleMesh& mesh_;
  const Points& normals_;
  const Topology& topology_;
};

/// An offset near the wanted one at which the plane passes no vertex: the section is then a clean polyline.
double clear_offset(const Eigen::VectorXd& coordinates, double wanted, double size) {
  const double clearance = 1e-9 * size;
  double offset = wanted;
  for (int attempt = 1; attempt < 1000; ++attempt) {
    if ((coordinates.array() - offset).abs().minCoeff() > clearance) return offset;
    offset = wanted + 1e-6 * size * attempt;
  }
  return offset;
}

/// A crossing as a place on a polyline.
struct Station {
  size_t piece;
  double fraction;  // along the piece
  int node;
};

struct Crossing {
  Vector3d position;
  Vector3d normal;  // of the mesh
};

/// The points where polylines cross.
class CrossingFinder {
 public:
  explicit CrossingFinder(const std::vector<MeshPolyline>& lines) : stations(lines.size()), lines_(lines) {
    find_between_sections();
    find_at_borders();
    for (auto& list : stations)
      std::sort(list.begin(), list.end(), [](const Station& a, const Station& b) {
        return std::pair(a.piece, a.fraction) < std::pair(b.piece, b.fraction);
      });
  }

  std::vector<Crossing> crossings;
  std::vector<std::vector<Station>> stations;  // per polyline

 private:
  void add(const Vector3d& position, const Vector3d& normal, size_t line_a, Station a, size_t line_b,
           Station b) {
    a.node = b.node = static_cast<int>(crossings.size());
    crossings.push_back({position, normal});
    stations[line_a].push_back(a);
    stations[line_b].push_back(b);
  }

  void find_between_sections() {
    std::unordered_map<int, std::vector<std::pair<size_t, size_t>>> pieces_of_face;
    for (size_t a = 0; a < lines_.size(); ++a)
      for (size_t k = 0; k < lines_[a].faces.size(); ++k) {
        auto& here = pieces_of_face[lines_[a].faces[k]];
        for (const auto& [b, m] : here) {
          if (lines_[b].axis == lines_[a].axis) continue;
          const MeshPolyline& one = lines_[a];
          const MeshPolyline& two = lines_[b];
          // Heights of the first piece's ends over the second's plane, and the other way round.
          const double h0 = one.points[k][two.axis] - two.offset;
          const double h1 = one.next(k)[two.axis] - two.offset;
          const double g0 = two.points[m][one.axis] - one.offset;
          const double g1 = two.next(m)[one.axis] - one.offset;
          if ((h0 < 0) == (h1 < 0) || (g0 < 0) == (g1 < 0)) continue;
          const double u = h0 / (h0 - h1);
          const double v = g0 / (g0 - g1);
          const Vector3d normal = (1 - u) * one.normals[k] + u * one.normals[(k + 1) % one.points.size()];
          add((1 - u) * one.points[k] + u * one.next(k), normal.normalized(), a, {k, u, 0}, b, {m, v, 0});
        }
        here.emplace_back(a, k);
      }
  }

  void find_at_borders() {
    std::map<Edge, std::pair<size_t, size_t>> border_edges;
    for (size_t b = 0; b < lines_.size(); ++b)
      if (lines_[b].boundary)
        for (size_t k = 0; k < lines_[b].edges.size(); ++k) border_edges[lines_[b].edges[k]] = {b, k};
    for (size_t a = 0; a < lines_.size(); ++a) {
      const MeshPolyline& line = lines_[a];
      if (line.boundary || line.closed) continue;
      for (const size_t end : {size_t{0}, line.points.size() - 1}) {
        const auto place = border_edges.find(line.edges[end]);
        if (place == border_edges.end()) continue;
        const auto [b, k] = place->second;
        const MeshPolyline& border = lines_[b];
        const double u =
            (line.points[end] - border.points[k]).norm() / (border.next(k) - border.points[k]).norm();
        const Station on_line = end == 0 ? Station{0, 0, 0} : Station{line.n_pieces() - 1, 1, 0};
        add(line.points[end], line.normals[end], a, on_line, b, {k, u, 0});
      }
    }
  }

  const std::vector<MeshPolyline>& lines_;
};

/// Points of a polyline at even distances between its crossings, which are all among them.
struct Knots {
  std::vector<Vector3d> points, normals;
  std::vector<int> nodes;  // −1 away from crossings
};

Knots place_knots(const MeshPolyline& line, const std::vector<Station>& stations,
                  const std::vector<Crossing>& crossings, double spacing) {
  std::vector<double> starts = {0};  // of the pieces
  for (size_t k = 0; k < line.n_pieces(); ++k)
    starts.push_back(starts.back() + (line.next(k) - line.points[k]).norm());
  const double length = starts.back();
  const auto place = [&](double s, Knots& knots) {
    if (line.closed && s >= length) s -= length;
    const auto after = std::upper_bound(starts.begin() + 1, starts.end() - 1, s);
    const auto k = static_cast<size_t>(after - starts.begin()) - 1;
    const double piece = starts[k + 1] - starts[k];
    const double u = piece > 0 ? std::clamp((s - starts[k]) / piece, 0.0, 1.0) : 0.0;
    knots.points.emplace_back((1 - u) * line.points[k] + u * line.next(k));
    knots.normals.emplace_back(
        ((1 - u) * line.normals[k] + u * line.normals[(k + 1) % line.normals.size()]).normalized());
    knots.nodes.push_back(-1);
  };
  // Fixed places: crossings, and the ends of open lines.
  std::vector<std::pair<double, int>> fixed;
  fixed.reserve(stations.size() + 2);
  for (const Station& station : stations)
    fixed.emplace_back(
        starts[station.piece] + station.fraction * (starts[station.piece + 1] - starts[station.piece]),
        station.node);
  if (fixed.empty()) fixed.emplace_back(0, -1);
  if (line.closed) {
    fixed.emplace_back(fixed.front().first + length, fixed.front().second);
  } else {
    if (fixed.front().first > 1e-9 * length) fixed.insert(fixed.begin(), {0, -1});
    if (fixed.back().first < length * (1 - 1e-9)) fixed.emplace_back(length, -1);
  }
  Knots knots;
  for (size_t j = 0; j < fixed.size(); ++j) {
    const bool last = j + 1 == fixed.size();
    if (last && line.closed) break;
    const auto [s, node] = fixed[j];
    place(s, knots);
    if (node >= 0) {
      knots.points.back() = crossings[static_cast<size_t>(node)].position;
      knots.normals.back() = crossings[static_cast<size_t>(node)].normal;
      knots.nodes.back() = node;
    }
    if (last) break;
    const double gap = fixed[j + 1].first - s;
    // A closed spline needs three knots.
    const int fewest = line.closed && fixed.size() <= 3 ? 3 : 1;
    const int pieces = std::max(fewest, static_cast<int>(std::lround(gap / spacing)));
    for (int k = 1; k < pieces; ++k) place(s + gap * k / pieces, knots);
  }
  return knots;
}

/// Gives every curve normals that agree at the crossings with those of the curves that cross there.
void set_consistent_normals(std::vector<std::shared_ptr<SplineCurve>>& splines, std::vector<Knots>& knots,
                            std::vector<Crossing>& crossings, std::vector<std::string>& warnings) {
  std::vector<std::vector<Vector3d>> tangents(crossings.size());
  for (size_t c = 0; c < splines.size(); ++c)
    for (size_t i = 0; i < knots[c].nodes.size(); ++i)
      if (knots[c].nodes[i] >= 0)
        tangents[static_cast<size_t>(knots[c].nodes[i])].push_back(splines[c]->tangent_at_knot(i));
  int flat = 0;
  for (size_t v = 0; v < crossings.size(); ++v) {
    if (tangents[v].size() != 2) continue;
    const Vector3d across = tangents[v][0].cross(tangents[v][1]);
    if (across.norm() < std::sin(kFlatCrossing)) ++flat;
    if (across.norm() < 1e-3) continue;
    crossings[v].normal = across.normalized() * (across.dot(crossings[v].normal) < 0 ? -1 : 1);
  }
  if (flat > 0)
    warnings.push_back(
        concat(flat, " of ", crossings.size(),
               " crossings are flatter than 15 degrees; other planes (--planes, --axes) may suit "
               "the mesh better"));
  for (size_t c = 0; c < splines.size(); ++c) {
    const size_t n = splines[c]->n_knots();
    // Mesh normals at right angles to the curve, and the angle about the tangent by which each crossing wants
    // them turned.
    std::vector<Vector3d> normals(n);
    std::vector<Vector3d> along(n);
    std::vector<size_t> fixed;
    std::vector<double> turns(n, 0);
    for (size_t i = 0; i < n; ++i) {
      along[i] = splines[c]->tangent_at_knot(i);
      const Vector3d flat_normal = knots[c].normals[i] - knots[c].normals[i].dot(along[i]) * along[i];
      normals[i] = flat_normal.norm() > 1e-6 ? Vector3d(flat_normal.normalized()) : along[i].unitOrthogonal();
      if (knots[c].nodes[i] < 0) continue;
      const Vector3d wanted = crossings[static_cast<size_t>(knots[c].nodes[i])].normal;
      fixed.push_back(i);
      turns[i] = std::atan2(along[i].dot(normals[i].cross(wanted)), normals[i].dot(wanted));
    }
    for (size_t j = 0; j < fixed.size(); ++j) {
      // Between two crossings the turn is interpolated by the arc length; beyond the last of an open curve it
      // stays.
      const bool wraps = j + 1 == fixed.size();
      const size_t from = fixed[j];
      const size_t to = wraps ? fixed[0] + n : fixed[j + 1];
      const bool open = wraps && !splines[c]->closed();
      for (size_t i = from + 1; i < to; ++i) {
        if (open && i >= n) break;
        const double w = open ? 0 : static_cast<double>(i - from) / static_cast<double>(to - from);
        turns[i % n] = (1 - w) * turns[from] + w * turns[to % n];
      }
      if (j == 0 && !splines[c]->closed())
        for (size_t i = 0; i < from; ++i) turns[i] = turns[from];
    }
    for (size_t i = 0; i < n; ++i) normals[i] = so3_exp(turns[i] * along[i]) * normals[i];
    splines[c]->set_normals(std::move(normals));
  }
}

/// Keeps the polylines that hang together with the longest part.
void keep_connected(std::vector<MeshPolyline>& lines, std::vector<std::string>& warnings) {
  const CrossingFinder found(lines);
  std::vector<size_t> root(lines.size());
  std::iota(root.begin(), root.end(), size_t{0});
  const auto find = [&root](size_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  std::vector<size_t> line_of_node(found.crossings.size(), lines.size());
  for (size_t c = 0; c < lines.size(); ++c)
    for (const Station& station : found.stations[c]) {
      size_t& first = line_of_node[static_cast<size_t>(station.node)];
      if (first == lines.size())
        first = c;
      else
        root[find(c)] = find(first);
    }
  std::map<size_t, double> lengths;
  for (size_t c = 0; c < lines.size(); ++c) lengths[find(c)] += lines[c].length();
  const auto longest = std::max_element(lengths.begin(), lengths.end(),
                                        [](const auto& a, const auto& b) { return a.second < b.second; });
  std::vector<MeshPolyline> kept;
  size_t borders = 0;
  for (size_t c = 0; c < lines.size(); ++c) {
    if (find(c) == longest->first)
      kept.push_back(std::move(lines[c]));
    else
      borders += lines[c].boundary ? 1 : 0;
  }
  if (kept.size() < lines.size())
    warnings.push_back(concat(lines.size() - kept.size(), " of ", lines.size(), " curves (", borders,
                              " of them borders) meet no other part of the network and are left out: a scan "
                              "cannot tell where separate parts lie; lay more planes to join them"));
  lines = std::move(kept);
}

}  // namespace

std::optional<std::string> MeshSectionOptions::problem() const {
  if (planes < 1 || planes > 100) return concat("planes must lie in 1 … 100, got ", planes);
  const std::set<char> distinct(axes.begin(), axes.end());
  if (distinct.size() != axes.size() || axes.size() < 2 || axes.find_first_not_of("xyz") != std::string::npos)
    return concat("axes must be two or three of x, y and z, got '", axes, "'");
  if (!(knot_spacing >= 0 && knot_spacing <= 0.2))
    return concat("knot_spacing must lie in [0, 0.2] diameters, got ", knot_spacing);
  return std::nullopt;
}

TracedNetwork trace_mesh(const TriangleMesh& mesh, const MeshSectionOptions& options) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  if (mesh.n_triangles() == 0) throw InvalidInput("the mesh has no faces; nothing can be scanned on it");
  const Topology topology(mesh);
  const double diameter = bounding_box_diagonal(mesh.positions);
  const Points normals = vertex_normals(mesh.positions, mesh.triangles);
  TracedNetwork traced;
  traced.diameter = diameter;

  std::vector<MeshPolyline> lines;
  const std::vector<std::vector<int>> loops = topology.border_loops();
  for (size_t b = 0; b < loops.size(); ++b) {
    MeshPolyline line;
    line.name = loops.size() == 1 ? std::string("border") : concat("border ", b + 1);
    line.boundary = line.closed = true;
    for (size_t k = 0; k < loops[b].size(); ++k) {
      const int v = loops[b][k];
      line.points.emplace_back(mesh.positions.row(v));
      line.normals.emplace_back(normals.row(v));
      line.edges.push_back(edge_of(v, loops[b][(k + 1) % loops[b].size()]));
    }
    lines.push_back(std::move(line));
  }
  const Slicer slicer(mesh, normals, topology);
  size_t n_sections = 0;
  const auto lay_plane = [&](char letter, double wanted) {
    const int axis = letter - 'x';
    const double offset = clear_offset(mesh.positions.col(axis), wanted, diameter);
    std::vector<MeshPolyline> sections = slicer.slice(axis, offset);
    for (size_t part = 0; part < sections.size(); ++part) {
      // A scrap shorter than this has no room for readings.
      if (sections[part].length() < kShortestCurve * diameter || sections[part].points.size() < 3) continue;
      sections[part].name = concat(letter, " = ", offset);
      if (sections.size() > 1) sections[part].name += concat(" part ", part + 1);
      lines.push_back(std::move(sections[part]));
      ++n_sections;
    }
  };
  for (const char letter : options.axes) {
    const double low = mesh.positions.col(letter - 'x').minCoeff();
    const double high = mesh.positions.col(letter - 'x').maxCoeff();
    for (int k = 1; k <= options.planes; ++k)
      lay_plane(letter, low + (high - low) * k / (options.planes + 1));
  }
  // A border that no plane meets would be lost; it gets a plane of its own across its longest side.
  const std::vector<std::vector<Station>> met = CrossingFinder(lines).stations;
  for (size_t b = 0; b < loops.size(); ++b) {
    if (!met[b].empty() || lines[b].length() < kShortestCurve * diameter) continue;
    Eigen::AlignedBox3d box;
    for (const Vector3d& point : lines[b].points) box.extend(point);
    char longest = options.axes.front();
    for (const char letter : options.axes)
      if (box.sizes()[letter - 'x'] > box.sizes()[longest - 'x']) longest = letter;
    lay_plane(longest, box.center()[longest - 'x']);
  }
  if (n_sections == 0) throw InvalidInput("no plane meets the mesh; lay planes across other axes");
  keep_connected(lines, traced.warnings);
  CrossingFinder found(lines);
  if (found.crossings.empty() && lines.size() > 1)
    throw InvalidInput("the curves do not cross; lay more planes");

  double spacing = options.knot_spacing * diameter;
  if (spacing == 0) {
    double sum = 0;
    for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f)
      for (int k = 0; k < 3; ++k)
        sum += (mesh.positions.row(mesh.triangles(f, k)) - mesh.positions.row(mesh.triangles(f, (k + 1) % 3)))
                   .norm();
    spacing =
        std::clamp(sum / (3.0 * static_cast<double>(mesh.n_triangles())), 0.005 * diameter, 0.02 * diameter);
  }
  std::vector<std::shared_ptr<SplineCurve>> splines;
  std::vector<Knots> knots;
  for (size_t c = 0; c < lines.size(); ++c) {
    knots.push_back(place_knots(lines[c], found.stations[c], found.crossings, spacing));
    splines.push_back(std::make_shared<SplineCurve>(knots.back().points, lines[c].closed));
  }
  set_consistent_normals(splines, knots, found.crossings, traced.warnings);

  const auto n_nodes = static_cast<Eigen::Index>(found.crossings.size());
  traced.node_positions.resize(n_nodes, 3);
  traced.node_normals.resize(n_nodes, 3);
  for (Eigen::Index v = 0; v < n_nodes; ++v) {
    traced.node_positions.row(v) = found.crossings[static_cast<size_t>(v)].position;
    traced.node_normals.row(v) = found.crossings[static_cast<size_t>(v)].normal;
  }
  for (size_t c = 0; c < lines.size(); ++c) {
    TracedCurve curve;
    curve.name = lines[c].name;
    curve.boundary = lines[c].boundary;
    curve.closed = lines[c].closed;
    curve.path = splines[c];
    for (size_t i = 0; i < knots[c].nodes.size(); ++i) {
      if (knots[c].nodes[i] < 0) continue;
      curve.node_distances.push_back(splines[c]->distance_of_knot(i));
      curve.node_ids.push_back(knots[c].nodes[i]);
    }
    if (curve.closed && !curve.node_ids.empty()) {  // the knots of a closed curve start at its first crossing
      curve.node_distances.push_back(splines[c]->length());
      curve.node_ids.push_back(curve.node_ids.front());
    }
    traced.curves.push_back(std::move(curve));
  }
  return traced;
}

}  // namespace batten
