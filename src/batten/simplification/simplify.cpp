#include "batten/simplification/simplify.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/parallel.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/mesh/halfedge_mesh.hpp"
#include "batten/simplification/decimator_detail.hpp"
#include "batten/simplification/face_tree_detail.hpp"
#include "batten/simplification/surface_fit_detail.hpp"

namespace batten {

using Eigen::Vector3d;
using simplification::Decimator;
using simplification::DecimatorOptions;
using simplification::FaceTree;
using simplification::FitOptions;
using simplification::SurfaceFit;
using simplification::SurfaceSample;

namespace {

/// Samples per face of the result, and in all where the input has that many faces for it: enough to see every
/// face bend, few enough for time.
constexpr double kSamplesPerFace = 16;
constexpr double kEnoughSamples = 60000;

/// @param faces of the input, @param left of the result.
int sample_count(Eigen::Index faces, Eigen::Index left) {
  return static_cast<int>(
      std::max(kSamplesPerFace * double(left), std::min(kEnoughSamples, kSamplesPerFace * double(faces))));
}

/// The vertex that stands for each vertex of the input now; paths are halved on the way.
class Representatives {
 public:
  explicit Representatives(int n) : parent_(n) {
    for (int v = 0; v < n; ++v) parent_[v] = v;
  }
  void join(int removed, int kept) { parent_[removed] = kept; }
  int operator()(int v) {
    while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
    return v;
  }

 private:
  std::vector<int> parent_;
};

void mark_sharp_edges(HalfedgeMesh& mesh, double angle) {
  const double limit = std::cos(angle);
  for (int h = 0; h < mesh.halfedge_capacity(); ++h) {
    if (!mesh.is_representative(h)) continue;
    if (mesh.is_border_edge(h)) {
      mesh.set_marked(h, true);
      continue;
    }
    const Vector3d n = mesh.area_normal(HalfedgeMesh::face(h)),
                   o = mesh.area_normal(HalfedgeMesh::face(mesh.opposite(h)));
    if (n.dot(o) < limit * n.norm() * o.norm()) mesh.set_marked(h, true);
  }
}

/// The work of one simplification, its mesh kept between the levels.
class Simplification {
 public:
  Simplification(const TriangleMesh& input, const SimplifyOptions& options, const Progress& progress)
      : input_(input),
        options_(options),
        progress_(progress),
        mesh_(input.positions, input.triangles, NonManifoldVertices::Split),
        tree_(after_report(mesh_)),
        representative_(mesh_.vertex_capacity()) {
    progress.report("collapse", 0);
    if (mesh_.vertex_capacity() > input.n_vertices())
      result_.warnings.push_back(
          concat("several fans of faces meet in one point at ", mesh_.vertex_capacity() - input.n_vertices(),
                 " places (first at vertex ", mesh_.source_vertex(static_cast<int>(input.n_vertices())),
                 "); each fan was given a vertex of its own"));
    if (options.keep_edges > 0) mark_sharp_edges(mesh_, options.keep_edges);
    if (options.keep_history) {
      HalfedgeMesh::Compact all = mesh_.compacted();
      Points positions(mesh_.vertex_capacity(), 3);
      for (int v = 0; v < mesh_.vertex_capacity(); ++v) positions.row(v) = mesh_.position(v);
      Triangles triangles = all.triangles;
      for (Eigen::Index f = 0; f < triangles.rows(); ++f)
        for (int k = 0; k < 3; ++k) triangles(f, k) = all.vertices[triangles(f, k)];
      result_.history.start(std::move(positions), std::move(triangles));
    }
  }

  SimplifyResult run(Eigen::Index target) {
    const bool in_levels = options_.method == SimplifyMethod::PLaplacian || options_.keep_levels;
    const std::vector<Eigen::Index> targets =
        faces_per_level(mesh_.n_faces(), target, in_levels ? options_.levels : 1);
    std::vector<int> finer(
        static_cast<std::size_t>(input_.n_vertices()));  // numbers of the vertices of the level before
    std::iota(finer.begin(), finer.end(), 0);
    for (std::size_t level = 0; level < targets.size(); ++level) {
      const bool last = level + 1 == targets.size();
      collapse_to(targets[level]);
      if (last || options_.keep_levels) {
        ScopedStage stage(result_.times, "fit");
        fit();
      }
      if (options_.keep_history) result_.history.end_level();
      if (options_.keep_levels) keep_level(finer);
    }
    finish(target);
    return std::move(result_);
  }

