#include "batten/modelling/spline_faces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SparseCore>

#include "batten/core/disjoint_sets.hpp"
#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/linalg/sparse_cholesky.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/welding.hpp"
#include "batten/modelling/quad_layout_detail.hpp"
#include "batten/modelling/spline_controls_detail.hpp"

namespace batten {

namespace {

using detail::clamped_knots;
using detail::LayoutEdge;
using detail::LayoutQuad;
using detail::LayoutSample;
using detail::QuadLayout;
using detail::spline_basis;
using Eigen::Vector3d;

constexpr int kRounds = 5;           ///< with twice the knots where they do not suffice
constexpr int kFirstSpans = 4;       ///< along a side
constexpr int kPlainSteps = 2;       ///< solves in turns with the parameters
constexpr int kTangentSteps = 5;     ///< solves in turns with the common normals
constexpr double kSmoothing = 1e-5;  ///< of second differences, against one sample per cell
/// Weight of the sine between a derivative and the common tangent plane, in diameters: 0.1° counts as much as
/// a distance of 5e-4 diameters.
constexpr double kTangentWeight = 0.3;
/// Weight of the way from the last solution while tangent planes are made one: without it rows of control
/// points close up beside corners where no bicubic faces have the same planes, which fulfils the condition
/// and nothing else.
constexpr double kDamping = 0.3;
constexpr double kInnerWeight = 0.02;  ///< of points inside triangles, against vertices
constexpr int kTangentSamples = 4;     ///< per span of an edge
/// Samples per span below which more knots would follow the triangles instead of the surface.
constexpr double kSamplesPerSpan = 2.5;

class FaceFitter : private detail::SplineControls {
 public:
  FaceFitter(QuadLayout layout, double diameter, const SplineFacesOptions& options)
      : SplineControls(std::move(layout)), options_(options), diameter_(diameter) {
    limit_spans();
  }

  SplineFaces fit(const Progress& progress) {
    for (int round = 0; round < kRounds; ++round) {
      const Progress part =
          progress.part("fit", static_cast<double>(round) / kRounds, (round + 1.0) / kRounds);
      number_controls();
      part.report("fit", 0);
      for (int step = 0; step < kPlainSteps; ++step) {
        solve(assembled());
        find_parameters();
      }
      make_smooth(assembled(), part);
      find_parameters();
      if (!refine()) break;
    }
    return result();
  }

 private:
  /// Points inside triangles lie beside a bent surface: they only say where it is where there are no
  /// vertices.
  bool is_vertex(const LayoutSample& sample) const { return sample.point < layout_.n_vertices; }

  /// As many spans as the samples along a side determine.
  void limit_spans() {
    std::vector<int> count(layout_.quads.size(), 0);
    for (const LayoutSample& sample : layout_.samples)
      if (is_vertex(sample)) ++count[at(sample.quad)];
    // Lengths along u and v by the spread of positions over that of parameters.
    std::vector<std::array<double, 4>> sums(layout_.quads.size(), {0, 0, 0, 0});
    std::vector<LayoutSample> last(layout_.quads.size(), LayoutSample{-1, 0, 0, 0});
    for (const LayoutSample& sample : layout_.samples) {
      if (!is_vertex(sample)) continue;
      LayoutSample& before = last[at(sample.quad)];
      if (before.point < 0) before = sample;
      const double du = std::abs(sample.u - before.u), dv = std::abs(sample.v - before.v);
      const double length = (layout_.points.row(sample.point) - layout_.points.row(before.point)).norm();
      std::array<double, 4>& sum = sums[at(sample.quad)];
      if (du > 2 * dv) sum[0] += length, sum[1] += du;
      if (dv > 2 * du) sum[2] += length, sum[3] += dv;
      before = sample;
    }
    limit_.assign(layout_.edges.size(), 1);
    for (std::size_t q = 0; q < layout_.quads.size(); ++q) {
      const std::array<double, 4>& sum = sums[q];
      const double along_u = sum[1] > 0 ? sum[0] / sum[1] : 1, along_v = sum[3] > 0 ? sum[2] / sum[3] : 1;
      const double aspect = along_v > 0 && along_u > 0 ? std::clamp(along_u / along_v, 0.05, 20.0) : 1;
      const double n = count[q];
      const int in_u = static_cast<int>(std::sqrt(n * aspect) / kSamplesPerSpan);
      const int in_v = static_cast<int>(std::sqrt(n / aspect) / kSamplesPerSpan);
      for (int k = 0; k < 2; ++k) {
        int& limit = limit_[at(class_[at(layout_.quads[q].edges[at(k)])])];
        limit = std::max(limit, std::min(k == 0 ? in_u : in_v, options_.most_spans));
      }
    }
    spans_.resize(layout_.edges.size());
    for (std::size_t e = 0; e < spans_.size(); ++e) spans_[e] = std::min(kFirstSpans, limit_[e]);
  }

