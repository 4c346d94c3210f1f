#include "batten/surfacing/surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>

#include <Eigen/Dense>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/operators/curvature.hpp"
#include "batten/surfacing/fairing_detail.hpp"
#include "batten/surfacing/patch_detail.hpp"

namespace batten {

namespace {

using detail::FairingSystems;
using detail::PatchLayout;
using detail::PatchMesh;
using detail::ScaledNetwork;
using Eigen::Index;
using Eigen::RowVector3d;

/// Most rebuilds when the criterion decides. The way of the vertices shrinks some tenfold with each.
constexpr int kMostRebuilds = 3;
/// A rebuild that moved the vertices by less than this mean way (÷ diameter) was the last: the next would
/// move them by about a tenth of it, 0.002 %, a tenth of the distance between a chord of 2 % and its arc.
constexpr double kMoveThatEnds = 2e-4;
/// Passes of the normals towards the map into the sphere; the second changes them by some 0.01°.
constexpr int kNormalPasses = 2;
/// Soft constraints: weight 1 stands for (2π / 0.15)³, see SurfaceOptions::soft_weight.
constexpr double kSoftUnit = 7.3e4;

void check(const CurveNetwork& network, const SurfaceOptions& options) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  if (network.curves.empty()) throw InvalidInput("the network has no curves; there is nothing to surface");
  if (!network.has_normals())
    throw InvalidInput(
        "the network has no normals, which the surface is built from; give one unit normal per vertex");
  network_topology(network);  // indices in range, curves long enough
  for (std::size_t c = 0; c < network.curves.size(); ++c)
    for (const int v : network.curves[c].vertices)
      if (!network.positions.row(v).allFinite() || !network.normals.row(v).allFinite())
        throw InvalidInput(concat("vertex ", v, " of ", curve_name(network, static_cast<int>(c)),
                                  " has a coordinate that is not a number; repair or remove it"));
}

ScaledNetwork scaled(const CurveNetwork& network) {
  RowVector3d low = RowVector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const NetworkCurve& curve : network.curves)
    for (const int v : curve.vertices) {
      low = low.cwiseMin(network.positions.row(v));
      high = high.cwiseMax(network.positions.row(v));
    }
  ScaledNetwork result;
  result.diameter = (high - low).norm();
  if (!(result.diameter > 0) || !std::isfinite(result.diameter))
    throw InvalidInput("the network has no extent; all its vertices lie at one place");
  result.centre = 0.5 * (low + high);
  result.positions = (network.positions.rowwise() - result.centre) / result.diameter;
  result.normals = network.normals;
  for (Index v = 0; v < result.normals.rows(); ++v)
    if (result.normals.row(v).norm() > 0) result.normals.row(v).normalize();
  return result;
}

/// Samples crowded on a curve say little about the normals but much about their noise: two that differ by 5°
/// at a hundredth of the usual distance bend the propagated normals over in the whole patch. Of samples
/// closer than 0.3 of the mean step only the first keeps its normal, the others interpolate.
/// @return how many were changed.
int calm_crowded_normals(const CurveNetwork& network, ScaledNetwork& s) {
  constexpr double kCrowded = 0.3;
  std::vector<int> degree(network.positions.rows(), 0);
  for (const NetworkCurve& curve : network.curves)
    for (std::size_t i = 0; i + 1 < curve.vertices.size(); ++i) {
      ++degree[curve.vertices[i]];
      ++degree[curve.vertices[i + 1]];
    }
  int changed = 0;
  for (const NetworkCurve& curve : network.curves) {
    const std::size_t n = curve.vertices.size();
    std::vector<double> along(n, 0);
    for (std::size_t i = 1; i < n; ++i)
      along[i] =
          along[i - 1] + (s.positions.row(curve.vertices[i]) - s.positions.row(curve.vertices[i - 1])).norm();
    const double gap = kCrowded * along.back() / static_cast<double>(n - 1);
    std::vector<std::size_t> kept = {0};
    for (std::size_t i = 1; i < n; ++i) {
      const bool node = degree[curve.vertices[i]] != 2 || i + 1 == n;
      // A sample just before a node gives way to the node.
      while (node && kept.size() > 1 && along[i] - along[kept.back()] < gap &&
             degree[curve.vertices[kept.back()]] == 2)
        kept.pop_back();
      if (node || along[i] - along[kept.back()] >= gap) kept.push_back(i);
    }
    for (std::size_t k = 0; k + 1 < kept.size(); ++k)
      for (std::size_t i = kept[k] + 1; i < kept[k + 1]; ++i) {
        const double t = (along[i] - along[kept[k]]) / (along[kept[k + 1]] - along[kept[k]]);
        const RowVector3d mean =
            (1 - t) * s.normals.row(curve.vertices[kept[k]]) + t * s.normals.row(curve.vertices[kept[k + 1]]);
        if (mean.norm() < 1e-9) continue;
        s.normals.row(curve.vertices[i]) = mean.normalized();
        ++changed;
      }
  }
  return changed;
}

