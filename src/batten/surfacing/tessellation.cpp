#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>
#include <tuple>

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Constrained_triangulation_face_base_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include "batten/core/text.hpp"
#include "batten/operators/intrinsic.hpp"
#include "batten/surfacing/tessellation_detail.hpp"

namespace batten::detail {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<int, Kernel>;
using FaceBase =
    CGAL::Constrained_triangulation_face_base_2<Kernel,
                                                CGAL::Triangulation_face_base_with_info_2<char, Kernel>>;
using Structure = CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>;
using Cdt =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel, Structure,
                                               CGAL::No_constraint_intersection_requiring_constructions_tag>;
using Point = Kernel::Point_2;
using Face = Cdt::Face_handle;
using Vertex = Cdt::Vertex_handle;

/// Lengths and area of a triangle of the plane.
struct Shape {
  double area = 0, longest2 = 0, shortest2 = 0;
  int shortest = 0;  ///< the corner opposite the shortest side
  Shape(const Point& a, const Point& b, const Point& c) {
    const double sides[3] = {CGAL::squared_distance(b, c), CGAL::squared_distance(c, a),
                             CGAL::squared_distance(a, b)};
    area = 0.5 * ((b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x()));
    longest2 = std::max({sides[0], sides[1], sides[2]});
    shortest = static_cast<int>(std::min_element(sides, sides + 3) - sides);
    shortest2 = sides[shortest];
    circumradius2 = area > 0 ? sides[0] * sides[1] * sides[2] / (16 * area * area) : 0;
  }
  double circumradius2 = 0;
};

class Mesher {
 public:
  Mesher(const PlaneRegion& region, const TessellationOptions& options) : region_(region), options_(options) {
    // sin of the smallest angle = shortest side / (2 circumradius).
    const double s = std::sin(options.min_angle);
    worst_ratio2_ = 1 / (4 * s * s);
  }

  const std::vector<int>& pinned() const { return pinned_; }

  Tessellation run() {
    Tessellation result;
    if (!insert_corners(result.problem) || !insert_loops(result.problem) || !mark_region(result.problem))
      return result;
    refine();
    collect(result);
    result.valid = true;
    return result;
  }

 private:
  bool insert_corners(std::string& problem) {
    Face hint;
    handles_.reserve(static_cast<std::size_t>(region_.corners.rows()));
    for (Eigen::Index i = 0; i < region_.corners.rows(); ++i) {
      const std::size_t before = cdt_.number_of_vertices();
      const Vertex v = cdt_.insert(Point(region_.corners(i, 0), region_.corners(i, 1)), hint);
      if (cdt_.number_of_vertices() == before) {
        problem = "two of its vertices fall on one point";
        return false;
      }
      v->info() = static_cast<int>(i);
      hint = v->face();
      handles_.push_back(v);
    }
    return true;
  }

  bool insert_loops(std::string& problem) {
    try {
      for (const std::vector<int>& loop : region_.loops)
        for (std::size_t i = 0; i < loop.size(); ++i) {
          const Vertex a = handles_[loop[i]], b = handles_[loop[(i + 1) % loop.size()]];
          cdt_.insert_constraint(a, b);
          // A corner on the edge splits the constraint: the loops touch.
          if (!cdt_.is_edge(a, b)) {
            problem = "its outline touches itself";
            return false;
          }
        }
    } catch (const Cdt::Intersection_of_constraints_exception&) {
      problem = "its outline crosses itself";
      return false;
    }
    return true;
  }

