#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "batten/scan/node_search_detail.hpp"

namespace batten {

namespace {

using Eigen::Vector3d;

constexpr size_t kBeam = 128;     ///< numberings that are kept
constexpr size_t kBranches = 12;  ///< ways to add a curve to one of them
/// Gains that differ by less are about the same.
constexpr double kAlike = 8;
/// Twice the log odds that a visit that fits is none by chance: places within a thousandth of the volume of
/// the object, normals within a hundredth of all.
constexpr double kVisitGain = 23;
/// What a curve must bring on top that meets itself: most do not.
constexpr double kSelfCost = 12;

/// A numbering under way.
struct BeamState {
  StayNumbering found;
  std::vector<char> placed;  // per curve
  std::vector<int> visits;   // per node
  std::vector<int> number;   // per node, given ones; else −1
};

/// What a translation of a curve makes of its stays.
struct Placement {
  Vector3d shift = Vector3d::Zero();
  std::vector<int> node_of;  // −1: a new one
  double gain = 0;
  int n_matched = 0;
};

class NumberingSearch {
 public:
  NumberingSearch(const std::vector<std::vector<CurveStay>>& curves, const StayNoise& noise)
      : curves_(curves), noise_(noise) {}

  std::vector<StayNumbering> run(const Progress& progress) {
    std::vector<BeamState> beam{start()};
    for (size_t round = 1; round < curves_.size(); ++round) {
      progress.report("nodes", static_cast<double>(round) / static_cast<double>(curves_.size()));
      std::vector<BeamState> next;
      for (const BeamState& state : beam) extend(state, next);
      keep_best(next);
      beam = std::move(next);
    }
    for (BeamState& state : beam) improve(state);
    keep_best(beam);
    std::vector<StayNumbering> all;
    for (BeamState& state : beam) {
      state.found.is_complete =
          std::all_of(state.placed.begin(), state.placed.end(), [](char p) { return p != 0; });
      all.push_back(std::move(state.found));
    }
    return all;
  }

 private:
  BeamState start() const {
    size_t first = 0;
    for (size_t c = 1; c < curves_.size(); ++c)
      if (curves_[c].size() > curves_[first].size()) first = c;
    BeamState state;
    state.placed.assign(curves_.size(), 0);
    state.found.node_of.resize(curves_.size());
    for (size_t c = 0; c < curves_.size(); ++c) state.found.node_of[c].assign(curves_[c].size(), -1);
    state.found.shifts.assign(curves_.size(), Vector3d::Zero());
    Placement none;
    none.node_of.assign(curves_[first].size(), -1);
    add(first, none, state);
    return state;
  }

  /// The distance of a stay from the nearest one of those that hold the curve.
  double along(size_t c, size_t i, const std::vector<size_t>& held) const {
    double least = std::numeric_limits<double>::infinity();
    for (const size_t j : held)
      least = std::min(least, std::abs(curves_[c][i].distance - curves_[c][j].distance));
    return least;
  }

  /// Every stay of a curve at the best node near it, none twice.
  void match(size_t c, const BeamState& state, const std::vector<size_t>& held, Placement& p) const {
    const std::vector<CurveStay>& stays = curves_[c];
    p.node_of.assign(stays.size(), -1);
    p.gain = 0;
    p.n_matched = 0;
    std::vector<char> taken(state.visits.size(), 0);
    for (size_t i = 0; i < stays.size(); ++i) {
      if (stays[i].same_as >= 0) {
        p.node_of[i] = p.node_of[static_cast<size_t>(stays[i].same_as)];
        continue;
      }
      const double away = along(c, i, held);
      double least = kMostStayMisfit;
      for (size_t k = 0; k < state.visits.size(); ++k) {
        if (taken[k] != 0 || !may_be(stays[i].number, state.number[k])) continue;
        const double misfit =
            stay_misfit(stays[i], p.shift, state.found.places[k], state.found.normals[k], away, noise_);
        if (misfit < least) least = misfit, p.node_of[i] = static_cast<int>(k);
      }
      if (p.node_of[i] < 0) continue;
      taken[static_cast<size_t>(p.node_of[i])] = 1;
      p.gain += kVisitGain - least;
      ++p.n_matched;
    }
  }

  static bool may_be(int number, int of_node) { return number < 0 || of_node < 0 || number == of_node; }

