#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include <Eigen/Geometry>

#include "batten/core/parallel.hpp"
#include "batten/simplification/decimator_detail.hpp"

namespace batten::simplification {

using Eigen::Vector3d;

namespace {

constexpr int kNone = HalfedgeMesh::kNone;
/// Twice the area of a face over its longest edge squared: no collapse makes one thinner than kThin where
/// none was, nor than kLeastThin where some were.
constexpr double kThin = 0.02, kLeastThin = 0.001;

void add_outer(double* m, const Vector3d& n, double w) {
  m[0] += w * n.x() * n.x();
  m[1] += w * n.x() * n.y();
  m[2] += w * n.x() * n.z();
  m[3] += w * n.y() * n.y();
  m[4] += w * n.y() * n.z();
  m[5] += w * n.z() * n.z();
}

Vector3d times(const double* m, const Vector3d& x) {
  return {m[0] * x.x() + m[1] * x.y() + m[2] * x.z(), m[1] * x.x() + m[3] * x.y() + m[4] * x.z(),
          m[2] * x.x() + m[4] * x.y() + m[5] * x.z()};
}

/// Inverse of a symmetric positive definite 3 × 3 by cofactors, in the same packing.
bool invert(const double* m, double* inverse) {
  const double c0 = m[3] * m[5] - m[4] * m[4], c1 = m[2] * m[4] - m[1] * m[5], c2 = m[1] * m[4] - m[2] * m[3];
  const double d = m[0] * c0 + m[1] * c1 + m[2] * c2;
  if (!(d > 0)) return false;
  const double r = 1 / d;
  inverse[0] = c0 * r;
  inverse[1] = c1 * r;
  inverse[2] = c2 * r;
  inverse[3] = (m[0] * m[5] - m[2] * m[2]) * r;
  inverse[4] = (m[1] * m[2] - m[0] * m[4]) * r;
  inverse[5] = (m[0] * m[3] - m[1] * m[1]) * r;
  return true;
}

}  // namespace

std::size_t CostQueue::bucket(double cost) {
  // Non-negative floats are ordered as their bits are: exponent and four bits of the fraction.
  const auto narrow = static_cast<float>(cost);
  std::uint32_t bits = 0;
  std::memcpy(&bits, &narrow, sizeof bits);
  return bits >> 19;
}

void CostQueue::push(const Entry& entry) {
  const std::size_t b = bucket(entry.cost);
  if (b > current_) {
    buckets_[b].push_back(entry);
    return;
  }
  heap_.push_back(entry);
  std::push_heap(heap_.begin(), heap_.end());
}

bool CostQueue::pop(Entry& entry) {
  while (heap_.empty()) {
    if (++current_ >= buckets_.size()) {
      current_ = buckets_.size() - 1;
      return false;
    }
    heap_.swap(buckets_[current_]);
    std::make_heap(heap_.begin(), heap_.end());
  }
  std::pop_heap(heap_.begin(), heap_.end());
  entry = heap_.back();
  heap_.pop_back();
  return true;
}

Decimator::Decimator(HalfedgeMesh& mesh, FaceTree& tree, const DecimatorOptions& options,
                     const Progress& progress)
    : mesh_(mesh), tree_(tree), options_(options) {
  quadric_.resize(mesh.vertex_capacity());
  sum_normal_.resize(mesh.vertex_capacity());
  stamp_.assign(mesh.halfedge_capacity(), 0);
  stale_.assign(mesh.halfedge_capacity(), 0);
  const auto update = [&](Eigen::Index begin, Eigen::Index end) {
    for (int v = static_cast<int>(begin); v < end; ++v)
      if (mesh.has_vertex(v)) update_vertex(v);
  };
  parallel_for(mesh.vertex_capacity(), 2048, update, progress.part("collapse", 0, 0.01));
  enqueue_all(progress.part("collapse", 0.01, 0.05));
}

void Decimator::enqueue_all(const Progress& progress) {
  const int n = mesh_.halfedge_capacity();
  std::vector<double> orders(n, 0.0);
  const auto place_edges = [&](Eigen::Index begin, Eigen::Index end) {
    for (int h = static_cast<int>(begin); h < end; ++h)
      if (mesh_.is_representative(h)) orders[h] = place(h).cost;
  };
  parallel_for(n, 4096, place_edges, progress);
  if (options_.flowed != nullptr)
    for (int h = 0; h < n; ++h) {
      if (!mesh_.is_representative(h)) continue;
      if (std::isfinite(orders[h])) largest_cost_ = std::max(largest_cost_, orders[h]);
      largest_length_ = std::max(
          largest_length_, ((*options_.flowed)[mesh_.from(h)] - (*options_.flowed)[mesh_.to(h)]).norm());
    }
  progress.report("collapse", 1);
  for (int h = 0; h < n; ++h)
    if (mesh_.is_representative(h)) enqueue(h, order_of(h, orders[h]));
}

void Decimator::update_vertex(int v) {
  Symmetric q;
  Vector3d sum = Vector3d::Zero();
  mesh_.for_each_outgoing(v, [&](int h) {
    const Vector3d n = mesh_.area_normal(HalfedgeMesh::face(h));
    const double w = 1 / std::max(n.norm(), 1e-300);  // area × distance² is the error in the L² sense
    add_outer(q.m, n, w);
    sum += n;
    for (const int e : {h, HalfedgeMesh::prev(h)}) {
      if (!mesh_.is_border_edge(e)) continue;
      const Vector3d d = mesh_.position(mesh_.to(e)) - mesh_.position(mesh_.from(e));
      const double l2 = d.squaredNorm();  // |d × x|²: the square of the area that the border loses
      q.m[0] += l2;
      q.m[3] += l2;
      q.m[5] += l2;
      add_outer(q.m, d, -1);
    }
  });
  quadric_[v] = q;
  sum_normal_[v] = sum;
}

Placement Decimator::place(int h) const {
  const int u = mesh_.from(h), v = mesh_.to(h);
  const Vector3d origin = mesh_.position(u), e = mesh_.position(v) - origin;
  // The faces on both vertices are in both sums: take them out once. Their planes hold u and v.
  double shared[6] = {0, 0, 0, 0, 0, 0};
  Vector3d g = sum_normal_[u] + sum_normal_[v];
  for (const int side : {h, mesh_.opposite(h)}) {
    if (side == kNone) continue;
    const Vector3d n = mesh_.area_normal(HalfedgeMesh::face(side));
    const double w = 1 / std::max(n.norm(), 1e-300);  // area × distance² is the error in the L² sense
    add_outer(shared, n, w);
    g -= n;
  }
  double A[6], M[6], inverse[6];
  double trace = 0;
  for (int i = 0; i < 6; ++i) A[i] = quadric_[u].m[i] - shared[i];
  for (int i = 0; i < 6; ++i) M[i] = A[i] + quadric_[v].m[i];
  trace = M[0] + M[3] + M[5];
  const double pull = options_.regularisation * trace + 1e-300;
  M[0] += pull;
  M[3] += pull;
  M[5] += pull;
  // Where the planes leave the vertex free it goes to the middle of its ring.
  const Vector3d middle = 0.5 * e;
  Vector3d y = middle;
  const Vector3d right = times(quadric_[v].m, e) + pull * middle;
  const double volume = sum_normal_[v].dot(e);
  const Hold hold = held(h);
  if (hold == Hold::Never) return {std::numeric_limits<double>::infinity(), origin + middle};
  if (hold == Hold::From || hold == Hold::To) {
    y = hold == Hold::From ? Vector3d(Vector3d::Zero()) : e;
  } else if (invert(M, inverse)) {
    y = times(inverse, right);
    const bool border = mesh_.is_border_vertex(u) || mesh_.is_border_vertex(v);
    const Vector3d z = times(inverse, g);
    const double gz = g.dot(z);
    if (!border && gz > 0) {
      const Vector3d shifted = y + z * ((volume - g.dot(y)) / gz);
      if ((shifted - middle).squaredNorm() < 4 * e.squaredNorm()) y = shifted;
    }
    if (!((y - middle).squaredNorm() < 9 * e.squaredNorm())) y = middle;
  }
  Placement placement;
  placement.point = hold == Hold::To ? mesh_.position(v) : Vector3d(origin + y);  // to the last bit
  const Vector3d ye = y - e;
  placement.cost = y.dot(times(A, y)) + ye.dot(times(quadric_[v].m, ye));
  // Flat pieces: the shortest edges first.
  placement.cost += 1e-10 * trace * e.squaredNorm();
  return placement;
}

Decimator::Hold Decimator::held(int h) const {
  if (options_.hold_border) {
    const bool from = mesh_.is_border_vertex(mesh_.from(h)), to = mesh_.is_border_vertex(mesh_.to(h));
    if (from && to) return Hold::Never;
    // With marks the border is marked too, and the rules below hold it.
    if (!options_.keep_marked && (from || to)) return from ? Hold::From : Hold::To;
  }
  if (!options_.keep_marked) return Hold::Free;
  const auto marks = [&](int v) {
    int n = 0;
    mesh_.for_each_outgoing(v, [&](int g) {
      n += mesh_.is_marked(g) ? 1 : 0;
      const int last = HalfedgeMesh::prev(g);
      n += mesh_.is_border_edge(last) && mesh_.is_marked(last) ? 1 : 0;
    });
    return n;
  };
  const int at_from = marks(mesh_.from(h)), at_to = marks(mesh_.to(h));
  if (at_from == 0 && at_to == 0) return Hold::Free;
  if (at_from == 0) return Hold::To;
  if (at_to == 0) return Hold::From;
  if (!mesh_.is_marked(h)) return Hold::Never;  // would join two features, or two places of one
  // Along a feature: its ends and crossings hold; else the planes on both sides lead the vertex.
  if (at_from != 2) return at_to != 2 ? Hold::Never : Hold::From;
  return at_to != 2 ? Hold::To : Hold::Free;
}

double Decimator::order_of(int h, double cost) const {
  if (options_.flowed == nullptr || !std::isfinite(cost)) return cost;
  const double length = ((*options_.flowed)[mesh_.from(h)] - (*options_.flowed)[mesh_.to(h)]).norm();
  // (2.100), less the constant 2; the largest values guarded against zero.
  return std::pow(1 + cost / std::max(largest_cost_, 1e-300), options_.alpha) +
         std::pow(1 + length / std::max(largest_length_, 1e-300), options_.beta) - 2;
}

bool Decimator::is_allowed(int h, const Vector3d& p) {
  const int u = mesh_.from(h), v = mesh_.to(h);
  const int f0 = HalfedgeMesh::face(h),
            f1 = mesh_.is_border_edge(h) ? -1 : HalfedgeMesh::face(mesh_.opposite(h));
  star_.clear();
  replaced_.clear();
  bool allowed = true;
  double worst_before = 1, worst_after = 1;
  const auto shape = [](const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& n) {
    return n.norm() / std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  };
  for (const int end : {u, v}) {
    mesh_.for_each_outgoing(end, [&](int g) {
      const int f = HalfedgeMesh::face(g);
      if (f == f0 || f == f1) {
        if (end == u) replaced_.push_back(f);
        return;
      }
      replaced_.push_back(f);
      const int ia = mesh_.to(g), ib = mesh_.tip(g);
      const Vector3d &a = mesh_.position(ia), &b = mesh_.position(ib), &c = mesh_.position(end);
      const Vector3d before = (a - c).cross(b - c), after = (a - p).cross(b - p);
      if (before.dot(after) < options_.least_cosine * before.norm() * after.norm()) allowed = false;
      worst_before = std::min(worst_before, shape(a, b, c, before));
      worst_after = std::min(worst_after, shape(a, b, p, after));
      star_.push_back({{v, ia, ib}, {p, a, b}});
    });
    if (!allowed) return false;
  }
  if (star_.size() > 24) return false;
  // Among needles, as rods of CAD programs have them, a face may get somewhat flatter than the flattest.
  const double least = worst_before < kThin ? std::max(0.5 * worst_before, kLeastThin) : kThin;
  if (worst_after < least && worst_after < worst_before) return false;
  if (!(worst_after > 1e-9)) return false;
  return !tree_.intersects(star_, replaced_);
}

void Decimator::enqueue(int h, double order) {
  stale_[h] = 0;
  stamp_[h] = 0;
  if (!std::isfinite(order)) return;
  queue_.push({order, h, ++last_stamp_});
  stamp_[h] = last_stamp_;
}

void Decimator::run(int faces, double max_cost, const Progress& progress) {
  const int before = mesh_.n_faces();
  int steps = 0;
  const Progress part = progress.part("collapse", 0.05, 1);
  part.report("collapse", 0);
  std::vector<int> ring;
  CostQueue::Entry entry{};
  while (mesh_.n_faces() > faces && queue_.pop(entry)) {
    const int h = entry.h;
    if (stamp_[h] != entry.stamp || !mesh_.is_representative(h)) continue;
    if (stale_[h] != 0) {
      enqueue(h);
      continue;
    }
    if (entry.cost > max_cost) {
      queue_.push(entry);
      break;
    }
    stamp_[h] = 0;  // not in the queue: comes back when something changes beside it
    if (!mesh_.can_collapse(h)) continue;
    const Placement placement = place(h);
    if (!is_allowed(h, placement.point)) continue;
    if (on_collapse) on_collapse(h, placement.point);
    const int u = mesh_.from(h);
    const int v = mesh_.collapse(h);
    mesh_.set_position(v, placement.point);
    if (options_.flowed != nullptr)
      (*options_.flowed)[v] = 0.5 * Vector3d((*options_.flowed)[u] + (*options_.flowed)[v]);
    if (++steps % 1024 == 0) {
      part.report("collapse", (before - mesh_.n_faces()) / std::max(1.0, double(before - faces)));
      tree_.rebuild_if_thinned();
    }
    ring.clear();
    mesh_.for_each_outgoing(v, [&](int g) { tree_.update(HalfedgeMesh::face(g)); });
    mesh_.for_each_neighbour(v, [&](int w) { ring.push_back(w); });
    update_vertex(v);
    for (const int w : ring) update_vertex(w);
    const auto touch = [&](int g) {
      const int r = representative(g);
      if (stamp_[r] == 0)
        enqueue(r);
      else
        stale_[r] = 1;
    };
    for (const int w : ring)
      mesh_.for_each_outgoing(w, [&](int g) {
        if (mesh_.to(g) != v) touch(g);
        if (mesh_.is_border_edge(HalfedgeMesh::prev(g)) && mesh_.tip(g) != v) touch(HalfedgeMesh::prev(g));
      });
    mesh_.for_each_outgoing(v, [&](int g) {
      enqueue(representative(g));
      if (mesh_.is_border_edge(HalfedgeMesh::prev(g))) enqueue(HalfedgeMesh::prev(g));
    });
  }
}

}  // namespace batten::simplification
