#include "batten/surfacing/surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Dense>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/operators/curvature.hpp"
#include "batten/surfacing/fairing_detail.hpp"
#include "batten/surfacing/patch_detail.hpp"
#include "batten/surfacing/relaxation_detail.hpp"
#include "batten/surfacing/surface_input_detail.hpp"
#include "batten/surfacing/surface_move_detail.hpp"
#include "batten/surfacing/welded_sides_detail.hpp"

namespace batten {

namespace {

using detail::curvature_target;
using detail::FairingSystems;
using detail::PatchLayout;
using detail::PatchMesh;
using detail::ScaledNetwork;
using detail::Soundness;
using detail::soundness_of;
using Eigen::Index;
using Eigen::RowVector3d;

/// Most rebuilds when the criterion decides: their ways shrink tenfold, by half where few curves bend far.
constexpr int kMostRebuilds = 6;
/// A rebuild that moved the vertices by less than this mean way (÷ diameter) was the last: the next would
/// move them by about a tenth of it, 0.002 %, a tenth of the distance between a chord of 2 % and its arc.
constexpr double kMoveThatEnds = 2e-4;
/// Passes of the normals towards the map into the sphere; the second changes them by some 0.01°.
constexpr int kNormalPasses = 2;
/// Diameters that a vertex may move where mean curvature bends: some ten times the error of a network that
/// says enough.
constexpr double kFarthestBend = 0.01;
/// Times that needles are evened out and the surface solved for again.
constexpr int kRelaxations = 3;
/// Soft constraints: weight 1 stands for (2π / 0.15)³, see SurfaceOptions::soft_weight.
constexpr double kSoftUnit = 7.3e4;

}  // namespace

struct SurfaceSolver::Implementation {
  CurveNetwork network;
  SurfaceOptions options;
  ScaledNetwork scaled_network;
  std::vector<NetworkCycle> cycles;
  SurfaceResult result;
  Triangles triangles;
  EdgeLengths layout_lengths, metric_lengths;  ///< the latter those of the last solve
  std::unique_ptr<FairingSystems> systems;
  std::vector<char> held, border;
  Points positions, normals;  ///< of all vertices, in diameters; normals propagated
  bool metric_from_layout = true;
  CurveNetwork uncut;  ///< where `network` was cut open along sharp curves: as it came, and its patches
  std::vector<NetworkCycle> uncut_cycles;
  std::vector<int> place;  ///< of the vertices of `network` in `uncut`; empty where nothing was cut
  detail::WeldedSides sides;
  bool cycles_are_given = false;  ///< found from curves alone, so that one that cannot be filled may be wrong

  void build(const Progress& progress) {
    detail::check_surface_input(network, options);
    progress.report("cycles", 0);
    {
      ScopedStage stage(result.times, "cycles");
      scaled_network = detail::scaled_network(network);
      detail::check_coincident(network, scaled_network, cycles);
      if (cycles.empty()) {
        CycleReport report = find_cycles(network);
        cycles = std::move(report.cycles);
        result.warnings = std::move(report.warnings);
        for (const SharpFinding& finding : find_sharp_curves(network, cycles)) {
          network.curves[at(finding.curve)].sharp = true;
          result.warnings.push_back(finding.sentence);
        }
      }
      cut_open();
      if (const int crowded = detail::calm_crowded_normals(network, scaled_network); crowded > 0)
        result.warnings.push_back(
            concat(crowded,
                   " samples closer than 0.3 of the mean step of their curve took the normal "
                   "between their neighbours; resample the network to use them all"));
    }
    check_size();
    lay_out(progress);
    relax(progress);
    let_curvature_bend(progress);
    finish();
  }

  /// Triangles and shape. Patches that folded over are laid out in up to two other ways, until nothing of
  /// them folds; each keeps the one in which least does.
  void lay_out(const Progress& progress) {
    const auto shares = [&] {
      return detail::folded_shares(positions, normals, triangles, result.patch_of_triangle, cycles.size());
    };
    std::vector<int> made(cycles.size(), 0), best = made;
    make(made, progress);
    std::vector<double> least = shares();
    std::vector<char> folded_over(cycles.size(), 0);
    for (std::size_t p = 0; p < cycles.size(); ++p) folded_over[p] = least[p] > detail::kFoldedShare;
    for (int attempt = 1; attempt < detail::kLayoutAttempts; ++attempt) {
      std::vector<int> wanted = best;
      for (std::size_t p = 0; p < cycles.size(); ++p)
        if (folded_over[p] && least[p] > 0) wanted[p] = attempt;
      if (wanted == best) break;
      made = wanted;
      try {
        make(made, progress);
      } catch (const SolverFailure&) {
        made.clear();
        break;
      }
      const std::vector<double> now = shares();
      for (std::size_t p = 0; p < cycles.size(); ++p)
        if (made[p] == attempt && now[p] < least[p]) {
          best[p] = attempt;
          least[p] = now[p];
        }
    }
    if (made != best) make(best, progress);
  }

