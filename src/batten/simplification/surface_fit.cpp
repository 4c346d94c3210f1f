#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "batten/core/parallel.hpp"
#include "batten/core/units.hpp"
#include "batten/simplification/surface_fit_detail.hpp"

namespace batten::simplification {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr int kNoEdge = HalfedgeMesh::kNone;
constexpr double kLeastCosine = 0.2;   ///< between the normals of a face before and after a step
constexpr int kTriesPerReport = 256;   ///< moves or flips: some 10 ms
constexpr double kLeastHeight = 0.02;  ///< of a triangle over its longest edge, unless it was worse before

/// Closest point of a triangle; after [ericson2005], 5.1.5.
double nearest_on_triangle(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c,
                           double* w) {
  const Vector3d ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  const auto done = [&](double v, double t) {
    w[0] = 1 - v - t;
    w[1] = v;
    w[2] = t;
    return (ap - v * ab - t * ac).squaredNorm();
  };
  if (d1 <= 0 && d2 <= 0) return done(0, 0);
  const Vector3d bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return done(1, 0);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return done(d1 / (d1 - d3), 0);
  const Vector3d cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return done(0, 1);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return done(0, d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    const double d = done(1 - t, t);
    w[0] = 0;  // exactly: callers read off the zeros which edge or corner it is
    return d;
  }
  const double sum = va + vb + vc;
  if (!(sum > 0)) return done(0, 0);
  return done(vb / sum, vc / sum);
}

double smallest_angle(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  // The smallest angle lies opposite the shortest edge.
  const double ab = (b - a).squaredNorm(), bc = (c - b).squaredNorm(), ca = (a - c).squaredNorm();
  const double twice_area = (b - a).cross(c - a).norm();
  const double least = std::min({ab, bc, ca});
  return std::atan2(2 * twice_area, ab + bc + ca - 2 * least);
}

double height_ratio(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  return (b - a).cross(c - a).norm() /
         std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
}

}  // namespace

SurfaceFit::SurfaceFit(HalfedgeMesh& mesh, FaceTree& tree, std::vector<SurfaceSample> samples,
                       const FitOptions& options)
    : mesh_(mesh), tree_(tree), samples_(std::move(samples)), located_(samples_.size()), options_(options) {
  for (const SurfaceSample& s : samples_) area_ += s.area;
}

double SurfaceFit::squared_distance(const Vector3d& p, int f, double* weights) const {
  return nearest_on_triangle(p, mesh_.position(mesh_.from(3 * f)), mesh_.position(mesh_.from(3 * f + 1)),
                             mesh_.position(mesh_.from(3 * f + 2)), weights);
}

void SurfaceFit::locate_one(int s) {
  SurfaceSample& sample = samples_[s];
  Located& at = located_[s];
  at.squared = squared_distance(sample.point, sample.face, at.weights);
  // Walk to better faces across the edge or around the corner on which the nearest point lies.
  for (int steps = 0; steps < 100; ++steps) {
    const double* w = at.weights;
    const int n_zero = (w[0] == 0) + (w[1] == 0) + (w[2] == 0);
    const int from = sample.face;
    if (n_zero == 0) break;
    double weights[3];
    const auto consider = [&](int f) {
      const double d = squared_distance(sample.point, f, weights);
      if (d < at.squared) {
        at.squared = d;
        std::copy(weights, weights + 3, at.weights);
        sample.face = f;
      }
    };
    if (n_zero == 1) {
      const int k = w[0] == 0 ? 1 : w[1] == 0 ? 2 : 0;  // the edge opposite the zero
      const int o = mesh_.opposite(3 * from + k);
      if (o != kNoEdge) consider(HalfedgeMesh::face(o));
    } else {
      const int k = w[0] != 0 ? 0 : w[1] != 0 ? 1 : 2;
      mesh_.for_each_outgoing(mesh_.from(3 * from + k), [&](int h) {
        if (HalfedgeMesh::face(h) != from) consider(HalfedgeMesh::face(h));
      });
    }
    if (sample.face == from) break;
  }
}

void SurfaceFit::start_at(int s, const int* vertices, int n) {
  double best = std::numeric_limits<double>::infinity(), weights[3];
  for (int i = 0; i < n; ++i)
    mesh_.for_each_outgoing(vertices[i], [&](int h) {
      const double d = squared_distance(samples_[s].point, HalfedgeMesh::face(h), weights);
      if (!(d < best)) return;
      best = d;
      samples_[s].face = HalfedgeMesh::face(h);
    });
}

