#include "batten/surfacing/hole_filling.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include <Eigen/Dense>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/box_tree.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/mesh/quality.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/mesh/welding.hpp"
#include "batten/surfacing/surface.hpp"

namespace batten {

namespace {

using Eigen::Index;
using Eigen::RowVector3d;

/// Rings of neighbours that a quadric is fitted to: two hold enough vertices, beyond three shape changes.
constexpr int kFewestRings = 2, kMostFillRings = 3;
/// A quadric that misses its vertices by more than this share of their distance, in the mean square, lies
/// over an edge; the mean normal of the triangles is then the better guess.
constexpr double kMisfit = 0.05;

/// Share of the triangles of a patch that may look away from the normals, as beside a jag of the rim.
constexpr double kMostFolded = 0.02;

/// Triangles of a patch: local vertices 0 … rim − 1 are those of the rim, the inner ones follow.
struct Patch {
  Points inner;
  Triangles triangles;
};

class HoleFiller {
 public:
  explicit HoleFiller(const TriangleMesh& mesh)
      : mesh_(mesh),
        normals_(vertex_normals(mesh.positions, mesh.triangles)),
        rings_(one_rings(mesh.triangles, mesh.n_vertices())),
        boxes_(boxes(mesh.positions, mesh.triangles)),
        tree_(boxes_) {}

  /// The patch of a rim, or nothing.
  std::optional<Patch> fill(const std::vector<int>& rim, bool& fair, const Progress& progress) const {
    fair = false;
    if (rim.size() == 3) {
      Patch patch;
      patch.inner.resize(0, 3);
      patch.triangles.resize(1, 3);
      patch.triangles << 0, 2, 1;  // the hole lies to the right of its rim
      if (is_sound(rim, patch)) {
        fair = true;
        return patch;
      }
    }
    for (const SurfaceMethod method : {SurfaceMethod::Curvature, SurfaceMethod::Harmonic}) {
      std::optional<Patch> patch = surfaced(rim, method, progress);
      if (!patch) continue;
      part_from_mesh(rim, *patch);
      if (!is_sound(rim, *patch)) continue;
      fair = method == SurfaceMethod::Curvature;
      return patch;
    }
    return std::nullopt;
  }

 private:
  static std::vector<Box> boxes(const Points& positions, const Triangles& triangles) {
    std::vector<Box> result(static_cast<size_t>(triangles.rows()));
    for (Index f = 0; f < triangles.rows(); ++f) {
      Box& box = result[static_cast<size_t>(f)];
      box = {positions.row(triangles(f, 0)), positions.row(triangles(f, 0))};
      for (int k = 1; k < 3; ++k)
        box.include({positions.row(triangles(f, k)), positions.row(triangles(f, k))});
    }
    return result;
  }

  /// The normal at a vertex of a border. That of its triangles, which lie to one side, is the one half an
  /// edge away; a quadric through the vertex does better where the surface is smooth.
  RowVector3d normal_at(int vertex) const {
    const RowVector3d mean = normals_.row(vertex);
    std::set<int> near{vertex};
    std::vector<int> last{vertex};
    for (int ring = 0; ring < kMostFillRings && (ring < kFewestRings || near.size() < 12); ++ring) {
      std::vector<int> next;
      for (const int v : last)
        for (int k = rings_.offsets[at(v)]; k < rings_.offsets[at(v) + 1]; ++k)
          if (near.insert(rings_.vertices[at(k)]).second) next.push_back(rings_.vertices[at(k)]);
      last = std::move(next);
    }
    near.erase(vertex);
    constexpr int kUnknowns = 5;
    if (near.size() < kUnknowns + 2) return mean;
    const RowVector3d x = mean.cross(std::abs(mean(0)) < 0.6 ? RowVector3d(1, 0, 0) : RowVector3d(0, 1, 0))
                              .normalized(),
                      y = mean.cross(x);
    double radius = 0;
    for (const int v : near)
      radius = std::max(radius, (mesh_.positions.row(v) - mesh_.positions.row(vertex)).norm());
    if (!(radius > 0)) return mean;
    Eigen::MatrixXd A(static_cast<Index>(near.size()), kUnknowns);
    Eigen::VectorXd b(A.rows());
    Index row = 0;
    for (const int v : near) {
      const RowVector3d d = (mesh_.positions.row(v) - mesh_.positions.row(vertex)) / radius;
      const double p = d.dot(x), q = d.dot(y), weight = 1 / std::max(d.norm(), 1e-3);
      A.row(row) << p, q, p * p, p * q, q * q;
      A.row(row) *= weight;
      b(row++) = weight * d.dot(mean);
    }
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(A);
    if (qr.rank() < kUnknowns) return mean;
    const Eigen::VectorXd fit = qr.solve(b);
    if ((A * fit - b).norm() > kMisfit * std::sqrt(static_cast<double>(b.size()))) return mean;
    const RowVector3d normal = (mean - fit(0) * x - fit(1) * y).normalized();
    return normal.dot(mean) > 0.5 ? normal : mean;
  }

