#include "batten/sketch/tools.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "batten/core/text.hpp"
#include "batten/curves/polyline.hpp"
#include "batten/sketch/tools_detail.hpp"

namespace batten {

using detail::require_curve;

double default_snap(const PolylineMesh& mesh, const Points& stroke) {
  Box all{};
  bool any = !mesh.empty();
  if (any) all = mesh.edge_boxes().bounds();
  if (stroke.rows() > 0 && stroke.allFinite()) {
    const Box own{stroke.colwise().minCoeff(), stroke.colwise().maxCoeff()};
    if (!any) all = own;
    all.include(own);
    any = true;
  }
  return any ? 0.015 * (all.high - all.low).norm() : 0;
}

namespace {

/// The edges of a curve on the way from one of its vertices to another, the fewest there are.
std::vector<int> edges_between(const PolylineMesh& mesh, int curve, int from, int to) {
  std::map<int, int> arrived_by{{from, -1}};  // vertex → edge
  std::vector<int> queue{from};
  for (size_t k = 0; k < queue.size() && arrived_by.count(to) == 0; ++k)
    for (const int e : mesh.vertex(queue[k]).edges) {
      if (mesh.edge(e).curve != curve) continue;
      const auto& ends = mesh.edge(e).vertices;
      const int next = ends[0] == queue[k] ? ends[1] : ends[0];
      if (arrived_by.emplace(next, e).second) queue.push_back(next);
    }
  std::vector<int> way;
  if (arrived_by.count(to) == 0) return way;
  for (int at = to; at != from;) {
    const int e = arrived_by.at(at);
    way.push_back(e);
    at = mesh.edge(e).vertices[mesh.edge(e).vertices[0] == at ? 1 : 0];
  }
  return way;
}

}  // namespace

EditReport set_curve_sharpness(PolylineMesh& mesh, int curve, double sharpness,
                               const std::optional<std::array<int, 2>>& between) {
  require_curve(mesh, curve);
  if (!(sharpness >= 0 && sharpness <= 1))
    throw RefusedEdit(concat("the sharpness of c", curve, " would be ", sharpness),
                      "give a value from 0 (smooth) to 1 (sharp)");
  std::vector<int> edges = mesh.edges_of_curve(curve);
  if (between) {
    for (const int v : *between)
      if (v < 0 || static_cast<size_t>(v) >= mesh.vertices().size() || !mesh.vertex(v).alive)
        throw RefusedEdit(concat("there is no vertex v", v), "name two vertices of the curve");
    edges = edges_between(mesh, curve, (*between)[0], (*between)[1]);
    if (edges.empty())
      throw RefusedEdit(concat("c", curve, " does not lead from v", (*between)[0], " to v", (*between)[1]),
                        "name two different vertices of the curve");
  }
  for (const int e : edges) mesh.set_sharpness(e, sharpness);
  return {};
}

EditReport transform_model(PolylineMesh& mesh, const Eigen::Matrix4d& matrix) {
  if (!matrix.allFinite())
    throw RefusedEdit("the matrix has a number that is not finite", "give 16 finite numbers");
  if (matrix(3, 0) != 0 || matrix(3, 1) != 0 || matrix(3, 2) != 0 || matrix(3, 3) != 1)
    throw RefusedEdit("the last row of the matrix is not 0 0 0 1", "give an affine matrix, row by row");
  const Eigen::Matrix3d linear = matrix.topLeftCorner<3, 3>();
  const double scale = linear.cwiseAbs().maxCoeff();
  if (!(scale > 0) || !(std::abs((linear / scale).determinant()) > 1e-12))  // scaled, or cubes would overflow
    throw RefusedEdit("the matrix flattens the model", "give a matrix with a determinant other than 0");
  if (mesh.empty()) throw RefusedEdit("there is nothing to move", "insert a first boundary");
  // As for strokes: squares of coordinates near the ends of the range of double would leave it.
  constexpr double kFarthest = 1e100, kSmallest = 1e-100;
  const Box& all = mesh.edge_boxes().bounds();
  const double farthest = std::max(all.low.cwiseAbs().maxCoeff(), all.high.cwiseAbs().maxCoeff());
  if (!(3 * scale * farthest + matrix.topRightCorner<3, 1>().cwiseAbs().maxCoeff() <= kFarthest))
    throw RefusedEdit(concat("the matrix takes the model beyond ", kFarthest), "give a smaller matrix");
  if (!(scale * mesh.diameter() >= kSmallest))
    throw RefusedEdit(concat("the matrix shrinks the model below ", kSmallest), "give a larger matrix");
  mesh.move_everything(matrix);
  if ((linear / scale).determinant() < 0) {
    std::vector<char> turned(mesh.faces().size(), 0);
    for (size_t f = 0; f < mesh.faces().size(); ++f) {
      if (!mesh.faces()[f].alive || turned[f]) continue;
      std::vector<int> stack{static_cast<int>(f)};
      turned[f] = 1;
      while (!stack.empty()) {
        const int current = stack.back();
        stack.pop_back();
        for (const int side : mesh.face(current).sides) {
          const int next = mesh.face_of(opposite_side(side));
          if (next >= 0 && !turned[static_cast<size_t>(next)]) {
            turned[static_cast<size_t>(next)] = 1;
            stack.push_back(next);
          }
        }
      }
      mesh.flip_component(static_cast<int>(f));
    }
  }
  return {};
}

std::optional<std::string> InsertOptions::problem() const {
  const auto below = [](double value, double least) { return !(value >= least) || !std::isfinite(value); };
  if (below(snap, 0)) return concat("snap must be finite and at least 0, got ", snap);
  if (below(snap_factor, 0) || snap_factor == 0)
    return concat("snap_factor must be finite and above 0, got ", snap_factor);
  if (below(reach_factor, 0)) return concat("reach_factor must be finite and at least 0, got ", reach_factor);
  if (!(sharpness >= 0 && sharpness <= 1))
    return concat("sharpness must lie in 0 (smooth) to 1 (sharp), got ", sharpness);
  return std::nullopt;
}

namespace detail {

double snap_or_default(const PolylineMesh& mesh, const Points& stroke, const InsertOptions& options) {
  if (const auto problem = options.problem()) throw RefusedEdit(*problem, "give a value in this range");
  return options.snap > 0 ? options.snap : options.snap_factor * default_snap(mesh, stroke);
}

Stroke ready_stroke(const DrawnStroke& drawn, double snap, bool may_close) {
  StrokeOptions options;
  options.closed = drawn.closed;
  options.recognise_loops = may_close;
  options.snap = snap;
  const Stroke stroke = neat_stroke(prepare_stroke(drawn.points, options));
  const SelfContact self = self_contact(stroke, 0.25 * snap);
  if (self.found)
    throw RefusedEdit(concat("the stroke meets itself near (", text_of_length(self.place.x()), ", ",
                             text_of_length(self.place.y()), ", ", text_of_length(self.place.z()),
                             ") at a distance of ", text_of_length(self.distance)),
                      "draw it as several strokes that do not cross themselves");
  return stroke;
}

double reach_of(const PolylineMesh& mesh, const Stroke& stroke, double factor) {
  return std::min(factor * default_snap(mesh, stroke.points), 0.25 * stroke.length);
}

namespace {

/// The end of a stroke that reaches_stroke() makes.
Stroke with_reaching_end(const PolylineMesh& mesh, const Stroke& stroke, double reach,
                         const std::function<bool(int)>& may_end) {
  constexpr double kAlong = 0.5;       // what a place along the stroke costs, of one as far beside it
  constexpr double kDirection = 0.05;  // of the length
  const std::vector<double> arcs = stroke.arcs();
  const Polyline line(stroke.points);
  const Eigen::Vector3d tip = line.back();
  const Eigen::Vector3d heading = (tip - line.at(stroke.length * (1 - kDirection))).stableNormalized();
  Points around(2, 3);
  const Stroke tail = part_of(stroke, stroke.length - reach, stroke.length);
  around = tail.points;
  constexpr int kSteps = 16;
  const Eigen::Index n_tail = around.rows();
  around.conservativeResize(n_tail + kSteps, 3);
  for (int k = 0; k < kSteps; ++k)
    around.row(n_tail + k) = (tip + heading * reach * (k + 1) / kSteps).transpose();
  double least = reach;
  const Hit* best = nullptr;
  const std::vector<Hit> hits = find_hits(mesh, Polyline(around), reach);
  for (const Hit& hit : hits) {
    if (may_end && !may_end(hit.edge)) continue;
    const double cost = hit.distance + kAlong * std::abs(hit.arc - reach);
    if (cost >= least) continue;
    least = cost;
    best = &hit;
  }
  if (!best || least <= 1e-9 * stroke.length) return stroke;
  const double along = best->arc - reach;  // of the end; negative: the stroke is cut off
  Stroke result = along < 0 ? part_of(stroke, 0, stroke.length + along) : stroke;
  if (along > 0) {
    const double step = stroke.length / static_cast<double>(stroke.points.rows());
    const int n = std::max(1, static_cast<int>(std::ceil(along / step)));
    const Eigen::Index before = result.points.rows();
    result.points.conservativeResize(before + n, 3);
    for (int k = 0; k < n; ++k)
      result.points.row(before + k) = (tip + heading * along * (k + 1) / n).transpose();
  }
  result.length = result.arcs().back();
  result.is_neat = true;
  const Eigen::Vector3d place = mesh.edge(best->edge).polyline->at(best->edge_arc);
  const Eigen::Vector3d aside = place - result.points.row(result.points.rows() - 1).transpose();
  const double blend = std::min(result.length, std::max(10 * aside.norm(), 0.25 * result.length));
  const std::vector<double> new_arcs = result.arcs();
  for (Eigen::Index i = 0; i < result.points.rows(); ++i) {
    const double t = 1 - (result.length - new_arcs[static_cast<size_t>(i)]) / blend;
    if (t > 0) result.points.row(i) += t * t * (3 - 2 * t) * aside.transpose();
  }
  result.length = result.arcs().back();
  return result;
}

}  // namespace

Stroke reaching_stroke(const PolylineMesh& mesh, const Stroke& stroke, double reach,
                       const std::function<bool(int)>& may_end) {
  if (mesh.empty() || stroke.closed || reach <= 0) return stroke;
  const Stroke back = with_reaching_end(mesh, stroke, reach, may_end);
  return reversed_stroke(with_reaching_end(mesh, reversed_stroke(back), reach, may_end));
}

void require_curve(const PolylineMesh& mesh, int curve) {
  if (curve >= 0 && curve < mesh.n_curves() && !mesh.edges_of_curve(curve).empty()) return;
  if (curve >= 0 && curve < mesh.n_curves())
    throw RefusedEdit(concat("c", curve, " was deleted"), "name a curve that exists, or undo its deletion");
  throw RefusedEdit(concat("there is no curve c", curve),
                    mesh.n_curves() == 0 ? std::string("insert a curve first")
                                         : concat("the curves are c0 to c", mesh.n_curves() - 1));
}

Stroke reversed_stroke(const Stroke& stroke) {
  Stroke result = stroke;
  result.points = stroke.points.colwise().reverse();
  for (int& corner : result.corners) corner = static_cast<int>(stroke.points.rows()) - 1 - corner;
  std::reverse(result.corners.begin(), result.corners.end());
  return result;
}

Stroke part_of(const Stroke& stroke, double from, double to) {
  const std::vector<double> arcs = stroke.arcs();
  const Polyline line(stroke.points);
  Stroke part = stroke;
  std::vector<Eigen::Index> rows;
  const double tiny = 1e-9 * stroke.length;
  part.corners.clear();
  for (Eigen::Index i = 0; i < stroke.points.rows(); ++i) {
    const double arc = arcs[static_cast<size_t>(i)];
    if (arc <= from + tiny || arc >= to - tiny) continue;
    rows.push_back(i);
    if (std::count(stroke.corners.begin(), stroke.corners.end(), static_cast<int>(i)) > 0)
      part.corners.push_back(static_cast<int>(rows.size()));
  }
  part.points.resize(static_cast<Eigen::Index>(rows.size()) + 2, 3);
  part.points.row(0) = line.at(from).transpose();
  for (size_t k = 0; k < rows.size(); ++k)
    part.points.row(static_cast<Eigen::Index>(k) + 1) = stroke.points.row(rows[k]);
  part.points.row(part.points.rows() - 1) = line.at(to).transpose();
  part.length = part.arcs().back();
  return part;
}

std::vector<int> reversed_chain(const std::vector<int>& chain) {
  std::vector<int> result(chain.rbegin(), chain.rend());
  for (int& side : result) side = opposite_side(side);
  return result;
}

Eigen::Vector3d half_direction(const PolylineMesh& mesh, const std::vector<int>& chain) {
  double length = 0;
  for (const int side : chain) length += mesh.edge(edge_of(side)).polyline->length();
  double left = length / 2;
  Eigen::Vector3d middle = mesh.vertex(mesh.start_of(chain.front())).position;
  for (const int side : chain) {
    const Polyline& line = *mesh.edge(edge_of(side)).polyline;
    if (left <= line.length()) {
      middle = line.at(side & 1 ? line.length() - left : left);
      break;
    }
    left -= line.length();
  }
  const Eigen::Vector3d ends =
      (mesh.vertex(mesh.start_of(chain.front())).position + mesh.vertex(mesh.end_of(chain.back())).position) /
      2;
  return (ends - middle).stableNormalized();
}

bool first_faces_first(const PolylineMesh& mesh, const std::array<std::vector<int>, 2>& a,
                       const std::array<std::vector<int>, 2>& b) {
  double best[2] = {-2, -2};
  for (size_t i = 0; i < 2; ++i)
    for (size_t j = 0; j < 2; ++j)
      best[i == j ? 0 : 1] =
          std::max(best[i == j ? 0 : 1], half_direction(mesh, a[i]).dot(half_direction(mesh, b[j])));
  return best[0] >= best[1];
}

std::vector<int> seams_near(const PolylineMesh& mesh, const std::vector<int>& vertices) {
  std::vector<int> seams;
  for (const int v : vertices)
    for (const int e : mesh.vertex(v).edges)
      for (const int end : mesh.edge(e).vertices)
        if (mesh.vertex(end).is_seam && std::find(seams.begin(), seams.end(), end) == seams.end())
          seams.push_back(end);
  return seams;
}

}  // namespace detail

}  // namespace batten
