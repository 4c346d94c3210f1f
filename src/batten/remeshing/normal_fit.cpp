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

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kNone = HalfedgeMesh::kNone;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Points whose normal differs from that of the nearest triangle by more than 60° lie on the other side of an
/// edge; a triangle may not turn by more in one move.
constexpr double kSameSide = 0.5;
/// By which the logarithm of the shape weight falls per radian of mean angle in excess: about halved at 2°.
constexpr double kGain = 20;
/// Edges of the reference that turn by more than this are worth a vertex on them.
constexpr double kCreaseAngle = radians(4.0);
/// Vertices of one block: blocks are worked on in parallel, and what lies between them afterwards, by one
/// thread. Some 7 % of the vertices of a block have neighbours in another.
constexpr Eigen::Index kBlock = 4096;
constexpr std::size_t kSamplesPerReport = 1 << 17;  ///< some 20 ms
/// Around a vertex with a smaller mean error of the normals (and distances), radians, there is nothing to
/// fit.
constexpr double kExact = 1e-3;

Vector3d cross(const Vector3d& u, const Vector3d& v) {
  return {u.y() * v.z() - u.z() * v.y(), u.z() * v.x() - u.x() * v.z(), u.x() * v.y() - u.y() * v.x()};
}

/// The sine of the smallest angle, which lies between the two longest sides.
double sine_of_smallest_angle(double doubled_area, double uu, double vv, double ww) {
  const double longest_two = uu <= vv && uu <= ww ? vv * ww : (vv <= ww ? uu * ww : uu * vv);
  return doubled_area / std::sqrt(longest_two);
}