/// Two vertices at one place make an edge of no length somewhere; say which before the mesher stumbles. Where
/// the cycles are given, that is so only of two in one cycle: others make a crease.
void check_coincident(const CurveNetwork& network, const ScaledNetwork& s,
                      const std::vector<NetworkCycle>& given) {
  struct Place {
    std::array<std::int64_t, 3> cell;
    int vertex, curve;
    bool operator<(const Place& o) const { return std::tie(cell, vertex) < std::tie(o.cell, o.vertex); }
  };
  std::vector<Place> places;
  std::vector<char> seen(network.positions.rows(), 0);
  for (std::size_t c = 0; c < network.curves.size(); ++c)
    for (const int v : network.curves[c].vertices) {
      if (seen[v]) continue;
      seen[v] = 1;
      Place place{{}, v, static_cast<int>(c)};
      for (int k = 0; k < 3; ++k) place.cell[k] = std::llround(s.positions(v, k) / 0.7548776662466927e-9);
      places.push_back(place);
    }
  std::sort(places.begin(), places.end());
  std::vector<std::vector<std::size_t>> cycles_of(given.empty() ? 0 : seen.size());
  for (std::size_t c = 0; c < given.size(); ++c)
    for (const NetworkCycle::Loop& loop : given[c].loops)
      for (const int v : loop.vertices)
        if (cycles_of[v].empty() || cycles_of[v].back() != c) cycles_of[v].push_back(c);
  const auto share_a_cycle = [&](int a, int b) {
    for (const std::size_t c : cycles_of[a])
      if (std::binary_search(cycles_of[b].begin(), cycles_of[b].end(), c)) return true;
    return false;
  };
  for (std::size_t i = 1; i < places.size(); ++i)
    for (std::size_t j = i; j-- > 0 && places[j].cell == places[i].cell;)
      if (given.empty() || share_a_cycle(places[j].vertex, places[i].vertex))
        throw InvalidInput(
            concat("the vertices ", places[j].vertex, " of ", curve_name(network, places[j].curve), " and ",
                   places[i].vertex, " of ", curve_name(network, places[i].curve),
                   " lie at the same place; merge them into one vertex so that the curves are joined"));
}

}  // namespace

std::optional<std::string> SurfaceOptions::problem() const {
  if (base_order < 1 || base_order > 3) return concat("base_order must be 1, 2 or 3, got ", base_order);
  if (rebuilds < -1 || rebuilds > 20)
    return concat("rebuilds must be -1 (automatic) or 0 to 20, got ", rebuilds);
  if (!(soft_weight > 0) || !std::isfinite(soft_weight))
    return concat("soft_weight must be positive, got ", soft_weight);
  if (!(edge_length >= 0) || !std::isfinite(edge_length))
    return concat("edge_length must be >= 0, got ", edge_length);
  return std::nullopt;
}