void SurfaceFit::locate(const Progress& progress) {
  const auto search = [&](Eigen::Index begin, Eigen::Index end) {
    for (int s = static_cast<int>(begin); s < end; ++s) {
      locate_one(s);
      const SurfaceSample& sample = samples_[s];
      Located& at = located_[s];
      const int f = sample.face;
      const Vector3d n = mesh_.area_normal(f);
      if (at.weights[0] > 0 && at.weights[1] > 0 && at.weights[2] > 0) {
        at.direction = n.normalized();
        continue;
      }
      Vector3d d = sample.point;
      for (int k = 0; k < 3; ++k) d -= at.weights[k] * mesh_.position(mesh_.from(3 * f + k));
      // On the surface itself the difference has no direction.
      at.direction = at.squared > 1e-20 * n.norm() ? d.normalized() : n.normalized();
    }
  };
  parallel_for(static_cast<Eigen::Index>(samples_.size()), 1024, search, progress);
  first_.assign(mesh_.face_capacity(), kNoEdge);
  next_.resize(samples_.size());
  double sum = 0;
  for (int s = static_cast<int>(samples_.size()) - 1; s >= 0; --s) {
    const int f = samples_[s].face;
    next_[s] = first_[f];
    first_[f] = s;
    sum += samples_[s].area * located_[s].squared;
  }
  rms_ = std::sqrt(sum / area_);
}

bool SurfaceFit::gains_by_flip(int h) const {
  if (!mesh_.can_flip(h)) return false;
  const int o = mesh_.opposite(h);
  const Vector3d &pu = mesh_.position(mesh_.from(h)), &pv = mesh_.position(mesh_.to(h)),
                 &pw = mesh_.position(mesh_.tip(h)), &px = mesh_.position(mesh_.tip(o));
  // Faces after the flip: (x, w, u) and (w, x, v).
  const Vector3d a1 = (pw - px).cross(pu - px), a2 = (px - pw).cross(pv - pw);
  const Vector3d b1 = (pv - pu).cross(pw - pu), b2 = (pu - pv).cross(px - pv);
  const Vector3d before = b1.normalized() + b2.normalized();
  if (a1.dot(before) <= kLeastCosine * a1.norm() * before.norm() ||
      a2.dot(before) <= kLeastCosine * a2.norm() * before.norm())
    return false;
  const double least_after = std::min(height_ratio(px, pw, pu), height_ratio(pw, px, pv));
  const double least_before = std::min(height_ratio(pu, pv, pw), height_ratio(pv, pu, px));
  if (least_after < kLeastHeight && least_after < least_before) return false;
  const double gain = smallest_angle(px, pw, pu) + smallest_angle(pw, px, pv) - smallest_angle(pu, pv, pw) -
                      smallest_angle(pv, pu, px);
  const double area = 0.5 * (b1.norm() + b2.norm());
  const double allowance = options_.flip_shape * budget_ * budget_ * area * gain / (M_PI / 3);
  double change = 0, furthest = 0;
  double weights[3];
  for (const int side : {h, o})
    for (int s = first_[HalfedgeMesh::face(side)]; s != kNoEdge; s = next_[s]) {
      const Vector3d& p = samples_[s].point;
      const double d =
          std::min(nearest_on_triangle(p, px, pw, pu, weights), nearest_on_triangle(p, pw, px, pv, weights));
      change += samples_[s].area * (d - located_[s].squared);
      if (d > located_[s].squared) furthest = std::max(furthest, d);
    }
  return change < allowance && (change < 0 || gain > 0) && !(furthest > largest_);
}

bool SurfaceFit::flip_if_free(int h) {
  const int o = mesh_.opposite(h);
  const int u = mesh_.from(h), v = mesh_.to(h), w = mesh_.tip(h), x = mesh_.tip(o);
  const Vector3d &pu = mesh_.position(u), &pv = mesh_.position(v), &pw = mesh_.position(w),
                 &px = mesh_.position(x);
  star_ = {{{x, w, u}, {px, pw, pu}}, {{w, x, v}, {pw, px, pv}}};
  replaced_ = {HalfedgeMesh::face(h), HalfedgeMesh::face(o)};
  if (tree_.intersects(star_, replaced_)) return false;
  mesh_.flip(h);
  const int f = HalfedgeMesh::face(h), g = HalfedgeMesh::face(o);
  tree_.update(f);
  tree_.update(g);
  int moved = kNoEdge;
  for (const int side : {f, g})
    while (first_[side] != kNoEdge) {
      const int s = first_[side];
      first_[side] = next_[s];
      next_[s] = moved;
      moved = s;
    }
  while (moved != kNoEdge) {
    const int s = moved;
    moved = next_[s];
    double wf[3], wg[3];
    const double df = squared_distance(samples_[s].point, f, wf),
                 dg = squared_distance(samples_[s].point, g, wg);
    const int to = df <= dg ? f : g;
    samples_[s].face = to;
    located_[s].squared = std::min(df, dg);
    std::copy_n(df <= dg ? wf : wg, 3, located_[s].weights);
    located_[s].direction = mesh_.area_normal(to).normalized();
    next_[s] = first_[to];
    first_[to] = s;
  }
  return true;
}

