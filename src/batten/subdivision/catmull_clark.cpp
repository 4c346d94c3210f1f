// Catmull–Clark subdivision with semi-sharp creases by OpenSubdiv: [catmull1978], [derose1998]; limit
// masks [halstead1993]. The only source that includes OpenSubdiv.
#include <algorithm>
#include <cmath>
#include <memory>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <opensubdiv/far/patchTableFactory.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/subdivision/catmull_clark_detail.hpp"

namespace batten::detail {

namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

/// Rows of three numbers as OpenSubdiv wants to see them.
class Rows {
 public:
  class Row {
   public:
    explicit Row(double* values) : values_(values) {}
    void Clear() { values_[0] = values_[1] = values_[2] = 0; }
    void AddWithWeight(const Row& other, double weight) {
      values_[0] += weight * other.values_[0];
      values_[1] += weight * other.values_[1];
      values_[2] += weight * other.values_[2];
    }

   private:
    double* values_;
  };
  explicit Rows(double* values) : values_(values) {}
  Row operator[](int row) const { return Row(values_ + 3 * static_cast<std::ptrdiff_t>(row)); }

 private:
  double* values_;
};

std::unique_ptr<Far::TopologyRefiner> refiner_of(const ControlCage& cage, const CageTopology& topology,
                                                 bool smooth_corners) {
  const std::vector<double> of_edges = edge_sharpness(cage, topology), of_vertices = vertex_sharpness(cage);
  std::vector<int> crease_ends, corner_vertices, n_corners;
  std::vector<float> crease_weights, corner_weights;
  const auto weight = [](double sharpness) {
    return static_cast<float>(std::min<double>(sharpness, Sdc::Crease::SHARPNESS_INFINITE));
  };
  for (size_t e = 0; e < of_edges.size(); ++e)
    if (of_edges[e] > 0) {
      crease_ends.insert(crease_ends.end(), topology.edges[e].begin(), topology.edges[e].end());
      crease_weights.push_back(weight(of_edges[e]));
    }
  for (size_t v = 0; v < of_vertices.size(); ++v)
    if (of_vertices[v] > 0) {
      corner_vertices.push_back(static_cast<int>(v));
      corner_weights.push_back(weight(of_vertices[v]));
    }
  const PolygonMesh& mesh = cage.mesh;
  for (size_t f = 0; f + 1 < mesh.offsets.size(); ++f)
    n_corners.push_back(mesh.offsets[f + 1] - mesh.offsets[f]);
  Far::TopologyDescriptor descriptor;
  descriptor.numVertices = static_cast<int>(mesh.positions.rows());
  descriptor.numFaces = static_cast<int>(mesh.n_faces());
  descriptor.numVertsPerFace = n_corners.data();
  descriptor.vertIndicesPerFace = mesh.corners.data();
  descriptor.numCreases = static_cast<int>(crease_weights.size());
  descriptor.creaseVertexIndexPairs = crease_ends.data();
  descriptor.creaseWeights = crease_weights.data();
  descriptor.numCorners = static_cast<int>(corner_weights.size());
  descriptor.cornerVertexIndices = corner_vertices.data();
  descriptor.cornerWeights = corner_weights.data();
  Sdc::Options options;
  options.SetVtxBoundaryInterpolation(smooth_corners ? Sdc::Options::VTX_BOUNDARY_EDGE_ONLY
                                                     : Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER);
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  std::unique_ptr<Far::TopologyRefiner> refiner(
      Factory::Create(descriptor, Factory::Options(Sdc::SCHEME_CATMARK, options)));
  if (!refiner)
    throw InvalidInput("OpenSubdiv refuses the cage; look for faces with more than 65535 corners");
  return refiner;
}

/// Replaces what evaluate_limit() gives at darts that stay sharp.
void evaluate_darts(const Far::TopologyLevel& level, const Points& last, Points& positions, Points& normals) {
  for (int v = 0; v < level.GetNumVertices(); ++v) {
    if (level.GetVertexRule(v) != Sdc::Crease::RULE_DART) continue;
    const Far::ConstIndexArray edges = level.GetVertexEdges(v), faces = level.GetVertexFaces(v);
    const int n = edges.size();
    int first = 0;
    while (first + 1 < n && !(level.GetEdgeSharpness(edges[first]) > 0)) ++first;
    Points ring(2 * n + 1, 3);
    ring.row(0) = last.row(v);
    for (int k = 0; k < n; ++k) {
      const Far::ConstIndexArray ends = level.GetEdgeVertices(edges[(first + k) % n]);
      ring.row(1 + k) = last.row(ends[ends[0] == v ? 1 : 0]);
      const Far::ConstIndexArray corners = level.GetFaceVertices(faces[(first + k) % n]);
      int here = 0;
      while (corners[here] != v) ++here;
      ring.row(1 + n + k) = last.row(corners[(here + 2) % 4]);
    }
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> limit = dart_masks(n) * ring;
    positions.row(v) = limit.row(0);
    Eigen::RowVector3d normal = limit.row(1).cross(limit.row(2));
    if (normal.dot(normals.row(v)) < 0) normal = -normal;  // eigenvectors have no sign
    if (normal.norm() > 1e-12 * limit.row(1).norm() * limit.row(2).norm())
      normals.row(v) = normal.normalized();
  }
}

/// Limit points and normals at the vertices of the last level.
void evaluate_limit(const Far::TopologyRefiner& refiner, Points& last, Points& positions, Points& normals) {
  const int n = refiner.GetLevel(refiner.GetMaxLevel()).GetNumVertices();
  Points first(n, 3), second(n, 3);
  positions.resize(n, 3);
  const Rows source(last.data());
  Rows to(positions.data()), to_first(first.data()), to_second(second.data());
  Far::PrimvarRefinerReal<double>(refiner).Limit(source, to, to_first, to_second);
  normals.resize(n, 3);
  for (int v = 0; v < n; ++v) {
    const Eigen::RowVector3d normal = first.row(v).cross(second.row(v));
    const double length = normal.norm(), scale = first.row(v).norm() * second.row(v).norm();
    normals.row(v) = length > 1e-12 * scale && scale > 0 ? Eigen::RowVector3d(normal / length)
                                                         : Eigen::RowVector3d::Zero();
  }
}

/// Replaces the normals of vertices that have no one tangent plane, and those that came out as nothing.
void average_normals(const Far::TopologyLevel& level, const Points& positions, Points& normals) {
  std::vector<char> wanted(static_cast<size_t>(normals.rows()), 0);
  for (int v = 0; v < level.GetNumVertices(); ++v) {
    const Sdc::Crease::Rule rule = level.GetVertexRule(v);
    wanted[at(v)] =
        normals.row(v).isZero(0) ||
        (!level.IsVertexBoundary(v) &&
         (rule == Sdc::Crease::RULE_CREASE || rule == Sdc::Crease::RULE_CORNER)) ||
        (level.IsVertexBoundary(v) && rule == Sdc::Crease::RULE_CORNER && level.GetVertexFaces(v).size() > 1);
    if (wanted[at(v)]) normals.row(v).setZero();
  }
  for (int f = 0; f < level.GetNumFaces(); ++f) {
    const Far::ConstIndexArray corners = level.GetFaceVertices(f);
    Eigen::RowVector3d area = Eigen::RowVector3d::Zero();
    const Eigen::RowVector3d origin = positions.row(corners[0]);
    for (int k = 1; k + 1 < corners.size(); ++k)
      area += (positions.row(corners[k]) - origin).cross(positions.row(corners[k + 1]) - origin);
    for (int k = 0; k < corners.size(); ++k)
      if (wanted[at(corners[k])]) normals.row(corners[k]) += area;
  }
  for (Eigen::Index v = 0; v < normals.rows(); ++v)
    if (wanted[static_cast<size_t>(v)]) {
      const double length = normals.row(v).norm();
      if (length > 0)
        normals.row(v) /= length;
      else
        normals.row(v) << 0, 0, 1;  // faces without area: any direction will do
    }
}

/// Follows the vertices and edges of the cage down to level `levels`.
void trace_edges(const Far::TopologyRefiner& refiner, const CageTopology& topology, int levels,
                 SubdividedSurface& surface) {
  const Far::TopologyLevel& base = refiner.GetLevel(0);
  const Eigen::Index n_edges = static_cast<Eigen::Index>(topology.edges.size());
  const Eigen::Index n_points = (Eigen::Index(1) << levels) + 1;
  surface.cage_edges = topology.edges;
  surface.edge_chains.resize(n_edges, n_points);
  std::vector<int> chain, finer;
  std::vector<Far::Index> links, finer_links;  // the edges between the vertices of the chain
  for (Eigen::Index e = 0; e < n_edges; ++e) {
    const std::array<int, 2>& ends = topology.edges[static_cast<size_t>(e)];
    chain.assign({ends[0], ends[1]});
    links.assign({base.FindEdge(ends[0], ends[1])});
    for (int k = 0; k < levels; ++k) {
      const Far::TopologyLevel& level = refiner.GetLevel(k);
      finer.clear();
      finer_links.clear();
      for (size_t i = 0; i < links.size(); ++i) {
        finer.push_back(level.GetVertexChildVertex(chain[i]));
        finer.push_back(level.GetEdgeChildVertex(links[i]));
        if (k + 1 == levels) continue;  // the last level may lack its edges
        const Far::ConstIndexArray children = level.GetEdgeChildEdges(links[i]);
        const bool forward = level.GetEdgeVertices(links[i])[0] == chain[i];
        finer_links.push_back(children[forward ? 0 : 1]);
        finer_links.push_back(children[forward ? 1 : 0]);
      }
      finer.push_back(level.GetVertexChildVertex(chain.back()));
      chain.swap(finer);
      links.swap(finer_links);
    }
    for (Eigen::Index i = 0; i < n_points; ++i) surface.edge_chains(e, i) = chain[static_cast<size_t>(i)];
  }
}

void copy_faces(const Far::TopologyRefiner& refiner, int levels, SubdividedSurface& surface) {
  const Far::TopologyLevel& last = refiner.GetLevel(levels);
  const int n_faces = last.GetNumFaces();
  std::vector<int>& corners = surface.cage.mesh.corners;
  std::vector<int>& offsets = surface.cage.mesh.offsets;
  corners.clear();
  corners.reserve(static_cast<size_t>(last.GetNumFaceVertices()));
  offsets.assign(1, 0);
  offsets.reserve(at(n_faces) + 1);
  for (int f = 0; f < n_faces; ++f) {
    const Far::ConstIndexArray of_face = last.GetFaceVertices(f);
    corners.insert(corners.end(), of_face.begin(), of_face.end());
    offsets.push_back(static_cast<int>(corners.size()));
  }
  std::vector<int> parents, finer;
  for (int f = 0; f < refiner.GetLevel(0).GetNumFaces(); ++f) parents.push_back(f);
  for (int k = 1; k <= levels; ++k) {
    const Far::TopologyLevel& level = refiner.GetLevel(k);
    finer.resize(at(level.GetNumFaces()));
    for (int f = 0; f < level.GetNumFaces(); ++f) finer[at(f)] = parents[at(level.GetFaceParentFace(f))];
    parents.swap(finer);
  }
  surface.face_parent = std::move(parents);
}

}  // namespace

