// How honest the uncertainty of a scan is: for each shape the share of the errors below two deviations, and
// the rank correlation of deviation and error, over seeds that nothing was tuned on.
//
//     bench_uncertainty [SEEDS [FIRST_SEED]]
#include "scan/scan_fixtures.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "batten/core/units.hpp"
#include "batten/mesh/registration.hpp"
#include "batten/pipeline/network_surface.hpp"
#include "batten/rotation/so3.hpp"
#include "batten/scan/reconstruct.hpp"
#include "batten/simulation/shapes.hpp"
#include "batten/simulation/simulate.hpp"

namespace {

using namespace batten;

/// Errors with the deviations foretold for them.
struct Judged {
  std::vector<double> errors, deviations;
  void add(double error, double deviation) {
    errors.push_back(error);
    deviations.push_back(deviation);
  }
};

double coverage(const Judged& judged) {
  double below = 0;
  for (size_t i = 0; i < judged.errors.size(); ++i) below += judged.errors[i] < 2 * judged.deviations[i];
  return 100 * below / static_cast<double>(judged.errors.size());
}

std::vector<double> ranks(const std::vector<double>& values) {
  std::vector<size_t> order(values.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return values[a] < values[b]; });
  std::vector<double> rank(values.size());
  for (size_t i = 0; i < order.size(); ++i) rank[order[i]] = static_cast<double>(i);
  return rank;
}

double rank_correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const std::vector<double> x = ranks(a), y = ranks(b);
  const double mean = 0.5 * (static_cast<double>(a.size()) - 1);
  double xy = 0, xx = 0, yy = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    xy += (x[i] - mean) * (y[i] - mean);
    xx += (x[i] - mean) * (x[i] - mean);
    yy += (y[i] - mean) * (y[i] - mean);
  }
  return xy / std::sqrt(xx * yy);
}

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

void judge_network(const TracedNetwork& traced, const ScanNetwork& result, Judged& points, Judged& curves) {
  const Points truth = test::true_points(traced, result);
  const Points moved =
      fit_transform(result.network.positions, truth, RegistrationKind::Rigid)(result.network.positions);
  const Eigen::VectorXd& deviations = result.uncertainty->deviations;
  for (size_t c = 0; c < traced.curves.size(); ++c) {
    const SampledCurve& curve = result.samples.curves[c];
    const ArcLengthCurve& path = *traced.curves[c].path;
    for (int k = 0; k < curve.n_samples(); ++k) {
      const int v = result.network.curves[c].vertices[static_cast<size_t>(k)];
      const CurvePoint at = path.at(curve.parameters[k] / curve.length() * path.length());
      const Eigen::Vector3d error = moved.row(v).transpose() - at.position;
      points.add(error.norm() / traced.diameter, deviations[v] / traced.diameter);
      curves.add((error - error.dot(at.tangent) * at.tangent).norm() / traced.diameter,
                 deviations[v] / traced.diameter);
    }
  }
}

/// The mesh moved rigidly onto the surface f = 0 (Gauss–Newton on f / |∇f|), from where `start` puts it.
Points registered(const ImplicitFunction& f, const Points& mesh, const SimilarityTransform& start) {
  Points moved = start(mesh);
  for (int round = 0; round < 6; ++round) {
    const Eigen::RowVector3d centre = moved.colwise().mean();
    Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> b = Eigen::Matrix<double, 6, 1>::Zero();
    for (Eigen::Index v = 0; v < moved.rows(); ++v) {
      Eigen::Vector3d gradient;
      const double value = f(moved.row(v).transpose(), gradient);
      const Eigen::Vector3d n = gradient.normalized(), arm = (moved.row(v) - centre).transpose();
      Eigen::Matrix<double, 6, 1> J;
      J << arm.cross(n), n;
      A += J * J.transpose();
      b -= J * (value / gradient.norm());
    }
    A.diagonal().array() += 1e-6 * A.trace();  // round shapes turn in themselves
    const Eigen::Matrix<double, 6, 1> x = A.ldlt().solve(b);
    const Eigen::Matrix3d R = so3_exp(x.head<3>());
    moved = ((moved.rowwise() - centre) * R.transpose()).rowwise() + (centre + x.tail<3>().transpose());
  }
  return moved;
}