int SurfaceFit::flip_edges(const Progress& progress) {
  const int n = mesh_.halfedge_capacity();
  // What an edge gains depends on its two faces alone: all are asked at once, and those beside a flip again
  // when their turn comes, so that the order of the edges decides as if they were asked one by one.
  std::vector<char> gains(static_cast<std::size_t>(n), 0);
  parallel_for(
      n, 1024,
      [&](Eigen::Index begin, Eigen::Index end) {
        for (int h = static_cast<int>(begin); h < end; ++h)
          gains[h] = mesh_.has_halfedge(h) && mesh_.is_representative(h) && gains_by_flip(h) ? 1 : 0;
      },
      progress.part("flips", 0, 0.7));
  std::vector<char> flipped_face(static_cast<std::size_t>(mesh_.face_capacity()), 0);
  int flipped = 0, tried = 0;
  for (int h = 0; h < n; ++h) {
    if (!mesh_.has_halfedge(h) || !mesh_.is_representative(h)) continue;
    const int o = mesh_.opposite(h);
    const bool changed = flipped_face[HalfedgeMesh::face(h)] != 0 ||
                         (o != kNoEdge && flipped_face[HalfedgeMesh::face(o)] != 0);
    // A flip elsewhere may have made the edge that this one would.
    if (!(changed ? gains_by_flip(h) : gains[h] != 0 && mesh_.can_flip(h))) continue;
    if (tried++ % kTriesPerReport == 0) progress.report("flips", 0.7 + 0.3 * h / n);
    if (!flip_if_free(h)) continue;
    ++flipped;
    flipped_face[HalfedgeMesh::face(h)] = flipped_face[HalfedgeMesh::face(mesh_.opposite(h))] = 1;
  }
  return flipped;
}

SurfaceFit::Pull SurfaceFit::pull_at(int v) const {
  const Vector3d p = mesh_.position(v);
  Pull pull;
  Matrix3d& A = pull.matrix;
  Vector3d normal = Vector3d::Zero(), target = Vector3d::Zero();
  double mass = 0, target_weight = 0;
  int n_faces = 0;
  mesh_.for_each_outgoing(v, [&](int h) {
    const int f = HalfedgeMesh::face(h), k = h % 3;
    pull.held = pull.held || mesh_.is_marked(h);
    const Vector3d &a = mesh_.position(mesh_.to(h)), &b = mesh_.position(mesh_.tip(h));
    const Vector3d corners[3] = {mesh_.position(mesh_.from(3 * f)), mesh_.position(mesh_.from(3 * f + 1)),
                                 mesh_.position(mesh_.from(3 * f + 2))};
    for (int s = first_[f]; s != kNoEdge; s = next_[s]) {
      const Located& at = located_[s];
      const double w = at.weights[k];
      if (w == 0) continue;
      const double r = at.direction.dot(samples_[s].point - at.weights[0] * corners[0] -
                                        at.weights[1] * corners[1] - at.weights[2] * corners[2]);
      const double area = samples_[s].area;
      A.noalias() += (area * w * w) * at.direction * at.direction.transpose();
      pull.right += (area * w * r) * at.direction;
      mass += area * w * w;
    }
    normal += (a - p).cross(b - p);
    pull.least_height = std::min(pull.least_height, height_ratio(p, a, b));
    pull.shortest = std::min(pull.shortest, (a - p).squaredNorm());
    // Apex of the equilateral triangle over the opposite edge, in the plane of the face.
    const Vector3d edge = b - a, middle = 0.5 * (a + b);
    const double l2 = edge.squaredNorm();
    Vector3d up = p - middle;
    up -= edge * (edge.dot(up) / l2);
    const double height = up.norm();
    if (height > 0) {
      target += (middle + up * (0.866 * std::sqrt(l2) / height)) / l2;
      target_weight += 1 / l2;
      ++n_faces;
    }
  });
  if (n_faces > 0) target_weight /= n_faces;
  pull.held = pull.held || target_weight == 0 || normal.squaredNorm() == 0;
  if (pull.held) return pull;
  normal.normalize();
  pull.target = target / (target_weight * n_faces);
  pull.weight = shape_pull_ * budget_ * budget_ * target_weight * mass + 1e-12 * mass + 1e-30;
  pull.tangential = Matrix3d::Identity() - normal * normal.transpose();
  A += pull.weight * pull.tangential + (1e-6 * mass + 1e-30) * Matrix3d::Identity();
  pull.right += pull.weight * (pull.tangential * (pull.target - p));
  return pull;
}