struct SurfaceSolver::Implementation {
  CurveNetwork network;
  SurfaceOptions options;
  ScaledNetwork scaled_network;
  std::vector<NetworkCycle> cycles;
  SurfaceResult result;
  Triangles triangles;
  EdgeLengths layout_lengths;
  std::unique_ptr<FairingSystems> systems;
  std::vector<char> border;
  Points positions, normals;  ///< of all vertices, in diameters; normals propagated
  bool metric_from_layout = true;
  bool cycles_are_given = false;  ///< found from curves alone, so that one that cannot be filled may be wrong

  void build(const Progress& progress) {
    check(network, options);
    progress.report("cycles", 0);
    {
      ScopedStage stage(result.times, "cycles");
      scaled_network = scaled(network);
      check_coincident(network, scaled_network, cycles);
      if (cycles.empty()) {
        CycleReport report = find_cycles(network);
        cycles = std::move(report.cycles);
        result.warnings = std::move(report.warnings);
      }
      if (const int crowded = calm_crowded_normals(network, scaled_network); crowded > 0)
        result.warnings.push_back(
            concat(crowded,
                   " samples closer than 0.3 of the mean step of their curve took the normal "
                   "between their neighbours; resample the network to use them all"));
    }
    std::vector<char> in_space(cycles.size(), 0);
    make(in_space, progress);
    const std::vector<char> folded = folded_patches();
    if (std::find(folded.begin(), folded.end(), 1) != folded.end()) {
      // A patch that folded over gets another layout, once; where that is no better, the first is kept.
      const int before = judge(positions, normals).folded;
      std::vector<char> retry = in_space;
      for (std::size_t p = 0; p < cycles.size(); ++p)
        if (folded[p]) retry[p] = 1;
      bool better = false;
      if (retry != in_space) {
        try {
          make(retry, progress);
          better = judge(positions, normals).folded < before;
        } catch (const InvalidInput&) {  // not to be filled in space
        } catch (const SolverFailure&) {
        }
        if (!better) make(in_space, progress);
      }
    }
    finish();
  }

  void make(std::vector<char>& in_space, const Progress& progress) {
    tessellate(in_space, progress);
    solve(progress);
  }

  void tessellate(std::vector<char>& in_space, const Progress& progress) {
    ScopedStage stage(result.times, "tessellation");
    const double edge = options.edge_length / scaled_network.diameter;
    std::vector<PatchMesh> patches;
    Index n = network.positions.rows(), m = 0;
    result.patches_in_space = 0;
    std::vector<std::string> warnings;
    for (std::size_t p = 0; p < cycles.size(); ++p) {
      progress.report("tessellation", static_cast<double>(p) / static_cast<double>(cycles.size()));
      std::string warning;
      PatchMesh patch;
      try {
        if (in_space[p]) {
          patch = mesh_patch_in_space(scaled_network, cycles[p], static_cast<int>(p), edge);
          warning = concat(detail::patch_name(cycles[p], static_cast<int>(p)),
                           " folded over from its plane layout; it was triangulated in space");
        } else {
          patch = mesh_patch(scaled_network, cycles[p], static_cast<int>(p), options.map, edge, warning);
          in_space[p] = patch.layout == PatchLayout::Space;
        }
      } catch (const InvalidInput& problem) {
        if (!cycles_are_given || in_space[p]) throw;  // a second layout may fail, the first stands
        patch = PatchMesh();
        warning = concat(problem.what(), "; it was left open");
      }
      patches.push_back(std::move(patch));
      if (!warning.empty()) warnings.push_back(warning);
      result.patches_in_space += in_space[p];
    }
    detail::split_shared_inner_edges(patches, cycles);
    for (const PatchMesh& patch : patches) {
      n += patch.n_inner;
      m += patch.triangles.rows();
    }
    patch_warnings = std::move(warnings);
    if (m == 0) throw InvalidInput(patch_warnings.front());
    triangles.resize(m, 3);
    layout_lengths.resize(m, 3);
    result.patch_of_triangle.assign(static_cast<std::size_t>(m), 0);
    Index row = 0;
    int next = static_cast<int>(network.positions.rows());
    for (std::size_t p = 0; p < patches.size(); ++p) {
      const PatchMesh& patch = patches[p];
      const auto n_network = static_cast<int>(patch.network_vertices.size());
      for (Index f = 0; f < patch.triangles.rows(); ++f, ++row) {
        for (int k = 0; k < 3; ++k) {
          const int v = patch.triangles(f, k);
          triangles(row, k) =
              v < n_network ? patch.network_vertices[static_cast<std::size_t>(v)] : next + v - n_network;
        }
        layout_lengths.row(row) = patch.lengths.row(f);
        result.patch_of_triangle[static_cast<std::size_t>(row)] = static_cast<int>(p);
      }
      next += patch.n_inner;
    }
    border = border_vertices(triangles, n);
    result.on_network.assign(static_cast<std::size_t>(n), 0);
    for (const NetworkCurve& curve : network.curves)
      for (const int v : curve.vertices) result.on_network[static_cast<std::size_t>(v)] = 1;
    // Vertices of the network that no curve uses keep their place; they are in no triangle and in no system.
    std::vector<char> fixed = result.on_network;
    for (Index v = 0; v < network.positions.rows(); ++v) fixed[static_cast<std::size_t>(v)] = 1;
    systems = std::make_unique<FairingSystems>(fixed, border, soft_weights(n));
    positions = Points::Zero(n, 3);
    normals = Points::Zero(n, 3);
    take_network();
  }

