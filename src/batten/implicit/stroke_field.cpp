#include "batten/implicit/stroke_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/implicit/field_mesh.hpp"
#include "batten/implicit/held_values_detail.hpp"
#include "batten/implicit/slope_search.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/essential_loops.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

namespace {

constexpr int kFewestSites = 8;
/// Sites that lie nearer together say the same twice and spoil the system; in diameters.
constexpr double kLeastGap = 0.003;
/// Two pieces of a stroke that turn by more have no common direction between them.
const double kCornerCosine = std::cos(radians(35));
/// Of adding points that a field did not leave outside.
constexpr int kMostTurns = 4;
/// Strokes in a plane: their extent across it ÷ diameter.
constexpr double kLeastDepth = 1e-3;

// Of the smoothing: how many are tried, by which factor each is less, and by how much it must lessen the
// misses.
constexpr int kLevels = 6;
constexpr double kLevelFactor = 0.316, kWorthwhile = 0.97;
/// Edges of the meshes on which handles are counted, in diameters.
constexpr double kCoarseEdge = 0.025;
/// The largest miss may grow by this factor while the others shrink.
constexpr double kMayGrow = 1.1;
/// Sites that are missed by so many times the median contradict others; smoothing there by this power of it.
constexpr double kUsualMisses = 2, kContradiction = 1;
// Of taking handles away: how many fields are tried in all, across how many loops of one surface, and how
// much more a field without the handle may vary.
constexpr int kMostCuts = 8;
constexpr std::size_t kCutsAtOnce = 4;
constexpr double kMayCost = 1.03;
/// A largest miss that is no reason against it, in diameters.
constexpr double kFarMiss = 0.01;
// What a cut asks for: points half-way between a loop and its middle, which is the first, held as far on the
// other side as they are from the loop, and by this in diameters at least; values of this smoothing.
constexpr int kCutRing = 6;
constexpr double kCutLeast = 0.02, kCutSmoothing = 1e-4;
/// Where the field is flatter, |f| says little about a distance.
constexpr double kLeastSlope = 1e-3;

/// Zero at sites spread over the strokes, with slopes to be found across them.
FieldConditions conditions_on_strokes(const StrokeSamples& samples, const Points& scaled,
                                      const StrokeFieldOptions& options) {
  std::vector<int> with_direction;
  for (Eigen::Index i = 0; i < scaled.rows(); ++i)
    if (samples.directions.row(i).squaredNorm() > 0) with_direction.push_back(static_cast<int>(i));
  const std::vector<int> chosen =
      farthest_points(rows_of(scaled, with_direction), options.most_sites, kLeastGap);
  if (static_cast<int>(chosen.size()) < kFewestSites)
    throw InvalidInput(concat("the strokes have ", chosen.size(), " places with a direction; ", kFewestSites,
                              " are needed to find their normals (longer strokes, or more of them)"));
  const auto n = static_cast<Eigen::Index>(chosen.size());
  FieldConditions conditions;
  conditions.sites.resize(n, 3);
  conditions.values = Eigen::VectorXd::Zero(n);
  conditions.smoothing = Eigen::VectorXd::Constant(n, options.smoothing);
  conditions.across.resize(n, 3);
  conditions.aside.resize(n, 3);
  for (Eigen::Index j = 0; j < n; ++j) {
    const int i = with_direction[at(chosen[at(j)])];
    conditions.sites.row(j) = scaled.row(i);
    const Eigen::RowVector3d t = samples.directions.row(i);
    Eigen::Index least = 0;
    t.cwiseAbs().minCoeff(&least);
    const Eigen::RowVector3d u = t.cross(Eigen::RowVector3d::Unit(least)).normalized();
    conditions.across.row(j) = u;
    conditions.aside.row(j) = t.cross(u).normalized();
  }
  return conditions;
}

/// How far samples are from f = 0, |f|/|∇f| ÷ diameter: 95th percentile and largest.
std::pair<double, double> misfit_of(const StrokeField& field, const Points& samples) {
  std::vector<double> misfit(at(samples.rows()));
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    Eigen::Vector3d gradient;
    const double f = field.value(samples.row(i).transpose(), gradient);
    misfit[at(i)] = std::abs(f) / (std::max(gradient.norm(), kLeastSlope) * field.diameter());
  }
  const double largest = *std::max_element(misfit.begin(), misfit.end());
  return {percentile(misfit, 0.95), largest};
}