SurfaceFit::Fit SurfaceFit::fit_at(int v, const Vector3d& x, const Pull& pull) const {
  Fit fit{pull.weight * (pull.tangential * (x - pull.target)).squaredNorm(),
          std::numeric_limits<double>::infinity(), 0, 0};
  double w[3];
  mesh_.for_each_outgoing(v, [&](int h) {
    const int f = HalfedgeMesh::face(h);
    const Vector3d &a = mesh_.position(mesh_.to(h)), &b = mesh_.position(mesh_.tip(h));
    const int before = mesh_.opposite(h), after = mesh_.opposite(HalfedgeMesh::prev(h));
    const Vector3d *pa = before == kNoEdge ? nullptr : &mesh_.position(mesh_.tip(before)),
                   *pb = after == kNoEdge ? nullptr : &mesh_.position(mesh_.to(after));
    for (int s = first_[f]; s != kNoEdge; s = next_[s]) {
      const Vector3d& y = samples_[s].point;
      const double near = (y - x).squaredNorm();
      if (near < fit.nearest) {
        fit.nearest = near;
        fit.height = samples_[s].normal.cast<double>().dot(x - y);
      }
      double d = nearest_on_triangle(y, x, a, b, w);
      const double own[3] = {w[0], w[1], w[2]};
      if (own[2] == 0 && pa != nullptr) d = std::min(d, nearest_on_triangle(y, x, *pa, a, w));
      if (own[1] == 0 && pb != nullptr) d = std::min(d, nearest_on_triangle(y, x, b, *pb, w));
      fit.sum += samples_[s].area * d;
      fit.furthest = std::max(fit.furthest, d);
    }
  });
  return fit;
}

bool SurfaceFit::keeps_shape(int v, const Vector3d& q, double least_height) const {
  const Vector3d p = mesh_.position(v);
  bool keeps = true;
  double least_after = 1;
  mesh_.for_each_outgoing(v, [&](int h) {
    const Vector3d &a = mesh_.position(mesh_.to(h)), &b = mesh_.position(mesh_.tip(h));
    const Vector3d before = (a - p).cross(b - p), after = (a - q).cross(b - q);
    if (before.dot(after) < kLeastCosine * before.norm() * after.norm()) keeps = false;
    least_after = std::min(least_after, height_ratio(q, a, b));
  });
  return keeps && !(least_after < kLeastHeight && least_after < least_height);
}

SurfaceFit::Move SurfaceFit::plan_move(int v, int first_attempt) const {
  const Vector3d p = mesh_.position(v);
  const Pull pull = pull_at(v);
  if (pull.held) return {};
  Vector3d step = pull.matrix.ldlt().solve(pull.right);
  if (!step.allFinite()) return {};
  const double longest = 0.5 * std::sqrt(pull.shortest);
  if (step.squaredNorm() > longest * longest) step *= longest / step.norm();
  const Fit present = fit_at(v, p, pull);
  const double away = 1.5 * spacing_ + 3 * budget_;
  const double nearest = std::max(present.nearest, away * away),
               furthest = std::max(present.furthest, largest_),
               highest = std::max(present.height * present.height, largest_);
  for (int attempt = 0; attempt < kAttempts; ++attempt, step *= 0.3) {
    if (attempt < first_attempt) continue;
    const Fit fit = fit_at(v, p + step, pull);
    if (fit.sum < present.sum && !(fit.nearest > nearest) && !(fit.furthest > furthest) &&
        !(fit.height * fit.height > highest) && keeps_shape(v, p + step, pull.least_height))
      return {attempt, p + step};
  }
  return {};
}