  /// Least squares of the distances of the samples at their parameters, and of second differences.
  struct System {
    SparseMatrix matrix;
    Points right;
  };
  System assembled() const {
    const Eigen::Index n = controls_.rows();
    System system{SparseMatrix(n, n), Points::Zero(n, 3)};
    std::vector<Eigen::Triplet<double>> entries;
    add_samples(entries, system.right);
    add_smoothing(entries);
    system.matrix.setFromTriplets(entries.begin(), entries.end());
    return system;
  }

  void solve(const System& system) {
    SparseCholesky factor("fit of B-spline faces");
    factor.factorize(system.matrix);
    controls_ = factor.solve(system.right);
  }

  /// Also with the normals' common plane along smooth edges, in turns with these planes.
  void make_smooth(const System& system, const Progress& progress) {
    const Eigen::Index n = controls_.rows();
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(static_cast<std::size_t>(3 * (system.matrix.nonZeros() + n)));
    for (int c = 0; c < system.matrix.outerSize(); ++c)
      for (SparseMatrix::InnerIterator entry(system.matrix, c); entry; ++entry)
        for (int d = 0; d < 3; ++d)
          entries.emplace_back(3 * static_cast<int>(entry.row()) + d, 3 * static_cast<int>(entry.col()) + d,
                               entry.value());
    for (Eigen::Index i = 0; i < 3 * n; ++i)
      entries.emplace_back(static_cast<int>(i), static_cast<int>(i), kDamping);
    SparseMatrix distances(3 * n, 3 * n), planes(3 * n, 3 * n);
    distances.setFromTriplets(entries.begin(), entries.end());
    SparseCholesky factor("fit of B-spline faces with common tangent planes");
    for (int step = 0; step < kTangentSteps; ++step) {
      progress.report("fit", (step + 1.0) / (kTangentSteps + 1));
      entries.clear();
      const std::vector<Vector3d> corner_normals = normals_at_corners();
      for (std::size_t e = 0; e < layout_.edges.size(); ++e)
        if (layout_.edges[e].quads[1] >= 0 && !layout_.edges[e].is_sharp)
          add_tangents(e, corner_normals, entries);
      planes.setFromTriplets(entries.begin(), entries.end());
      factor.factorize(distances + planes);
      Eigen::VectorXd right(3 * n);
      for (Eigen::Index i = 0; i < n; ++i)
        right.segment<3>(3 * i) = (system.right.row(i) + kDamping * controls_.row(i)).transpose();
      const Eigen::VectorXd solution = factor.solve(right);
      for (Eigen::Index i = 0; i < n; ++i) controls_.row(i) = solution.segment<3>(3 * i).transpose();
    }
  }

