// H 2.2; [botsch2004].
#include "batten/remeshing/remesh.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/mesh/self_intersections.hpp"
#include "batten/operators/curvature.hpp"
#include "batten/operators/laplacian.hpp"
#include "batten/remeshing/connectivity.hpp"
#include "batten/remeshing/crossings.hpp"
#include "batten/remeshing/feature_chains.hpp"
#include "batten/remeshing/normal_fit.hpp"
#include "batten/remeshing/regularization.hpp"
#include "batten/remeshing/size_field.hpp"
#include "batten/remeshing/surface_fit.hpp"

namespace batten {

namespace {

using Eigen::Vector3d;

/// Edges are split above and collapsed below these multiples of the wanted length [botsch2004]: after
/// either the parts are nearer to it than before.
constexpr double kSplitAbove = 4.0 / 3.0, kCollapseBelow = 4.0 / 5.0;
/// Standard deviation of the edges of a result over their mean (measured: 0.13 to 0.16).
constexpr double kScatter = 0.14;
/// Edge lengths change by at most this per unit of length: neighbouring triangles stay well shaped.
constexpr double kGradation = 0.25;
/// σ of the weights of STEP 1 (H 2.39).
constexpr double kAreaSimilarity = 0.05;
constexpr std::size_t kMostCrossings = 10000;
/// Most rounds on parts of facets, where the mean edge takes longer to reach.
constexpr int kMostRounds = 20;
/// Inputs a fifth of which has edges longer than this many wanted lengths are refined before anything moves.
constexpr double kCoarse = 3;
/// Faces that meet at less than this lie in one plane.
constexpr double kFlat = radians(0.05);
/// Lines between the facets of a part that turn by more are kept: an edge of length h that cuts across a line
/// of angle θ misses it by h θ/4, here 2 % of h.
constexpr double kFacetAngle = radians(4.0);

void check(const TriangleMesh& mesh, const RemeshOptions& options) {
  if (mesh.n_triangles() == 0) throw InvalidInput("there are no triangles to remesh");
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  if (options.sizes.size() == 0) return;
  if (options.sizes.size() != mesh.n_vertices())
    throw InvalidInput(concat("there are ", options.sizes.size(), " sizes, but the mesh has ",
                              mesh.n_vertices(), " vertices"));
}

double mean_edge_length(const HalfedgeMesh& mesh) {
  double sum = 0;
  int count = 0;
  for (int h = 0; h < mesh.halfedge_capacity(); ++h)
    if (mesh.is_representative(h)) {
      sum += (mesh.position(mesh.from(h)) - mesh.position(mesh.to(h))).norm();
      ++count;
    }
  return sum / std::max(count, 1);
}

double total_area(const HalfedgeMesh& mesh) {
  double area = 0;
  for (int f = 0; f < mesh.face_capacity(); ++f)
    if (mesh.has_face(f)) area += 0.5 * mesh.area_normal(f).norm();
  return area;
}

Points area_weighted_normals(const Points& positions, const Triangles& triangles) {
  Points normals = Points::Zero(positions.rows(), 3);
  for (Eigen::Index f = 0; f < triangles.rows(); ++f) {
    const Vector3d a = positions.row(triangles(f, 0));
    const Vector3d b = positions.row(triangles(f, 1)), c = positions.row(triangles(f, 2));
    const Vector3d cross = (b - a).cross(c - a);
    for (int k = 0; k < 3; ++k) normals.row(triangles(f, k)) += cross.transpose();
  }
  for (Eigen::Index v = 0; v < normals.rows(); ++v) {
    const double length = normals.row(v).norm();
    if (length > 0) normals.row(v) /= length;
  }
  return normals;
}

double dihedral_angle(const HalfedgeMesh& mesh, int h) {
  return angle_between(mesh.area_normal(HalfedgeMesh::face(h)),
                       mesh.area_normal(HalfedgeMesh::face(mesh.opposite(h))));
}

/// Whether the mesh is that of a part of flat facets, as CAD programs export cylinders: in strips between
/// straight lines. There the facets are the surface, and what lies between them is not curvature but lines to
/// keep. It is one where it is coarse beside edges of the given length, or where nearly every vertex is the
/// end of a line at a sharp edge.
bool is_faceted(const HalfedgeMesh& mesh, double length, double crease_angle) {
  std::vector<double> angle(mesh.halfedge_capacity(), kPi);
  for (int h = 0; h < mesh.halfedge_capacity(); ++h)
    if (mesh.has_halfedge(h) && !mesh.is_border_edge(h)) angle[h] = dihedral_angle(mesh, h);
  const auto edge_length = [&](int h) {
    return (mesh.position(mesh.from(h)) - mesh.position(mesh.to(h))).norm();
  };
  std::vector<char> is_flat(mesh.face_capacity(), 0);
  double area = 0, coarse = 0;
  for (int f = 0; f < mesh.face_capacity(); ++f) {
    if (!mesh.has_face(f)) continue;
    double longest = 0;
    for (int h = 3 * f; h < 3 * f + 3; ++h) {
      longest = std::max(longest, edge_length(h));
      if (angle[h] < kFlat) is_flat[f] = 1;
    }
    const double doubled = mesh.area_normal(f).norm();
    if (longest * longest > 8 * doubled) is_flat[f] = 1;  // a needle
    area += doubled;
    if (longest > 2 * length) coarse += doubled;
  }
  struct Lines {
    int all = 0, sharp = 0;
  };
  std::vector<Lines> at(mesh.vertex_capacity());
  double lines = 0, flat = 0;
  for (int h = 0; h < mesh.halfedge_capacity(); ++h) {
    if (!mesh.is_representative(h) || !(angle[h] > kFacetAngle)) continue;
    const bool is_sharp = angle[h] > crease_angle;
    for (const int v : {mesh.from(h), mesh.to(h)}) {
      ++at[v].all;
      at[v].sharp += is_sharp ? 1 : 0;
    }
    if (is_sharp) continue;
    lines += edge_length(h);
    if (is_flat[HalfedgeMesh::face(h)] != 0 && is_flat[HalfedgeMesh::face(mesh.opposite(h))] != 0)
      flat += edge_length(h);
  }
  if (lines > 0 && !(flat > 0.9 * lines)) return false;
  const auto ends =
      std::count_if(at.begin(), at.end(), [](const Lines& n) { return n.all > 2 && n.sharp > 0; });
  return coarse > 0.3 * area || static_cast<double>(ends) > 0.8 * mesh.n_vertices();
}

/// Sizes at a border that stays as it is are the lengths of its edges, as far as the gradation lets them.
void fit_sizes_to_border(const HalfedgeMesh& mesh, Eigen::VectorXd& sizes) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(sizes.size()), edges = sum;
  for (int h = 0; h < mesh.halfedge_capacity(); ++h) {
    if (!mesh.has_halfedge(h) || !mesh.is_border_edge(h)) continue;
    const double length = (mesh.position(mesh.from(h)) - mesh.position(mesh.to(h))).norm();
    for (const int v : {mesh.from(h), mesh.to(h)}) {
      sum[v] += length;
      edges[v] += 1;
    }
  }
  for (Eigen::Index v = 0; v < sizes.size(); ++v)
    if (sum[v] > 0) sizes[v] = sum[v] / edges[v];
  limit_gradation(mesh, kGradation, sizes);
}

/// The surface that the new triangles must follow, and the sizes on it.
struct Reference {
  Points positions;
  Triangles triangles;
  Eigen::VectorXd sizes;
  std::optional<TriangleTree> tree;