  std::optional<Patch> surfaced(const std::vector<int>& rim, SurfaceMethod method,
                                const Progress& progress) const {
    const auto n = static_cast<int>(rim.size());
    CurveNetwork network;
    network.positions.resize(n, 3);
    network.normals.resize(n, 3);
    NetworkCurve curve;
    NetworkCycle cycle;
    cycle.loops.emplace_back();
    double length = 0;
    for (int k = 0; k < n; ++k) {
      network.positions.row(k) = mesh_.positions.row(rim[at(k)]);
      network.normals.row(k) = normal_at(rim[at(k)]);
      length += (mesh_.positions.row(rim[at((k + 1) % n)]) - mesh_.positions.row(rim[at(k)])).norm();
      curve.vertices.push_back(n - 1 - k);
    }
    cycle.loops[0].vertices = curve.vertices;
    cycle.loops[0].segments = {0};
    curve.vertices.push_back(curve.vertices[0]);
    network.curves.push_back(std::move(curve));
    SurfaceOptions options;
    options.method = method;
    options.edge_length = length / n;
    try {
      const SurfaceResult surface = surface_network(network, {cycle}, options, progress);
      // The membrane knows nothing of normals; of a tube's end all of it stands against them.
      const bool is_folded =
          method != SurfaceMethod::Harmonic &&
          surface.folded_triangles > kMostFolded * static_cast<double>(surface.mesh.n_triangles());
      if (surface.mesh.n_triangles() == 0 || is_folded) return std::nullopt;
      Patch patch;
      patch.inner = surface.mesh.positions.bottomRows(surface.mesh.n_vertices() - n);
      patch.triangles = surface.mesh.triangles;
      return patch;
    } catch (const InvalidInput&) {
      return std::nullopt;
    } catch (const SolverFailure&) {
      return std::nullopt;
    }
  }

  bool has_edge(int a, int b) const {
    const auto begin = rings_.vertices.begin() + rings_.offsets[at(a)],
               end = rings_.vertices.begin() + rings_.offsets[at(a) + 1];
    return std::find(begin, end, b) != end;
  }

  /// An inner edge of the patch between two vertices that the mesh joins already gets a vertex in its middle.
  void part_from_mesh(const std::vector<int>& rim, Patch& patch) const {
    const auto n = static_cast<int>(rim.size());
    for (bool again = true; again;) {
      again = false;
      const MeshEdges edges = mesh_edges(patch.triangles, n + patch.inner.rows());
      for (Index e = 0; e < edges.n_edges() && !again; ++e) {
        const int a = edges.vertices(e, 0), b = edges.vertices(e, 1);
        if (edges.n_triangles(e) != 2 || b >= n || !has_edge(rim[at(a)], rim[at(b)])) continue;
        const auto middle = static_cast<int>(n + patch.inner.rows());
        patch.inner.conservativeResize(patch.inner.rows() + 1, 3);
        patch.inner.row(patch.inner.rows() - 1) =
            (mesh_.positions.row(rim[at(a)]) + mesh_.positions.row(rim[at(b)])) / 2;
        for (int s = 0; s < 2; ++s) {
          const int side = edges.sides[at(edges.offsets[static_cast<size_t>(e)] + s)], f = side / 3,
                    k = side % 3;
          const Index added = patch.triangles.rows();
          patch.triangles.conservativeResize(added + 1, 3);
          patch.triangles.row(added) << middle, patch.triangles(f, (k + 1) % 3),
              patch.triangles(f, (k + 2) % 3);
          patch.triangles(f, (k + 1) % 3) = middle;
        }
        again = true;
      }
    }
  }