  /// Each vertex of a curve weighs as much as the piece of curve that it stands for.
  Eigen::VectorXd soft_weights(Index n) const {
    if (!options.soft_constraints) return {};
    Eigen::VectorXd weights = Eigen::VectorXd::Zero(n);
    for (const NetworkCurve& curve : network.curves)
      for (std::size_t i = 0; i + 1 < curve.vertices.size(); ++i) {
        const int a = curve.vertices[i], b = curve.vertices[i + 1];
        const double length = (scaled_network.positions.row(a) - scaled_network.positions.row(b)).norm();
        weights[a] += 0.5 * length * kSoftUnit * options.soft_weight;
        weights[b] += 0.5 * length * kSoftUnit * options.soft_weight;
      }
    // Unused vertices of the network would make the system singular.
    for (Index v = 0; v < network.positions.rows(); ++v)
      if (weights[v] == 0) weights[v] = 1;
    return weights;
  }

  void take_network() {
    positions.topRows(network.positions.rows()) = scaled_network.positions;
    normals.topRows(network.normals.rows()) = scaled_network.normals;
  }

  Points network_values(const Points& of_network) const {
    Points values = Points::Zero(positions.rows(), 3);
    values.topRows(of_network.rows()) = of_network;
    return values;
  }

  /// Curvature target 2HN·A of the final fit. The first metric comes from plane layouts that do not fit
  /// together, so there the positions' own curvature vector (4.18) is used; later ones are those of the
  /// positions themselves, and the form along edges is exact on spheres.
  Points curvature_target(const Points& X, const Points& N) const {
    Points target(X.rows(), 3);
    if (metric_from_layout) {
      const Points vectors = integrated_curvature_from_normals(X, N, triangles);
      for (Index v = 0; v < X.rows(); ++v) target.row(v) = -vectors.row(v).dot(N.row(v)) * N.row(v);
    } else {
      const Eigen::VectorXd curvature = detail::curvature_along_edges(systems->stiffness(), X, N);
      for (Index v = 0; v < X.rows(); ++v) target.row(v) = curvature[v] * N.row(v);
    }
    return target;
  }

