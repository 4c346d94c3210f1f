#include "batten/sketch/polyline_mesh.hpp"

#include <algorithm>
#include <numeric>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

/// Remembers the value of an element the first time it is touched in an edit.
template <typename Element>
Element& touch(std::vector<Element>& elements, std::vector<char>& touched,
               PolylineMesh::Change::Part<Element>& part, int i) {
  if (touched.size() < elements.size()) touched.resize(elements.size(), 0);
  if (!touched[at(i)]) {
    touched[at(i)] = 1;
    part.before.emplace_back(i, elements[at(i)]);
  }
  return elements[at(i)];
}

template <typename Element>
void finish(const std::vector<Element>& elements, std::vector<char>& touched,
            PolylineMesh::Change::Part<Element>& part) {
  part.size_after = static_cast<int>(elements.size());
  for (const auto& [i, value] : part.before) {
    touched[at(i)] = 0;
    part.after.emplace_back(i, elements[at(i)]);
  }
}

template <typename Element>
void restore(std::vector<Element>& elements, const std::vector<std::pair<int, Element>>& values, int size) {
  elements.resize(at(size));
  for (const auto& [i, value] : values)
    if (i < size) elements[at(i)] = value;
}

template <typename Element>
void unmark(std::vector<char>& touched, const PolylineMesh::Change::Part<Element>& part) {
  for (const auto& [i, value] : part.before) touched[at(i)] = 0;
}

void erase_one(std::vector<int>& values, int value) {
  values.erase(std::find(values.begin(), values.end(), value));
}

void insert_sorted(std::vector<int>& values, int value) {
  values.insert(std::lower_bound(values.begin(), values.end(), value), value);
}

void erase_sorted(std::vector<int>& values, int value) {
  values.erase(std::lower_bound(values.begin(), values.end(), value));
}

}  // namespace

bool SketchEdge::operator==(const SketchEdge& other) const {
  if (alive != other.alive) return false;
  if (!alive) return true;
  return vertices == other.vertices && faces == other.faces && curve == other.curve &&
         sharpness == other.sharpness && drawn == other.drawn &&
         (polyline == other.polyline || polyline->points() == other.polyline->points());
}

bool PolylineMesh::operator==(const PolylineMesh& other) const {
  return n_curves_ == other.n_curves_ && vertices_ == other.vertices_ && edges_ == other.edges_ &&
         faces_ == other.faces_;
}

bool PolylineMesh::empty() const {
  return edge_boxes_.empty();
}

Eigen::Vector3d PolylineMesh::direction_of(int side) const {
  const Polyline& polyline = *edge(edge_of(side)).polyline;
  return side & 1 ? polyline.direction_at_back() : polyline.direction_at_front();
}

std::vector<int> PolylineMesh::opening(int side) const {
  std::vector<int> sides;
  int current = side;
  do {
    sides.push_back(current);
    int next = -1;
    for (const int e : vertex(end_of(current)).edges)
      for (const int s : {side_of(e, false), side_of(e, true)})
        if (start_of(s) == end_of(current) && face_of(s) < 0 && face_of(opposite_side(s)) >= 0) next = s;
    if (next < 0 || sides.size() > edges_.size()) break;
    current = next;
  } while (current != side);
  return sides;
}

std::vector<int> PolylineMesh::edges_of_curve(int curve) const {
  if (curve < 0 || at(curve) >= edges_of_curve_.size()) return {};
  return edges_of_curve_[at(curve)];
}

double PolylineMesh::diameter() const {
  return empty() ? 0 : (edge_boxes_.bounds().high - edge_boxes_.bounds().low).norm();
}

void PolylineMesh::require_editing(bool wanted) const {
  if (editing_ == wanted) return;
  throw InvalidInput(wanted ? "a model changes within an edit only; call begin() first"
                            : "an edit of the model is under way; commit() it or roll_back() first");
}

void PolylineMesh::begin() {
  require_editing(false);
  change_ = {};
  change_.vertices.size_before = static_cast<int>(vertices_.size());
  change_.edges.size_before = static_cast<int>(edges_.size());
  change_.faces.size_before = static_cast<int>(faces_.size());
  change_.n_curves_before = n_curves_;
  editing_ = true;
}

PolylineMesh::Change PolylineMesh::commit() {
  require_editing(true);
  finish(vertices_, touched_vertices_, change_.vertices);
  finish(edges_, touched_edges_, change_.edges);
  finish(faces_, touched_faces_, change_.faces);
  change_.n_curves_after = n_curves_;
  editing_ = false;
  return std::move(change_);
}