  bool mark_region(std::string& problem) {
    for (Face f : cdt_.all_face_handles()) f->info() = 0;
    std::vector<Face> stack, outer;
    for (const std::vector<int>& loop : region_.loops)
      for (std::size_t i = 0; i < loop.size(); ++i) {
        const Vertex a = handles_[loop[i]], b = handles_[loop[(i + 1) % loop.size()]];
        Face f;
        int k = 0;
        cdt_.is_edge(a, b, f, k);
        Face g = f->neighbor(k);
        if (f->vertex(Cdt::ccw(k)) != a) std::swap(f, g);
        stack.push_back(f);
        outer.push_back(g);
      }
    while (!stack.empty()) {
      const Face f = stack.back();
      stack.pop_back();
      if (f->info() != 0) continue;
      if (cdt_.is_infinite(f)) {
        problem = "its outline runs the wrong way round";
        return false;
      }
      f->info() = 1;
      for (int k = 0; k < 3; ++k)
        if (!f->is_constrained(k)) stack.push_back(f->neighbor(k));
    }
    // The right side of a loop lies in the region only along slits, whose edges are passed both ways.
    std::size_t inside_right = 0, slit = 0;
    std::vector<std::pair<int, int>> edges;
    for (const std::vector<int>& loop : region_.loops)
      for (std::size_t i = 0; i < loop.size(); ++i) edges.emplace_back(loop[i], loop[(i + 1) % loop.size()]);
    std::vector<std::pair<int, int>> sorted = edges;
    std::sort(sorted.begin(), sorted.end());
    for (const auto& [a, b] : edges)
      if (std::binary_search(sorted.begin(), sorted.end(), std::pair<int, int>(b, a))) ++slit;
    for (const Face& g : outer)
      if (g->info() == 1) ++inside_right;
    if (inside_right != slit) {
      problem = "its outline winds round twice";
      return false;
    }
    return true;
  }

  struct Task {
    double size;  ///< squared circumradius: the emptiest place first
    int a, b, c;
    Face face;
    bool operator<(const Task& other) const {
      return std::tie(size, other.a, other.b, other.c) < std::tie(other.size, a, b, c);
    }
  };

  void enqueue(Face f) {
    if (f->info() != 1) return;
    const Shape shape(f->vertex(0)->point(), f->vertex(1)->point(), f->vertex(2)->point());
    if (!(shape.area > 0)) return;
    if (blunt_ear(f) >= 0) {  // before everything else: no refinement of its neighbours removes it
      queue_.push({std::numeric_limits<double>::infinity(), f->vertex(0)->info(), f->vertex(1)->info(),
                   f->vertex(2)->info(), f});
      return;
    }
    const bool large = shape.area > options_.max_area;
    // A small angle between two given edges cannot be mended, nor one over a short given edge alone.
    const bool thin =
        shape.circumradius2 > worst_ratio2_ * shape.shortest2 &&
        !(f->is_constrained(Cdt::ccw(shape.shortest)) && f->is_constrained(Cdt::cw(shape.shortest)));
    if (!large && !thin) return;
    queue_.push({shape.circumradius2, f->vertex(0)->info(), f->vertex(1)->info(), f->vertex(2)->info(), f});
  }

  /// The corner where two given edges meet at more than 110° under a triangle that cuts them off, or -1. Its
  /// third side would skip a sample of the curve, and the patch beyond the curve may do the same.
  static int blunt_ear(Face f) {
    for (int k = 0; k < 3; ++k) {
      if (!f->is_constrained(Cdt::ccw(k)) || !f->is_constrained(Cdt::cw(k))) continue;
      const Kernel::Vector_2 a = f->vertex(Cdt::ccw(k))->point() - f->vertex(k)->point();
      const Kernel::Vector_2 b = f->vertex(Cdt::cw(k))->point() - f->vertex(k)->point();
      if (a * b < -0.342 * std::sqrt(a.squared_length() * b.squared_length())) return k;
    }
    return -1;
  }

  /// A vertex into the opening of a blunt ear, as far from its corner as the shorter side is long.
  void open_ear(Face f, int k) {
    const Point corner = f->vertex(k)->point();
    const Kernel::Vector_2 a = f->vertex(Cdt::ccw(k))->point() - corner,
                           b = f->vertex(Cdt::cw(k))->point() - corner;
    const double length = std::sqrt(std::min(a.squared_length(), b.squared_length()));
    const Kernel::Vector_2 chord = b - a;
    // (corner, ccw, cw) runs counter-clockwise, so the region lies to the left of the chord turned back.
    const double scale = 0.9 * length / std::sqrt(chord.squared_length());
    const Point p(corner.x() + chord.y() * scale, corner.y() - chord.x() * scale);
    if (try_insert(p, f, 0.4 * length)) pinned_.push_back(next_ - 1);
  }