  /// Moves the normals towards the field of unit vectors with the least Σ A |tangential part of ΔN|². On a
  /// surface that part is 2∇H (Δ N = −|∇N|² N − 2∇H), so constant mean curvature costs nothing, while the
  /// biharmonic field of (4.12b) is not exact even on a sphere. The matrix is the same.
  void refine_normals() {
    const Points given = network_values(scaled_network.normals);
    for (int pass = 0; pass < kNormalPasses; ++pass) {
      const Eigen::MatrixXd KN = systems->stiffness() * normals;
      Points target(normals.rows(), 3);
      for (Index v = 0; v < normals.rows(); ++v)
        target.row(v) = KN.row(v).dot(normals.row(v)) * normals.row(v);
      normals = systems->fit_laplacian(target, given);
      detail::normalize_propagated(normals, systems->stiffness());
    }
  }

  void propagate_base(int order) {
    Eigen::MatrixXd values(positions.rows(), 6);
    values << network_values(scaled_network.positions), network_values(scaled_network.normals);
    const Eigen::MatrixXd base = systems->polyharmonic(order, values);
    positions = base.leftCols(3);
    normals = base.rightCols(3);
    detail::normalize_propagated(normals, systems->stiffness());
  }

  /// One pass of the wanted method with the present metric. Starts from `positions` and `normals` unless the
  /// metric is that of the layouts, where it makes the base geometry first.
  void pass() {
    const Points given = network_values(scaled_network.positions);
    switch (options.method) {
      case SurfaceMethod::Harmonic:
      case SurfaceMethod::Biharmonic:
      case SurfaceMethod::Triharmonic:
        propagate_base(options.method == SurfaceMethod::Harmonic     ? 1
                       : options.method == SurfaceMethod::Biharmonic ? 2
                                                                     : 3);
        return;
      case SurfaceMethod::BiharmonicNormals: {
        if (metric_from_layout) propagate_base(options.base_order);
        Points vectors = curvature_target(positions, normals);
        const Eigen::VectorXd& inverse = systems->inverse_mass();
        for (Index v = 0; v < vectors.rows(); ++v) vectors.row(v) *= inverse[v];
        positions = systems->biharmonic_with_curvature(vectors, given);
        return;
      }
      case SurfaceMethod::Curvature:
        if (metric_from_layout)
          propagate_base(options.base_order);
        else
          refine_normals();
        positions = systems->fit_laplacian(curvature_target(positions, normals), given);
        return;
    }
  }

  void solve(const Progress& progress) {
    ScopedStage stage(result.times, "geometry");
    result.rebuilds = 0;
    result.last_move = 0;
    metric_from_layout = true;
    progress.report("geometry", 0);
    systems->set_metric(triangles, layout_lengths);
    pass();
    // The baselines have no curvature to improve: they are rebuilt only on demand.
    const bool automatic = options.rebuilds < 0;
    const int most =
        automatic ? (options.method == SurfaceMethod::Curvature ? kMostRebuilds : 0) : options.rebuilds;
    Soundness soundness = judge(positions, normals);
    EdgeLengths kept_lengths = layout_lengths;
    for (int rebuild = 1; rebuild <= most; ++rebuild) {
      progress.report("geometry", static_cast<double>(rebuild) / (most + 1));
      const Points old_positions = positions, old_normals = normals;
      const bool old_metric = metric_from_layout;
      const EdgeLengths lengths = edge_lengths(positions, triangles);
      std::string refusal;
      double move = 0;
      Soundness now;
      try {
        systems->set_metric(triangles, lengths);
        metric_from_layout = false;
        pass();
        move = (positions - old_positions).rowwise().norm().mean();
        now = judge(positions, normals);
        if (now.folded > soundness.folded || now.degenerate > soundness.degenerate)
          refusal = "it would fold or flatten triangles";
        else if (rebuild > 1 && move > 0.9 * result.last_move)
          refusal = "the surface no longer settles";
      } catch (const SolverFailure&) {
        refusal = "its system is singular";
      }
      if (!refusal.empty()) {
        positions = old_positions;
        normals = old_normals;
        metric_from_layout = old_metric;
        systems->set_metric(triangles, kept_lengths);
        if (!automatic)
          result.warnings.push_back(concat("rebuild ", rebuild, " of the Laplacian was refused: ", refusal));
        break;
      }
      soundness = now;
      kept_lengths = lengths;
      result.rebuilds = rebuild;
      result.last_move = move;
      if (automatic && move < kMoveThatEnds) break;
    }
  }