  /// The placements that a hypothesis, stay i at node k, leads to: matched, moved to the mean of the matches,
  /// and matched anew.
  Placement placement(size_t c, size_t i, size_t k, const BeamState& state) const {
    Placement p;
    p.shift = state.found.places[k] - curves_[c][i].place;
    std::vector<size_t> held{i};
    for (int pass = 0; pass < 2; ++pass) {
      match(c, state, held, p);
      Vector3d sum = Vector3d::Zero();
      held.clear();
      for (size_t j = 0; j < p.node_of.size(); ++j) {
        if (p.node_of[j] < 0) continue;
        sum += state.found.places[static_cast<size_t>(p.node_of[j])] - curves_[c][j].place;
        held.push_back(j);
      }
      if (held.empty()) break;
      p.shift = sum / static_cast<double>(held.size());
    }
    return p;
  }

  std::vector<Placement> placements(size_t c, const BeamState& state) const {
    std::vector<Placement> all;
    const double most_angle2 = kMostStayMisfit * 2 * noise_.normal * noise_.normal;
    for (size_t i = 0; i < curves_[c].size(); ++i) {
      if (curves_[c][i].same_as >= 0) continue;
      for (size_t k = 0; k < state.visits.size(); ++k) {
        if ((curves_[c][i].normal - state.found.normals[k]).squaredNorm() > most_angle2 ||
            !may_be(curves_[c][i].number, state.number[k]))
          continue;
        Placement p = placement(c, i, k, state);
        if (p.n_matched == 0) continue;
        const bool is_known =
            std::any_of(all.begin(), all.end(), [&](const Placement& q) { return q.node_of == p.node_of; });
        if (!is_known) all.push_back(std::move(p));
      }
    }
    std::stable_sort(all.begin(), all.end(),
                     [](const Placement& a, const Placement& b) { return a.gain > b.gain; });
    if (all.size() > kBranches) all.resize(kBranches);
    return all;
  }

  /// A numbering without one of its curves.
  BeamState without(size_t left_out, const StayNumbering& old) const {
    BeamState state;
    state.placed.assign(curves_.size(), 0);
    state.found.node_of.resize(curves_.size());
    state.found.shifts.assign(curves_.size(), Vector3d::Zero());
    std::vector<int> now(old.places.size(), -1);
    for (size_t c = 0; c < curves_.size(); ++c) {
      state.found.node_of[c].assign(curves_[c].size(), -1);
      if (c == left_out || curves_[c].empty() || old.node_of[c][0] < 0) continue;
      Placement p;
      p.shift = old.shifts[c];
      for (size_t i = 0; i < curves_[c].size(); ++i) {
        const int node = now[static_cast<size_t>(old.node_of[c][i])];
        p.node_of.push_back(node);
        if (node < 0 || curves_[c][i].same_as >= 0) continue;
        const auto k = static_cast<size_t>(node);
        p.gain += kVisitGain - stay_misfit(curves_[c][i], p.shift, state.found.places[k],
                                           state.found.normals[k], 0, noise_);
      }
      add(c, p, state);
      for (size_t i = 0; i < curves_[c].size(); ++i)
        now[static_cast<size_t>(old.node_of[c][i])] = state.found.node_of[c][i];
    }
    return state;
  }

  /// Takes each curve out and puts it where it fits best among the others, as long as that gains something:
  /// a curve that came early was placed by few.
  void improve(BeamState& state) const {
    constexpr int kSweeps = 3;
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      bool improved = false;
      for (size_t c = 0; c < curves_.size(); ++c) {
        BeamState other = without(c, state.found);
        const std::vector<Placement> all = placements(c, other);
        if (all.empty()) continue;
        add(c, all.front(), other);
        if (other.found.gain < state.found.gain + 1) continue;
        state = std::move(other);
        improved = true;
      }
      if (!improved) break;
    }
  }

  /// Adds the curve whose best placement brings most; of those that bring about as much the one that has the
  /// fewest such placements: the others will have fewer once it is there.
  void extend(const BeamState& state, std::vector<BeamState>& next) const {
    std::vector<Placement> best;
    size_t curve = 0, fewest = 0;
    for (size_t c = 0; c < curves_.size(); ++c) {
      if (state.placed[c] != 0) continue;
      std::vector<Placement> all = placements(c, state);
      if (all.empty()) continue;
      const double most = all.front().gain, known = best.empty() ? -kAlike : best.front().gain;
      const auto n = static_cast<size_t>(
          std::count_if(all.begin(), all.end(), [&](const Placement& p) { return p.gain > most - kAlike; }));
      if (most < known - kAlike || (most < known + kAlike && !best.empty() && n >= fewest)) continue;
      best = std::move(all);
      curve = c;
      fewest = n;
    }
    if (best.empty()) next.push_back(state);  // nothing fits: the rest stays away
    for (const Placement& p : best) {
      next.push_back(state);
      add(curve, p, next.back());
    }
  }