/// Smoothing at each site: `least` where the field passes as near as at most sites, more where strokes
/// contradict each other and it passes far away (pieces drawn again, or not on the surface), `most` at most.
Eigen::VectorXd lessened_smoothing(const HermiteField& field, const Points& sites, double least,
                                   double most) {
  std::vector<double> miss(at(sites.rows()));
  for (Eigen::Index j = 0; j < sites.rows(); ++j)
    miss[at(j)] = std::abs(field.value(sites.row(j).transpose()));
  std::vector<double> sorted = miss;
  const double usual = kUsualMisses * percentile(sorted, 0.5);
  Eigen::VectorXd smoothing(sites.rows());
  for (Eigen::Index j = 0; j < sites.rows(); ++j) {
    const double excess = usual > 0 ? std::max(1.0, miss[at(j)] / usual) : 1;
    smoothing[j] = std::min(most, least * std::pow(excess, kContradiction));
  }
  return smoothing;
}

/// A field and what it was found with.
struct Fit {
  Eigen::VectorXd smoothing;  // at the sites on strokes
  std::set<int> held;         // rows of FieldSearch::outside that it would not leave outside by itself
  HeldValues cuts;            // of handles
  FoundSlopes found;
  HermiteField field;
  double p95 = 0, largest = 0;  // misses
  TriangleMesh mesh;            // a rough one
  Eigen::Index n_handles = 0;
  int n_components = 0;
  int n_cuts = 0;
};

struct FieldSearch {
  const StrokeSamples& samples;
  FieldConditions on_strokes;
  HeldValues outside;
  Eigen::Vector3d middle;
  double diameter = 1;
  const Progress& progress;

  StrokeField field_of(const Fit& fit) const { return {fit.field, middle, diameter}; }

  /// Goes down from the slopes that were found, under the other conditions of the fit.
  void descend(Fit& fit) const {
    FieldConditions conditions = on_strokes;
    conditions.smoothing = fit.smoothing;
    for (int turn = 0; turn < kMostTurns; ++turn) {
      HeldValues held = outside.part(fit.held);
      held.append(fit.cuts);
      const SlopeEnergy energy(with_held(conditions, held), progress);
      fit.found = descended_slopes(energy, fit.found.slopes);
      fit.field = energy.field(fit.found.slopes);
      if (!add_not_outside(outside, fit.field, fit.held)) break;
    }
    std::tie(fit.p95, fit.largest) = misfit_of(field_of(fit), samples.positions);
  }

  [[gnu::cold]] void outline(Fit& fit) const {
    LevelSetOptions coarse;
    coarse.edge_length = kCoarseEdge * diameter;
    fit.mesh = field_mesh(field_of(fit), samples, coarse, progress);
    const MeshTopology topology = mesh_topology(fit.mesh.triangles, fit.mesh.n_vertices());
    fit.n_handles = topology.genus().value_or(0);
    fit.n_components = topology.n_components;
  }

  /// Takes handles away as long as the strokes are met as well, and the field varies hardly more, without
  /// them: a handle that strokes go around resists. (Cold: its time is that of the fields; the code stays
  /// small.)
  [[gnu::cold]] void close_handles(Fit& fit) const {
    int tries = 0;
    for (bool is_closed = true; is_closed && fit.n_handles > 0;) {
      is_closed = false;
      for (const HeldValues& cut : handle_cuts(fit)) {
        if (++tries > kMostCuts) return;
        Fit without = fit;
        without.cuts.append(cut);
        ++without.n_cuts;
        descend(without);
        if (without.p95 > std::max(kNearMiss, kMayGrow * fit.p95) ||
            without.largest > std::max(kFarMiss, kMayGrow * fit.largest) ||
            without.found.energy > kMayCost * fit.found.energy)
          continue;
        outline(without);
        if (without.n_handles >= fit.n_handles || without.n_components > fit.n_components) continue;
        fit = std::move(without);
        is_closed = true;
        break;
      }
    }
  }