  struct Soundness {
    int folded = 0, degenerate = 0;
  };

  bool is_folded(const Points& X, const Points& N, Index f) const {
    return detail::is_folded(X, N, triangles, f);
  }

  Soundness judge(const Points& X, const Points& N) const {
    Soundness s;
    const double least2 = std::pow(std::sin(radians(0.5)), 2);
    for (Index f = 0; f < triangles.rows(); ++f) {
      const RowVector3d a = X.row(triangles(f, 0)), b = X.row(triangles(f, 1)), c = X.row(triangles(f, 2));
      const double sides2[3] = {(c - b).squaredNorm(), (a - c).squaredNorm(), (b - a).squaredNorm()};
      // The two longest sides enclose the smallest angle; the area is half its sine times both.
      const double shortest2 = std::min({sides2[0], sides2[1], sides2[2]});
      const double longer2 = shortest2 > 0 ? sides2[0] * sides2[1] * sides2[2] / shortest2 : 0;
      if (!((b - a).cross(c - a).squaredNorm() > least2 * longer2)) ++s.degenerate;
      if (is_folded(X, N, f)) ++s.folded;
    }
    return s;
  }

  /// Patches of which more than a thousandth of the area is folded: fewer are slivers beside samples that lie
  /// close together, which no other layout would mend.
  std::vector<char> folded_patches() const {
    std::vector<double> folded_area(cycles.size(), 0), area(cycles.size(), 0);
    for (Index f = 0; f < triangles.rows(); ++f) {
      const RowVector3d a = positions.row(triangles(f, 0)), b = positions.row(triangles(f, 1)),
                        c = positions.row(triangles(f, 2));
      const double size = (b - a).cross(c - a).norm();
      const auto p = static_cast<std::size_t>(result.patch_of_triangle[static_cast<std::size_t>(f)]);
      area[p] += size;
      if (is_folded(positions, normals, f)) folded_area[p] += size;
    }
    std::vector<char> folded(cycles.size(), 0);
    for (std::size_t p = 0; p < cycles.size(); ++p) folded[p] = folded_area[p] > 1e-3 * area[p];
    return folded;
  }

  void finish() {
    ScopedStage stage(result.times, "output");
    const Soundness s = judge(positions, normals);
    result.folded_triangles = s.folded;
    result.degenerate_triangles = s.degenerate;
    result.n_cycles = static_cast<int>(cycles.size());
    built_positions = positions;
    built_normals = normals;
    base_warnings = result.warnings;
    base_warnings.insert(base_warnings.end(), patch_warnings.begin(), patch_warnings.end());
    write_result(s);
  }

  void write_result(const Soundness& s) {
    result.warnings = base_warnings;
    if (s.folded > 0)
      result.warnings.push_back(
          concat(s.folded,
                 " triangles are turned away from the propagated normals; the network has too few "
                 "curves there, or normals that contradict its curves"));
    if (s.degenerate > 0)
      result.warnings.push_back(concat(s.degenerate, " triangles have an angle below half a degree"));
    if (result.mesh.triangles.rows() != triangles.rows() || result.mesh.triangles != triangles)
      result.mesh.triangles = triangles;
    result.mesh.positions = (positions * scaled_network.diameter).rowwise() + scaled_network.centre;
    // Interpolation is exact, not up to the rounding of the scaling.
    if (!options.soft_constraints)
      result.mesh.positions.topRows(network.positions.rows()) = network.positions;
    result.mesh.normals = normals;
  }

  std::vector<std::string> patch_warnings, base_warnings;
  Points built_positions, built_normals;  ///< as built, from which moves start
};