Eigen::MatrixXd dart_masks(int n) {
  const auto edge = [n](int k) { return 1 + (k + n) % n; };
  const auto diagonal = [n](int k) { return 1 + n + (k + n) % n; };
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(2 * n + 1, 2 * n + 1);
  for (int k = 0; k < n; ++k) {
    // Face k lies between the edges k and k + 1.
    for (const int i : {0, edge(k), edge(k + 1), diagonal(k)}) S(diagonal(k), i) += 0.25;
    S(edge(k), 0) += k == 0 ? 0.5 : 3.0 / 8;
    S(edge(k), edge(k)) += k == 0 ? 0.5 : 3.0 / 8;
    if (k == 0) continue;
    for (const int i : {edge(k - 1), edge(k + 1), diagonal(k - 1), diagonal(k)}) S(edge(k), i) += 1.0 / 16;
  }
  S(0, 0) = 1 - 7.0 / (4 * n);
  for (int k = 0; k < n; ++k) {
    S(0, edge(k)) = 3.0 / (2.0 * n * n);
    S(0, diagonal(k)) = 1.0 / (4.0 * n * n);
  }
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(S.transpose());
  std::vector<int> order(at(2 * n + 1));
  for (size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  std::sort(order.begin(), order.end(), [&](int i, int j) {
    return std::abs(solver.eigenvalues()(i)) > std::abs(solver.eigenvalues()(j));
  });
  Eigen::MatrixXd masks(3, 2 * n + 1);
  for (int i = 0; i < 3; ++i) masks.row(i) = solver.eigenvectors().col(order[at(i)]).real().transpose();
  masks.row(0) /= masks.row(0).sum();
  return masks;
}

struct CatmullClark::Implementation {
  std::unique_ptr<Far::TopologyRefiner> refiner;
  int levels_wanted = 0;
  int levels = 0;  // refined: more than wanted where the limit needs them
  bool limit = false;
};

CatmullClark::CatmullClark(const ControlCage& cage, const CageTopology& topology,
                           const SubdivisionOptions& options, const Progress& progress)
    : implementation_(std::make_unique<Implementation>()) {
  std::unique_ptr<Far::TopologyRefiner>& refiner = implementation_->refiner;
  refiner = refiner_of(cage, topology, options.smooth_corners);
  implementation_->levels_wanted = options.levels;
  implementation_->limit = options.limit;
  // The limit masks hold for quads, and where no semi-sharp feature is left: further levels are made for
  // them.
  int levels = options.levels;
  if (options.limit) {
    levels = std::max(levels, 1);
    for (const std::vector<double>& all : {edge_sharpness(cage, topology), vertex_sharpness(cage)})
      for (const double sharpness : all)
        if (sharpness < Sdc::Crease::SHARPNESS_INFINITE)
          levels = std::max(levels, static_cast<int>(std::ceil(sharpness)));
    if (static_cast<double>(cage.mesh.corners.size()) * std::pow(4.0, levels - 1) > kMostFaces)
      throw InvalidInput(concat("the limit of the semi-sharp features needs ", levels,
                                " levels, which makes too many faces; lower the sharpness or set it to 10, ",
                                "which is sharp for ever"));
  }
  implementation_->levels = levels;
  Far::TopologyRefiner::UniformOptions uniform(levels);
  uniform.fullTopologyInLastLevel = options.limit;
  if (levels > 0) refiner->RefineUniform(uniform);
  progress.report("subdivide", 0.6);
}

CatmullClark::~CatmullClark() = default;

void CatmullClark::copy_topology(const CageTopology& topology, SubdividedSurface& surface) const {
  copy_faces(*implementation_->refiner, implementation_->levels_wanted, surface);
  trace_edges(*implementation_->refiner, topology, implementation_->levels_wanted, surface);
}

void CatmullClark::interpolate(const Points& positions, SubdividedSurface& surface,
                               const Progress& progress) const {
  const Far::TopologyRefiner& refiner = *implementation_->refiner;
  const int levels = implementation_->levels, levels_wanted = implementation_->levels_wanted;
  Points coarse = positions, fine, wanted, limit_positions, limit_normals;
  if (levels_wanted == 0) wanted = coarse;
  const Far::PrimvarRefinerReal<double> interpolation(refiner);
  for (int k = 1; k <= levels; ++k) {
    fine.resize(refiner.GetLevel(k).GetNumVertices(), 3);
    const Rows source(coarse.data());
    Rows target(fine.data());
    interpolation.Interpolate(k, source, target);
    coarse.swap(fine);
    if (k == levels_wanted && k < levels) wanted = coarse;
    progress.report("subdivide", 0.6 + 0.4 * k / (levels + 1));
  }
  if (implementation_->limit) {
    evaluate_limit(refiner, coarse, limit_positions, limit_normals);
    const Far::TopologyLevel& last = refiner.GetLevel(levels);
    evaluate_darts(last, coarse, limit_positions, limit_normals);
    average_normals(last, limit_positions, limit_normals);
    if (levels_wanted < levels) {
      const Far::TopologyLevel& level = refiner.GetLevel(levels_wanted);
      Points of_wanted(level.GetNumVertices(), 3), normals_of_wanted(level.GetNumVertices(), 3);
      for (int v = 0; v < level.GetNumVertices(); ++v) {
        int finest = v;
        for (int k = levels_wanted; k < levels; ++k)
          finest = refiner.GetLevel(k).GetVertexChildVertex(finest);
        of_wanted.row(v) = limit_positions.row(finest);
        normals_of_wanted.row(v) = limit_normals.row(finest);
      }
      limit_positions.swap(of_wanted);
      limit_normals.swap(normals_of_wanted);
    }
  }
  surface.limit_positions = std::move(limit_positions);
  surface.limit_normals = std::move(limit_normals);
  surface.cage.mesh.positions = std::move(levels_wanted < levels || levels == 0 ? wanted : coarse);
}

LimitCells limit_cells(const ControlCage& cage, const CageTopology& topology, int depth,
                       bool smooth_corners) {
  const std::unique_ptr<Far::TopologyRefiner> refiner = refiner_of(cage, topology, smooth_corners);
  Far::PatchTableFactory::Options table_options(static_cast<unsigned int>(depth));
  table_options.useInfSharpPatch = true;
  // Bilinear patches at irregular places, so that those can be told apart from the regular ones and left out.
  table_options.SetEndCapType(Far::PatchTableFactory::Options::ENDCAP_BILINEAR_BASIS);
  refiner->RefineAdaptive(table_options.GetRefineAdaptiveOptions());
  const std::unique_ptr<Far::PatchTable> table(Far::PatchTableFactory::Create(*refiner, table_options));

  Points points(refiner->GetNumVerticesTotal(), 3);
  points.topRows(cage.mesh.positions.rows()) = cage.mesh.positions;
  const Far::PrimvarRefinerReal<double> interpolation(*refiner);
  double* source = points.data();
  for (int k = 1; k <= refiner->GetMaxLevel(); ++k) {
    double* target = source + 3 * static_cast<std::ptrdiff_t>(refiner->GetLevel(k - 1).GetNumVertices());
    const Rows from(source);
    Rows to(target);
    interpolation.Interpolate(k, from, to);
    source = target;
  }

  LimitCells result;
  const int n_patches = table->GetNumPatchesTotal();
  result.cells.reserve(at(n_patches));
  for (int array = 0, patch = 0; array < table->GetNumPatchArrays(); ++array)
    for (int k = 0; k < table->GetNumPatches(array); ++k, ++patch) {
      if (table->GetPatchArrayDescriptor(array).GetType() != Far::PatchDescriptor::REGULAR) continue;
      const Far::PatchParam param = table->GetPatchParam(array, k);
      const Far::ConstIndexArray vertices = table->GetPatchVertices(array, k);
      LimitCell cell;
      cell.face = param.GetFaceId();
      cell.depth = param.GetDepth();
      cell.u = param.GetU();
      cell.v = param.GetV();
      for (int i = 0; i < 16; ++i)
        cell.control_points.row(i) = vertices[i] >= 0 ? points.row(vertices[i]) : points.row(vertices[5]);
      // Beyond a border or a crease stand points that continue the row in a straight line: the surface ends
      // in the curve of the border points (bits: v = 0, u = 1, v = 1, u = 0).
      const int border = param.GetBoundary();
      auto& p = cell.control_points;
      const auto mirror = [&p](int target, int edge, int inner) {
        p.row(target) = 2 * p.row(edge) - p.row(inner);
      };
      for (int i = 0; i < 4; ++i) {
        if (border & 1) mirror(i, 4 + i, 8 + i);
        if (border & 4) mirror(12 + i, 8 + i, 4 + i);
      }
      for (int j = 0; j < 4; ++j) {
        if (border & 2) mirror(4 * j + 3, 4 * j + 2, 4 * j + 1);
        if (border & 8) mirror(4 * j, 4 * j + 1, 4 * j + 2);
      }
      result.cells.push_back(cell);
    }

  SubdivisionOptions options;
  options.levels = 0;
  options.limit = true;
  options.smooth_corners = smooth_corners;
  SubdividedSurface surface;
  CatmullClark(cage, topology, options, {}).interpolate(cage.mesh.positions, surface, {});
  result.vertex_positions = std::move(surface.limit_positions);
  result.vertex_normals = std::move(surface.limit_normals);
  return result;
}

}  // namespace batten::detail
