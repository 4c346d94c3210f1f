#include "batten/remeshing/normal_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/parallel.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/spatial_order.hpp"
#include "batten/remeshing/area_samples.hpp"
#include "batten/remeshing/fit_ring_detail.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using remeshing::cross;
using remeshing::FitPlace;
using remeshing::sine_of_smallest_angle;

constexpr int kNone = HalfedgeMesh::kNone;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// By which the logarithm of the shape weight falls per radian of mean angle in excess: about halved at 2°.
constexpr double kGain = 20;
/// Edges of the reference that turn by more than this are worth a vertex on them.
constexpr double kCreaseAngle = radians(4.0);
/// Vertices of one block: blocks are worked on in parallel, and what lies between them afterwards, by one
/// thread. Some 7 % of the vertices of a block have neighbours in another.
constexpr Eigen::Index kBlock = 4096;
/// Around a vertex with a smaller mean error of the normals (and distances), radians, there is nothing to
/// fit.
constexpr double kExact = 1e-3;

class NormalFit {
 public:
  NormalFit(RemeshState& state, const FeatureChains& features, const Points& X, const Triangles& T,
            ReferenceSamples reference, const NormalFitOptions& options, const Progress& progress)
      : state_(state),
        mesh_(state.mesh),
        features_(features),
        X_(X),
        T_(T),
        options_(options),
        weights_{options.shape, options.distance} {
    progress.report("creases", 0);
    creases_ = remeshing::crease_corners(X, T, kCreaseAngle);
    progress.report("order", 0.3);
    const HalfedgeMesh::Compact compact = mesh_.compacted();
    order_elements(compact);
    progress.report("samples", 0.6);
    samples_.take(std::move(reference), mesh_, compact, faces_, progress.part("samples", 0.6, 0.9));
    valence_.assign(mesh_.vertex_capacity(), 0);
    for (int v = 0; v < mesh_.vertex_capacity(); ++v)
      if (mesh_.has_vertex(v)) valence_[v] = mesh_.valence(v);
  }

  int run(const Progress& progress) {
    std::vector<char> changed(mesh_.vertex_capacity(), kChanged);
    exact_.assign(mesh_.vertex_capacity(), 0);
    int total = 0;
    for (int round = 0; round < options_.rounds; ++round) {
      const Progress part = progress.part("fitting normals", static_cast<double>(round) / options_.rounds,
                                          (round + 1.0) / options_.rounds);
      next_.assign(mesh_.vertex_capacity(), 0);
      const int count = flip_edges(changed, part.part("flips", 0, 0.3)) +
                        move_vertices(changed, part.part("moves", 0.3, 1));
      total += count;
      const double excess = mean_smallest_angle() - options_.mean_angle;
      // The weight of the shape follows the angles: as low as they allow. All is looked at again where it
      // changed much.
      const double factor = std::clamp(std::exp(-kGain * excess), 0.4, 2.5);
      weights_.shape = std::min(weights_.shape * factor, options_.shape);
      changed.swap(next_);
      // A lower weight alone is no news where nothing is left to fit.
      if (std::abs(factor - 1) > 0.25)
        for (char& mark : changed) mark = mark == kChanged || factor > 1 ? kChanged : kReweighted;
      else if (count == 0)
        break;
    }
    return total;
  }

 private:
  /// Why a vertex is looked at again: something around it changed, or only the weight of the shape.
  static constexpr char kChanged = 1, kReweighted = 2;

  /// What a thread needs while it looks at a vertex or an edge.
  struct Workspace {
    remeshing::FitRing ring;
    std::vector<int> first, second;    ///< samples of the two faces after a flip
    remeshing::NearestPlaces<3> near;  ///< vertices of the reference
    remeshing::NearestPlaces<2> feet;  ///< points on its creases
  };