/// Per corner k of every triangle: 1 where the edge to the next corner turns by more than `angle` radians.
std::vector<std::array<char, 3>> creases(const Points& X, const Triangles& T, double angle) {
  struct Side {
    int low, high, triangle, corner;
    bool operator<(const Side& other) const {
      return std::tie(low, high, triangle) < std::tie(other.low, other.high, other.triangle);
    }
  };
  std::vector<Side> sides;
  sides.reserve(3 * T.rows());
  std::vector<Vector3d> normals(T.rows());
  for (Eigen::Index f = 0; f < T.rows(); ++f) {
    normals[f] = cross(X.row(T(f, 1)) - X.row(T(f, 0)), X.row(T(f, 2)) - X.row(T(f, 0))).normalized();
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(T(f, k), T(f, (k + 1) % 3));
      sides.push_back({low, high, static_cast<int>(f), k});
    }
  }
  std::sort(sides.begin(), sides.end());
  std::vector<std::array<char, 3>> result(T.rows(), {0, 0, 0});
  const double cosine = std::cos(angle);
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    const Side &a = sides[i], &b = sides[i + 1];
    if (a.low == b.low && a.high == b.high && normals[a.triangle].dot(normals[b.triangle]) < cosine)
      result[a.triangle][a.corner] = result[b.triangle][b.corner] = 1;
  }
  return result;
}

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
        pieces_(std::move(reference.pieces)) {
    progress.report("creases", 0);
    creases_ = creases(X, T, kCreaseAngle);
    progress.report("order", 0.3);
    const HalfedgeMesh::Compact compact = mesh_.compacted();
    order_elements(compact);
    progress.report("samples", 0.6);
    sort_samples(reference, compact, progress.part("samples", 0.6, 0.9));
    valence_.assign(mesh_.vertex_capacity(), 0);
    for (int v = 0; v < mesh_.vertex_capacity(); ++v)
      if (mesh_.has_vertex(v)) valence_[v] = mesh_.valence(v);
  }

  int run(const Progress& progress) {
    std::vector<char> changed(mesh_.vertex_capacity(), kChanged);
    exact_.assign(mesh_.vertex_capacity(), 0);
    shape_ = options_.shape;
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
      shape_ = std::min(shape_ * factor, options_.shape);
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

  /// A triangle around the vertex: its two other corners and the sector between feature edges that it is in.
  struct Spoke {
    Vector3d b, c, normal;
    double squared_far_side;  ///< |c − b|²
    int face, sector;
  };
  /// The same with the vertex at a trial place x: a point p of its plane lies between the rays to b and c
  /// where (p − x) · after_b and (p − x) · before_c are both positive.
  struct Trial {
    Vector3d normal, after_b, before_c;
  };
  /// A sample on one of the triangles around the vertex.
  struct RingSample {
    AreaSample sample;
    int number;  ///< of the sample
    int spoke;
  };

  struct Place {
    double squared;  ///< distance from the vertex
    int number;      ///< tells apart places at the same distance
    Vector3d point;
  };
  /// The nearest `n` different places of those offered, nearest first. Places as far as another up to
  /// rounding, with the same number, are the same: an edge is seen from both of its triangles.
  template <int n>
  struct Nearest {
    std::array<Place, n> places;
    int size = 0;

    void clear() { size = 0; }
    void offer(const Place& place) {
      int at = size;
      while (at > 0 && before(place, places[at - 1])) --at;
      if (at == n || (at > 0 && same(places[at - 1], place)) || (at < size && same(place, places[at])))
        return;
      if (size < n) ++size;
      for (int i = size - 1; i > at; --i) places[i] = places[i - 1];
      places[at] = place;
    }
    static bool before(const Place& a, const Place& b) {
      return a.squared != b.squared ? a.squared < b.squared : a.number < b.number;
    }
    static bool same(const Place& a, const Place& b) {
      return a.number == b.number && b.squared <= a.squared * (1 + 1e-9);
    }
  };

  /// What is known of the triangles around one vertex or edge while it is looked at. Every thread has its
  /// own.
  struct Ring {
    std::vector<Spoke> spokes;
    std::vector<RingSample> ring_samples;
    bool has_sectors = false;  ///< whether feature edges part the spokes
    double ring_area = 0;      ///< of the samples
    double ring_shape = 0;     ///< of the last ring_cost()
    std::vector<Trial> trials;
    std::vector<int> first, second;  ///< samples of the two faces after a flip
    Nearest<3> near;                 ///< vertices of the reference
    Nearest<2> feet;                 ///< points on its creases
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

  /// Samples in the order of their faces: what is used together lies together.
  void sort_samples(ReferenceSamples& reference, const HalfedgeMesh::Compact& compact,
                    const Progress& progress) {
    std::vector<int> first(mesh_.face_capacity() + 1, 0);
    for (const int nearest : reference.nearest) ++first[compact.faces[nearest]];
    int total = 0;
    for (const int f : faces_) total += std::exchange(first[f], total);
    samples_.resize(reference.points.size());
    of_face_.resize(mesh_.face_capacity());
    for (std::size_t s = 0; s < samples_.size(); ++s) {
      if (s % kSamplesPerReport == 0)
        progress.report("samples", static_cast<double>(s) / static_cast<double>(samples_.size()));
      const int f = compact.faces[reference.nearest[s]];
      samples_[first[f]] = reference.points[s];
      const Vector3d n = mesh_.area_normal(f);
      if (n.dot(sample(first[f]).normal) > kSameSide * n.norm()) of_face_[f].push_back(first[f]);
      ++first[f];
    }
    reference = {};
  }

  AreaSample sample(int s) const {
    const SamplePoint& point = samples_[s];
    const SampledTriangle& piece = pieces_[point.triangle];
    return {point.point, piece.normal, piece.area, point.triangle};
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
          Ring ring;
          for (const int f : faces_of_block[block])
            for (int h = 3 * f; h < 3 * f + 3; ++h)
              if (may_flip(h, changed) && is_interior_edge(h)) counts[block] += try_flip(h, ring) ? 1 : 0;
        },
        progress.part("flips", 0, 0.8));
    int count = std::accumulate(counts.begin(), counts.end(), 0);
    progress.report("flips", 0.8);
    Ring ring;
    for (const int f : faces_)
      for (int h = 3 * f; h < 3 * f + 3; ++h)
        if (may_flip(h, changed) && !is_interior_edge(h)) count += try_flip(h, ring) ? 1 : 0;
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
          Ring ring;
          int& count = counts[begin / kBlock];
          for (Eigen::Index i = begin; i < end; ++i)
            if (const int v = vertices_[i]; interior_[v] != 0 && is_due(v))
              count += try_moves(v, ring) ? 1 : 0;
        },
        progress.part("moves", 0, 0.8));
    int count = std::accumulate(counts.begin(), counts.end(), 0);
    Ring ring;
    for (std::size_t i = 0; i < vertices_.size(); ++i) {
      if (i % kBlock == 0)
        progress.report("moves", 0.8 + 0.2 * static_cast<double>(i) / static_cast<double>(vertices_.size()));
      if (const int v = vertices_[i]; interior_[v] == 0 && is_due(v)) count += try_moves(v, ring) ? 1 : 0;
    }
    return count;
  }

  double point_cost(const AreaSample& s, const Vector3d& normal, const Vector3d& on_plane,
                    double length) const {
    return s.area * ((s.normal - normal).norm() +
                     options_.distance * std::abs(normal.dot(s.point - on_plane)) / length);
  }
  double shape_cost(double sine, double length) const {
    return shape_ * 0.433 * length * length * (kPi / 3 - std::asin(std::min(1.0, sine)));
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

  void gather(int v, Ring& ring) const {
    ring.spokes.clear();
    ring.ring_samples.clear();
    mesh_.for_each_outgoing(v, [&](int h) {
      Spoke spoke;
      spoke.b = mesh_.position(mesh_.to(h));
      spoke.c = mesh_.position(mesh_.tip(h));
      spoke.squared_far_side = (spoke.c - spoke.b).squaredNorm();
      spoke.face = HalfedgeMesh::face(h);
      spoke.normal = mesh_.area_normal(spoke.face);
      const double length = spoke.normal.norm();
      if (length > 0) spoke.normal /= length;
      spoke.sector = ring.spokes.empty() ? 0 : ring.spokes.back().sector + (mesh_.is_marked(h) ? 1 : 0);
      ring.spokes.push_back(spoke);
    });
    // The last sector goes on in the first unless a feature edge parts them.
    if (!mesh_.is_border_vertex(v) && !mesh_.is_marked(mesh_.outgoing(v))) {
      const int last = ring.spokes.back().sector;
      for (Spoke& spoke : ring.spokes)
        if (spoke.sector == last) spoke.sector = 0;
    }
    for (std::size_t k = 0; k < ring.spokes.size(); ++k)
      for (const int s : of_face_[ring.spokes[k].face])
        ring.ring_samples.push_back({sample(s), s, static_cast<int>(k)});
    ring.ring_area = 0;
    for (const RingSample& entry : ring.ring_samples) ring.ring_area += entry.sample.area;
    ring.has_sectors = false;
    for (const Spoke& spoke : ring.spokes)
      ring.has_sectors = ring.has_sectors || spoke.sector != ring.spokes[0].sector;
  }

  /// The spoke on which a sample lies for the trial, its offset from the vertex being p: the first that holds
  /// it, from the one where it is now, else the one that it is least outside of.
  static std::size_t spoke_of(const RingSample& entry, const Vector3d& p, const Ring& ring) {
    const auto first = static_cast<std::size_t>(entry.spoke);
    const std::size_t m = ring.spokes.size();
    std::size_t best = first;
    double best_margin = std::min(p.dot(ring.trials[first].after_b), p.dot(ring.trials[first].before_c));
    for (std::size_t step = 1; step < m && best_margin < 0; ++step) {
      const std::size_t k = first + step < m ? first + step : first + step - m;
      if (ring.has_sectors && ring.spokes[k].sector != ring.spokes[first].sector) continue;
      const double margin = std::min(p.dot(ring.trials[k].after_b), p.dot(ring.trials[k].before_c));
      if (margin > best_margin) {
        best_margin = margin;
        best = k;
      }
    }
    return best;
  }

  /// The sum over the triangles around v with v at x; infinite where a triangle would be bad.
  /// @param least_sine of the smallest angles. @param bound above it the sum is of no interest: infinite is
  /// returned. Leaves the triangles in ring.trials, and in ring.ring_shape what their shapes cost.
  double ring_cost(const Vector3d& x, double length, double least_sine, double bound, Ring& ring) const {
    const std::size_t m = ring.spokes.size();
    ring.trials.resize(m);
    double cost = 0;
    for (std::size_t k = 0; k < m; ++k) {
      const Spoke& spoke = ring.spokes[k];
      const Vector3d u = spoke.b - x, w = spoke.c - x;
      const Vector3d n = cross(u, w);
      const double doubled = n.norm();
      if (!(doubled > 0)) return kInfinity;
      Trial& trial = ring.trials[k];
      trial.normal = n / doubled;
      if (!(trial.normal.dot(spoke.normal) > kSameSide)) return kInfinity;
      const double sine =
          sine_of_smallest_angle(doubled, u.squaredNorm(), w.squaredNorm(), spoke.squared_far_side);
      if (sine < least_sine) return kInfinity;
      trial.after_b = cross(trial.normal, u);
      trial.before_c = cross(w, trial.normal);
      cost += shape_cost(sine, length);
    }
    ring.ring_shape = cost;
    for (const RingSample& entry : ring.ring_samples) {
      if (cost > bound) return kInfinity;
      const Vector3d p = entry.sample.point - x;
      cost += point_cost(entry.sample, ring.trials[spoke_of(entry, p, ring)].normal, x, length);
    }
    return cost;
  }

  double least_sine_of_ring(int v, const Ring& ring) const {
    double least = 1;
    const Vector3d& x = mesh_.position(v);
    for (const Spoke& spoke : ring.spokes) {
      const Vector3d u = spoke.b - x, w = spoke.c - x;
      least = std::min(least, sine_of_smallest_angle(cross(u, w).norm(), u.squaredNorm(), w.squaredNorm(),
                                                     spoke.squared_far_side));
    }
    return least;
  }

  bool try_moves(int v, Ring& ring) {
    if (state_.corner[v] != kNone) return false;
    gather(v, ring);
    const double length = state_.size[v];
    const Vector3d x = mesh_.position(v);
    const double least = std::min(least_sine_of_ring(v, ring) - 1e-12, std::sin(options_.least_angle));
    const double before = ring_cost(x, length, least, kInfinity, ring);
    if (!(before < kInfinity)) return false;
    exact_[v] = before - ring.ring_shape <= kExact * ring.ring_area ? 1 : 0;
    double best = before * (1 - 1e-6) - 1e-12 * length * length;
    Vector3d best_place = x;
    double best_arc = 0;
    const auto consider = [&](const Vector3d& candidate, double arc) {
      const double cost = ring_cost(candidate, length, least, best, ring);
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
      if (exact_[v] == 0) try_free_places(x, length, consider, ring);
      try_middle(x, consider, ring);
    }
    if (best_place == x) return false;
    ring_cost(best_place, length, least, kInfinity, ring);  // for its triangles
    mesh_.set_position(v, best_place);
    if (state_.chain[v] != kNone) state_.place[v] = best_arc;
    for (const Spoke& spoke : ring.spokes) of_face_[spoke.face].clear();
    for (const RingSample& entry : ring.ring_samples)
      of_face_[ring.spokes[spoke_of(entry, entry.sample.point - best_place, ring)].face].push_back(
          entry.number);
    next_[v] = kChanged;
    mesh_.for_each_neighbour(v, [&](int u) { next_[u] = kChanged; });
    return true;
  }

  template <typename Consider>
  void try_free_places(const Vector3d& x, double length, Consider&& consider, Ring& ring) {
    ring.near.clear();
    ring.feet.clear();
    Matrix3d A = Matrix3d::Zero();
    Vector3d right = Vector3d::Zero();
    double area = 0;
    const double reach = 0.36 * length * length;
    for (std::size_t i = 0; i < ring.ring_samples.size();) {
      // Samples of a triangle mostly come together, and have one plane.
      const AreaSample& sample = ring.ring_samples[i].sample;
      double piece = 0;
      for (; i < ring.ring_samples.size() && ring.ring_samples[i].sample.triangle == sample.triangle; ++i)
        piece += ring.ring_samples[i].sample.area;
      const Vector3d weighted = piece * sample.normal;
      A += weighted * sample.normal.transpose();
      right += sample.normal.dot(sample.point - x) * weighted;
      area += piece;
      std::array<Vector3d, 3> corners;
      for (int k = 0; k < 3; ++k) {
        corners[k] = X_.row(T_(sample.triangle, k));
        const double squared = (corners[k] - x).squaredNorm();
        if (squared > 0 && squared < reach) ring.near.offer({squared, T_(sample.triangle, k), corners[k]});
      }
      for (int k = 0; k < 3; ++k) {
        if (creases_[sample.triangle][k] == 0) continue;
        const Vector3d &a = corners[k], side = corners[(k + 1) % 3] - a;
        const double along = (x - a).dot(side) / side.squaredNorm();
        if (!(along > 0 && along < 1)) continue;
        const Vector3d foot = a + along * side;
        const double apart = (foot - x).squaredNorm();
        if (apart > 0 && apart < reach) ring.feet.offer({apart, 0, foot});
      }
    }
    for (int i = 0; i < ring.feet.size; ++i) consider(ring.feet.places[i].point, 0);
    for (int i = 0; i < ring.near.size; ++i) consider(ring.near.places[i].point, 0);
    // Where the planes meet: the weak pull to x decides along directions that they leave open.
    A.diagonal().array() += 1e-3 * area;
    consider(x + A.ldlt().solve(right), 0);
  }

  /// Half the way to the middle of the neighbours, in the surface.
  template <typename Consider>
  void try_middle(const Vector3d& x, Consider&& consider, const Ring& ring) {
    Vector3d middle = Vector3d::Zero(), normal = Vector3d::Zero();
    for (const Spoke& spoke : ring.spokes) {
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

  bool try_flip(int h, Ring& ring) {
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
    if (!(mean.dot(normals[2]) > kSameSide && mean.dot(normals[3]) > kSameSide)) return false;
    const double least = std::min({sines[0], sines[1], std::sin(options_.least_angle)});
    if (sines[2] < least || sines[3] < least) return false;
    const double length = 0.25 * (state_.size[u] + state_.size[v] + state_.size[w] + state_.size[z]);
    double before = shape_cost(sines[0], length) + shape_cost(sines[1], length);
    double after = shape_cost(sines[2], length) + shape_cost(sines[3], length);
    int valences = 0;
    for (const auto& [vertex, change] : {std::pair{u, -1}, {v, -1}, {w, 1}, {z, 1}})
      if (state_.is_free(vertex)) {
        const int excess = valence_[vertex] - 6;
        valences += (excess + change) * (excess + change) - excess * excess;
      }
    after += options_.valence * 0.433 * length * length * valences;
    for (const int s : of_face_[f]) before += point_cost(sample(s), normals[0], pu, length);
    for (const int s : of_face_[g]) before += point_cost(sample(s), normals[1], pu, length);
    ring.first.clear();
    ring.second.clear();
    const Vector3d across = cross(mean, pw - pz);  // points to u
    for (const int face : {f, g})
      for (const int s : of_face_[face]) {
        const bool at_u = across.dot(samples_[s].point - pz) > 0;
        after += point_cost(sample(s), normals[at_u ? 2 : 3], pz, length);
        (at_u ? ring.first : ring.second).push_back(s);
      }
    if (!(after < before * (1 - 1e-6) - 1e-12 * length * length)) return false;
    if (!mesh_.can_flip(h)) return false;  // last, since it walks around vertices
    mesh_.flip(h);
    --valence_[u];
    --valence_[v];
    ++valence_[w];
    ++valence_[z];
    const int face_of_u = mesh_.tip(h) == u ? f : g;
    of_face_[face_of_u].swap(ring.first);
    of_face_[face_of_u == f ? g : f].swap(ring.second);
    for (const int vertex : {u, v, w, z}) next_[vertex] = kChanged;
    return true;
  }

  RemeshState& state_;
  HalfedgeMesh& mesh_;
  const FeatureChains& features_;
  const Points& X_;
  const Triangles& T_;
  NormalFitOptions options_;
  double shape_ = 0;                   ///< the weight now
  std::vector<int> vertices_, faces_;  ///< in an order that keeps neighbours together
  std::vector<int> block_;             ///< per vertex
  std::vector<char> interior_;         ///< per vertex: all of its neighbours belong to its block
  int n_blocks_ = 0;
  std::vector<SampledTriangle> pieces_;  ///< per triangle of the reference
  std::vector<SamplePoint> samples_;
  std::vector<std::vector<int>> of_face_;  ///< samples per face
  std::vector<char> next_;                 ///< per vertex: to be looked at again
  std::vector<char> exact_;                ///< per vertex: nothing was left to fit when last looked at
  std::vector<int> valence_;               ///< per vertex
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
