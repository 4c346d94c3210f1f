#include "batten/modelling/model_network.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/disjoint_sets.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/quality.hpp"

namespace batten {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

std::pair<int, int> ordered(int a, int b) {
  return std::minmax({a, b});
}

/// The corners of quads around each vertex, in parts between which there are only sharp edges.
class Sides {
 public:
  explicit Sides(const ControlCage& cage)
      : mesh_(cage.mesh), parts_(static_cast<int>(cage.mesh.corners.size())) {
    std::set<std::pair<int, int>> sharp;
    for (const SharpEdge& edge : cage.sharp_edges) sharp.insert(ordered(edge.from, edge.to));
    std::map<std::pair<int, int>, size_t> met;  // by edge, the corner from which the first quad walks it
    for (size_t c = 0; c < mesh_.corners.size(); ++c) {
      const size_t next = c / 4 * 4 + (c + 1) % 4;
      const auto [found, is_new] = met.insert({ordered(mesh_.corners[c], mesh_.corners[next]), c});
      if (is_new || sharp.count(found->first)) continue;
      const size_t other = found->second, other_next = other / 4 * 4 + (other + 1) % 4;
      join(c, mesh_.corners[other] == mesh_.corners[c] ? other : other_next);
      join(next, mesh_.corners[other] == mesh_.corners[c] ? other_next : other);
    }
  }

  /// A number for the part in which a corner lies: that of its first corner.
  int part(size_t corner) { return parts_.root(static_cast<int>(corner)); }

 private:
  void join(size_t a, size_t b) { parts_.unite(static_cast<int>(a), static_cast<int>(b)); }

  const PolygonMesh& mesh_;
  DisjointSets parts_;
};

/// Unit normals of parts around vertices: means of the corner normals, weighted by their angles, so that
/// quads of unequal size do not pull. Where they cancel, as at the corner of a foot where the sheet turns
/// back on itself, that of the widest corner.
/// @param part of each corner. @return n × 3.
Points corner_normals(const PolygonMesh& mesh, const std::vector<int>& part, int n) {
  Points normals = Points::Zero(n, 3), widest = normals;
  Eigen::VectorXd angles = Eigen::VectorXd::Zero(n), sums = angles;
  for (size_t corner = 0; corner < mesh.corners.size(); ++corner) {
    const int* c = &mesh.corners[corner / 4 * 4];
    const size_t k = corner % 4;
    const int v = part[corner];
    const Vector3d here = mesh.positions.row(c[k]);
    const Vector3d next = mesh.positions.row(c[(k + 1) % 4]).transpose() - here;
    const Vector3d last = mesh.positions.row(c[(k + 3) % 4]).transpose() - here;
    const Vector3d cross = next.cross(last);
    const double angle = std::atan2(cross.norm(), next.dot(last));
    normals.row(v) += angle * cross.stableNormalized().transpose();
    sums(v) += angle;
    if (cross.norm() > 0 && angle > angles(v)) {
      angles(v) = angle;
      widest.row(v) = cross.stableNormalized().transpose();
    }
  }
  for (Index v = 0; v < normals.rows(); ++v)
    if (const double length = normals.row(v).norm(); length > 0.05 * sums(v))
      normals.row(v) /= length;
    else
      normals.row(v) = widest.row(v);
  return normals;
}

/// Welding may bring two inner edges of different patches, or an inner edge and a curve, to the same ends:
/// such an edge would have more than two triangles. Inner ones get a vertex in their middle, all but the
/// first.
void split_doubled_edges(TriangleMesh& mesh, std::vector<int>& patch) {
  std::map<std::pair<int, int>, std::vector<Index>> around;
  for (Index t = 0; t < mesh.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k)
      around[ordered(mesh.triangles(t, k), mesh.triangles(t, (k + 1) % 3))].push_back(t);
  std::vector<std::array<int, 3>> to_split;  // ends and patch
  for (const auto& [edge, triangles] : around) {
    if (triangles.size() <= 2) continue;
    std::map<int, int> count;  // by patch
    for (const Index t : triangles) ++count[patch[static_cast<size_t>(t)]];
    bool taken = std::any_of(count.begin(), count.end(), [](const auto& entry) { return entry.second < 2; });
    for (const auto& [p, n] : count) {
      if (n < 2) continue;
      if (taken) to_split.push_back({edge.first, edge.second, p});
      taken = true;
    }
  }
  for (const auto& [a, b, p] : to_split) {
    const Index middle = mesh.positions.rows(), count = mesh.triangles.rows();
    mesh.positions.conservativeResize(middle + 1, 3);
    mesh.normals.conservativeResize(middle + 1, 3);
    mesh.positions.row(middle) = 0.5 * (mesh.positions.row(a) + mesh.positions.row(b));
    mesh.normals.row(middle) = (mesh.normals.row(a) + mesh.normals.row(b)).stableNormalized();
    for (Index t = 0; t < count; ++t) {
      if (patch[static_cast<size_t>(t)] != p) continue;
      for (int k = 0; k < 3; ++k) {
        if (ordered(mesh.triangles(t, k), mesh.triangles(t, (k + 1) % 3)) != std::pair(a, b)) continue;
        const Index more = mesh.triangles.rows();
        mesh.triangles.conservativeResize(more + 1, 3);
        mesh.triangles.row(more) = mesh.triangles.row(t);
        mesh.triangles(t, (k + 1) % 3) = static_cast<int>(middle);
        mesh.triangles(more, k) = static_cast<int>(middle);
        patch.push_back(p);
        break;
      }
    }
  }
}

/// Makes the network of a model: its vertices are parts of the corners around those of the refined surface.
class ModelNetworkBuilder {
 public:
  /// Both must outlive this.
  ModelNetworkBuilder(const PolylineMesh& mesh, const DiffusionSurface& surface)
      : mesh_(mesh),
        surface_(surface),
        refined_(surface.refined.mesh),
        on_edge_(static_cast<size_t>(refined_.positions.rows()), 0),
        part_(refined_.corners.size()),
        sharpness_(on_edge_.size(), 0) {
    for (const std::vector<int>& chain : surface.vertices_of_edge)
      for (const int v : chain) on_edge_[at(v)] = 1;
    number_parts();
  }