  void add_samples(std::vector<Eigen::Triplet<double>>& entries, Points& right) const {
    using Cell = Eigen::Matrix<double, 16, 16>;
    std::vector<std::vector<int>> samples_of(layout_.quads.size());
    for (std::size_t s = 0; s < layout_.samples.size(); ++s)
      samples_of[at(layout_.samples[s].quad)].push_back(static_cast<int>(s));
    for (std::size_t q = 0; q < layout_.quads.size(); ++q) {
      const LayoutQuad& quad = layout_.quads[q];
      const int ku = spans_u(quad), kv = spans_v(quad);
      std::vector<Cell> cells(at(ku * kv), Cell::Zero());
      const double per_sample =
          static_cast<double>(ku * kv) / std::max<double>(1, static_cast<double>(samples_of[q].size()));
      for (const int s : samples_of[q]) {
        const LayoutSample& sample = layout_.samples[at(s)];
        const CubicBasis a = spline_basis(sample.u, ku), b = spline_basis(sample.v, kv);
        const double weight = (is_vertex(sample) ? 1 : kInnerWeight) * per_sample;
        Eigen::Matrix<double, 16, 1> row;
        for (int j = 0; j < 4; ++j)
          for (int i = 0; i < 4; ++i) {
            row[4 * j + i] = a.values[at(i)] * b.values[at(j)];
            right.row(control(q, a.first + i, b.first + j)) +=
                weight * row[4 * j + i] * layout_.points.row(sample.point);
          }
        cells[at(b.first * ku + a.first)] += weight * row * row.transpose();
      }
      for (int cv = 0; cv < kv; ++cv)
        for (int cu = 0; cu < ku; ++cu) {
          std::array<int, 16> numbers{};
          for (int j = 0; j < 4; ++j)
            for (int i = 0; i < 4; ++i) numbers[at(4 * j + i)] = control(q, cu + i, cv + j);
          const Cell& cell = cells[at(cv * ku + cu)];
          for (int i = 0; i < 16; ++i)
            for (int j = 0; j < 16; ++j) entries.emplace_back(numbers[at(i)], numbers[at(j)], cell(i, j));
        }
    }
  }

  void add_smoothing(std::vector<Eigen::Triplet<double>>& entries) const {
    for (std::size_t q = 0; q < layout_.quads.size(); ++q) {
      const int nu = spans_u(layout_.quads[q]) + 3, nv = spans_v(layout_.quads[q]) + 3;
      const auto add = [&](const std::array<int, 3>& numbers, const std::array<double, 3>& weights) {
        for (std::size_t i = 0; i < 3; ++i)
          for (std::size_t j = 0; j < 3; ++j)
            entries.emplace_back(numbers[i], numbers[j], kSmoothing * weights[i] * weights[j]);
      };
      for (int j = 0; j < nv; ++j)
        for (int i = 0; i < nu; ++i) {
          if (i + 2 < nu)
            add({control(q, i, j), control(q, i + 1, j), control(q, i + 2, j)}, second_differences(i, nu));
          if (j + 2 < nv)
            add({control(q, i, j), control(q, i, j + 1), control(q, i, j + 2)}, second_differences(j, nv));
        }
    }
  }

  /// Weights of control points i to i + 2 of n in their second difference, which vanishes where they lie
  /// evenly over their Greville abscissae; 1, −2, 1 where the knots are even.
  static std::array<double, 3> second_differences(int i, int n) {
    const std::vector<double> knots = clamped_knots(n - 3);
    const auto place = [&](int k) { return (knots[at(k + 1)] + knots[at(k + 2)] + knots[at(k + 3)]) / 3; };
    const double a = place(i + 1) - place(i), b = place(i + 2) - place(i + 1), square = (a + b) * (a + b) / 4;
    return {2 * square / (a * (a + b)), -2 * square / (a * b), 2 * square / (b * (a + b))};
  }

  /// The mean normals of the faces at each corner, zero where they do not have one: beside sharp edges.
  std::vector<Vector3d> normals_at_corners() const {
    std::vector<Vector3d> normals(at(layout_.n_corners), Vector3d::Zero());
    for (std::size_t q = 0; q < layout_.quads.size(); ++q)
      for (int k = 0; k < 4; ++k) normals[at(layout_.quads[q].corners[at(k)])] += normal_at(q, k, 0);
    for (const LayoutEdge& edge : layout_.edges)
      if (edge.is_sharp)
        for (const int corner : edge.corners) normals[at(corner)].setZero();
    for (Vector3d& normal : normals)
      normal = normal.norm() > 0.1 ? Vector3d(normal.normalized()) : Vector3d(0, 0, 0);
    return normals;
  }