  /// No triangle of the patch is flat, crosses another one or lies on its surroundings.
  bool is_sound(const std::vector<int>& rim, const Patch& patch) const {
    const auto n = static_cast<int>(rim.size());
    const Index n_inner = patch.inner.rows();
    // The patch, then the triangles near it, with their corners.
    std::map<int, int> local;
    for (int k = 0; k < n; ++k) local[rim[at(k)]] = k;
    std::vector<RowVector3d> points;
    for (const int v : rim) points.emplace_back(mesh_.positions.row(v));
    for (Index v = 0; v < n_inner; ++v) points.emplace_back(patch.inner.row(v));
    Box box{points[0], points[0]};
    for (const RowVector3d& p : points) box.include({p, p});
    std::vector<int> near;
    tree_.query(box, [&](int f) {
      near.push_back(f);
      return true;
    });
    std::sort(near.begin(), near.end());
    Triangles triangles(patch.triangles.rows() + static_cast<Index>(near.size()), 3);
    triangles.topRows(patch.triangles.rows()) = patch.triangles;
    for (size_t i = 0; i < near.size(); ++i)
      for (int k = 0; k < 3; ++k) {
        const int v = mesh_.triangles(near[i], k);
        const auto [place, fresh] = local.try_emplace(v, static_cast<int>(points.size()));
        if (fresh) points.emplace_back(mesh_.positions.row(v));
        triangles(patch.triangles.rows() + static_cast<Index>(i), k) = place->second;
      }
    Points positions(static_cast<Index>(points.size()), 3);
    for (size_t v = 0; v < points.size(); ++v) positions.row(static_cast<Index>(v)) = points[v];
    if (!degenerate_triangles(positions, patch.triangles).empty()) return false;
    for (const auto& [f, g] : self_intersections(positions, triangles, static_cast<size_t>(triangles.rows())))
      if (f < patch.triangles.rows()) return false;
    return true;
  }

  const TriangleMesh& mesh_;
  Points normals_;
  OneRings rings_;
  std::vector<Box> boxes_;
  BoxTree tree_;
};

/// A rim that passes a place twice, by two vertices that were separated there, bounds several holes. One of
/// the vertices stands for both.
struct SimpleRims {
  std::vector<std::vector<int>> rims;
  std::vector<std::pair<int, int>> joined;  ///< the second vertex becomes the first
};

SimpleRims simple_rims(const std::vector<int>& rim, const std::vector<int>& place) {
  SimpleRims result;
  std::vector<int> walk;
  std::map<int, size_t> at_place;  // of the walk
  for (const int v : rim) {
    const auto found = at_place.find(place[at(v)]);
    if (found == at_place.end()) {
      at_place[place[at(v)]] = walk.size();
      walk.push_back(v);
      continue;
    }
    const size_t first = found->second;
    if (walk.size() - first >= 3)
      result.rims.emplace_back(walk.begin() + static_cast<std::ptrdiff_t>(first), walk.end());
    result.joined.emplace_back(walk[first], v);
    for (size_t k = first + 1; k < walk.size(); ++k) at_place.erase(place[at(walk[k])]);
    walk.resize(first + 1);
  }
  if (walk.size() >= 3) result.rims.push_back(std::move(walk));
  return result;
}

/// Vertices and triangles that patches of holes add to a mesh.
class PatchCollector {
 public:
  /// @param mesh outlives this.
  explicit PatchCollector(const TriangleMesh& mesh)
      : mesh_(mesh), at_patch_(static_cast<size_t>(mesh.n_vertices()), 0) {}