 private:
  /// The mesh, with a report before what is to be made of it: both take long.
  const HalfedgeMesh& after_report(const HalfedgeMesh& mesh) const {
    progress_.report("collapse", 0);
    return mesh;
  }

  void collapse_to(Eigen::Index target) {
    DecimatorOptions options;
    options.keep_marked = options_.keep_edges > 0;
    options.hold_border = options_.hold_border;
    std::vector<Vector3d> flowed;
    if (options_.method == SimplifyMethod::PLaplacian) {
      ScopedStage stage(result_.times, "flow");
      progress_.report("flow", 0);
      const HalfedgeMesh::Compact compact = mesh_.compacted();
      const Points moved = p_laplacian_flow(compact.positions, compact.triangles, options_.flow, progress_);
      flowed.assign(mesh_.vertex_capacity(), Vector3d::Zero());
      for (std::size_t v = 0; v < compact.vertices.size(); ++v)
        flowed[compact.vertices[v]] = moved.row(static_cast<Eigen::Index>(v));
      options.flowed = &flowed;
      options.alpha = options_.alpha;
      options.beta = options_.beta;
    }
    ScopedStage stage(result_.times, "collapse");
    Decimator decimator(mesh_, tree_, options, progress_);
    decimator.on_collapse = [&](int h, const Vector3d& point) {
      representative_.join(mesh_.from(h), mesh_.to(h));
      ++result_.collapses;
      if (options_.keep_history) record_collapse(h, point);
    };
    decimator.run(static_cast<int>(target), std::numeric_limits<double>::infinity(), progress_);
  }

  void record_collapse(int h, const Vector3d& point) {
    const int u = mesh_.from(h), v = mesh_.to(h);
    mesh_.for_each_outgoing(u, [&](int g) {
      const int f = HalfedgeMesh::face(g);
      SimplificationHistory::FaceChange change{f, {0, 0, 0}, {0, 0, 0}};
      bool removed = false;
      for (int k = 0; k < 3; ++k) {
        change.before[k] = mesh_.from(3 * f + k);
        change.after[k] = change.before[k] == u ? v : change.before[k];
        removed = removed || change.before[k] == v;
      }
      if (removed) change.after[0] = change.after[1] = change.after[2] = -1;
      result_.history.add(change);
    });
    record_move(v, mesh_.position(v), point);
    result_.history.end_step();
  }

  void record_move(int v, const Vector3d& from, const Vector3d& to) {
    result_.history.add(
        SimplificationHistory::VertexChange{v, {from.x(), from.y(), from.z()}, {to.x(), to.y(), to.z()}});
  }

  void fit() {
    progress_.report("fit", 0);
    std::vector<SurfaceSample> samples = simplification::sample_surface(
        input_.positions, input_.triangles, sample_count(input_.n_triangles(), mesh_.n_faces()));
    progress_.report("fit", 0);  // to sample and to begin the fit take long, each
    std::vector<int> source(samples.size());
    for (std::size_t s = 0; s < samples.size(); ++s) source[s] = samples[s].face;
    FitOptions options;
    options.rounds = options_.fit_rounds;
    SurfaceFit fit(mesh_, tree_, std::move(samples), options);
    progress_.report("fit", 0);
    start(fit, source);
    if (options_.keep_history) {
      std::vector<Vector3d> positions(mesh_.vertex_capacity());
      std::vector<int> corners(mesh_.halfedge_capacity());
      for (int v = 0; v < mesh_.vertex_capacity(); ++v) positions[v] = mesh_.position(v);
      for (int h = 0; h < mesh_.halfedge_capacity(); ++h) corners[h] = mesh_.from(h);
      fit.run(progress_);
      for (int f = 0; f < mesh_.face_capacity(); ++f) {
        SimplificationHistory::FaceChange change{f, {0, 0, 0}, {0, 0, 0}};
        bool changed = false;
        for (int k = 0; k < 3; ++k) {
          change.before[k] = corners[3 * f + k];
          change.after[k] = mesh_.from(3 * f + k);
          changed = changed || change.before[k] != change.after[k];
        }
        if (changed) result_.history.add(change);
      }
      for (int v = 0; v < mesh_.vertex_capacity(); ++v)
        if (mesh_.has_vertex(v) && positions[v] != mesh_.position(v))
          record_move(v, positions[v], mesh_.position(v));
      result_.history.end_step();
    } else {
      fit.run(progress_);
    }
    result_.rms_error = fit.rms();
    result_.max_error = fit.largest_distance();
  }