  /// Rows n · ∂P/∂(inwards) = 0 for both faces at an edge, n the mean of their normals in the last solution;
  /// near the ends it turns towards that of all faces there, or the conditions of the edges of a corner would
  /// differ.
  void add_tangents(std::size_t e, const std::vector<Vector3d>& corner_normals,
                    std::vector<Eigen::Triplet<double>>& entries) const {
    const LayoutEdge& edge = layout_.edges[e];
    const auto mean_normal = [&](double t) {
      Vector3d normal = Vector3d::Zero();
      for (int k = 0; k < 2; ++k) {
        const bool along = runs_along(layout_.quads[at(edge.quads[at(k)])], edge.sides[at(k)]);
        normal += normal_at(at(edge.quads[at(k)]), edge.sides[at(k)], along ? t : 1 - t);
      }
      return Vector3d(normal / 2);
    };
    std::array<Vector3d, 2> turn;
    for (int k = 0; k < 2; ++k) {
      const Vector3d& wanted = corner_normals[at(edge.corners[at(k)])];
      turn[at(k)] = wanted.isZero() ? wanted : Vector3d(wanted - mean_normal(k).normalized());
    }
    const int spans = spans_of_edge(static_cast<int>(e)), n = kTangentSamples * spans;
    for (int s = 0; s <= n; ++s) {
      const double t = static_cast<double>(s) / n;
      std::array<double, 2> along{};
      for (int k = 0; k < 2; ++k)
        along[at(k)] = runs_along(layout_.quads[at(edge.quads[at(k)])], edge.sides[at(k)]) ? t : 1 - t;
      Vector3d normal = mean_normal(t);
      if (!(normal.norm() > 0.1)) continue;  // faces that fold onto each other have no common plane
      normal = (normal.normalized() + std::pow(1 - t, 3) * turn[0] + std::pow(t, 3) * turn[1]).normalized();
      for (int k = 0; k < 2; ++k)
        add_tangent(at(edge.quads[at(k)]), edge.sides[at(k)], along[at(k)], normal, entries);
    }
  }

  void add_tangent(std::size_t q, int side, double t, const Vector3d& normal,
                   std::vector<Eigen::Triplet<double>>& entries) const {
    const LayoutQuad& quad = layout_.quads[q];
    const int nu = spans_u(quad) + 3, nv = spans_v(quad) + 3;
    const CubicBasis basis = spline_basis(t, spans_of_edge(quad.edges[at(side)]));
    // Control point i along the side, in its outermost row or the next.
    const auto number = [&](int i, int row) {
      switch (side) {
        case 0:
          return control(q, i, row);
        case 1:
          return control(q, nu - 1 - row, i);
        case 2:
          return control(q, nu - 1 - i, nv - 1 - row);
        default:
          return control(q, row, nv - 1 - i);
      }
    };
    std::array<int, 8> numbers{};
    std::array<double, 8> weights{};
    Vector3d inwards = Vector3d::Zero();
    for (int i = 0; i < 4; ++i)
      for (int row = 0; row < 2; ++row) {
        numbers[at(2 * i + row)] = number(basis.first + i, row);
        weights[at(2 * i + row)] = row == 1 ? basis.values[at(i)] : -basis.values[at(i)];
        inwards += weights[at(2 * i + row)] * controls_.row(numbers[at(2 * i + row)]).transpose();
      }
    if (!(inwards.norm() > 1e-9 * diameter_)) return;
    const double scale = kTangentWeight * diameter_ / inwards.norm();
    for (int i = 0; i < 8; ++i)
      for (int j = 0; j < 8; ++j)
        for (int c = 0; c < 3; ++c)
          for (int d = 0; d < 3; ++d)
            entries.emplace_back(3 * numbers[at(i)] + c, 3 * numbers[at(j)] + d,
                                 scale * scale * weights[at(i)] * weights[at(j)] * normal[c] * normal[d]);
  }

  /// The nearest point on the face of each sample, or on the next one where it has left its own.
  void find_parameters() {
    distance_.resize(layout_.samples.size());
    for (std::size_t s = 0; s < layout_.samples.size(); ++s) {
      LayoutSample& sample = layout_.samples[s];
      double nearest = nearest_point(sample);
      const LayoutQuad& quad = layout_.quads[at(sample.quad)];
      for (int k = 0; k < 4; ++k) {
        const LayoutEdge& edge = layout_.edges[at(quad.edges[at(k)])];
        const double away = k == 0 ? sample.v : k == 1 ? 1 - sample.u : k == 2 ? 1 - sample.v : sample.u;
        if (away > 0 || edge.quads[1] < 0 || edge.is_sharp) continue;
        const int place = edge.quads[0] == sample.quad && edge.sides[0] == k ? 1 : 0;
        const double t = k == 0 ? sample.u : k == 1 ? sample.v : k == 2 ? 1 - sample.u : 1 - sample.v;
        const LayoutQuad& next = layout_.quads[at(edge.quads[at(place)])];
        const bool same = runs_along(quad, k) == runs_along(next, edge.sides[at(place)]);
        const auto [u, v] = on_patch_side(edge.sides[at(place)], same ? t : 1 - t);
        LayoutSample other{sample.point, edge.quads[at(place)], u, v};
        const double distance = nearest_point(other);
        if (distance < nearest * (1 - 1e-6)) {
          sample = other;
          nearest = distance;
          break;
        }
      }
      distance_[s] = is_vertex(sample) ? nearest : 0;
    }
  }

