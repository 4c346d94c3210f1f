#include "batten/pipeline/checked_curves.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"

namespace batten {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

Points points_of(const CurveNetwork& network, const NetworkCurve& curve) {
  Points points(static_cast<Index>(curve.vertices.size()), 3);
  for (Index i = 0; i < points.rows(); ++i) points.row(i) = network.positions.row(curve.vertices[at(i)]);
  return points;
}

/// The largest of what a curve is held to, and where.
struct Largest {
  double value = 0;
  Vector3d place = Vector3d::Zero();

  void raise(double candidate, const Vector3d& where) {
    if (candidate > value) value = candidate, place = where;
  }
};

/// Judges one curve by its samples.
class Judge {
 public:
  Judge(const CurveCheckOptions& options, double diameter) : options_(options), diameter_(diameter) {}

  void judge(const std::vector<ContinuitySample>& samples, bool sharp, CheckedCurve& curve) const {
    curve.figures = continuity_figures(samples);
    curve.worst = curve.figures.worst;
    Largest gap, jump, share, distance;
    for (const ContinuitySample& sample : samples) {
      distance.raise(sample.distance, sample.point);
      if (sample.state != ContinuitySample::State::Measured) continue;
      gap.raise(sample.gap, sample.point);
      jump.raise(sample.normal_jump, sample.point);
      share.raise(sample.curvature_jump / std::max(sample.curvature, 1 / diameter_), sample.point);
    }
    curve.max_curvature_share = share.value;
    const bool measured = curve.figures.n_samples > 0;
    if (!measured && curve.figures.n_unfitted == 0) {
      curve.verdict = CurveVerdict::Border;
      return;
    }
    curve.verdict = sharp ? CurveVerdict::Sharp : CurveVerdict::Pass;
    const auto fail = [&](const Largest& largest, std::string reason) {
      if (curve.reasons.empty()) curve.worst = largest.place;
      curve.verdict = CurveVerdict::Fail;
      curve.reasons.push_back(std::move(reason));
    };
    if (distance.value > options_.distance * diameter_)
      fail(distance, concat("lies ", percent(distance.value), " of the size off the surface, more than ",
                            100 * options_.distance, " %"));
    if (!measured)
      fail(distance, "cannot be measured: too few vertices beside it; `batten remesh` makes more");
    if (gap.value > options_.gap * diameter_)
      fail(gap, concat("gap of ", percent(gap.value), " of the size, more than ", 100 * options_.gap, " %"));
    if (sharp) return;
    if (options_.require != ContinuityClass::G0 && jump.value > options_.tolerance)
      fail(jump, concat("normals differ by ", rounded(degrees(jump.value)), " degrees, more than ",
                        degrees(options_.tolerance)));
    if (options_.require == ContinuityClass::G2 && share.value > options_.curvature)
      fail(share, concat("curvatures differ by ", rounded(100 * share.value), " %, more than ",
                         100 * options_.curvature, " %"));
  }

 private:
  static double rounded(double value) { return std::round(1e3 * value) / 1e3; }
  std::string percent(double length) const { return concat(rounded(100 * length / diameter_), " %"); }

  const CurveCheckOptions& options_;
  double diameter_;
};

/// The pieces of a curve that lie within a radius of a place.
std::vector<NetworkCurve> pieces_near(const CurveNetwork& network, const NetworkCurve& curve,
                                      const Vector3d& place, double radius) {
  std::vector<NetworkCurve> pieces;
  bool is_open = false;
  for (const int v : curve.vertices) {
    const bool is_near = (network.positions.row(v).transpose() - place).norm() <= radius;
    if (is_near && !is_open) {
      NetworkCurve piece;
      piece.name = curve.name;
      piece.sharp = curve.sharp;
      pieces.push_back(std::move(piece));
    }
    if (is_near) pieces.back().vertices.push_back(v);
    is_open = is_near;
  }
  std::erase_if(pieces, [](const NetworkCurve& piece) { return piece.vertices.size() < 2; });
  return pieces;
}

}  // namespace