void judge_surface(AnalyticShape shape, const TracedNetwork& traced, const ScanNetwork& result,
                   Judged& surface) {
  const NetworkSurface made = uncertain_surface(result.network, *result.uncertainty);
  const ImplicitFunction f = shape_function(shape);
  const SimilarityTransform start =
      fit_transform(result.network.positions, test::true_points(traced, result), RegistrationKind::Rigid);
  const Points moved = registered(f, made.mesh.positions, start);
  const Eigen::VectorXd& deviations = made.mesh.vertex_values.at("uncertainty");
  for (Eigen::Index v = 0; v < moved.rows(); ++v) {
    Eigen::Vector3d gradient;
    const double value = f(moved.row(v).transpose(), gradient);
    surface.add(std::abs(value) / gradient.norm() / traced.diameter, deviations[v] / traced.diameter);
  }
}

/// The network without one of its curves: nodes where fewer than two curves are left are none.
TracedNetwork without_curve(TracedNetwork traced, size_t curve) {
  traced.curves.erase(traced.curves.begin() + static_cast<std::ptrdiff_t>(curve));
  std::map<int, std::set<size_t>> visitors;
  for (size_t c = 0; c < traced.curves.size(); ++c)
    for (const int id : traced.curves[c].node_ids) visitors[id].insert(c);
  for (TracedCurve& c : traced.curves) {
    std::vector<double> distances;
    std::vector<int> ids;
    for (size_t i = 0; i < c.node_ids.size(); ++i) {
      const bool seam = c.closed && (i == 0 || i + 1 == c.node_ids.size());
      if (!seam && visitors[c.node_ids[i]].size() < 2) continue;
      distances.push_back(c.node_distances[i]);
      ids.push_back(c.node_ids[i]);
    }
    c.node_distances = distances;
    c.node_ids = ids;
  }
  return traced;
}

/// The curves whose loss makes the net thin on one side; several where one alone is not felt.
struct Thinned {
  AnalyticShape shape;
  std::vector<size_t> curves;
};
const std::vector<Thinned> kThinned = {
    {AnalyticShape::Ellipsoid, {0}}, {AnalyticShape::BumpyCube, {2, 1}}, {AnalyticShape::Torus, {11, 10}},
    {AnalyticShape::Waves, {9, 8}},  {AnalyticShape::Dish, {2}},         {AnalyticShape::Sphere6, {5, 3}},
};

void print(const std::string& name, const std::vector<const Judged*>& all) {
  std::printf("%-14s", name.c_str());
  for (const Judged* judged : all)
    std::printf(" %7.3f %7.3f %6.1f %6.2f  ", 100 * mean_of(judged->errors),
                100 * mean_of(judged->deviations), coverage(*judged),
                rank_correlation(judged->errors, judged->deviations));
  std::printf("\n");
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const int n_seeds = argc > 1 ? std::atoi(argv[1]) : 100, first = argc > 2 ? std::atoi(argv[2]) : 1000;
  const std::string only = argc > 3 ? argv[3] : "";
  std::printf(
      "mean error, mean deviation (%% of the diameter), share below two deviations (%%), rank correlation\n");
  std::printf("%-14s %-32s%-32s%-32s\n", "", " points", " across the curves", " surface");
  const auto run = [&](const std::string& name, AnalyticShape shape, const TracedNetwork& traced) {
    if (!only.empty() && name.rfind(only, 0) != 0) return;
    Judged points, curves, surface;
    for (int seed = first; seed < first + n_seeds; ++seed) {
      ScanOptions options;
      options.uncertainty = true;
      const ScanNetwork result =
          network_from_scan(simulate_scan(traced, test::noisy_device(seed)).scan, options);
      judge_network(traced, result, points, curves);
      judge_surface(shape, traced, result, surface);
    }
    print(name, {&points, &curves, &surface});
  };
  for (const std::string& word : choice_words<AnalyticShape>()) {
    const auto shape = parse_choice<AnalyticShape>(word);
    run(word, shape, trace_shape(shape));
  }
  for (const Thinned& thinned : kThinned) {
    TracedNetwork traced = trace_shape(thinned.shape);
    for (const size_t curve : thinned.curves) traced = without_curve(traced, curve);
    run("thin " + std::string(word_of(thinned.shape)), thinned.shape, traced);
  }
  return 0;
}