  /// @param hole outlives this; its rim is that of the patch.
  void add(const MeshHole& hole, const Patch& patch) {
    const auto n = static_cast<int>(hole.rim.size());
    const auto first = static_cast<int>(mesh_.n_vertices()) + static_cast<int>(positions_.size());
    for (Index v = 0; v < patch.inner.rows(); ++v) {
      positions_.emplace_back(patch.inner.row(v));
      hole_of_.push_back(&hole);
    }
    for (const int v : hole.rim) at_patch_[at(v)] = 1;
    for (Index f = 0; f < patch.triangles.rows(); ++f) {
      const auto vertex = [&](int k) {
        const int v = patch.triangles(f, k);
        return v < n ? hole.rim[at(v)] : first + v - n;
      };
      triangles_.push_back({vertex(0), vertex(1), vertex(2)});
    }
  }

  bool touches(int vertex) const { return at_patch_[at(vertex)] != 0; }

  /// @param vertex_of per vertex of the mesh the one that takes its place in triangles.
  TriangleMesh joined(const std::vector<int>& vertex_of) const {
    TriangleMesh filled = mesh_;
    const Index n_before = mesh_.n_vertices(), m_before = mesh_.n_triangles();
    filled.positions.conservativeResize(n_before + static_cast<Index>(positions_.size()), 3);
    for (size_t v = 0; v < positions_.size(); ++v)
      filled.positions.row(n_before + static_cast<Index>(v)) = positions_[v];
    filled.triangles = mesh_.triangles.unaryExpr([&](int v) { return vertex_of[at(v)]; });
    filled.triangles.conservativeResize(m_before + static_cast<Index>(triangles_.size()), 3);
    for (size_t f = 0; f < triangles_.size(); ++f)
      filled.triangles.row(m_before + static_cast<Index>(f)) << triangles_[f][0], triangles_[f][1],
          triangles_[f][2];
    for (auto& [name, values] : filled.vertex_values) spread(values);
    if (filled.normals.rows() > 0) {
      const Points fresh = vertex_normals(filled.positions, filled.triangles);
      filled.normals.conservativeResize(filled.n_vertices(), 3);
      for (Index v = 0; v < filled.n_vertices(); ++v)
        if (v >= n_before || touches(static_cast<int>(v))) filled.normals.row(v) = fresh.row(v);
    }
    return filled;
  }

 private:
  /// Gives values per vertex of the mesh those of the new vertices: means over their rims.
  void spread(Eigen::VectorXd& values) const {
    const Index n_before = mesh_.n_vertices();
    values.conservativeResize(n_before + static_cast<Index>(positions_.size()));
    for (size_t v = 0; v < positions_.size(); ++v) {
      double sum = 0, weights = 0;
      for (const int r : hole_of_[v]->rim) {
        const double weight = 1 / (positions_[v] - mesh_.positions.row(r)).squaredNorm();
        sum += weight * values(r);
        weights += weight;
      }
      values(n_before + static_cast<Index>(v)) = sum / weights;
    }
  }