  void refine() {
    for (Face f : cdt_.finite_face_handles()) enqueue(f);
    next_ = static_cast<int>(handles_.size());
    while (!queue_.empty()) {
      const Task task = queue_.top();
      queue_.pop();
      const Face f = task.face;
      // Faces are reused by later insertions: the task holds only while its corners are the same.
      if (f->info() != 1 || f->vertex(0)->info() != task.a || f->vertex(1)->info() != task.b ||
          f->vertex(2)->info() != task.c)
        continue;
      const int ear = blunt_ear(f);
      if (ear >= 0) {
        open_ear(f, ear);
        continue;
      }
      const Shape shape(f->vertex(0)->point(), f->vertex(1)->point(), f->vertex(2)->point());
      const Point centre =
          CGAL::circumcenter(f->vertex(0)->point(), f->vertex(1)->point(), f->vertex(2)->point());
      if (try_insert(centre, f, 0)) continue;
      if (shape.area <= options_.max_area) continue;
      // Too large, but its circumcentre crowds or crosses the outline: over a given edge put the apex of the
      // equilateral triangle, else the centroid.
      bool done = false;
      for (int k = 0; k < 3 && !done; ++k) {
        if (!f->is_constrained(k)) continue;
        const Point a = f->vertex(Cdt::ccw(k))->point(), b = f->vertex(Cdt::cw(k))->point();
        const double h = 0.8660254037844386;
        const Point apex(0.5 * (a.x() + b.x()) - h * (b.y() - a.y()),
                         0.5 * (a.y() + b.y()) + h * (b.x() - a.x()));
        done = try_insert(apex, f, 0.45 * std::sqrt(CGAL::squared_distance(a, b)));
      }
      if (!done) {
        const Point centroid =
            CGAL::centroid(f->vertex(0)->point(), f->vertex(1)->point(), f->vertex(2)->point());
        try_insert(centroid, f, 0.6 * std::sqrt(options_.max_area));
      }
    }
  }

  /// Inserts p unless it lies outside, encroaches upon a given edge or, with clearance > 0, comes closer than
  /// that to a vertex. With a clearance the edges' circles do not count.
  bool try_insert(const Point& p, Face hint, double clearance) {
    Cdt::Locate_type type{};
    int k = 0;
    const Face at = cdt_.locate(p, type, k, hint);
    if (type != Cdt::FACE && type != Cdt::EDGE) return false;
    if (at->info() != 1 || (type == Cdt::EDGE && (at->is_constrained(k) || at->neighbor(k)->info() != 1)))
      return false;
    conflicts_.clear();
    rim_.clear();
    cdt_.get_conflicts_and_boundary(p, std::back_inserter(conflicts_), std::back_inserter(rim_), at);
    for (const auto& [f, i] : rim_) {
      const Point a = f->vertex(Cdt::ccw(i))->point(), b = f->vertex(Cdt::cw(i))->point();
      if (clearance > 0) {
        if (CGAL::squared_distance(a, p) < clearance * clearance) return false;
      } else if (f->is_constrained(i) &&
                 (a.x() - p.x()) * (b.x() - p.x()) + (a.y() - p.y()) * (b.y() - p.y()) <= 0) {
        return false;
      }
    }
    const Vertex v = cdt_.insert(p, type, at, k);
    v->info() = next_++;
    Cdt::Face_circulator around = cdt_.incident_faces(v), end = around;
    do {
      around->info() = 1;
    } while (++around != end);
    around = end = cdt_.incident_faces(v);
    do enqueue(around);
    while (++around != end);
    return true;
  }

  void collect(Tessellation& result) const {
    result.vertices.resize(static_cast<Eigen::Index>(cdt_.number_of_vertices()), 2);
    for (Vertex v : cdt_.finite_vertex_handles())
      result.vertices.row(v->info()) << v->point().x(), v->point().y();
    std::vector<std::array<int, 3>> list;
    for (Face f : cdt_.finite_face_handles()) {
      if (f->info() != 1) continue;
      std::array<int, 3> corners = {f->vertex(0)->info(), f->vertex(1)->info(), f->vertex(2)->info()};
      std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
      list.push_back(corners);
    }
    std::sort(list.begin(), list.end());
    result.triangles.resize(static_cast<Eigen::Index>(list.size()), 3);
    for (std::size_t f = 0; f < list.size(); ++f)
      result.triangles.row(static_cast<Eigen::Index>(f)) << list[f][0], list[f][1], list[f][2];
  }

