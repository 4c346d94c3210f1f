#include <cmath>
#include <utility>

#include <Eigen/Dense>

#include "batten/core/index.hpp"
#include "batten/core/units.hpp"
#include "batten/network/sharp_chain_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Vector3d;

/// A value known at an arc length.
struct Known {
  double arc, value;
};

/// The slope at k: of the parabola through a value and its neighbours, or through the three at an end.
double slope_at(const std::vector<Known>& known, std::size_t k) {
  const std::size_t n = known.size();
  if (n < 2) return 0;
  const std::size_t middle = k == 0 ? 1 : k + 1 == n ? n - 2 : k;
  const auto rise = [&](std::size_t i) {
    return (known[i + 1].value - known[i].value) / (known[i + 1].arc - known[i].arc);
  };
  if (n == 2) return rise(0);
  const double before = known[middle].arc - known[middle - 1].arc,
               after = known[middle + 1].arc - known[middle].arc;
  const double bend = (rise(middle) - rise(middle - 1)) / (before + after);
  if (k == 0) return rise(0) - bend * before;
  if (k + 1 == n) return rise(n - 2) + bend * after;
  return rise(middle - 1) + bend * before;
}

double cubic_at(const std::vector<Known>& known, double arc) {
  if (arc <= known.front().arc) return known.front().value;
  if (arc >= known.back().arc) return known.back().value;
  std::size_t k = 0;
  while (known[k + 1].arc < arc) ++k;
  const double width = known[k + 1].arc - known[k].arc, t = (arc - known[k].arc) / width;
  const double t2 = t * t, t3 = t2 * t;
  return (2 * t3 - 3 * t2 + 1) * known[k].value + (3 * t2 - 2 * t3) * known[k + 1].value +
         width * ((t3 - 2 * t2 + t) * slope_at(known, k) + (t3 - t2) * slope_at(known, k + 1));
}

/// The references square to the curve. At nodes, where curves of several sides meet, they are carried on from
/// the samples around.
std::vector<Vector3d> calm_references(const SharpChain& chain) {
  const auto n = static_cast<int>(chain.points.size());
  std::vector<Vector3d> references = chain.references;
  const auto inner = [&](int k) -> const Vector3d* {
    if (chain.periodic) k = (k + n - 1) % (n - 1);
    return k >= 0 && k < n && !chain.is_node[at(k)] ? &chain.references[at(k)] : nullptr;
  };
  for (int k = 0; k < n; ++k) {
    if (!chain.is_node[at(k)]) continue;
    const Vector3d *b = inner(k - 1), *bb = inner(k - 2), *a = inner(k + 1), *aa = inner(k + 2);
    if (b != nullptr && a != nullptr && bb != nullptr && aa != nullptr)
      references[at(k)] = 4 * (*b + *a) - (*bb + *aa);  // of fourth order in the step
    else if (b != nullptr && a != nullptr)
      references[at(k)] = *b + *a;
    else if (b != nullptr)
      references[at(k)] = bb != nullptr ? Vector3d(2 * *b - *bb) : *b;
    else if (a != nullptr)
      references[at(k)] = aa != nullptr ? Vector3d(2 * *a - *aa) : *a;
  }
  for (int k = 0; k < n; ++k) {
    const Vector3d t = chain.tangent(at(k));
    Vector3d& m = references[at(k)];
    m -= t * t.dot(m);
    m = m.norm() > 1e-6 ? m.normalized() : t.unitOrthogonal();
  }
  return references;
}

}  // namespace

Vector3d SharpChain::tangent(std::size_t k) const {
  const std::size_t n = points.size();
  std::size_t b = k > 0 ? k - 1 : k, a = k + 1 < n ? k + 1 : k;
  if (periodic && n > 3) {
    if (k == 0) b = n - 2;
    if (k + 1 == n) a = 1;
  }
  if (b == k || a == k) {
    if (n < 3) return (points[a] - points[b]).normalized();
    // One-sided: the parabola through the last three.
    const std::size_t first = b == k ? k : k, second = b == k ? k + 1 : k - 1, third = b == k ? k + 2 : k - 2;
    const Vector3d p = points[second] - points[first], q = points[third] - points[first];
    const double s = p.norm(), u = s + (points[third] - points[second]).norm();
    const Vector3d t = p / s * (u / (u - s)) - q / u * (s / (u - s));
    return b == k ? t.normalized() : Vector3d(-t.normalized());
  }
  const Vector3d p = points[k] - points[b], q = points[a] - points[k];
  const double s = p.norm(), u = q.norm();
  return (p / s * u + q / u * s).normalized();
}

void close_chains(const NetworkCurve& curve, std::vector<SharpChain>& chains,
                  const std::function<int(int)>& part) {
  if (!curve.closed() || chains.empty()) return;
  SharpChain &first = chains.front(), &last = chains.back();
  if (first.places.front() != 0 || last.places.back() + 1 != curve.vertices.size() ||
      part(first.corners.front()) != part(last.corners.back()))
    return;
  if (chains.size() == 1) {
    first.periodic = true;
    return;
  }
  last.corners.insert(last.corners.end(), first.corners.begin() + 1, first.corners.end());
  last.places.insert(last.places.end(), first.places.begin() + 1, first.places.end());
  first = std::move(last);
  chains.pop_back();
}

void interpolate_normals(SharpChain& chain) {
  const std::size_t n = chain.points.size();
  const std::vector<Vector3d> references = calm_references(chain);
  std::vector<double> arcs(n, 0);
  for (std::size_t k = 1; k < n; ++k) arcs[k] = arcs[k - 1] + (chain.points[k] - chain.points[k - 1]).norm();
  std::vector<Known> known;
  for (std::size_t k = 0; k < n; ++k) {
    if (chain.normals[k].squaredNorm() == 0 || (chain.periodic && k + 1 == n)) continue;
    const Vector3d sideways = references[k].cross(chain.tangent(k));
    double angle = std::atan2(chain.normals[k].dot(sideways), chain.normals[k].dot(references[k]));
    if (!known.empty()) angle = known.back().value + std::remainder(angle - known.back().value, 2 * kPi);
    known.push_back({arcs[k], angle});
  }
  if (chain.periodic) {  // two more on each side, so that slopes go on around the curve
    const std::vector<Known> once = known;
    const double turns = std::remainder(once.front().value - once.back().value, 2 * kPi) + once.back().value -
                         once.front().value;
    for (int more = 0; more < 2; ++more) {
      known.insert(known.begin(), once.begin(), once.end());
      for (std::size_t i = 0; i < once.size(); ++i) {
        known[i].arc -= (more + 1) * arcs.back();
        known[i].value -= (more + 1) * turns;
      }
      for (Known k : once) {
        k.arc += (more + 1) * arcs.back();
        k.value += (more + 1) * turns;
        known.push_back(k);
      }
    }
  }
  for (std::size_t k = 0; k < n; ++k) {
    if (chain.normals[k].squaredNorm() > 0) continue;
    const double angle = cubic_at(known, arcs[k]);
    chain.normals[k] =
        std::cos(angle) * references[k] + std::sin(angle) * references[k].cross(chain.tangent(k));
  }
}

}  // namespace batten::detail