  /// Gauss–Newton on the distance within the unit square. @return the distance.
  double nearest_point(LayoutSample& sample) const {
    const Vector3d X = layout_.points.row(sample.point).transpose();
    const auto q = at(sample.quad);
    PatchPoint point = evaluate_at(q, sample.u, sample.v);
    for (int step = 0; step < 8; ++step) {
      const Vector3d off = X - point.position;
      const double uu = point.along_u.squaredNorm(), uv = point.along_u.dot(point.along_v),
                   vv = point.along_v.squaredNorm();
      const double ru = point.along_u.dot(off), rv = point.along_v.dot(off), determinant = uu * vv - uv * uv;
      double du = 0, dv = 0;
      if (determinant > 1e-12 * uu * vv) {
        du = (vv * ru - uv * rv) / determinant;
        dv = (uu * rv - uv * ru) / determinant;
      }
      // A step that leaves the square goes along its side instead.
      if ((sample.u <= 0 && du < 0) || (sample.u >= 1 && du > 0)) du = 0, dv = vv > 0 ? rv / vv : 0;
      if ((sample.v <= 0 && dv < 0) || (sample.v >= 1 && dv > 0)) dv = 0, du = uu > 0 ? ru / uu : 0;
      LayoutSample next = sample;
      next.u = std::clamp(sample.u + std::clamp(du, -0.2, 0.2), 0.0, 1.0);
      next.v = std::clamp(sample.v + std::clamp(dv, -0.2, 0.2), 0.0, 1.0);
      const PatchPoint there = evaluate_at(q, next.u, next.v);
      if ((X - there.position).squaredNorm() >= off.squaredNorm()) break;
      const bool done = std::abs(next.u - sample.u) + std::abs(next.v - sample.v) < 1e-9;
      sample = next;
      point = there;
      if (done) break;
    }
    return (X - point.position).norm();
  }

  /// Twice as many spans along the sides of faces that miss the tolerance, where their vertices determine as
  /// many.
  /// @return false where nothing can be refined.
  bool refine() {
    std::vector<char> wanted(layout_.edges.size(), 0);
    for (std::size_t s = 0; s < layout_.samples.size(); ++s)
      if (distance_[s] > options_.tolerance * diameter_)
        for (int k = 0; k < 2; ++k)
          wanted[at(class_[at(layout_.quads[at(layout_.samples[s].quad)].edges[at(k)])])] = 1;
    bool refined = false;
    for (std::size_t c = 0; c < wanted.size(); ++c) {
      if (wanted[c] == 0 || spans_[c] >= limit_[c]) continue;
      spans_[c] = std::min(2 * spans_[c], limit_[c]);
      refined = true;
    }
    return refined;
  }

