#include "batten/remeshing/normal_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

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
            const ReferenceSamples& reference, const NormalFitOptions& options)
      : state_(state),
        mesh_(state.mesh),
        features_(features),
        X_(X),
        T_(T),
        options_(options),
        creases_(creases(X, T, kCreaseAngle)) {
    const HalfedgeMesh::Compact compact = mesh_.compacted();
    for (const int v : spatial_order(compact.positions)) vertices_.push_back(compact.vertices[v]);
    faces_.reserve(compact.faces.size());
    std::vector<char> seen(mesh_.face_capacity(), 0);
    for (const int v : vertices_)
      mesh_.for_each_outgoing(v, [&](int h) {
        const int f = HalfedgeMesh::face(h);
        if (seen[f] == 0) faces_.push_back(f);
        seen[f] = 1;
      });
    // Samples in the order of their faces: what is used together lies together.
    std::vector<int> first(mesh_.face_capacity() + 1, 0);
    for (const ClosestPoint& nearest : reference.nearest) ++first[compact.faces[nearest.element]];
    int total = 0;
    for (const int f : faces_) total += std::exchange(first[f], total);
    samples_.resize(reference.samples.size());
    of_face_.resize(mesh_.face_capacity());
    for (std::size_t s = 0; s < samples_.size(); ++s) {
      const int f = compact.faces[reference.nearest[s].element];
      const AreaSample& sample = reference.samples[s];
      const Vector3d n = mesh_.area_normal(f);
      samples_[first[f]] = sample;
      if (n.dot(sample.normal) > kSameSide * n.norm()) of_face_[f].push_back(first[f]);
      ++first[f];
    }
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
      progress.report("fitting normals", static_cast<double>(round) / options_.rounds);
      next_.assign(mesh_.vertex_capacity(), 0);
      int count = 0;
      for (const int f : faces_)
        for (int h = 3 * f; h < 3 * f + 3; ++h) {
          if (!mesh_.is_representative(h) || mesh_.is_border_edge(h) || mesh_.is_marked(h)) continue;
          if (changed[mesh_.from(h)] == 0 && changed[mesh_.to(h)] == 0) continue;
          count += try_flip(h) ? 1 : 0;
        }
      for (const int v : vertices_)
        if (changed[v] == kChanged || next_[v] != 0 || (changed[v] == kReweighted && exact_[v] == 0))
          count += try_moves(v) ? 1 : 0;
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

  double point_cost(const AreaSample& s, const Vector3d& normal, const Vector3d& on_plane,
                    double length) const {
    return s.area * ((s.normal - normal).norm() +
                     options_.distance * std::abs(normal.dot(s.point - on_plane)) / length);
  }
  double shape_cost(double sine, double length) const {
    return shape_ * 0.433 * length * length * (kPi / 3 - std::asin(std::min(1.0, sine)));
  }

  double mean_smallest_angle() const {
    double sum = 0;
    for (int f = 0; f < mesh_.face_capacity(); ++f) {
      if (!mesh_.has_face(f)) continue;
      const Vector3d &a = mesh_.position(mesh_.from(3 * f)), &b = mesh_.position(mesh_.from(3 * f + 1)),
                     &c = mesh_.position(mesh_.from(3 * f + 2));
      const double sine = sine_of_smallest_angle(mesh_.area_normal(f).norm(), (b - a).squaredNorm(),
                                                 (c - b).squaredNorm(), (a - c).squaredNorm());
      if (sine > 0) sum += std::asin(std::min(1.0, sine));
    }
    return sum / std::max(1, mesh_.n_faces());
  }

  void gather(int v) {
    spokes_.clear();
    ring_samples_.clear();
    mesh_.for_each_outgoing(v, [&](int h) {
      Spoke spoke;
      spoke.b = mesh_.position(mesh_.to(h));
      spoke.c = mesh_.position(mesh_.tip(h));
      spoke.squared_far_side = (spoke.c - spoke.b).squaredNorm();
      spoke.face = HalfedgeMesh::face(h);
      spoke.normal = mesh_.area_normal(spoke.face);
      const double length = spoke.normal.norm();
      if (length > 0) spoke.normal /= length;
      spoke.sector = spokes_.empty() ? 0 : spokes_.back().sector + (mesh_.is_marked(h) ? 1 : 0);
      spokes_.push_back(spoke);
    });
    // The last sector goes on in the first unless a feature edge parts them.
    if (!mesh_.is_border_vertex(v) && !mesh_.is_marked(mesh_.outgoing(v))) {
      const int last = spokes_.back().sector;
      for (Spoke& spoke : spokes_)
        if (spoke.sector == last) spoke.sector = 0;
    }
    for (std::size_t k = 0; k < spokes_.size(); ++k)
      for (const int s : of_face_[spokes_[k].face])
        ring_samples_.push_back({samples_[s], s, static_cast<int>(k)});
    ring_area_ = 0;
    for (const RingSample& entry : ring_samples_) ring_area_ += entry.sample.area;
    has_sectors_ = false;
    for (const Spoke& spoke : spokes_) has_sectors_ = has_sectors_ || spoke.sector != spokes_[0].sector;
  }

  /// The spoke on which a sample lies for the trial, its offset from the vertex being p: the first that holds
  /// it, from the one where it is now, else the one that it is least outside of.
  std::size_t spoke_of(const RingSample& entry, const Vector3d& p) const {
    const auto first = static_cast<std::size_t>(entry.spoke);
    const std::size_t m = spokes_.size();
    std::size_t best = first;
    double best_margin = std::min(p.dot(trials_[first].after_b), p.dot(trials_[first].before_c));
    for (std::size_t step = 1; step < m && best_margin < 0; ++step) {
      const std::size_t k = first + step < m ? first + step : first + step - m;
      if (has_sectors_ && spokes_[k].sector != spokes_[first].sector) continue;
      const double margin = std::min(p.dot(trials_[k].after_b), p.dot(trials_[k].before_c));
      if (margin > best_margin) {
        best_margin = margin;
        best = k;
      }
    }
    return best;
  }

  /// The sum over the triangles around v with v at x; infinite where a triangle would be bad.
  /// @param least_sine of the smallest angles. @param bound above it the sum is of no interest: infinite is
  /// returned. Leaves the triangles in trials_, and in ring_shape_ what their shapes cost.
  double ring_cost(const Vector3d& x, double length, double least_sine, double bound) {
    const std::size_t m = spokes_.size();
    trials_.resize(m);
    double cost = 0;
    for (std::size_t k = 0; k < m; ++k) {
      const Spoke& spoke = spokes_[k];
      const Vector3d u = spoke.b - x, w = spoke.c - x;
      const Vector3d n = cross(u, w);
      const double doubled = n.norm();
      if (!(doubled > 0)) return kInfinity;
      Trial& trial = trials_[k];
      trial.normal = n / doubled;
      if (!(trial.normal.dot(spoke.normal) > kSameSide)) return kInfinity;
      const double sine =
          sine_of_smallest_angle(doubled, u.squaredNorm(), w.squaredNorm(), spoke.squared_far_side);
      if (sine < least_sine) return kInfinity;
      trial.after_b = cross(trial.normal, u);
      trial.before_c = cross(w, trial.normal);
      cost += shape_cost(sine, length);
    }
    ring_shape_ = cost;
    for (const RingSample& entry : ring_samples_) {
      if (cost > bound) return kInfinity;
      const Vector3d p = entry.sample.point - x;
      cost += point_cost(entry.sample, trials_[spoke_of(entry, p)].normal, x, length);
    }
    return cost;
  }

  double least_sine_of_ring(int v) const {
    double least = 1;
    const Vector3d& x = mesh_.position(v);
    for (const Spoke& spoke : spokes_) {
      const Vector3d u = spoke.b - x, w = spoke.c - x;
      least = std::min(least, sine_of_smallest_angle(cross(u, w).norm(), u.squaredNorm(), w.squaredNorm(),
                                                     spoke.squared_far_side));
    }
    return least;
  }

  bool try_moves(int v) {
    if (state_.corner[v] != kNone) return false;
    gather(v);
    const double length = state_.size[v];
    const Vector3d x = mesh_.position(v);
    const double least = std::min(least_sine_of_ring(v) - 1e-12, std::sin(options_.least_angle));
    const double before = ring_cost(x, length, least, kInfinity);
    if (!(before < kInfinity)) return false;
    exact_[v] = before - ring_shape_ <= kExact * ring_area_ ? 1 : 0;
    double best = before * (1 - 1e-6) - 1e-12 * length * length;
    Vector3d best_place = x;
    double best_arc = 0;
    const auto consider = [&](const Vector3d& candidate, double arc) {
      const double cost = ring_cost(candidate, length, least, best);
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
      if (exact_[v] == 0) try_free_places(x, length, consider);
      try_middle(x, consider);
    }
    if (best_place == x) return false;
    ring_cost(best_place, length, least, kInfinity);  // for its triangles
    mesh_.set_position(v, best_place);
    if (state_.chain[v] != kNone) state_.place[v] = best_arc;
    for (const Spoke& spoke : spokes_) of_face_[spoke.face].clear();
    for (const RingSample& entry : ring_samples_)
      of_face_[spokes_[spoke_of(entry, entry.sample.point - best_place)].face].push_back(entry.number);
    next_[v] = kChanged;
    mesh_.for_each_neighbour(v, [&](int u) { next_[u] = kChanged; });
    return true;
  }

  template <typename Consider>
  void try_free_places(const Vector3d& x, double length, Consider&& consider) {
    near_.clear();
    feet_.clear();
    Matrix3d A = Matrix3d::Zero();
    Vector3d right = Vector3d::Zero();
    double area = 0;
    const double reach = 0.36 * length * length;
    for (std::size_t i = 0; i < ring_samples_.size();) {
      // Samples of a triangle mostly come together, and have one plane.
      const AreaSample& sample = ring_samples_[i].sample;
      double piece = 0;
      for (; i < ring_samples_.size() && ring_samples_[i].sample.triangle == sample.triangle; ++i)
        piece += ring_samples_[i].sample.area;
      const Vector3d weighted = piece * sample.normal;
      A += weighted * sample.normal.transpose();
      right += sample.normal.dot(sample.point - x) * weighted;
      area += piece;
      std::array<Vector3d, 3> corners;
      for (int k = 0; k < 3; ++k) {
        corners[k] = X_.row(T_(sample.triangle, k));
        const double squared = (corners[k] - x).squaredNorm();
        if (squared > 0 && squared < reach) near_.offer({squared, T_(sample.triangle, k), corners[k]});
      }
      for (int k = 0; k < 3; ++k) {
        if (creases_[sample.triangle][k] == 0) continue;
        const Vector3d &a = corners[k], side = corners[(k + 1) % 3] - a;
        const double along = (x - a).dot(side) / side.squaredNorm();
        if (!(along > 0 && along < 1)) continue;
        const Vector3d foot = a + along * side;
        const double apart = (foot - x).squaredNorm();
        if (apart > 0 && apart < reach) feet_.offer({apart, 0, foot});
      }
    }
    for (int i = 0; i < feet_.size; ++i) consider(feet_.places[i].point, 0);
    for (int i = 0; i < near_.size; ++i) consider(near_.places[i].point, 0);
    // Where the planes meet: the weak pull to x decides along directions that they leave open.
    A.diagonal().array() += 1e-3 * area;
    consider(x + A.ldlt().solve(right), 0);
  }

  /// Half the way to the middle of the neighbours, in the surface.
  template <typename Consider>
  void try_middle(const Vector3d& x, Consider&& consider) {
    Vector3d middle = Vector3d::Zero(), normal = Vector3d::Zero();
    for (const Spoke& spoke : spokes_) {
      middle += spoke.b;
      normal += spoke.normal;
    }
    middle = middle / static_cast<double>(spokes_.size()) - x;
    if (normal.norm() > 0) {
      normal.normalize();
      middle -= normal.dot(middle) * normal;
      consider(x + 0.5 * middle, 0);
    }
  }

  bool try_flip(int h) {
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
    for (const int s : of_face_[f]) before += point_cost(samples_[s], normals[0], pu, length);
    for (const int s : of_face_[g]) before += point_cost(samples_[s], normals[1], pu, length);
    first_.clear();
    second_.clear();
    const Vector3d across = cross(mean, pw - pz);  // points to u
    for (const int face : {f, g})
      for (const int s : of_face_[face]) {
        const bool at_u = across.dot(samples_[s].point - pz) > 0;
        after += point_cost(samples_[s], normals[at_u ? 2 : 3], pz, length);
        (at_u ? first_ : second_).push_back(s);
      }
    if (!(after < before * (1 - 1e-6) - 1e-12 * length * length)) return false;
    if (!mesh_.can_flip(h)) return false;  // last, since it walks around vertices
    mesh_.flip(h);
    --valence_[u];
    --valence_[v];
    ++valence_[w];
    ++valence_[z];
    const int face_of_u = mesh_.tip(h) == u ? f : g;
    of_face_[face_of_u].swap(first_);
    of_face_[face_of_u == f ? g : f].swap(second_);
    for (const int vertex : {u, v, w, z}) next_[vertex] = kChanged;
    return true;
  }

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

  RemeshState& state_;
  HalfedgeMesh& mesh_;
  const FeatureChains& features_;
  const Points& X_;
  const Triangles& T_;
  NormalFitOptions options_;
  double shape_ = 0;                   ///< the weight now
  std::vector<int> vertices_, faces_;  ///< in an order that keeps neighbours together
  std::vector<AreaSample> samples_;
  std::vector<std::vector<int>> of_face_;  ///< samples per face
  std::vector<char> next_;                 ///< per vertex: to be looked at again
  std::vector<char> exact_;                ///< per vertex: nothing was left to fit when last looked at
  std::vector<Spoke> spokes_;
  std::vector<RingSample> ring_samples_;
  bool has_sectors_ = false;  ///< whether feature edges part the spokes
  double ring_area_ = 0;      ///< of the samples
  double ring_shape_ = 0;     ///< of the last ring_cost()
  std::vector<Trial> trials_;
  std::vector<int> first_, second_;
  std::vector<int> valence_;  ///< per vertex
  Nearest<3> near_;           ///< vertices of the reference
  Nearest<2> feet_;           ///< points on its creases
  std::vector<std::array<char, 3>> creases_;
};

}  // namespace

int fit_normals(RemeshState& state, const FeatureChains& features, const Points& reference_positions,
                const Triangles& reference_triangles, const ReferenceSamples& reference,
                const NormalFitOptions& options, const Progress& progress) {
  if (options.rounds == 0) return 0;
  return NormalFit(state, features, reference_positions, reference_triangles, reference, options)
      .run(progress);
}

}  // namespace batten