SurfaceSolver::SurfaceSolver(const CurveNetwork& network, const SurfaceOptions& options,
                             const Progress& progress)
    : implementation_(std::make_unique<Implementation>()) {
  implementation_->network = network;
  implementation_->options = options;
  implementation_->build(progress);
}
SurfaceSolver::SurfaceSolver(const CurveNetwork& network, const std::vector<NetworkCycle>& cycles,
                             const SurfaceOptions& options, const Progress& progress)
    : implementation_(std::make_unique<Implementation>()) {
  if (cycles.empty()) throw InvalidInput("there is no cycle to fill");
  for (std::size_t c = 0; c < cycles.size(); ++c)
    for (const NetworkCycle::Loop& loop : cycles[c].loops)
      for (const int v : loop.vertices)
        if (v < 0 || v >= network.positions.rows())
          throw InvalidInput(concat("cycle ", c, " names vertex ", v,
                                    ", but the network has the vertices 0 to ",
                                    network.positions.rows() - 1));
  implementation_->network = network;
  implementation_->cycles = cycles;
  implementation_->cycles_are_given = true;
  implementation_->options = options;
  implementation_->build(progress);
}
SurfaceSolver::~SurfaceSolver() = default;
SurfaceSolver::SurfaceSolver(SurfaceSolver&&) noexcept = default;
SurfaceSolver& SurfaceSolver::operator=(SurfaceSolver&&) noexcept = default;

const SurfaceResult& SurfaceSolver::result() const {
  return implementation_->result;
}

const SurfaceResult& SurfaceSolver::move(const Points& positions, const Points& normals) {
  Implementation& self = *implementation_;
  const Index n = self.network.positions.rows();
  if (positions.rows() != n || normals.rows() != n)
    throw InvalidInput(concat("moving a network of ", n,
                              " vertices needs as many positions and normals, got ", positions.rows(),
                              " and ", normals.rows()));
  if (!positions.allFinite() || !normals.allFinite())
    throw InvalidInput("a moved vertex has a coordinate that is not a number");
  self.network.positions = positions;
  self.network.normals = normals;
  self.scaled_network.positions =
      (positions.rowwise() - self.scaled_network.centre) / self.scaled_network.diameter;
  self.scaled_network.normals = normals;
  for (Index v = 0; v < n; ++v)
    if (normals.row(v).norm() > 0) self.scaled_network.normals.row(v).normalize();
  calm_crowded_normals(self.network, self.scaled_network);
  // The surface that was built plus the displacement of its curves, spread biharmonically, is the base; then
  // the fit. Taken from the surface that was built, not from the last move: moves do not add up errors.
  Eigen::MatrixXd displacement = Eigen::MatrixXd::Zero(self.positions.rows(), 6);
  displacement.topLeftCorner(n, 3) = self.scaled_network.positions - self.built_positions.topRows(n);
  displacement.topRightCorner(n, 3) = self.scaled_network.normals - self.built_normals.topRows(n);
  const Eigen::MatrixXd spread = self.systems->polyharmonic(2, displacement);
  self.positions = self.built_positions + spread.leftCols(3);
  self.normals = self.built_normals + spread.rightCols(3);
  detail::normalize_propagated(self.normals, self.systems->stiffness());
  if (self.options.method == SurfaceMethod::Curvature)
    self.positions = self.systems->fit_laplacian(self.curvature_target(self.positions, self.normals),
                                                 self.network_values(self.scaled_network.positions));
  else if (self.options.method != SurfaceMethod::Biharmonic)
    self.pass();
  const Implementation::Soundness s = self.judge(self.positions, self.normals);
  self.result.folded_triangles = s.folded;
  self.result.degenerate_triangles = s.degenerate;
  self.write_result(s);
  return self.result;
}

SurfaceResult surface_network(const CurveNetwork& network, const SurfaceOptions& options,
                              const Progress& progress) {
  return SurfaceSolver(network, options, progress).result();
}

SurfaceResult surface_network(const CurveNetwork& network, const std::vector<NetworkCycle>& cycles,
                              const SurfaceOptions& options, const Progress& progress) {
  return SurfaceSolver(network, cycles, options, progress).result();
}

}  // namespace batten