  SplineFaces result() const {
    SplineFaces faces;
    BsplineSurface& surface = faces.surface;
    surface.vertices = controls_.topRows(layout_.n_corners);
    surface.is_closed = true;
    for (std::size_t e = 0; e < layout_.edges.size(); ++e) {
      const LayoutEdge& from = layout_.edges[e];
      const int spans = spans_of_edge(static_cast<int>(e));
      BsplineEdge edge;
      edge.vertices = from.corners;
      edge.patches = from.quads;
      edge.is_sharp = from.is_sharp;
      edge.curve.knots = clamped_knots(spans);
      edge.curve.control_points.resize(spans + 3, 3);
      for (int i = 0; i < spans + 3; ++i)
        edge.curve.control_points.row(i) = controls_.row(control_of_edge(static_cast<int>(e), i));
      surface.normal_jump = std::max(surface.normal_jump, jump_at(e));
      surface.is_closed = surface.is_closed && from.quads[1] >= 0;
      faces.n_sharp += from.is_sharp ? 1 : 0;
      surface.edges.push_back(std::move(edge));
    }
    DisjointSets parts(static_cast<int>(layout_.quads.size()));
    for (const LayoutEdge& edge : layout_.edges)
      if (edge.quads[1] >= 0) parts.unite(edge.quads[0], edge.quads[1]);
    for (std::size_t q = 0; q < layout_.quads.size(); ++q) {
      const LayoutQuad& quad = layout_.quads[q];
      BsplinePatch patch;
      patch.knots_u = clamped_knots(spans_u(quad));
      patch.knots_v = clamped_knots(spans_v(quad));
      patch.control_points.resize(patch.n_u() * patch.n_v(), 3);
      for (int j = 0; j < patch.n_v(); ++j)
        for (int i = 0; i < patch.n_u(); ++i)
          patch.control_points.row(j * patch.n_u() + i) = controls_.row(control(q, i, j));
      patch.vertices = quad.corners;
      patch.edges = quad.edges;
      patch.face = quad.patch;
      patch.is_exact = false;
      surface.patches.push_back(std::move(patch));
    }
    surface.n_components = parts.n_sets();
    double sum = 0;
    for (const double distance : distance_) {
      surface.deviation = std::max(surface.deviation, distance);
      sum += distance * distance;
    }
    const auto n_vertices = std::count_if(layout_.samples.begin(), layout_.samples.end(),
                                          [&](const LayoutSample& sample) { return is_vertex(sample); });
    faces.rms_deviation = std::sqrt(sum / static_cast<double>(n_vertices));
    return faces;
  }

  SplineFacesOptions options_;
  double diameter_;
  std::vector<int> limit_;        ///< of spans, per class
  std::vector<double> distance_;  ///< per sample
};

}  // namespace

std::optional<std::string> SplineFacesOptions::problem() const {
  if (!(tolerance > 0) || !std::isfinite(tolerance))
    return concat("tolerance must be above 0, got ", tolerance);
  if (!(crease_angle > 0 && crease_angle <= kPi + 1e-9))
    return concat("crease_angle must lie above 0 and at most at 180 degrees, got ", degrees(crease_angle),
                  " degrees");
  if (most_patches < 1) return concat("most_patches must be at least 1, got ", most_patches);
  if (most_spans < 1 || most_spans > 64) return concat("most_spans must lie in 1 ... 64, got ", most_spans);
  return std::nullopt;
}

SplineFaces spline_faces(const TriangleMesh& mesh, const std::vector<int>& patch_of_triangle,
                         const SplineFacesOptions& options, const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  if (static_cast<Eigen::Index>(patch_of_triangle.size()) != mesh.n_triangles())
    throw InvalidInput(concat("patch_of_triangle has ", patch_of_triangle.size(), " entries for ",
                              mesh.n_triangles(), " triangles"));
  if (mesh.n_triangles() == 0) throw InvalidInput("the surface has no triangles");
  // Patches that meet in a crease may have vertices of their own along it.
  const std::vector<int> places = places_of_vertices(mesh.positions);
  const Triangles triangles = mesh.triangles.unaryExpr([&](int v) { return places[at(v)]; });
  const MeshTopology topology = mesh_topology(triangles, mesh.n_vertices());
  if (!topology.non_manifold_edges.empty() || !topology.is_oriented() ||
      !topology.collapsed_triangles.empty())
    throw InvalidInput(topology.problems.front());
  QuadLayout layout = detail::quad_layout(mesh.positions, triangles, patch_of_triangle, options.crease_angle,
                                          progress.part("layout", 0, 0.3));
  if (static_cast<int>(layout.quads.size()) > options.most_patches)
    throw InvalidInput(concat("the surface would take ", layout.quads.size(),
                              " B-spline faces, more than most_patches = ", options.most_patches,
                              "; raise it, or write a mesh"));
  return FaceFitter(std::move(layout), bounding_box_diagonal(mesh.positions), options)
      .fit(progress.part("fit", 0.3, 1));
}

}  // namespace batten