void PolylineMesh::roll_back() {
  require_editing(true);
  replay(change_, false);
  unmark(touched_vertices_, change_.vertices);
  unmark(touched_edges_, change_.edges);
  unmark(touched_faces_, change_.faces);
  change_ = {};
  editing_ = false;
}

void PolylineMesh::undo(const Change& change) {
  require_editing(false);
  replay(change, false);
}

void PolylineMesh::redo(const Change& change) {
  require_editing(false);
  replay(change, true);
}

void PolylineMesh::replay(const Change& change, bool forwards) {
  const auto curve_of = [&](int e) { return at(e) < edges_.size() && edge(e).alive ? edge(e).curve : -1; };
  std::vector<int> old_curves;
  for (const auto& [e, value] : change.edges.before) old_curves.push_back(curve_of(e));
  const auto put_back = [&](auto& elements, const auto& part) {
    restore(elements, forwards ? part.after : part.before, forwards ? part.size_after : part.size_before);
  };
  put_back(vertices_, change.vertices);
  put_back(edges_, change.edges);
  put_back(faces_, change.faces);
  n_curves_ = forwards ? change.n_curves_after : change.n_curves_before;

  if (change.edges.before.size() > edges_.size() / 4) {
    index_everything();
    return;
  }
  edges_of_curve_.resize(std::max(at(n_curves_), edges_of_curve_.size()));
  std::vector<int> faces;
  for (const auto& [f, value] : change.faces.before) faces.push_back(f);
  for (size_t k = 0; k < old_curves.size(); ++k) {
    const int e = change.edges.before[k].first, curve = curve_of(e);
    index_edge(e);
    if (curve >= 0) faces.insert(faces.end(), edge(e).faces.begin(), edge(e).faces.end());
    if (curve == old_curves[k]) continue;
    if (old_curves[k] >= 0) erase_sorted(edges_of_curve_[at(old_curves[k])], e);
    if (curve >= 0) insert_sorted(edges_of_curve_[at(curve)], e);
  }
  edges_of_curve_.resize(at(n_curves_));
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  for (const int f : faces) index_face(f);
}

void PolylineMesh::index_edge(int e) {
  if (at(e) < edges_.size() && edge(e).alive)
    edge_boxes_.set(e, edge(e).polyline->box());
  else
    edge_boxes_.remove(e);
}

void PolylineMesh::index_face(int f) {
  if (f < 0) return;
  if (at(f) < faces_.size() && face(f).alive)
    face_boxes_.set(f, box_of_face(f));
  else
    face_boxes_.remove(f);
}

Box PolylineMesh::box_of_face(int f) const {
  const std::vector<int>& sides = face(f).sides;
  Box box = edge(edge_of(sides.front())).polyline->box();
  for (const int side : sides) box.include(edge(edge_of(side)).polyline->box());
  return box;
}

void PolylineMesh::index_everything() {
  std::vector<std::pair<int, Box>> boxes;
  edges_of_curve_.assign(at(n_curves_), {});
  for (int e = 0; e < static_cast<int>(edges_.size()); ++e) {
    if (!edge(e).alive) continue;
    boxes.emplace_back(e, edge(e).polyline->box());
    edges_of_curve_[at(edge(e).curve)].push_back(e);
  }
  edge_boxes_.assign(boxes);
  boxes.clear();
  for (int f = 0; f < static_cast<int>(faces_.size()); ++f)
    if (face(f).alive) boxes.emplace_back(f, box_of_face(f));
  face_boxes_.assign(boxes);
}

SketchVertex& PolylineMesh::touch_vertex(int v) {
  require_editing(true);
  return touch(vertices_, touched_vertices_, change_.vertices, v);
}
SketchEdge& PolylineMesh::touch_edge(int e) {
  require_editing(true);
  return touch(edges_, touched_edges_, change_.edges, e);
}
SketchFace& PolylineMesh::touch_face(int f) {
  require_editing(true);
  return touch(faces_, touched_faces_, change_.faces, f);
}

int PolylineMesh::add_curve() {
  require_editing(true);
  edges_of_curve_.emplace_back();
  return n_curves_++;
}

int PolylineMesh::add_vertex(const Eigen::Vector3d& position, bool is_seam) {
  require_editing(true);
  const int v = static_cast<int>(vertices_.size());
  vertices_.emplace_back();
  SketchVertex& vertex = touch_vertex(v);
  vertex.position = position;
  vertex.is_seam = is_seam;
  vertex.alive = true;
  return v;
}