  /// Along sharp curves the sides are filled apart; finish() welds them.
  void cut_open() {
    if (std::none_of(network.curves.begin(), network.curves.end(),
                     [](const NetworkCurve& curve) { return curve.sharp && !curve.boundary; }))
      return;
    uncut_cycles = cycles;
    SharpSplit split = split_at_sharp_curves(network, cycles);
    sides = detail::WeldedSides(split, network.positions.rows());
    place = split.place;
    uncut = std::exchange(network, std::move(split.network));
    cycles = std::move(split.cycles);
    scaled_network = detail::scaled_network(network);
  }

  void check_size() const {
    double n = 0;
    for (const NetworkCycle& cycle : cycles)
      n += detail::estimated_triangles(scaled_network, cycle, options.edge_length / scaled_network.diameter);
    if (n > options.max_triangles)
      throw InvalidInput(concat("the surface would have about ", n, " triangles, more than ",
                                options.max_triangles,
                                "; take longer edges (option edge-length), or allow more (max-triangles)"));
  }

  void make(std::vector<int>& attempts, const Progress& progress) {
    tessellate(attempts, progress);
    solve(progress);
  }

  /// @param attempts at the layout of each patch, 0 where a further one cannot be filled.
  void tessellate(std::vector<int>& attempts, const Progress& progress) {
    ScopedStage stage(result.times, "tessellation");
    const double edge = options.edge_length / scaled_network.diameter;
    std::vector<PatchMesh> patches;
    result.patches_in_space = 0;
    std::vector<std::string> warnings;
    for (std::size_t p = 0; p < cycles.size(); ++p) {
      progress.report("tessellation", static_cast<double>(p) / static_cast<double>(cycles.size()));
      std::string warning;
      PatchMesh patch;
      const auto lay_out = [&] {
        return mesh_patch(scaled_network, cycles[p], static_cast<int>(p),
                          {options.map, edge, attempts[p], !cycles_are_given}, warning);
      };
      try {
        patch = lay_out();
      } catch (const InvalidInput& problem) {
        if (std::exchange(attempts[p], 0) > 0) {
          patch = lay_out();
        } else {
          if (!cycles_are_given) throw;
          warning = concat(problem.what(), "; it was left open");
        }
      }
      patches.push_back(std::move(patch));
      if (!warning.empty()) warnings.push_back(warning);
      result.patches_in_space += patches.back().layout == PatchLayout::Space;
    }
    detail::split_shared_inner_edges(patches, cycles, place);
    const detail::JoinedPatches joined = detail::join_patches(patches, network.positions.rows());
    patch_warnings = std::move(warnings);
    if (joined.triangles.rows() == 0) throw InvalidInput(patch_warnings.front());
    triangles = joined.triangles;
    layout_lengths = joined.lengths;
    result.patch_of_triangle = joined.patch_of_triangle;
    const Index n = joined.n_vertices;
    border = border_vertices(triangles, n);
    result.on_network.assign(static_cast<std::size_t>(n), 0);
    for (const NetworkCurve& curve : network.curves)
      for (const int v : curve.vertices) result.on_network[at(v)] = 1;
    // Vertices of the network that no curve uses keep their place; they are in no triangle and in no system.
    std::vector<char> fixed = result.on_network;
    for (Index v = 0; v < network.positions.rows(); ++v) fixed[at(v)] = 1;
    held = std::move(fixed);
    systems = std::make_unique<FairingSystems>(held, border, soft_weights(n));
    positions = Points::Zero(n, 3);
    normals = Points::Zero(n, 3);
    take_network();
  }