  Reference(const HalfedgeMesh::Compact& compact, const Eigen::VectorXd& sizes_of_halfedge_mesh)
      : positions(compact.positions), triangles(compact.triangles), tree(TriangleTree(positions, triangles)) {
    sizes.resize(positions.rows());
    for (std::size_t v = 0; v < compact.vertices.size(); ++v)
      sizes[static_cast<Eigen::Index>(v)] = sizes_of_halfedge_mesh[compact.vertices[v]];
  }
  double size_at(const ClosestPoint& point) const {
    double size = 0;
    for (int k = 0; k < 3; ++k) size += point.weights[k] * sizes[triangles(point.element, k)];
    return size;
  }
};

/// One remeshing from start to end.
class Remesher {
 public:
  Remesher(const TriangleMesh& input, const RemeshOptions& options, const Progress& progress)
      : options_(options), progress_(progress) {
    HalfedgeMesh mesh(input.positions, input.triangles, NonManifoldVertices::Split);
    report_.split_vertices = mesh.vertex_capacity() - static_cast<int>(input.n_vertices());
    ScopedStage stage(times_, "features and sizes");
    progress_.report("remeshing", 0);
    const double area = total_area(mesh);
    if (!(area > 0)) throw InvalidInput("the triangles have no area; there is nothing to remesh");
    double length = options.edge_length > 0 ? options.edge_length : mean_edge_length(mesh);
    edge_length_ = length;
    // Areas follow the mean square of the edges, which exceeds the square of their mean by their scatter.
    length *= std::sqrt(1 + kScatter * kScatter);
    if (options.n_vertices > 0) length = std::sqrt(2 * area / (std::sqrt(3.0) * options.n_vertices));
    FeatureOptions feature_options;
    feature_options.crease_angle = options.keep_edges;
    feature_options.corner_angle = radians(40.0);
    // Creases that end freely within a few edges are the roughness of a scan, not a design.
    feature_options.least_length = 4 * length;
    feature_options.fade = 0.5;
    feature_options.hold_border = options.hold_border;
    if (options.keep_edges > kFacetAngle && options.keep_edges < kPi &&
        is_faceted(mesh, length, options.keep_edges)) {
      report_.is_faceted = true;
      feature_options.crease_angle = kFacetAngle;
      feature_options.least_length = 0;
      feature_options.fade = 1;
    }
    progress_.report("remeshing", 0);
    features_ = mark_features(mesh, feature_options);
    progress_.report("remeshing", 0);

    Eigen::VectorXd sizes;
    if (options.sizes.size() == 0) {
      const Eigen::VectorXd curvature = curvature_magnitude(mesh, features_);
      progress_.report("remeshing", 0);
      sizes = adaptive_sizes(mesh, curvature, length, options.adaptivity, kGradation);
    } else {
      sizes.resize(mesh.vertex_capacity());
      for (int v = 0; v < mesh.vertex_capacity(); ++v) sizes[v] = options.sizes[mesh.source_vertex(v)];
      if (options.n_vertices > 0) sizes *= std::sqrt(vertices_for_sizes(mesh, sizes) / options.n_vertices);
    }
    if (options.hold_border) fit_sizes_to_border(mesh, sizes);
    target_vertices_ = options.n_vertices > 0 ? options.n_vertices : vertices_for_sizes(mesh, sizes);
    if (target_vertices_ > 1e8)
      throw InvalidInput(concat("an edge length of ", length, " would take ", target_vertices_,
                                " vertices; ask for a longer one"));
    progress_.report("remeshing", 0);
    reference_.emplace(mesh.compacted(), sizes);
    progress_.report("remeshing", 0);
    state_.emplace(std::move(mesh), features_, sizes);
    state_->hold_border = options.hold_border;
  }