  const PlaneRegion& region_;
  const TessellationOptions& options_;
  double worst_ratio2_ = 0;
  Cdt cdt_;
  std::vector<Vertex> handles_;
  std::priority_queue<Task> queue_;
  std::vector<Face> conflicts_;
  std::vector<Cdt::Edge> rim_;
  int next_ = 0;
  std::vector<int> pinned_;  ///< vertices that hold blunt ears open; smoothing must leave them in place
};

/// Evens the triangles out: inner vertices move to the area-weighted mean of the circumcentres around them
/// (optimal Delaunay triangulation [chen2004]), where that turns no triangle over, and edges flip to
/// Delaunay.
void smooth(Tessellation& mesh, Eigen::Index n_corners, const std::vector<int>& pinned, int rounds) {
  const Eigen::Index n = mesh.vertices.rows();
  std::vector<char> held(static_cast<std::size_t>(n), 0);
  for (const int v : pinned) held[v] = 1;
  const auto embedded = [&] {
    Points points(n, 3);
    points << mesh.vertices, Eigen::VectorXd::Zero(n);
    return points;
  };
  for (int round = 0; round < rounds; ++round) {
    std::vector<int> start(static_cast<std::size_t>(n) + 1, 0);
    for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f)
      for (int k = 0; k < 3; ++k) ++start[mesh.triangles(f, k) + 1];
    for (Eigen::Index v = 0; v < n; ++v) start[v + 1] += start[v];
    std::vector<int> around(start.back()), fill(start.begin(), start.end() - 1);
    for (Eigen::Index f = 0; f < mesh.triangles.rows(); ++f)
      for (int k = 0; k < 3; ++k) around[fill[mesh.triangles(f, k)]++] = static_cast<int>(f);
    const auto twice_area = [&](int f) {
      const Eigen::RowVector2d a = mesh.vertices.row(mesh.triangles(f, 0)),
                               b = mesh.vertices.row(mesh.triangles(f, 1)),
                               c = mesh.vertices.row(mesh.triangles(f, 2));
      return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
    };
    for (Eigen::Index v = n_corners; v < n; ++v) {
      if (held[v]) continue;
      Eigen::RowVector2d sum = Eigen::RowVector2d::Zero();
      double total = 0, least = std::numeric_limits<double>::infinity();
      for (int i = start[v]; i < start[v + 1]; ++i) {
        const int f = around[i];
        const Eigen::RowVector2d a = mesh.vertices.row(mesh.triangles(f, 0)),
                                 b = mesh.vertices.row(mesh.triangles(f, 1)),
                                 c = mesh.vertices.row(mesh.triangles(f, 2));
        const double area = twice_area(f);
        const Eigen::RowVector2d p = b - a, q = c - a;
        const Eigen::RowVector2d offset(q.y() * p.squaredNorm() - p.y() * q.squaredNorm(),
                                        p.x() * q.squaredNorm() - q.x() * p.squaredNorm());
        // area · circumcentre; the quotient of `offset` by 2·area is taken once, at the end.
        sum += area * a + 0.5 * offset;
        total += area;
        least = std::min(least, area);
      }
      if (!(total > 0)) continue;
      const Eigen::RowVector2d old = mesh.vertices.row(v);
      mesh.vertices.row(v) = sum / total;
      for (int i = start[v]; i < start[v + 1]; ++i)
        if (!(twice_area(around[i]) > 0.3 * least)) {
          mesh.vertices.row(v) = old;
          break;
        }
    }
    const Points points = embedded();
    mesh.triangles = intrinsic_delaunay(mesh.triangles, edge_lengths(points, mesh.triangles)).triangles;
  }
}

}  // namespace

Tessellation tessellate(const PlaneRegion& region, const TessellationOptions& options) {
  Mesher mesher(region, options);
  Tessellation result = mesher.run();
  if (result.valid) smooth(result, region.corners.rows(), mesher.pinned(), options.smoothing_rounds);
  return result;
}

}  // namespace batten::detail