bool SurfaceFit::move_if_free(int v, Move move) {
  for (; move.attempt < kAttempts; move = plan_move(v, move.attempt + 1)) {
    star_.clear();
    replaced_.clear();
    mesh_.for_each_outgoing(v, [&](int h) {
      const int a = mesh_.to(h), b = mesh_.tip(h);
      star_.push_back({{v, a, b}, {move.to, mesh_.position(a), mesh_.position(b)}});
      replaced_.push_back(HalfedgeMesh::face(h));
    });
    if (tree_.intersects(star_, replaced_)) continue;
    mesh_.set_position(v, move.to);
    for (const int f : replaced_) tree_.update(f);
    return true;
  }
  return false;
}

std::vector<std::vector<int>> SurfaceFit::independent_vertices() const {
  std::vector<int> colour(static_cast<std::size_t>(mesh_.vertex_capacity()), -1);
  std::vector<std::vector<int>> sets;
  std::vector<char> taken;
  for (int v = 0; v < mesh_.vertex_capacity(); ++v) {
    if (!mesh_.has_vertex(v) || mesh_.is_border_vertex(v)) continue;
    taken.assign(sets.size() + 1, 0);
    mesh_.for_each_neighbour(v, [&](int w) {
      if (colour[w] >= 0) taken[colour[w]] = 1;
    });
    colour[v] = static_cast<int>(std::find(taken.begin(), taken.end(), 0) - taken.begin());
    if (colour[v] == static_cast<int>(sets.size())) sets.emplace_back();
    sets[colour[v]].push_back(v);
  }
  return sets;
}

int SurfaceFit::move_vertices(const Progress& progress) {
  int moved = 0, tried = 0;
  const std::vector<std::vector<int>> sets = independent_vertices();
  std::vector<Move> moves;
  double done = 0;
  for (const std::vector<int>& vertices : sets) {
    // A move depends on the faces around its vertex alone, and no two of the set share one: they are planned
    // at once. Whether the moved faces would meet others is asked one by one.
    moves.assign(vertices.size(), {});
    const double share = static_cast<double>(vertices.size()) / mesh_.vertex_capacity();
    parallel_for(
        static_cast<Eigen::Index>(vertices.size()), 64,
        [&](Eigen::Index begin, Eigen::Index end) {
          for (Eigen::Index i = begin; i < end; ++i) moves[i] = plan_move(vertices[i], 0);
        },
        progress.part("moves", done, done + 0.8 * share));
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      if (tried++ % kTriesPerReport == 0) progress.report("moves", done + 0.8 * share);
      if (move_if_free(vertices[i], moves[i])) ++moved;
    }
    done += share;
  }
  return moved;
}

double SurfaceFit::largest_distance() const {
  double largest = 0;
  for (const Located& at : located_) largest = std::max(largest, at.squared);
  return std::sqrt(largest);
}

double SurfaceFit::mean_smallest_angle() const {
  double sum = 0;
  for (int f = 0; f < mesh_.face_capacity(); ++f)
    if (mesh_.has_face(f))
      sum += smallest_angle(mesh_.position(mesh_.from(3 * f)), mesh_.position(mesh_.from(3 * f + 1)),
                            mesh_.position(mesh_.from(3 * f + 2)));
  return sum / mesh_.n_faces();
}

void SurfaceFit::run(const Progress& progress) {
  if (samples_.empty() || !(area_ > 0) || mesh_.n_faces() == 0) return;
  spacing_ = std::sqrt(area_ / static_cast<double>(samples_.size()));
  shape_pull_ = options_.shape_pull;
  locate(progress.part("fit", 0, 0.05));
  const double rms_before = rms_;
  largest_ = std::pow(largest_distance(), 2);
  for (int round = 0; round < options_.rounds; ++round) {
    const double rounds = options_.rounds;
    const Progress part =
        progress.part("fit", 0.05 + 0.95 * round / rounds, 0.05 + 0.95 * (round + 1) / rounds);
    // 38° is what error-driven collapses reach on smooth shapes at best; 32° and less is poor.
    const double poor = std::clamp((38 - degrees(mean_smallest_angle())) / 6, 0.0, 1.0);
    budget_ = rms_before * (options_.budget_good + (options_.budget_poor - options_.budget_good) * poor);
    if (round > 1 && rms_ > 0) shape_pull_ *= std::clamp(std::pow(0.985 * budget_ / rms_, 6), 0.2, 4.0);
    flip_edges(part.part("flips", 0, 0.2));
    move_vertices(part.part("moves", 0.2, 0.8));
    locate(part.part("samples", 0.8, 1));
  }
}

}  // namespace batten::simplification