  /// Starts every sample near the faces that stand for the one it comes from.
  void start(SurfaceFit& fit, const std::vector<int>& source) {
    std::vector<int> standing(static_cast<std::size_t>(input_.n_vertices()));
    for (std::size_t v = 0; v < standing.size(); ++v) standing[v] = representative_(static_cast<int>(v));
    const auto start_some = [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index s = begin; s < end; ++s) {
        // A face whose vertices were split is found by them all the same: corners of the input keep a number.
        std::array<int, 3> vertices{};
        int n = 0;
        for (int k = 0; k < 3; ++k) {
          const int v = standing[input_.triangles(source[s], k)];
          if (mesh_.has_vertex(v) &&
              std::find(vertices.begin(), vertices.begin() + n, v) == vertices.begin() + n)
            vertices[n++] = v;
        }
        fit.start_at(static_cast<int>(s), vertices.data(), n);
      }
    };
    parallel_for(static_cast<Eigen::Index>(source.size()), 1024, start_some, progress_.part("fit", 0, 0));
  }

  TriangleMesh as_mesh(const HalfedgeMesh::Compact& compact) const {
    TriangleMesh mesh;
    mesh.positions = compact.positions;
    mesh.triangles = compact.triangles;
    return mesh;
  }

  void keep_level(std::vector<int>& finer) {
    const HalfedgeMesh::Compact compact = mesh_.compacted();
    SimplifyLevel level;
    level.mesh = as_mesh(compact);
    for (const int v : finer) level.vertex_of_finer.push_back(compact.index[representative_(v)]);
    result_.levels.push_back(std::move(level));
    finer = compact.vertices;
  }

  void finish(Eigen::Index target) {
    const HalfedgeMesh::Compact compact = mesh_.compacted();
    result_.mesh = as_mesh(compact);
    for (int v = 0; v < input_.n_vertices(); ++v)
      result_.vertex_map.push_back(compact.index[representative_(v)]);
    result_.reached = mesh_.n_faces() <= target;
    if (!result_.reached)
      result_.warnings.push_back(concat("stopped at ", mesh_.n_faces(), " of ", target,
                                        " faces: no edge can be collapsed without changing the topology, ",
                                        "folding a face or making the surface touch itself",
                                        options_.keep_edges > 0 ? ", or leaving a kept edge" : "",
                                        options_.hold_border ? ", or moving the border" : ""));
  }

  const TriangleMesh& input_;
  const SimplifyOptions& options_;
  const Progress& progress_;
  HalfedgeMesh mesh_;
  FaceTree tree_;
  Representatives representative_;
  SimplifyResult result_;
};

/// Measures the distance between an input and its simplifications, in both directions.
class DistanceGauge {
 public:
  explicit DistanceGauge(const TriangleMesh& input) : tree_(input.positions, input.triangles) {
    const auto samples = simplification::sample_surface(input.positions, input.triangles,
                                                        sample_count(input.n_triangles(), 0));
    std::vector<char> used(input.n_vertices(), 0);
    for (Eigen::Index i = 0; i < input.triangles.size(); ++i) used[input.triangles.data()[i]] = 1;
    const auto n_used = std::count(used.begin(), used.end(), 1);
    points_.resize(static_cast<Eigen::Index>(samples.size()) + n_used, 3);
    Eigen::Index row = 0;
    for (const SurfaceSample& s : samples) points_.row(row++) = s.point;
    for (Eigen::Index v = 0; v < input.n_vertices(); ++v)
      if (used[v] != 0) points_.row(row++) = input.positions.row(v);
  }

  double largest(const TriangleMesh& mesh) const {
    Points back(mesh.n_vertices() + 4 * mesh.n_triangles(), 3);
    back.topRows(mesh.n_vertices()) = mesh.positions;
    Eigen::Index row = mesh.n_vertices();
    for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f) {
      const Vector3d a = mesh.positions.row(mesh.triangles(f, 0)),
                     b = mesh.positions.row(mesh.triangles(f, 1)),
                     c = mesh.positions.row(mesh.triangles(f, 2));
      back.row(row++) = (a + b + c) / 3;
      back.row(row++) = 0.5 * (a + b);
      back.row(row++) = 0.5 * (b + c);
      back.row(row++) = 0.5 * (c + a);
    }
    const TriangleTree tree(mesh.positions, mesh.triangles);
    return std::max(distances(tree.closest(points_)).maxCoeff(), distances(tree_.closest(back)).maxCoeff());
  }

 private:
  TriangleTree tree_;
  Points points_;
};