int PolylineMesh::add_edge(int from, int to, SharedPolyline polyline, int curve, double sharpness,
                           bool drawn) {
  require_editing(true);
  const int e = static_cast<int>(edges_.size());
  edges_.emplace_back();
  SketchEdge& edge = touch_edge(e);
  edge.vertices = {from, to};
  edge.polyline = std::move(polyline);
  edge.curve = curve;
  edge.sharpness = sharpness;
  edge.drawn = drawn;
  edge.alive = true;
  touch_vertex(from).edges.push_back(e);
  touch_vertex(to).edges.push_back(e);
  edges_of_curve_[at(curve)].push_back(e);
  index_edge(e);
  return e;
}

int PolylineMesh::add_face(std::vector<int> sides) {
  require_editing(true);
  const int f = static_cast<int>(faces_.size());
  faces_.emplace_back();
  SketchFace& face = touch_face(f);
  for (const int side : sides) touch_edge(edge_of(side)).faces[at(side & 1)] = f;
  face.sides = std::move(sides);
  face.alive = true;
  index_face(f);
  return f;
}

void PolylineMesh::remove_face(int f) {
  SketchFace& face = touch_face(f);
  for (const int side : face.sides) touch_edge(edge_of(side)).faces[at(side & 1)] = -1;
  face = {};
  index_face(f);
}

void PolylineMesh::remove_edge(int e) {
  SketchEdge& edge = touch_edge(e);
  for (const int v : edge.vertices) erase_one(touch_vertex(v).edges, e);
  erase_sorted(edges_of_curve_[at(edge.curve)], e);
  edge = {};
  index_edge(e);
}

void PolylineMesh::remove_vertex(int v) {
  touch_vertex(v) = {};
}

int PolylineMesh::split_edge(int e, double arc_length, const Eigen::Vector3d& at) {
  const int middle = add_vertex(at);
  const int end = edge(e).vertices[1];
  auto [first, second] = cut(*edge(e).polyline, arc_length, at);
  const SketchEdge old = edge(e);
  const int rest = add_edge(middle, end, std::move(second), old.curve, old.sharpness, old.drawn);
  touch_edge(rest).faces = old.faces;
  SketchEdge& kept = touch_edge(e);
  kept.polyline = std::move(first);
  kept.vertices[1] = middle;
  erase_one(touch_vertex(end).edges, e);
  touch_vertex(middle).edges.push_back(e);
  for (const bool backwards : {false, true}) {
    const int f = old.faces[backwards ? 1 : 0];
    if (f < 0) continue;
    auto& sides = touch_face(f).sides;
    const auto found = std::find(sides.begin(), sides.end(), side_of(e, backwards));
    sides.insert(backwards ? found : found + 1, side_of(rest, backwards));
  }
  index_edge(e);
  for (const int f : old.faces) index_face(f);
  return middle;
}

bool PolylineMesh::dissolve_vertex(int v) {
  if (vertex(v).edges.size() != 2) return false;
  const int kept = std::min(vertex(v).edges[0], vertex(v).edges[1]);
  const int gone = std::max(vertex(v).edges[0], vertex(v).edges[1]);
  const bool leaves_kept = edge(kept).vertices[0] == v, leaves_gone = edge(gone).vertices[0] == v;
  const int near_end = edge(kept).vertices[leaves_kept ? 1 : 0];
  const int far_end = edge(gone).vertices[leaves_gone ? 1 : 0];
  if (near_end == far_end) return false;
  // The polyline of the edge that goes, in the sense of the one that stays.
  const bool same_sense = leaves_kept != leaves_gone;
  const SharedPolyline other = same_sense ? edge(gone).polyline : reversed(*edge(gone).polyline);
  SharedPolyline whole =
      leaves_kept ? joined(*other, *edge(kept).polyline) : joined(*edge(kept).polyline, *other);
  for (const int f : edge(gone).faces) {
    if (f < 0) continue;
    auto& sides = touch_face(f).sides;
    sides.erase(std::find_if(sides.begin(), sides.end(), [&](int s) { return edge_of(s) == gone; }));
  }
  touch_edge(gone).faces = {-1, -1};
  remove_edge(gone);
  SketchEdge& edge = touch_edge(kept);
  edge.polyline = std::move(whole);
  edge.vertices[leaves_kept ? 0 : 1] = far_end;
  touch_vertex(far_end).edges.push_back(kept);
  touch_vertex(v) = {};
  index_edge(kept);
  for (const int f : edge.faces) index_face(f);
  return true;
}