  const TriangleMesh& mesh_;
  std::vector<char> at_patch_;  ///< per vertex of the mesh
  std::vector<RowVector3d> positions_;
  std::vector<std::array<int, 3>> triangles_;
  std::vector<const MeshHole*> hole_of_;  ///< per added vertex
};

/// Pairs of vertices of rims that lie at one place.
using JoinedVertices = std::vector<std::pair<int, int>>;

/// The holes of a mesh, none filled. A rim that passes a place twice is two.
std::vector<MeshHole> holes_of(const TriangleMesh& mesh, JoinedVertices& joined) {
  std::vector<MeshHole> holes;
  const MeshEdges edges = mesh_edges(mesh.triangles, mesh.n_vertices());
  const std::vector<int> place = places_of_vertices(mesh.positions);
  for (const std::vector<int>& rim : boundary_loops(mesh.triangles, edges)) {
    SimpleRims simple = simple_rims(rim, place);
    joined.insert(joined.end(), simple.joined.begin(), simple.joined.end());
    for (std::vector<int>& part : simple.rims) holes.push_back({std::move(part)});
  }
  return holes;
}

/// The mesh with its patches. Two vertices at one place become one as soon as a hole beside them is filled;
/// rims of the holes are renumbered.
TriangleMesh with_patches(const PatchCollector& patches, const JoinedVertices& joined, Index n_vertices,
                          std::vector<MeshHole>& holes) {
  std::vector<int> vertex_of(static_cast<size_t>(n_vertices));
  std::iota(vertex_of.begin(), vertex_of.end(), 0);
  std::vector<int> replaced;
  for (const auto& [kept, other] : joined)
    if (patches.touches(kept)) {
      vertex_of[at(other)] = kept;
      replaced.push_back(other);
    }
  TriangleMesh filled = patches.joined(vertex_of);
  if (replaced.empty()) return filled;
  std::vector<char> gone(static_cast<size_t>(filled.n_vertices()), 0);
  for (const int v : replaced) gone[at(v)] = 1;
  std::vector<int> number(gone.size(), 0);
  for (size_t v = 1; v < gone.size(); ++v) number[v] = number[v - 1] + (gone[v - 1] == 0 ? 1 : 0);
  for (MeshHole& hole : holes)
    for (int& v : hole.rim) v = number[at(vertex_of[at(v)])];
  return without_vertices(filled, gone);
}

}  // namespace

int FilledMesh::n_filled() const {
  return static_cast<int>(
      std::count_if(holes.begin(), holes.end(), [](const MeshHole& hole) { return hole.filled; }));
}

std::optional<std::string> HoleFillingOptions::problem(Index n_vertices) const {
  if (most_edges < 3) return concat("most_edges must be at least 3, got ", most_edges);
  if (!left_open.empty() && left_open.size() != static_cast<size_t>(n_vertices))
    return concat("left_open must have an entry per vertex or none, got ", left_open.size(), " entries for ",
                  n_vertices, " vertices");
  return std::nullopt;
}

FilledMesh filled_mesh(const TriangleMesh& mesh, const HoleFillingOptions& options,
                       const Progress& progress) {
  if (const auto problem = options.problem(mesh.n_vertices())) throw InvalidInput(*problem);
  FilledMesh result;
  JoinedVertices joined;
  result.holes = holes_of(mesh, joined);
  const auto wanted = [&](const MeshHole& hole) {
    return hole.rim.size() <= at(options.most_edges) &&
           (options.left_open.empty() || std::none_of(hole.rim.begin(), hole.rim.end(),
                                                      [&](int v) { return options.left_open[at(v)] != 0; }));
  };
  if (std::none_of(result.holes.begin(), result.holes.end(), wanted)) {
    result.mesh = mesh;
    return result;
  }
  const HoleFiller filler(mesh);
  PatchCollector patches(mesh);
  for (size_t h = 0; h < result.holes.size(); ++h) {
    MeshHole& hole = result.holes[h];
    const double from = static_cast<double>(h) / static_cast<double>(result.holes.size()),
                 to = static_cast<double>(h + 1) / static_cast<double>(result.holes.size());
    progress.report("fill holes", from);
    if (!wanted(hole)) continue;
    const std::optional<Patch> patch =
        filler.fill(hole.rim, hole.fair, progress.part("fill holes", from, to));
    if (!patch) continue;
    hole.filled = true;
    patches.add(hole, *patch);
  }
  result.mesh = with_patches(patches, joined, mesh.n_vertices(), result.holes);
  return result;
}

}  // namespace batten