  ModelNetwork network() {
    add_curves();
    place_vertices();
    add_cycles();
    return std::move(result_);
  }

 private:
  /// Parts are numbered by their first corners. A face has one at each of its vertices: its quads there lie
  /// in one fan without sharp edges.
  void number_parts() {
    Sides sides(surface_.refined);
    std::vector<int> number(part_.size(), -1);
    for (size_t c = 0; c < part_.size(); ++c) {
      int& own = number[at(sides.part(c))];
      if (own < 0) own = n_parts_++;
      part_[c] = own;
      const int v = refined_.corners[c], next = refined_.corners[c / 4 * 4 + (c + 1) % 4];
      if (!on_edge_[at(v)]) continue;
      part_of_face_.insert({{surface_.face_of_quad[c / 4], v}, own});
      if (on_edge_[at(next)]) walks_.insert({surface_.face_of_quad[c / 4], v, next});
    }
    vertex_of_part_.assign(at(n_parts_), -1);
  }

  /// The vertex of the network for that of the surface, as a face sees it.
  int vertex(int face, int v) {
    const int own = part_of_face_.at({face, v});
    int& found = vertex_of_part_[at(own)];
    if (found < 0) {
      found = static_cast<int>(part_of_vertex_.size());
      part_of_vertex_.push_back(own);
      result_.place.push_back(v);
    }
    return found;
  }

  /// A curve for each edge, two where its faces have different vertices.
  void add_curves() {
    std::vector<NetworkCurve>& curves = result_.network.curves;
    for (size_t e = 0; e < mesh_.edges().size(); ++e) {
      const SketchEdge& edge = mesh_.edges()[e];
      if (!edge.alive) continue;
      for (const int v : surface_.vertices_of_edge[e])
        sharpness_[at(v)] = std::max(sharpness_[at(v)], edge.sharpness);
      for (size_t side = 0; side < 2; ++side) {
        if (edge.faces[side] < 0) continue;
        NetworkCurve curve;
        curve.name = concat("c", edge.curve);
        curve.boundary = edge.faces[1 - side] < 0;
        for (const int v : surface_.vertices_of_edge[e])
          curve.vertices.push_back(vertex(edge.faces[side], v));
        if (side == 1 && edge.faces[0] >= 0 && curve.vertices == curves.back().vertices) continue;
        tag_ends(curve);
        curves.push_back(std::move(curve));
      }
    }
  }

  /// Ends of edges are nodes even where two edges meet smoothly.
  void tag_ends(const NetworkCurve& curve) {
    is_node_.resize(part_of_vertex_.size(), 0);
    for (const int end : {curve.vertices.front(), curve.vertices.back()}) {
      if (!is_node_[at(end)]) result_.network.tagged_nodes.push_back(end);
      is_node_[at(end)] = 1;
    }
  }

  void place_vertices() {
    CurveNetwork& network = result_.network;
    const Points of_part = corner_normals(refined_, part_, n_parts_);
    const Points of_both =
        corner_normals(refined_, refined_.corners, static_cast<int>(refined_.positions.rows()));
    network.positions.resize(static_cast<Index>(part_of_vertex_.size()), 3);
    network.normals.resize(network.positions.rows(), 3);
    for (size_t k = 0; k < part_of_vertex_.size(); ++k) {
      const int v = result_.place[k];
      const double sharp = std::min(sharpness_[at(v)], 1.0);
      const Eigen::RowVector3d own = of_part.row(part_of_vertex_[k]);
      const Eigen::RowVector3d mixed = sharp * own + (1 - sharp) * of_both.row(v);
      network.positions.row(static_cast<Index>(k)) = refined_.positions.row(v);
      network.normals.row(static_cast<Index>(k)) = mixed.norm() > 0.05 ? mixed.normalized() : own;
    }
  }