namespace {

/// The two walks into which a chain from corner to corner divides a closed walk.
std::pair<std::vector<int>, std::vector<int>> divided(const PolylineMesh& mesh, const std::vector<int>& walk,
                                                      const std::vector<int>& chain) {
  const int from = mesh.start_of(chain.front()), to = mesh.end_of(chain.back());
  const auto corner = [&](int v) {
    return static_cast<size_t>(
        std::find_if(walk.begin(), walk.end(), [&](int s) { return mesh.start_of(s) == v; }) - walk.begin());
  };
  const size_t at_from = corner(from), at_to = corner(to), n = walk.size();
  std::vector<int> first, second;
  for (size_t k = at_from; k % n != at_to; ++k) first.push_back(walk[k % n]);
  for (size_t k = at_to; k % n != at_from; ++k) second.push_back(walk[k % n]);
  for (auto side = chain.rbegin(); side != chain.rend(); ++side) first.push_back(opposite_side(*side));
  second.insert(second.end(), chain.begin(), chain.end());
  return {first, second};
}

}  // namespace

int PolylineMesh::split_face(int f, const std::vector<int>& chain) {
  auto [first, second] = divided(*this, face(f).sides, chain);
  for (const int side : first) touch_edge(edge_of(side)).faces[at(side & 1)] = f;
  touch_face(f).sides = std::move(first);
  index_face(f);
  return add_face(std::move(second));
}

void PolylineMesh::close_opening(int side, const std::vector<int>& chain) {
  auto [first, second] = divided(*this, opening(side), chain);
  add_face(std::move(first));
  add_face(std::move(second));
}

void PolylineMesh::set_sharpness(int e, double sharpness) {
  touch_edge(e).sharpness = sharpness;
}

void PolylineMesh::set_seam(int v, bool is_seam) {
  touch_vertex(v).is_seam = is_seam;
}

void PolylineMesh::move_everything(const Eigen::Matrix4d& matrix) {
  // The same expression for vertices and for points of polylines, so that ends stay on vertices bit for bit.
  const auto moved = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    Eigen::Vector3d q;
    for (int i = 0; i < 3; ++i)
      q(i) = matrix(i, 0) * p.x() + matrix(i, 1) * p.y() + matrix(i, 2) * p.z() + matrix(i, 3);
    return q;
  };
  for (size_t v = 0; v < vertices_.size(); ++v) {
    if (!vertices_[v].alive) continue;
    SketchVertex& vertex = touch_vertex(static_cast<int>(v));
    vertex.position = moved(vertex.position);
  }
  for (size_t e = 0; e < edges_.size(); ++e) {
    if (!edges_[e].alive) continue;
    SketchEdge& edge = touch_edge(static_cast<int>(e));
    Points points(edge.polyline->n_points(), 3);
    for (Eigen::Index i = 0; i < points.rows(); ++i)
      points.row(i) = moved(edge.polyline->points().row(i)).transpose();
    // Compilers may contract products and sums differently in the two loops; the ends follow the vertices.
    points.row(0) = vertex(edge.vertices[0]).position.transpose();
    points.row(points.rows() - 1) = vertex(edge.vertices[1]).position.transpose();
    edge.polyline = std::make_shared<Polyline>(std::move(points));
  }
  index_everything();
}

void PolylineMesh::flip_component(int f) {
  std::vector<int> stack{f};
  std::vector<char> seen(faces_.size(), 0);
  seen[at(f)] = 1;
  std::vector<int> faces, edges;
  while (!stack.empty()) {
    const int current = stack.back();
    stack.pop_back();
    faces.push_back(current);
    for (const int side : face(current).sides) {
      edges.push_back(edge_of(side));
      const int next = face_of(opposite_side(side));
      if (next >= 0 && !seen[at(next)]) {
        seen[at(next)] = 1;
        stack.push_back(next);
      }
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  for (const int e : edges) std::swap(touch_edge(e).faces[0], touch_edge(e).faces[1]);
  for (const int current : faces) {
    auto& sides = touch_face(current).sides;
    std::reverse(sides.begin(), sides.end());
    for (int& side : sides) side = opposite_side(side);
  }
}

PolylineMesh PolylineMeshReader::assemble(std::vector<SketchVertex> vertices, std::vector<SketchEdge> edges,
                                          std::vector<SketchFace> faces, int n_curves) {
  PolylineMesh mesh;
  mesh.vertices_ = std::move(vertices);
  mesh.edges_ = std::move(edges);
  mesh.faces_ = std::move(faces);
  mesh.n_curves_ = n_curves;
  if (const std::string problem = mesh.broken_invariant(); !problem.empty())
    throw InvalidInput("the stored model is damaged: " + problem);
  mesh.index_everything();
  return mesh;
}

}  // namespace batten