  RemeshResult run() {
    report_.target_vertices = target_vertices_;
    for (const int c : state_->corner) report_.corners += c >= 0 ? 1 : 0;
    refine(progress_.part("refine", 0, 0));
    double last_variance = 0;
    const auto misses_length = [&] {
      return report_.is_faceted && options_.n_vertices == 0 &&
             std::abs(mean_edge_length(state_->mesh) / edge_length_ - 1) > 0.1;
    };
    for (int round = 0;
         (round < options_.max_iterations || (round < kMostRounds && misses_length())) && !report_.converged;
         ++round) {
      const double done = std::min(round, options_.max_iterations - 1);
      const Progress part = progress_.part("remeshing", done / (options_.max_iterations + 2),
                                           (done + 1) / (options_.max_iterations + 2));
      change_connectivity(round, part.part("connectivity", 0, 0.5));
      const double variance = regularize(5, part.part("regularization", 0.5, 1));
      report_.area_variance.push_back(variance);
      ++report_.iterations;
      report_.converged = round > 0 && std::abs(variance - last_variance) < options_.tolerance;
      last_variance = variance;
    }
    finish();
    RemeshResult result;
    const HalfedgeMesh::Compact compact = state_->mesh.compacted();
    result.mesh.positions = compact.positions;
    result.mesh.triangles = compact.triangles;
    for (int h = 0; h < state_->mesh.halfedge_capacity(); ++h)
      report_.feature_edges += state_->mesh.is_representative(h) && state_->mesh.is_marked(h) ? 1 : 0;
    result.report = std::move(report_);
    result.times = std::move(times_);
    return result;
  }