  void add_cycles() {
    for (size_t f = 0; f < mesh_.faces().size(); ++f) {
      if (!mesh_.faces()[f].alive) continue;
      const int face = static_cast<int>(f);
      std::vector<int> loop;
      for (const int side : mesh_.faces()[f].sides) {
        std::vector<int> chain = surface_.vertices_of_edge[at(edge_of(side))];
        if (side & 1) std::reverse(chain.begin(), chain.end());
        loop.insert(loop.end(), chain.begin(), chain.end() - 1);
      }
      // Closed components that were drawn inside out have been turned.
      if (!walks_.count({face, loop[0], loop[1]})) std::reverse(loop.begin(), loop.end());
      for (int& v : loop) v = vertex(face, v);
      NetworkCycle cycle;
      cycle.name = concat("the face f", face);
      cycle.loops.emplace_back();
      cycle.loops.back().vertices = std::move(loop);
      result_.cycles.push_back(std::move(cycle));
      result_.face_of_cycle.push_back(face);
    }
  }

  const PolylineMesh& mesh_;
  const DiffusionSurface& surface_;
  const PolygonMesh& refined_;
  std::vector<char> on_edge_;  ///< per vertex of the surface: on an edge of the model
  std::vector<int> part_;      ///< per corner of the surface
  int n_parts_ = 0;
  std::map<std::pair<int, int>, int> part_of_face_;  ///< by face and vertex
  std::set<std::array<int, 3>> walks_;               ///< faces, and edges in the sense of their quads
  std::vector<int> vertex_of_part_, part_of_vertex_;
  std::vector<double> sharpness_;  ///< per vertex of the surface, of its sharpest edge
  std::vector<char> is_node_;      ///< per vertex of the network
  ModelNetwork result_;
};

}  // namespace

ModelNetwork network_of_model(const PolylineMesh& mesh, const DiffusionSurface& surface) {
  return ModelNetworkBuilder(mesh, surface).network();
}

FilledModel fill_model(const PolylineMesh& mesh, const DiffusionSurface& surface,
                       const SurfaceOptions& options, const Progress& progress) {
  const ModelNetwork model = network_of_model(mesh, surface);
  SurfaceResult filled = surface_network(model.network, model.cycles, options, progress);
  // Between far sides of a face whose normals lean outwards, the propagated normals may swing over to the
  // inside. Harmonic ones keep within those of the border.
  if (SurfaceOptions harmonic = options; filled.folded_triangles > 0 && options.base_order > 1) {
    harmonic.base_order = 1;
    SurfaceResult other = surface_network(model.network, model.cycles, harmonic, progress);
    if (other.folded_triangles < filled.folded_triangles) filled = std::move(other);
  }
  FilledModel result;
  result.times = std::move(filled.times);
  result.warnings = std::move(filled.warnings);
  result.turned = folded_triangles(filled.mesh.positions, filled.mesh.triangles, filled.mesh.normals);

  const Index n = filled.mesh.positions.rows();
  std::vector<int> number(static_cast<size_t>(n), -1);
  std::vector<int> at_place(static_cast<size_t>(surface.refined.mesh.positions.rows()), -1);
  TriangleMesh& welded = result.mesh;
  welded.positions.resize(n, 3);
  welded.normals = Points::Zero(n, 3);
  int count = 0;
  for (Index v = 0; v < n; ++v) {
    int* own = &number[static_cast<size_t>(v)];
    if (static_cast<size_t>(v) < model.place.size()) {
      int& there = at_place[at(model.place[static_cast<size_t>(v)])];
      if (there < 0) there = count++;
      *own = there;
    } else {
      *own = count++;
    }
    welded.positions.row(*own) = filled.mesh.positions.row(v);
    welded.normals.row(*own) += filled.mesh.normals.row(v);
  }
  welded.positions.conservativeResize(count, 3);
  welded.normals.conservativeResize(count, 3);
  for (Index v = 0; v < count; ++v) welded.normals.row(v).stableNormalize();
  welded.triangles = filled.mesh.triangles.unaryExpr([&](int v) { return number[at(v)]; });
  std::vector<int> patch = std::move(filled.patch_of_triangle);
  split_doubled_edges(welded, patch);
  for (const int p : patch) result.face_of_triangle.push_back(model.face_of_cycle[at(p)]);
  return result;
}

}  // namespace batten