/// The coarsest mesh within a distance: the number of faces is found on the way down with fits of two rounds,
/// bracketed by halving and then by bisection.
SimplifyResult simplify_within(const TriangleMesh& mesh, SimplifyOptions options, const Progress& progress) {
  const DistanceGauge gauge(mesh);
  const double limit = options.max_error;
  options.max_error = 0;
  StageTimes times;
  std::optional<SimplifyResult> best;
  Eigen::Index good = mesh.n_triangles(), bad = 0;
  const auto try_faces = [&](Eigen::Index faces) {
    options.faces = faces;
    SimplifyResult result = Simplification(mesh, options, progress).run(faces);
    times.add(result.times);
    const double distance = gauge.largest(result.mesh);
    result.max_error = distance;
    const bool within = distance <= limit;
    const bool reached = result.reached;
    if (within) {
      good = std::min(good, result.mesh.n_triangles());
      best = std::move(result);
    } else {
      bad = std::max(bad, faces);
    }
    return within && reached;
  };
  for (Eigen::Index faces = std::max<Eigen::Index>(1, mesh.n_triangles() / 8); try_faces(faces) && faces > 1;)
    faces = std::max<Eigen::Index>(1, faces / 8);
  // Closed in to 2 %; distances do not fall quite evenly with the number of faces.
  for (int i = 0; i < 12 && bad > 0 && good - bad > std::max<Eigen::Index>(2, good / 50); ++i)
    try_faces(static_cast<Eigen::Index>(std::sqrt(double(good) * double(bad))));
  if (!best) {
    options.faces = mesh.n_triangles();
    best = Simplification(mesh, options, progress).run(mesh.n_triangles());
  }
  best->times = times;
  best->reached = true;
  best->warnings.erase(std::remove_if(best->warnings.begin(), best->warnings.end(),
                                      [](const std::string& w) { return w.rfind("stopped at", 0) == 0; }),
                       best->warnings.end());
  return std::move(*best);
}

}  // namespace

std::optional<std::string> SimplifyOptions::problem() const {
  const int criteria = (faces != 0 ? 1 : 0) + (remove != 0 ? 1 : 0) + (max_error != 0 ? 1 : 0);
  if (criteria != 1) return concat("give exactly one of faces, remove and max_error, got ", criteria);
  if (faces < 0) return concat("faces must be at least 1, got ", faces);
  if (remove != 0 && !(remove > 0 && remove < 1))
    return concat("remove must be above 0 % and below 100 %, got ", 100 * remove, " %");
  if (max_error != 0 && !(max_error > 0 && std::isfinite(max_error)))
    return concat("max_error must be above 0, got ", max_error);
  if (levels < 1 || levels > 100) return concat("levels must be 1 to 100, got ", levels);
  if (!(keep_edges >= 0 && keep_edges < kPi))
    return concat("keep_edges must be 0 or an angle below 180 degrees, got ", degrees(keep_edges));
  if (!(alpha >= 0 && std::isfinite(alpha))) return concat("alpha must be at least 0, got ", alpha);
  if (!(beta >= 0 && std::isfinite(beta))) return concat("beta must be at least 0, got ", beta);
  if (fit_rounds < 0) return concat("fit_rounds must be at least 0, got ", fit_rounds);
  return flow.problem();
}

std::vector<Eigen::Index> faces_per_level(Eigen::Index faces, Eigen::Index target, int levels) {
  std::vector<Eigen::Index> result;
  const double removed = static_cast<double>(std::max<Eigen::Index>(faces - target, 0));
  double share = 0;
  for (int k = 0; k + 1 < levels; ++k) {
    share += (3.0 * (levels - 1) - 2.0 * k) / (2.0 * levels * (levels - 1));
    result.push_back(faces - static_cast<Eigen::Index>(std::llround(share * removed)));
  }
  result.push_back(target);
  return result;
}

SimplifyResult simplify(const TriangleMesh& mesh, const SimplifyOptions& options, const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  if (options.max_error > 0) {
    if (mesh.n_triangles() == 0) throw InvalidInput("the mesh has no faces: there is nothing to simplify");
    return simplify_within(mesh, options, progress);
  }
  if (mesh.n_triangles() == 0) throw InvalidInput("the mesh has no faces: there is nothing to simplify");
  const Eigen::Index target =
      options.faces > 0
          ? options.faces
          : std::max<Eigen::Index>(1, static_cast<Eigen::Index>(std::floor(
                                          (1 - options.remove) * double(mesh.n_triangles()) + 1e-6)));
  return Simplification(mesh, options, progress).run(target);
}

}  // namespace batten