  /// Points across the smallest loops around handles or through them, which are to lie on the other side.
  [[gnu::cold]] std::vector<HeldValues> handle_cuts(const Fit& fit) const {
    std::vector<HeldValues> cuts;
    Points positions = fit.mesh.positions;
    positions.rowwise() -= middle.transpose();
    positions /= diameter;
    for (const EssentialLoop& loop : essential_loops(positions, fit.mesh.triangles)) {
      const Points ring = rows_of(positions, loop.vertices);
      const Eigen::RowVector3d centre = ring.colwise().mean();
      const double radius = (ring.rowwise() - centre).rowwise().norm().mean();
      const bool is_known = std::any_of(cuts.begin(), cuts.end(), [&](const HeldValues& cut) {
        return (cut.points.row(0) - centre).norm() < radius;
      });
      if (is_known) continue;
      const double side = fit.field.value(centre.transpose()) > 0 ? 1 : -1;
      HeldValues cut;
      cut.points.resize(1 + kCutRing, 3);
      cut.values.resize(1 + kCutRing);
      cut.smoothing = Eigen::VectorXd::Constant(1 + kCutRing, kCutSmoothing);
      cut.points.row(0) = centre;
      cut.values[0] = -side * std::max(radius, kCutLeast);
      int agree = 0;
      for (int k = 0; k < kCutRing; ++k) {
        const Eigen::RowVector3d p = ring.row(k * ring.rows() / kCutRing);
        cut.points.row(1 + k) = 0.5 * (p + centre);
        cut.values[1 + k] = -side * std::max(0.5 * (p - centre).norm(), kCutLeast);
        if (side * fit.field.value(cut.points.row(1 + k).transpose()) > 0) ++agree;
      }
      if (agree < kCutRing) continue;
      cuts.push_back(std::move(cut));
      if (cuts.size() == kCutsAtOnce) break;
    }
    return cuts;
  }
};

double depth_of(const Points& points) {
  const Points centred = points.rowwise() - points.colwise().mean();
  const Eigen::Matrix3d spread = centred.transpose() * centred / static_cast<double>(points.rows());
  return std::sqrt(std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvalues()[0]));
}

}  // namespace

StrokeSamples stroke_samples(const CurveNetwork& strokes, double step) {
  if (!(step > 0)) throw InvalidInput(concat("the step of stroke samples must be positive, got ", step));
  std::vector<Eigen::RowVector3d> positions, directions;
  StrokeSamples samples;
  for (std::size_t c = 0; c < strokes.curves.size(); ++c) {
    const std::vector<int>& vertices = strokes.curves[c].vertices;
    std::vector<double> arc(vertices.size(), 0);
    for (std::size_t k = 1; k < vertices.size(); ++k)
      arc[k] =
          arc[k - 1] + (strokes.positions.row(vertices[k]) - strokes.positions.row(vertices[k - 1])).norm();
    if (!(arc.back() > 0)) continue;
    const bool closed = strokes.curves[c].closed();
    const int n = std::max(1, static_cast<int>(std::lround(arc.back() / step)));
    std::vector<Eigen::RowVector3d> along;
    std::size_t piece = 0;
    for (int i = 0; i <= n - (closed ? 1 : 0); ++i) {
      const double s = arc.back() * i / n;
      while (piece + 2 < vertices.size() && arc[piece + 1] < s) ++piece;
      const double length = arc[piece + 1] - arc[piece];
      const double t = length > 0 ? std::clamp((s - arc[piece]) / length, 0.0, 1.0) : 0;
      along.emplace_back((1 - t) * strokes.positions.row(vertices[piece]) +
                         t * strokes.positions.row(vertices[piece + 1]));
    }
    const std::size_t count = along.size();
    for (std::size_t i = 0; i < count; ++i) {
      const bool has_both = closed ? count > 2 : i > 0 && i + 1 < count;
      Eigen::RowVector3d direction = Eigen::RowVector3d::Zero();
      if (has_both) {
        const Eigen::RowVector3d back = (along[i] - along[(i + count - 1) % count]).normalized();
        const Eigen::RowVector3d ahead = (along[(i + 1) % count] - along[i]).normalized();
        if (back.dot(ahead) > kCornerCosine) direction = (back + ahead).normalized();
      }
      positions.push_back(along[i]);
      directions.push_back(direction);
      samples.stroke.push_back(static_cast<int>(c));
    }
  }
  samples.positions.resize(static_cast<Eigen::Index>(positions.size()), 3);
  samples.directions.resize(samples.positions.rows(), 3);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    samples.positions.row(static_cast<Eigen::Index>(i)) = positions[i];
    samples.directions.row(static_cast<Eigen::Index>(i)) = directions[i];
  }
  return samples;
}