 private:
  /// Brings triangles that are far too long down to size while the surface stays as it is: in the fans of
  /// needles that single splits leave, vertices would move out of the surface and across each other.
  void refine(const Progress& progress) {
    ScopedStage stage(times_, "connectivity");
    double longest = 0, area = 0, coarse = 0;
    for (int f = 0; f < state_->mesh.face_capacity(); ++f) {
      if (!state_->mesh.has_face(f)) continue;
      double ratio = 0;
      for (int h = 3 * f; h < 3 * f + 3; ++h)
        ratio = std::max(ratio, state_->edge_length(h) / state_->wanted_length(h));
      longest = std::max(longest, ratio);
      const double doubled = state_->mesh.area_normal(f).norm();
      area += doubled;
      if (ratio > kCoarse) coarse += doubled;
    }
    if (!(coarse > 0.2 * area)) return;
    // Lines first, and by halves with good triangles between: cutting needles as they are would make many
    // times the vertices that are wanted, and fans of thousands.
    for (const bool lines_only : {true, false})
      for (double ratio = longest; ratio > kSplitAbove;) {
        ratio = std::max(0.5 * ratio, kSplitAbove);
        state_->refine(ratio, lines_only, kFlat, progress);
        state_->flip_flat_pieces(kFlat);
      }
  }

  /// STEP 0. The sizes are scaled towards the wanted number of vertices after the first rounds.
  void change_connectivity(int round, const Progress& progress) {
    ScopedStage stage(times_, "connectivity");
    if (round >= 2 && (round < 8 || report_.is_faceted)) {
      // Between the lines of a part triangles can be longer than wide: there it is the length that counts.
      const double ratio = report_.is_faceted && options_.n_vertices == 0
                               ? std::clamp(edge_length_ / mean_edge_length(state_->mesh), 0.5, 2.0)
                               : std::sqrt(state_->mesh.n_vertices() / target_vertices_);
      scale_ *= ratio;
      for (double& size : state_->size) size *= ratio;
    }
    progress.report("split", 0);
    state_->split_long_edges(kSplitAbove, progress.part("split", 0, 0.3));
    progress.report("collapse", 0.3);
    state_->collapse_short_edges(kCollapseBelow, kSplitAbove, progress.part("collapse", 0.3, 0.7));
    progress.report("flip", 0.7);
    state_->flip_for_valence(radians(20.0), radians(15.0));
  }