  void add(size_t c, const Placement& p, BeamState& state) const {
    StayNumbering& found = state.found;
    state.placed[c] = 1;
    found.shifts[c] = p.shift;
    found.gain += p.gain;
    const size_t known = state.visits.size();
    for (size_t i = 0; i < curves_[c].size(); ++i) {
      const CurveStay& stay = curves_[c][i];
      int& node = found.node_of[c][i];
      if (stay.same_as >= 0) {
        node = found.node_of[c][static_cast<size_t>(stay.same_as)];
        continue;
      }
      node = p.node_of[i] >= 0 ? p.node_of[i] : self_match(c, i, known, state);
      const Vector3d place = stay.place + p.shift;
      if (node < 0) {
        node = static_cast<int>(state.visits.size());
        found.places.push_back(place);
        found.normals.push_back(stay.normal);
        state.visits.push_back(1);
        state.number.push_back(stay.number);
        continue;
      }
      const auto k = static_cast<size_t>(node);
      const double n = ++state.visits[k];
      found.places[k] += (place - found.places[k]) / n;
      found.normals[k] = (found.normals[k] * (n - 1) + stay.normal).normalized();
      if (state.number[k] < 0) state.number[k] = stay.number;
    }
  }

  /// An earlier stay of the same curve where it meets itself, or −1.
  int self_match(size_t c, size_t i, size_t known, BeamState& state) const {
    const CurveStay& stay = curves_[c][i];
    int node = -1;
    double least = kMostStayMisfit - kSelfCost;
    for (size_t j = 0; j < i; ++j) {
      const int k = state.found.node_of[c][j];
      if (k < static_cast<int>(known) || !may_be(stay.number, state.number[static_cast<size_t>(k)])) continue;
      const double away = std::abs(stay.distance - curves_[c][j].distance);
      const double misfit =
          stay_misfit(stay, state.found.shifts[c], state.found.places[static_cast<size_t>(k)],
                      state.found.normals[static_cast<size_t>(k)], away, noise_);
      if (misfit < least) least = misfit, node = k;
    }
    if (node >= 0) state.found.gain += kVisitGain - kSelfCost - least;
    return node;
  }

  /// The best states, none twice: nodes named in the order of the visits.
  static void keep_best(std::vector<BeamState>& states) {
    std::stable_sort(states.begin(), states.end(),
                     [](const BeamState& a, const BeamState& b) { return a.found.gain > b.found.gain; });
    std::set<std::vector<int>> seen;
    std::vector<BeamState> kept;
    for (BeamState& state : states) {
      if (kept.size() == kBeam) break;
      std::vector<int> name(state.visits.size(), -1), key;
      int names = 0;
      for (const std::vector<int>& of_curve : state.found.node_of)
        for (const int node : of_curve) {
          if (node >= 0 && name[static_cast<size_t>(node)] < 0) name[static_cast<size_t>(node)] = names++;
          key.push_back(node < 0 ? -1 : name[static_cast<size_t>(node)]);
        }
      if (seen.insert(std::move(key)).second) kept.push_back(std::move(state));
    }
    states = std::move(kept);
  }

  const std::vector<std::vector<CurveStay>>& curves_;
  const StayNoise& noise_;
};

}  // namespace

double stay_misfit(const CurveStay& stay, const Vector3d& shift, const Vector3d& place,
                   const Vector3d& normal, double along, const StayNoise& noise) {
  const double part = noise.part * along;
  // The node has an error as well, as if it lay a quarter of the size from where it is known.
  const double variance = 2 * noise.floor * noise.floor + noise.walk * (along + 0.25) + part * part;
  return (stay.place + shift - place).squaredNorm() / variance +
         (stay.normal - normal).squaredNorm() / (2 * noise.normal * noise.normal);
}

std::vector<StayNumbering> search_numberings(const std::vector<std::vector<CurveStay>>& curves,
                                             const StayNoise& noise, const Progress& progress) {
  return NumberingSearch(curves, noise).run(progress);
}

}  // namespace batten