std::vector<int> farthest_points(const Points& points, int count, double least) {
  std::vector<int> chosen;
  Eigen::VectorXd squared = Eigen::VectorXd::Constant(points.rows(), std::numeric_limits<double>::infinity());
  Eigen::Index next = 0;
  while (points.rows() > 0 && static_cast<int>(chosen.size()) < count && squared[next] > least * least) {
    chosen.push_back(static_cast<int>(next));
    squared = squared.cwiseMin((points.rowwise() - points.row(next)).rowwise().squaredNorm());
    squared.maxCoeff(&next);
  }
  return chosen;
}

std::optional<std::string> StrokeFieldOptions::problem() const {
  if (most_sites < kFewestSites)
    return concat("most_sites must be ", kFewestSites, " or more, got ", most_sites);
  if (!(smoothing >= 0) || !std::isfinite(smoothing))
    return concat("smoothing must be 0 or more, got ", smoothing);
  return std::nullopt;
}

StrokeFieldResult stroke_field(const StrokeSamples& samples, const StrokeFieldOptions& options,
                               const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  const double diameter = bounding_box_diagonal(samples.positions);
  if (!(diameter > 0) || !std::isfinite(diameter))
    throw InvalidInput("the strokes lie at one place; a surface needs strokes around a body");
  if (depth_of(samples.positions) < kLeastDepth * diameter)
    throw InvalidInput(
        "the strokes lie in a plane or on a line; a body needs strokes that go around it, a flat piece a "
        "closed "
        "outline");
  StrokeFieldResult result;
  const Eigen::RowVector3d middle =
      0.5 * (samples.positions.colwise().minCoeff() + samples.positions.colwise().maxCoeff());
  const Points scaled = (samples.positions.rowwise() - middle) / diameter;

  FieldSearch search{samples, {}, {}, middle.transpose(), diameter, progress};
  {
    const ScopedStage stage(result.times, "sites");
    search.on_strokes = conditions_on_strokes(samples, scaled, options);
    if (options.closed) search.outside = points_outside(scaled);
    result.n_sites = static_cast<int>(search.on_strokes.across.rows());
  }
  const ScopedStage stage(result.times, "field");
  Fit best, next;
  next.smoothing = search.on_strokes.smoothing;
  next.found = find_slopes(SlopeEnergy(with_held(search.on_strokes, search.outside), progress), progress);
  for (int level = 0; level < kLevels; ++level) {
    const double smoothing = options.smoothing * std::pow(kLevelFactor, level);
    if (level > 0)
      next.smoothing = lessened_smoothing(next.field, search.on_strokes.sites, smoothing, options.smoothing);
    search.descend(next);
    if (level > 0 && !(next.p95 < kWorthwhile * best.p95 && next.largest < kMayGrow * best.largest)) break;
    if (options.closed) {
      search.outline(next);
      if (level > 0 && next.n_handles > best.n_handles) break;
    }
    best = next;
    result.smoothing = smoothing;
    if (best.p95 <= kNearMiss) break;
  }
  if (options.closed) search.close_handles(best);
  result.field = search.field_of(best);
  result.energy = best.found.energy;
  result.misfit_p95 = best.p95;
  result.misfit_max = best.largest;
  result.n_cuts = best.n_cuts;
  return result;
}

}  // namespace batten