  /// Vertices and faces in an order that keeps neighbours together, and the block of each vertex.
  void order_elements(const HalfedgeMesh::Compact& compact) {
    for (const int v : spatial_order(compact.positions)) vertices_.push_back(compact.vertices[v]);
    block_.assign(mesh_.vertex_capacity(), 0);
    faces_.reserve(compact.faces.size());
    std::vector<char> seen(mesh_.face_capacity(), 0);
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      block_[vertices_[i]] = static_cast<int>(i / kBlock);
      mesh_.for_each_outgoing(vertices_[i], [&](int h) {
        const int f = HalfedgeMesh::face(h);
        if (seen[f] == 0) faces_.push_back(f);
        seen[f] = 1;
      });
    }
    n_blocks_ = static_cast<int>((vertices_.size() + kBlock - 1) / kBlock);
  }

  /// Marks the vertices all of whose neighbours belong to the same block. What one block does to them is not
  /// seen by any other.
  void mark_interior() {
    interior_.assign(mesh_.vertex_capacity(), 0);
    parallel_for(static_cast<Eigen::Index>(vertices_.size()), 4096,
                 [&](Eigen::Index begin, Eigen::Index end) {
                   for (Eigen::Index i = begin; i < end; ++i) {
                     const int v = vertices_[i];
                     bool inside = true;
                     mesh_.for_each_neighbour(v, [&](int u) { inside = inside && block_[u] == block_[v]; });
                     interior_[v] = inside ? 1 : 0;
                   }
                 });
  }

  /// Whether the two faces at h touch interior vertices only, which are then of one block.
  bool is_interior_edge(int h) const {
    return interior_[mesh_.from(h)] != 0 && interior_[mesh_.to(h)] != 0 && interior_[mesh_.tip(h)] != 0 &&
           interior_[mesh_.tip(mesh_.opposite(h))] != 0;
  }

  bool may_flip(int h, const std::vector<char>& changed) const {
    return mesh_.is_representative(h) && !mesh_.is_border_edge(h) && !mesh_.is_marked(h) &&
           (changed[mesh_.from(h)] != 0 || changed[mesh_.to(h)] != 0);
  }

  /// One pass over the edges: inside of the blocks, in parallel, then between them.
  int flip_edges(const std::vector<char>& changed, const Progress& progress) {
    mark_interior();
    // Faces may have come into another block since the last round, by flips between the blocks.
    std::vector<std::vector<int>> faces_of_block(n_blocks_);
    for (const int f : faces_) {
      const int v = mesh_.from(3 * f);
      if (interior_[v] != 0 && interior_[mesh_.from(3 * f + 1)] != 0 && interior_[mesh_.from(3 * f + 2)] != 0)
        faces_of_block[block_[v]].push_back(f);
    }
    std::vector<int> counts(n_blocks_, 0);
    parallel_for(
        n_blocks_, 1,
        [&](Eigen::Index block, Eigen::Index) {
          Workspace work;
          for (const int f : faces_of_block[block])
            for (int h = 3 * f; h < 3 * f + 3; ++h)
              if (may_flip(h, changed) && is_interior_edge(h)) counts[block] += try_flip(h, work) ? 1 : 0;
        },
        progress.part("flips", 0, 0.8));
    int count = std::accumulate(counts.begin(), counts.end(), 0);
    progress.report("flips", 0.8);
    Workspace work;
    for (const int f : faces_)
      for (int h = 3 * f; h < 3 * f + 3; ++h)
        if (may_flip(h, changed) && !is_interior_edge(h)) count += try_flip(h, work) ? 1 : 0;
    return count;
  }

  /// One pass over the vertices, in the same way.
  int move_vertices(const std::vector<char>& changed, const Progress& progress) {
    mark_interior();
    const auto is_due = [&](int v) {
      return changed[v] == kChanged || next_[v] != 0 || (changed[v] == kReweighted && exact_[v] == 0);
    };
    std::vector<int> counts(n_blocks_, 0);
    // Chunks of one block, so that several can be worked on and progress be told between them.
    parallel_for(
        static_cast<Eigen::Index>(vertices_.size()), kBlock,
        [&](Eigen::Index begin, Eigen::Index end) {
          Workspace work;
          int& count = counts[begin / kBlock];
          for (Eigen::Index i = begin; i < end; ++i)
            if (const int v = vertices_[i]; interior_[v] != 0 && is_due(v))
              count += try_moves(v, work) ? 1 : 0;
        },
        progress.part("moves", 0, 0.8));
    int count = std::accumulate(counts.begin(), counts.end(), 0);
    Workspace work;
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      if (i % kBlock == 0)
        progress.report("moves", 0.8 + 0.2 * static_cast<double>(i) / static_cast<double>(vertices_.size()));
      if (const int v = vertices_[i]; interior_[v] == 0 && is_due(v)) count += try_moves(v, work) ? 1 : 0;
    }
    return count;
  }

  double mean_smallest_angle() const {
    std::vector<double> angles(mesh_.face_capacity(), 0.0);
    parallel_for(mesh_.face_capacity(), 8192, [&](Eigen::Index begin, Eigen::Index end) {
      for (int f = static_cast<int>(begin); f < end; ++f) {
        if (!mesh_.has_face(f)) continue;
        const Vector3d &a = mesh_.position(mesh_.from(3 * f)), &b = mesh_.position(mesh_.from(3 * f + 1)),
                       &c = mesh_.position(mesh_.from(3 * f + 2));
        const double sine = sine_of_smallest_angle(mesh_.area_normal(f).norm(), (b - a).squaredNorm(),
                                                   (c - b).squaredNorm(), (a - c).squaredNorm());
        if (sine > 0) angles[f] = std::asin(std::min(1.0, sine));
      }
    });
    return std::accumulate(angles.begin(), angles.end(), 0.0) / std::max(1, mesh_.n_faces());
  }

  bool try_moves(int v, Workspace& work) {
    if (state_.corner[v] != kNone) return false;
    remeshing::FitRing& ring = work.ring;
    ring.gather(mesh_, samples_, v);
    const double length = state_.size[v];
    const Vector3d x = mesh_.position(v);
    const double least = std::min(ring.least_sine(x) - 1e-12, std::sin(options_.least_angle));
    const double before = ring.cost(x, length, least, kInfinity, weights_);
    if (!(before < kInfinity)) return false;
    exact_[v] = before - ring.shape <= kExact * ring.area ? 1 : 0;
    double best = before * (1 - 1e-6) - 1e-12 * length * length;
    Vector3d best_place = x;
    double best_arc = 0;
    const auto consider = [&](const Vector3d& candidate, double arc) {
      const double cost = ring.cost(candidate, length, least, best, weights_);
      if (cost < best) {
        best = cost;
        best_place = candidate;
        best_arc = arc;
      }
    };
    if (state_.chain[v] != kNone) {
      const FeatureChain& chain = features_.chains[state_.chain[v]];
      const auto after = std::lower_bound(chain.lengths.begin(), chain.lengths.end(), state_.place[v]);
      const auto i = after - chain.lengths.begin();
      for (auto k = i - 1; k <= i; ++k)
        if (k > 0 && k + 1 < static_cast<std::ptrdiff_t>(chain.lengths.size()) &&
            std::abs(chain.lengths[k] - state_.place[v]) < 0.5 * length)
          consider(chain.points[k], chain.lengths[k]);
    } else {
      if (exact_[v] == 0) try_free_places(x, length, consider, work);
      try_middle(x, consider, ring);
    }
    if (best_place == x) return false;
    ring.cost(best_place, length, least, kInfinity, weights_);  // for its triangles
    mesh_.set_position(v, best_place);
    if (state_.chain[v] != kNone) state_.place[v] = best_arc;
    for (const auto& spoke : ring.spokes) samples_.of_face(spoke.face).clear();
    for (const auto& entry : ring.entries)
      samples_.of_face(ring.spokes[ring.spoke_of(entry, entry.sample.point - best_place)].face)
          .push_back(entry.number);
    next_[v] = kChanged;
    mesh_.for_each_neighbour(v, [&](int u) { next_[u] = kChanged; });
    return true;
  }

  template <typename Consider>
  void try_free_places(const Vector3d& x, double length, Consider&& consider, Workspace& work) {
    const std::vector<remeshing::FitRing::Entry>& entries = work.ring.entries;
    work.near.clear();
    work.feet.clear();
    Matrix3d A = Matrix3d::Zero();
    Vector3d right = Vector3d::Zero();
    double area = 0;
    const double reach = 0.36 * length * length;
    for (std::size_t i = 0; i < entries.size();) {
      // Samples of a triangle mostly come together, and have one plane.
      const AreaSample& sample = entries[i].sample;
      double piece = 0;
      for (; i < entries.size() && entries[i].sample.triangle == sample.triangle; ++i)
        piece += entries[i].sample.area;
      const Vector3d weighted = piece * sample.normal;
      A += weighted * sample.normal.transpose();
      right += sample.normal.dot(sample.point - x) * weighted;
      area += piece;
      std::array<Vector3d, 3> corners;
      for (int k = 0; k < 3; ++k) {
        corners[k] = X_.row(T_(sample.triangle, k));
        const double squared = (corners[k] - x).squaredNorm();
        if (squared > 0 && squared < reach) work.near.offer({squared, T_(sample.triangle, k), corners[k]});
      }
      for (int k = 0; k < 3; ++k) {
        if (creases_[sample.triangle][k] == 0) continue;
        const Vector3d &a = corners[k], side = corners[(k + 1) % 3] - a;
        const double along = (x - a).dot(side) / side.squaredNorm();
        if (!(along > 0 && along < 1)) continue;
        const Vector3d foot = a + along * side;
        const double apart = (foot - x).squaredNorm();
        if (apart > 0 && apart < reach) work.feet.offer({apart, 0, foot});
      }
    }
    for (int i = 0; i < work.feet.size; ++i) consider(work.feet.places[i].point, 0);
    for (int i = 0; i < work.near.size; ++i) consider(work.near.places[i].point, 0);
    // Where the planes meet: the weak pull to x decides along directions that they leave open.
    A.diagonal().array() += 1e-3 * area;
    consider(x + A.ldlt().solve(right), 0);
  }

  /// Half the way to the middle of the neighbours, in the surface.
  template <typename Consider>
  void try_middle(const Vector3d& x, Consider&& consider, const remeshing::FitRing& ring) {
    Vector3d middle = Vector3d::Zero(), normal = Vector3d::Zero();
    for (const auto& spoke : ring.spokes) {
      middle += spoke.b;
      normal += spoke.normal;
    }
    middle = middle / static_cast<double>(ring.spokes.size()) - x;
    if (normal.norm() > 0) {
      normal.normalize();
      middle -= normal.dot(middle) * normal;
      consider(x + 0.5 * middle, 0);
    }
  }

  bool try_flip(int h, Workspace& work) {
    const int o = mesh_.opposite(h);
    const int u = mesh_.from(h), v = mesh_.to(h), w = mesh_.tip(h), z = mesh_.tip(o);
    if ((valence_[u] <= 3 && !mesh_.is_border_vertex(u)) || (valence_[v] <= 3 && !mesh_.is_border_vertex(v)))
      return false;
    const int f = HalfedgeMesh::face(h), g = HalfedgeMesh::face(o);
    const Vector3d &pu = mesh_.position(u), &pv = mesh_.position(v), &pw = mesh_.position(w),
                   &pz = mesh_.position(z);
    // Before: u v w and v u z. After: u z w and z v w.
    const std::array<std::array<Vector3d, 3>, 4> corners = {
        {{pu, pv, pw}, {pv, pu, pz}, {pu, pz, pw}, {pz, pv, pw}}};
    std::array<Vector3d, 4> normals;
    std::array<double, 4> sines{};
    for (int k = 0; k < 4; ++k) {
      const Vector3d a = corners[k][1] - corners[k][0], b = corners[k][2] - corners[k][0];
      normals[k] = cross(a, b);
      const double doubled = normals[k].norm();
      if (!(doubled > 0)) return false;
      normals[k] /= doubled;
      sines[k] = sine_of_smallest_angle(doubled, a.squaredNorm(), b.squaredNorm(), (b - a).squaredNorm());
    }
    const Vector3d mean = (normals[0] + normals[1]).normalized();
    if (!(mean.dot(normals[2]) > remeshing::kSameSide && mean.dot(normals[3]) > remeshing::kSameSide))
      return false;
    const double least = std::min({sines[0], sines[1], std::sin(options_.least_angle)});
    if (sines[2] < least || sines[3] < least) return false;
    const double length = 0.25 * (state_.size[u] + state_.size[v] + state_.size[w] + state_.size[z]);
    double before = weights_.of_shape(sines[0], length) + weights_.of_shape(sines[1], length);
    double after = weights_.of_shape(sines[2], length) + weights_.of_shape(sines[3], length);
    int valences = 0;
    for (const auto& [vertex, change] : {std::pair{u, -1}, {v, -1}, {w, 1}, {z, 1}})
      if (state_.is_free(vertex)) {
        const int excess = valence_[vertex] - 6;
        valences += (excess + change) * (excess + change) - excess * excess;
      }
    after += options_.valence * 0.433 * length * length * valences;
    for (const int s : samples_.of_face(f)) before += weights_.of_point(samples_[s], normals[0], pu, length);
    for (const int s : samples_.of_face(g)) before += weights_.of_point(samples_[s], normals[1], pu, length);
    work.first.clear();
    work.second.clear();
    const Vector3d across = cross(mean, pw - pz);  // points to u
    for (const int face : {f, g})
      for (const int s : samples_.of_face(face)) {
        const bool at_u = across.dot(samples_.point(s) - pz) > 0;
        after += weights_.of_point(samples_[s], normals[at_u ? 2 : 3], pz, length);
        (at_u ? work.first : work.second).push_back(s);
      }
    if (!(after < before * (1 - 1e-6) - 1e-12 * length * length)) return false;
    if (!mesh_.can_flip(h)) return false;  // last, since it walks around vertices
    mesh_.flip(h);
    --valence_[u];
    --valence_[v];
    ++valence_[w];
    ++valence_[z];
    const int face_of_u = mesh_.tip(h) == u ? f : g;
    samples_.of_face(face_of_u).swap(work.first);
    samples_.of_face(face_of_u == f ? g : f).swap(work.second);
    for (const int vertex : {u, v, w, z}) next_[vertex] = kChanged;
    return true;
  }

  RemeshState& state_;
  HalfedgeMesh& mesh_;
  const FeatureChains& features_;
  const Points& X_;
  const Triangles& T_;
  NormalFitOptions options_;
  remeshing::FitWeights weights_;      ///< the shape's changes from round to round
  std::vector<int> vertices_, faces_;  ///< in an order that keeps neighbours together
  std::vector<int> block_;             ///< per vertex
  std::vector<char> interior_;         ///< per vertex: all of its neighbours belong to its block
  int n_blocks_ = 0;
  remeshing::FitSamples samples_;
  std::vector<char> next_;    ///< per vertex: to be looked at again
  std::vector<char> exact_;   ///< per vertex: nothing was left to fit when last looked at
  std::vector<int> valence_;  ///< per vertex
  std::vector<std::array<char, 3>> creases_;
};

}  // namespace

std::optional<std::string> NormalFitOptions::problem() const {
  const std::pair<const char*, double> weights[] = {
      {"shape", shape}, {"distance", distance}, {"valence", valence}};
  for (const auto& [name, value] : weights)
    if (!(value >= 0) || !std::isfinite(value)) return concat(name, " must be >= 0, got ", value);
  if (!(mean_angle >= 0 && mean_angle <= kPi / 3))
    return concat("mean_angle must be 0 to π/3, got ", mean_angle);
  if (!(least_angle >= 0 && least_angle <= kPi / 3))
    return concat("least_angle must be 0 to π/3, got ", least_angle);
  if (rounds < 0) return concat("rounds must be >= 0, got ", rounds);
  return std::nullopt;
}

int fit_normals(RemeshState& state, const FeatureChains& features, const Points& reference_positions,
                const Triangles& reference_triangles, ReferenceSamples reference,
                const NormalFitOptions& options, const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  if (options.rounds == 0) return 0;
  return NormalFit(state, features, reference_positions, reference_triangles, std::move(reference), options,
                   progress.part("fitting normals", 0, 0.1))
      .run(progress.part("fitting normals", 0.1, 1));
}

}  // namespace batten