  /// STEP 1 and 2, and back to the surface. @return Var(A) / (N Ā²) of the areas over their shares.
  double regularize(int steps, const Progress& progress) {
    progress.report("regularization", 0);
    const HalfedgeMesh::Compact compact = state_->mesh.compacted();
    const Points& X = compact.positions;
    const Eigen::Index n = X.rows();
    Eigen::VectorXd lengths(n);
    std::vector<char> fixed(n);
    for (Eigen::Index v = 0; v < n; ++v) {
      lengths[v] = state_->size[compact.vertices[v]];
      fixed[v] = state_->is_free(compact.vertices[v]) ? 0 : 1;
    }
    Points moved;
    double variance = 0;
    {
      ScopedStage stage(times_, "regularization");
      const Eigen::VectorXd shares = lengths.cwiseAbs2() / lengths.cwiseAbs2().mean();
      const EdgeLengths edges = edge_lengths(X, compact.triangles);
      const SparseMatrix K = clamped_stiffness(compact.triangles, edges, n);
      progress.report("regularization", 0.15);
      const Eigen::VectorXd areas = lumped_mass(compact.triangles, edges, n);
      const Eigen::VectorXd relative = areas.cwiseQuotient(shares);
      variance = (relative.array() - relative.mean()).square().mean() / (relative.mean() * relative.mean());
      const Points normals = area_weighted_normals(X, compact.triangles);
      SparseMatrix L;
      if (options_.method == RemeshMethod::Adaptive) {
        Eigen::VectorXd H = (K * X).rowwise().norm().cwiseQuotient(2 * areas);
        // On kept edges curvature is that of the edge and says nothing of the faces beside it.
        for (Eigen::Index v = 0; v < n; ++v)
          if (fixed[v] != 0) H[v] = 0;
        progress.report("regularization", 0.3);
        const RegularizedAreas wanted = regularized_areas(K, areas, H, shares, kAreaSimilarity,
                                                          progress.part("regularization", 0.35, 0.5));
        report_.solves.add(wanted.solve);
        progress.report("regularization", 0.5);
        L = relocation_matrix(K, X, areas, wanted.areas, lengths, H);
      } else {
        L = laplacian_flow_matrix(K, areas, shares);
      }
      progress.report("regularization", 0.7);
      moved = relocated(L, X, normals, lengths, fixed, steps);
    }
    for (Eigen::Index v = 0; v < n; ++v)
      if (fixed[v] == 0) state_->mesh.set_position(compact.vertices[v], moved.row(v));
    state_->relax_chains(0.5);
    progress.report("projection", 0.8);
    project(progress.part("projection", 0.8, 1));
    return variance;
  }

  void project(const Progress& progress) {
    ScopedStage stage(times_, "projection");
    HalfedgeMesh& mesh = state_->mesh;
    std::vector<int> vertices;
    for (int v = 0; v < mesh.vertex_capacity(); ++v)
      if (mesh.has_vertex(v)) vertices.push_back(v);
    Points queries(static_cast<Eigen::Index>(vertices.size()), 3);
    for (std::size_t i = 0; i < vertices.size(); ++i)
      queries.row(static_cast<Eigen::Index>(i)) = mesh.position(vertices[i]);
    const std::vector<ClosestPoint> closest = reference_->tree->closest(queries, progress);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const int v = vertices[i];
      if (state_->is_free(v)) mesh.set_position(v, closest[i].point);
      state_->size[v] = scale_ * reference_->size_at(closest[i]);
    }
  }

  /// Triangles that cross, where those of the input do not.
  void mend() {
    ScopedStage stage(times_, "crossings");
    const Progress part = progress_.part("remeshing", 1, 1);
    const HalfedgeMesh::Compact compact = state_->mesh.compacted();
    report_.crossings = self_intersections(compact.positions, compact.triangles, kMostCrossings, part).size();
    if (report_.crossings == 0) return;
    report_.input_crossings =
        self_intersections(reference_->positions, reference_->triangles, kMostCrossings, part).size();
    report_.crossings =
        mend_crossings(*state_, reference_->positions, reference_->triangles, report_.input_crossings, part);
  }