std::optional<std::string> CurveCheckOptions::problem() const {
  const auto positive = [](double value) { return value > 0 && std::isfinite(value); };
  if (!positive(gap)) return concat("gap must be > 0, got ", gap);
  if (!positive(tolerance) || tolerance > kPi)
    return concat("tolerance must be an angle above 0 and at most 180 degrees, got ", degrees(tolerance));
  if (!positive(curvature)) return concat("curvature must be > 0, got ", curvature);
  if (!positive(distance)) return concat("distance must be > 0, got ", distance);
  if (const auto wrong = measure.problem()) return "measure." + *wrong;
  return std::nullopt;
}

CurveCheck check_curves(const TriangleMesh& mesh, const CurveNetwork& network,
                        const CurveCheckOptions& options, const Progress& progress) {
  if (const auto wrong = options.problem()) throw InvalidInput(*wrong);
  if (network.curves.empty()) throw InvalidInput("the network has no curves to check");
  CurveCheck check;
  check.diameter = bounding_box_diagonal(mesh.positions);
  std::vector<Points> curves;
  for (const NetworkCurve& curve : network.curves) curves.push_back(points_of(network, curve));
  const ScopedStage stage(check.times, "check");
  const std::vector<std::vector<ContinuitySample>> samples =
      curve_continuity(mesh.positions, mesh.triangles, curves, options.measure, progress);
  const Judge judge(options, check.diameter);
  for (std::size_t c = 0; c < samples.size(); ++c) {
    CheckedCurve& curve = check.curves.emplace_back();
    curve.name = curve_name(network, static_cast<int>(c));
    judge.judge(samples[c], network.curves[c].sharp, curve);
    check.n_checked += curve.verdict != CurveVerdict::Border ? 1 : 0;
    check.n_failed += curve.verdict == CurveVerdict::Fail ? 1 : 0;
  }
  return check;
}

Surroundings surroundings(const TriangleMesh& mesh, const CurveNetwork& network, int curve,
                          const Vector3d& place, double radius) {
  Surroundings result;
  std::vector<int> local(at(mesh.n_vertices()), -1);
  std::vector<Index> faces;
  for (Index f = 0; f < mesh.n_triangles(); ++f)
    for (int k = 0; k < 3; ++k)
      if ((mesh.positions.row(mesh.triangles(f, k)).transpose() - place).norm() <= radius) {
        faces.push_back(f);
        break;
      }
  if (faces.empty()) throw InvalidInput(concat("no triangle lies within ", radius, " of the place"));
  result.mesh.triangles.resize(static_cast<Index>(faces.size()), 3);
  int n = 0;
  for (std::size_t i = 0; i < faces.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      int& vertex = local[at(mesh.triangles(faces[i], k))];
      if (vertex < 0) vertex = n++;
      result.mesh.triangles(static_cast<Index>(i), k) = vertex;
    }
  result.mesh.positions.resize(n, 3);
  for (Index v = 0; v < mesh.n_vertices(); ++v)
    if (local[at(v)] >= 0) result.mesh.positions.row(local[at(v)]) = mesh.positions.row(v);

  // Weighted by the triangles' areas, so that slivers say nothing.
  Points areas(result.mesh.n_triangles(), 3);
  for (Index f = 0; f < areas.rows(); ++f) {
    const Vector3d a = result.mesh.positions.row(result.mesh.triangles(f, 0)),
                   b = result.mesh.positions.row(result.mesh.triangles(f, 1)),
                   c = result.mesh.positions.row(result.mesh.triangles(f, 2));
    areas.row(f) = (b - a).cross(c - a).transpose();
  }
  const Vector3d normal = areas.colwise().sum().transpose();
  if (normal.norm() > 0) result.normal = normal.stableNormalized();
  double squares = 0;
  for (Index f = 0; f < areas.rows(); ++f) {
    const Vector3d area = areas.row(f);
    const double angle = std::atan2(area.cross(result.normal).norm(), area.dot(result.normal));
    squares += area.norm() * angle * angle;
  }
  result.spread = std::sqrt(squares / std::max(areas.rowwise().norm().sum(), 1e-300));

  result.network.positions = network.positions;
  result.network.unit = network.unit;
  result.network.curves = pieces_near(network, network.curves[at(curve)], place, radius);
  return result;
}

}  // namespace batten
