#include <limits>

#include "batten/remeshing/fit_ring_detail.hpp"

namespace batten::remeshing {

using Eigen::Vector3d;

void FitRing::gather(const HalfedgeMesh& mesh, const FitSamples& samples, int vertex) {
  spokes.clear();
  entries.clear();
  mesh.for_each_outgoing(vertex, [&](int h) {
    Spoke spoke;
    spoke.b = mesh.position(mesh.to(h));
    spoke.c = mesh.position(mesh.tip(h));
    spoke.squared_far_side = (spoke.c - spoke.b).squaredNorm();
    spoke.face = HalfedgeMesh::face(h);
    spoke.normal = mesh.area_normal(spoke.face);
    const double length = spoke.normal.norm();
    if (length > 0) spoke.normal /= length;
    spoke.sector = spokes.empty() ? 0 : spokes.back().sector + (mesh.is_marked(h) ? 1 : 0);
    spokes.push_back(spoke);
  });
  // The last sector goes on in the first unless a feature edge parts them.
  if (!mesh.is_border_vertex(vertex) && !mesh.is_marked(mesh.outgoing(vertex))) {
    const int last = spokes.back().sector;
    for (Spoke& spoke : spokes)
      if (spoke.sector == last) spoke.sector = 0;
  }
  for (std::size_t k = 0; k < spokes.size(); ++k)
    for (const int s : samples.of_face(spokes[k].face))
      entries.push_back({samples[s], s, static_cast<int>(k)});
  area = 0;
  for (const Entry& entry : entries) area += entry.sample.area;
  has_sectors = false;
  for (const Spoke& spoke : spokes) has_sectors = has_sectors || spoke.sector != spokes[0].sector;
}

std::size_t FitRing::spoke_of(const Entry& entry, const Vector3d& p) const {
  const auto first = static_cast<std::size_t>(entry.spoke);
  const std::size_t m = spokes.size();
  std::size_t best = first;
  double best_margin = std::min(p.dot(trials[first].after_b), p.dot(trials[first].before_c));
  for (std::size_t step = 1; step < m && best_margin < 0; ++step) {
    const std::size_t k = first + step < m ? first + step : first + step - m;
    if (has_sectors && spokes[k].sector != spokes[first].sector) continue;
    const double margin = std::min(p.dot(trials[k].after_b), p.dot(trials[k].before_c));
    if (margin > best_margin) {
      best_margin = margin;
      best = k;
    }
  }
  return best;
}

double FitRing::cost(const Vector3d& x, double length, double least_sine, double bound,
                     const FitWeights& weights) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::size_t m = spokes.size();
  trials.resize(m);
  double cost = 0;
  for (std::size_t k = 0; k < m; ++k) {
    const Spoke& spoke = spokes[k];
    const Vector3d u = spoke.b - x, w = spoke.c - x;
    const Vector3d n = cross(u, w);
    const double doubled = n.norm();
    if (!(doubled > 0)) return kInfinity;
    Trial& trial = trials[k];
    trial.normal = n / doubled;
    if (!(trial.normal.dot(spoke.normal) > kSameSide)) return kInfinity;
    const double sine =
        sine_of_smallest_angle(doubled, u.squaredNorm(), w.squaredNorm(), spoke.squared_far_side);
    if (sine < least_sine) return kInfinity;
    trial.after_b = cross(trial.normal, u);
    trial.before_c = cross(w, trial.normal);
    cost += weights.of_shape(sine, length);
  }
  shape = cost;
  for (const Entry& entry : entries) {
    if (cost > bound) return kInfinity;
    const Vector3d p = entry.sample.point - x;
    cost += weights.of_point(entry.sample, trials[spoke_of(entry, p)].normal, x, length);
  }
  return cost;
}

double FitRing::least_sine(const Vector3d& x) const {
  double least = 1;
  for (const Spoke& spoke : spokes) {
    const Vector3d u = spoke.b - x, w = spoke.c - x;
    least = std::min(least, sine_of_smallest_angle(cross(u, w).norm(), u.squaredNorm(), w.squaredNorm(),
                                                   spoke.squared_far_side));
  }
  return least;
}

}  // namespace batten::remeshing