  void finish() {
    for (int round = 0; round < 3; ++round) {
      const double done = options_.max_iterations + round / 3.0;
      const Progress part = progress_.part("remeshing", done / (options_.max_iterations + 2),
                                           (done + 1.0 / 3) / (options_.max_iterations + 2));
      part.report("flips", 0);
      {
        ScopedStage stage(times_, "connectivity");
        state_->flip_for_angles(radians(20.0));
      }
      regularize(3, part.part("regularization", 0.3, 1));
    }
    // The Laplacian flow is there to be compared with: it ends here, as its authors have it.
    if (options_.method == RemeshMethod::LaplacianFlow) return;
    fit(progress_.part("remeshing", (options_.max_iterations + 1.0) / (options_.max_iterations + 2), 1));
    mend();
  }

  /// Vertices and edges to where the triangles fit the old surface best.
  void fit(const Progress& progress) {
    ScopedStage stage(times_, "fit");
    progress.report("fit", 0);
    reference_->tree.reset();  // no longer needed, and a third of what is in memory
    ReferenceSamples reference;
    {
      const HalfedgeMesh::Compact compact = state_->mesh.compacted();
      std::vector<char> fixed;
      for (const int v : compact.vertices) fixed.push_back(state_->is_free(v) ? 0 : 1);
      reference = sample_reference(compact.positions, compact.triangles, reference_->positions,
                                   reference_->triangles, progress.part("samples", 0, 0.3));
      progress.report("fit", 0.3);
      const SurfaceFitResult fitted = fitted_to_surface(compact.positions, compact.triangles, fixed,
                                                        reference, {}, progress.part("fit", 0.3, 0.4));
      report_.solves.add(fitted.solve);
      for (std::size_t v = 0; v < compact.vertices.size(); ++v)
        state_->mesh.set_position(compact.vertices[v], fitted.positions.row(static_cast<Eigen::Index>(v)));
    }
    fit_normals(*state_, features_, reference_->positions, reference_->triangles, std::move(reference), {},
                progress.part("fitting normals", 0.4, 1));
  }

  RemeshOptions options_;
  Progress progress_;
  StageTimes times_;
  RemeshReport report_;
  FeatureChains features_;
  std::optional<Reference> reference_;
  std::optional<RemeshState> state_;
  double edge_length_ = 0;  ///< the mean that is asked for
  double target_vertices_ = 0;
  double scale_ = 1;  ///< of the sizes, to meet the number of vertices
};

}  // namespace

std::optional<std::string> RemeshOptions::problem() const {
  if (!(edge_length >= 0) || !std::isfinite(edge_length))
    return concat("edge_length must be positive, got ", edge_length);
  if (n_vertices < 0) return concat("n_vertices must be positive, got ", n_vertices);
  if (n_vertices > 0 && edge_length > 0)
    return "give either an edge length or a number of vertices, not both";
  if (!(adaptivity >= 0 && adaptivity <= 1)) return concat("adaptivity must lie in [0, 1], got ", adaptivity);
  if (!(keep_edges > 0 && keep_edges <= kPi + 1e-9))
    return concat("keep_edges must lie above 0 and at most at 180 degrees, got ", degrees(keep_edges),
                  " degrees");
  if (max_iterations < 1) return concat("max_iterations must be at least 1, got ", max_iterations);
  if (!(tolerance >= 0)) return concat("tolerance must be at least 0, got ", tolerance);
  for (Eigen::Index v = 0; v < sizes.size(); ++v)
    if (!(sizes[v] > 0) || !std::isfinite(sizes[v]))
      return concat("the size at vertex ", v, " is ", sizes[v], "; sizes are edge lengths above 0");
  return std::nullopt;
}

RemeshResult remesh(const TriangleMesh& mesh, const RemeshOptions& options, const Progress& progress) {
  check(mesh, options);
  return Remesher(mesh, options, progress).run();
}

}  // namespace batten