  Eigen::VectorXd soft_weights(Index n) const {
    if (!options.soft_constraints) return {};
    return detail::soft_weights(network, scaled_network, n, kSoftUnit * options.soft_weight);
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

  /// What is least over the tangential part r of ΔN. On a surface r is 2∇H (ΔN = −|∇N|² N − 2∇H): where mean
  /// curvature is constant both are 0, while the biharmonic field of (4.12b) is not exact even on a sphere.
  enum class NormalEnergy {
    Laplacian,  ///< ∫|r|²
    Gradient,   ///< ∫|∇r|²: mean curvature goes up and down evenly, as on a torus
  };

  /// Moves the normals towards the field of unit vectors with the least energy.
  void refine_normals(NormalEnergy energy, const Progress& progress = {}) {
    const Points given = network_values(scaled_network.normals);
    for (int pass = 0; pass < kNormalPasses; ++pass) {
      progress.report("curvature", pass / (kNormalPasses + 1.0));
      const Eigen::MatrixXd KN = systems->stiffness() * normals;
      Points target(normals.rows(), 3);
      for (Index v = 0; v < normals.rows(); ++v)
        target.row(v) = KN.row(v).dot(normals.row(v)) * normals.row(v);
      normals = energy == NormalEnergy::Gradient ? systems->fit_laplacian_gradient(target, given)
                                                 : systems->fit_laplacian(target, given);
      detail::normalize_propagated(normals, systems->stiffness());
    }
  }

  /// Positions with the curvature that positions and normals have now.
  void fit_positions() {
    positions =
        systems->fit_laplacian(curvature_target(*systems, triangles, metric_from_layout, positions, normals),
                               network_values(scaled_network.positions));
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
        Points vectors = curvature_target(*systems, triangles, metric_from_layout, positions, normals);
        const Eigen::VectorXd& inverse = systems->inverse_mass();
        for (Index v = 0; v < vectors.rows(); ++v) vectors.row(v) *= inverse[v];
        positions = systems->biharmonic_with_curvature(vectors, given);
        return;
      }
      case SurfaceMethod::Curvature:
        if (metric_from_layout)
          propagate_base(options.base_order);
        else
          refine_normals(NormalEnergy::Laplacian);
        fit_positions();
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
    Soundness soundness = soundness_of(positions, normals, triangles);
    metric_lengths = layout_lengths;
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
        now = soundness_of(positions, normals, triangles);
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
        systems->set_metric(triangles, metric_lengths);
        if (!automatic)
          result.warnings.push_back(concat("rebuild ", rebuild, " of the Laplacian was refused: ", refusal));
        break;
      }
      soundness = now;
      metric_lengths = lengths;
      result.rebuilds = rebuild;
      result.last_move = move;
      if (automatic && move < kMoveThatEnds) break;
    }
  }

  /// Evens out needles that the layouts left, and solves again on the new triangles; where that is no better,
  /// what was before is kept.
  void relax(const Progress& progress) {
    if (options.rebuilds >= 0 || options.method != SurfaceMethod::Curvature) return;
    ScopedStage stage(result.times, "geometry");
    const auto set_up = [&](const EdgeLengths& lengths) {
      systems = std::make_unique<FairingSystems>(held, border, soft_weights(positions.rows()));
      systems->set_metric(triangles, lengths);
    };
    for (int round = 0; round < kRelaxations; ++round) {
      progress.report("evening out", static_cast<double>(round) / kRelaxations);
      const Points old_positions = positions, old_normals = normals;
      const Triangles old_triangles = triangles;
      const bool old_metric = metric_from_layout;
      const Soundness before = soundness_of(positions, normals, triangles);
      const int needles = detail::count_needles(positions, triangles, result.on_network);
      if (!detail::relax_triangles(positions, normals, triangles, result.on_network)) return;
      const EdgeLengths lengths = edge_lengths(positions, triangles);
      bool better = false;
      try {
        set_up(lengths);
        metric_from_layout = false;
        pass();
        const Soundness now = soundness_of(positions, normals, triangles);
        better = now.folded <= before.folded && now.degenerate <= before.degenerate &&
                 detail::count_needles(positions, triangles, result.on_network) < needles;
      } catch (const SolverFailure&) {  // the triangles before can be solved for
      }
      if (!better) {
        positions = old_positions;
        normals = old_normals;
        triangles = old_triangles;
        metric_from_layout = old_metric;
        return set_up(metric_lengths);
      }
      metric_lengths = lengths;
    }
  }

  /// Once more at the end, with normals in which mean curvature may bend; what was before stays where
  /// triangles would fold or flatten, or a vertex move far: there the curves say too little, and curvature
  /// that changes least is the safer. Normals that were estimated from the curves are too rough for it
  /// altogether. Smooth shapes come out up to thirty times nearer to the truth
  /// (docs/surface.md#mean-curvature-that-bends); the factor of sixth order is too dear for every rebuild.
  void let_curvature_bend(const Progress& progress) {
    if (options.method != SurfaceMethod::Curvature || options.soft_constraints || metric_from_layout) return;
    ScopedStage stage(result.times, "geometry");
    const Points old_positions = positions, old_normals = normals;
    const Soundness before = soundness_of(positions, normals, triangles);
    bool sound = false;
    try {
      metric_lengths = edge_lengths(positions, triangles);
      systems->set_metric(triangles, metric_lengths);
      refine_normals(NormalEnergy::Gradient, progress);
      progress.report("curvature", kNormalPasses / (kNormalPasses + 1.0));
      fit_positions();
      progress.report("curvature", 1);
      const Soundness now = soundness_of(positions, normals, triangles);
      sound = now.folded <= before.folded && now.degenerate <= before.degenerate &&
              (positions - old_positions).rowwise().norm().maxCoeff() < kFarthestBend;
    } catch (const SolverFailure&) {  // what was before stays
    }
    if (sound) return;
    positions = old_positions;
    normals = old_normals;
  }

  void finish() {
    ScopedStage stage(result.times, "output");
    result.n_cycles = static_cast<int>(cycles.size());
    result.warnings.insert(result.warnings.end(), patch_warnings.begin(), patch_warnings.end());
    warnings_of_build = result.warnings;
    take_soundness(soundness_of(positions, normals, triangles));
    result.folded = detail::all_folded(positions, normals, triangles);
    result.mesh.triangles = triangles;
    result.mesh.positions = (positions * scaled_network.diameter).rowwise() + scaled_network.centre;
    // Interpolation is exact, not up to the rounding of the scaling.
    if (!options.soft_constraints)
      result.mesh.positions.topRows(network.positions.rows()) = network.positions;
    result.mesh.normals = normals;
    sides.weld(result);
  }

  void take_soundness(const Soundness& s) {
    result.folded_triangles = s.folded;
    result.degenerate_triangles = s.degenerate;
    result.warnings = warnings_of_build;
    if (s.folded > 0)
      result.warnings.push_back(
          concat(s.folded,
                 " triangles are turned away from the propagated normals; the network has too few "
                 "curves there, or normals that contradict its curves"));
    if (s.degenerate > 0)
      result.warnings.push_back(concat(s.degenerate, " triangles have an angle below half a degree"));
  }

  SurfaceMove move(const Points& moved_positions, const Points& moved_normals,
                   const SurfaceMoveOptions& move_options) {
    const CurveNetwork& whole = sides.any() ? uncut : network;
    const Index n = whole.positions.rows();
    if (moved_positions.rows() != n || moved_normals.rows() != n)
      throw InvalidInput(concat("moving a network of ", n,
                                " vertices needs as many positions and normals, got ", moved_positions.rows(),
                                " and ", moved_normals.rows()));
    if (!moved_positions.allFinite() || !moved_normals.allFinite())
      throw InvalidInput("a moved vertex has a coordinate that is not a number");
    CurveNetwork moved = whole;
    moved.positions = moved_positions;
    moved.normals = moved_normals;
    if (sides.any()) {
      uncut = moved;
      moved = split_at_sharp_curves(uncut, uncut_cycles).network;
    }
    ScaledNetwork scaled = scaled_network;
    detail::rescale_network(moved, scaled);
    detail::calm_crowded_normals(moved, scaled);
    if (!mover)
      mover = std::make_unique<detail::SurfaceMover>(*systems, triangles, metric_from_layout, options.method,
                                                     positions, normals, scaled_network);
    const detail::MovedVertices changed = mover->move(scaled.positions, scaled.normals, move_options);
    network = std::move(moved);
    const auto moved_by = [&](Index v) -> RowVector3d {
      if (v < network.positions.rows() && !options.soft_constraints) return network.positions.row(v);
      return mover->positions().row(v) * scaled_network.diameter + scaled_network.centre;
    };
    SurfaceMove report;
    report.patches_solved = changed.parts_solved;
    std::vector<std::array<int, 2>> rows;  // welded, and before
    for (const int v : changed.vertices) rows.push_back({sides.row(v), v});
    if (sides.any()) std::sort(rows.begin(), rows.end());
    for (const auto& [row, v] : rows) {
      if (const RowVector3d p = moved_by(v); p != result.mesh.positions.row(row)) {
        result.mesh.positions.row(row) = p;
        detail::append(report.positions, row);
      }
      if (move_options.positions_only) continue;
      if (const RowVector3d N = sides.normal(row, mover->normals()); N != result.mesh.normals.row(row)) {
        result.mesh.normals.row(row) = N;
        detail::append(report.normals, row);
      }
    }
    if (!move_options.positions_only) take_soundness(mover->soundness());
    return report;
  }

  std::vector<std::string> patch_warnings, warnings_of_build;
  std::unique_ptr<detail::SurfaceMover> mover;  ///< made by the first move
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
  detail::check_cycles(cycles, network);
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

SurfaceMove SurfaceSolver::move(const Points& positions, const Points& normals,
                                const SurfaceMoveOptions& options) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  return implementation_->move(positions, normals, options);
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
