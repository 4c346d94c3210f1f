#include "batten/strokes/snapping.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "batten/core/disjoint_sets.hpp"
#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/network/contacts.hpp"

namespace batten {

namespace {

using detail::Contact;
using detail::CurveIndex;
using detail::CurvePlace;
using Vector = Eigen::Vector3d;

/// Collects what is to become one, then rebuilds the network.
class Welder {
 public:
  Welder(const CurveNetwork& network, double tolerance)
      : network_(network),
        tolerance_(tolerance),
        merged_(static_cast<int>(network.positions.rows())),
        insertions_(network.curves.size()) {
    for (Eigen::Index v = 0; v < network.positions.rows(); ++v)
      positions_.emplace_back(network.positions.row(v));
    if (network.has_normals())
      for (Eigen::Index v = 0; v < network.normals.rows(); ++v) normals_.emplace_back(network.normals.row(v));
  }

  /// The vertex at a place of a curve: an existing one within the tolerance along the curve (its ends first),
  /// else a new one. @param other_than a vertex that is not meant: the end of a curve that closes lies where
  /// its other end does.
  int vertex_at(const CurvePlace& place, int other_than = -1) {
    const std::vector<int>& vertices = network_.curves[at(place.curve)].vertices;
    const int a = vertices[at(place.edge)], b = vertices[at(place.edge) + 1];
    const auto distance_to = [&](int v) {
      return v == other_than ? std::numeric_limits<double>::infinity()
                             : (positions_[at(v)] - place.point).norm();
    };
    const double to_a = distance_to(a), to_b = distance_to(b);
    const double to_first = distance_to(vertices.front()), to_last = distance_to(vertices.back());
    // A vertex moves by half of what it is merged over, so half the tolerance is left for the way along.
    const double near = 0.5 * tolerance_;
    if (std::min(to_first, to_last) <= near && !network_.curves[at(place.curve)].closed())
      return to_first <= to_last ? vertices.front() : vertices.back();
    if (std::min(to_a, to_b) <= near) return to_a <= to_b ? a : b;
    for (const auto& [position, vertex] : insertions_[at(place.curve)])
      if ((positions_[at(vertex)] - place.point).norm() <= near) return vertex;
    const int vertex = merged_.add();
    positions_.push_back(place.point);
    if (!normals_.empty()) {
      Vector normal = (1 - place.fraction) * normals_[at(a)] + place.fraction * normals_[at(b)];
      if (!(normal.norm() > 0)) normal = normals_[at(a)];
      normals_.push_back(normal.normalized());
    }
    insertions_[at(place.curve)].emplace_back(place.edge + place.fraction, vertex);
    return vertex;
  }

  void unite(int a, int b) { merged_.unite(a, b); }

  WeldedNetwork result() {
    WeldedNetwork result;
    WeldReport& report = result.report;
    CurveNetwork& welded = result.network;
    for (auto& list : insertions_) report.n_inserted_nodes += static_cast<int>(list.size());
    // Means over what is united.
    const auto n = static_cast<int>(positions_.size());
    std::vector<Vector> mean(at(n), Vector::Zero()), normal(at(n), Vector::Zero());
    std::vector<int> count(at(n), 0);
    for (int v = 0; v < n; ++v) {
      const int r = merged_.root(v);
      mean[at(r)] += positions_[at(v)];
      if (!normals_.empty()) normal[at(r)] += normals_[at(v)];
      ++count[at(r)];
      report.n_merged_vertices += r != v;
    }
    welded.unit = network_.unit;
    std::vector<char> used(at(n), 0);
    for (size_t c = 0; c < network_.curves.size(); ++c) {
      NetworkCurve curve = network_.curves[c];
      std::vector<std::pair<double, int>>& inserted = insertions_[c];
      std::sort(inserted.begin(), inserted.end());
      std::vector<int> vertices;
      size_t next = 0;
      const auto append = [&](int v) {
        v = merged_.root(v);
        if (vertices.empty() || vertices.back() != v) vertices.push_back(v);
      };
      for (size_t k = 0; k < curve.vertices.size(); ++k) {
        append(curve.vertices[k]);
        while (next < inserted.size() && inserted[next].first < static_cast<double>(k + 1))
          append(inserted[next++].second);
      }
      if (vertices.size() < 2) {
        ++report.n_removed_curves;
        continue;
      }
      curve.vertices = std::move(vertices);
      for (const int v : curve.vertices) used[at(v)] = 1;
      welded.curves.push_back(std::move(curve));
    }
    std::vector<int> number(at(n), -1);
    int n_kept = 0;
    for (int v = 0; v < n; ++v)
      if (used[at(v)]) number[at(v)] = n_kept++;
    welded.positions.resize(n_kept, 3);
    if (!normals_.empty()) welded.normals.resize(n_kept, 3);
    for (int v = 0; v < n; ++v) {
      if (!used[at(v)]) continue;
      welded.positions.row(number[at(v)]) =
          count[at(v)] == 1 ? positions_[at(v)] : Vector(mean[at(v)] / count[at(v)]);
      if (!normals_.empty())
        welded.normals.row(number[at(v)]) = count[at(v)] == 1 || !(normal[at(v)].norm() > 0)
                                                ? normals_[at(v)]
                                                : Vector(normal[at(v)].normalized());
    }
    for (NetworkCurve& curve : welded.curves)
      for (int& v : curve.vertices) v = number[at(v)];
    for (const int v : network_.tagged_nodes)
      if (const int place = number[at(merged_.root(v))];
          place >= 0 && std::find(welded.tagged_nodes.begin(), welded.tagged_nodes.end(), place) ==
                            welded.tagged_nodes.end())
        welded.tagged_nodes.push_back(place);
    return result;
  }

 private:
  const CurveNetwork& network_;
  double tolerance_;
  DisjointSets merged_;
  std::vector<Vector> positions_, normals_;
  std::vector<std::vector<std::pair<double, int>>> insertions_;  // per curve: place along it, vertex
};

}  // namespace

WeldedNetwork welded(const CurveNetwork& network, double tolerance) {
  if (!(tolerance > 0) || !std::isfinite(tolerance))
    throw InvalidInput(concat("the weld tolerance must be more than 0, got ", tolerance));
  const NetworkTopology topology = network_topology(network);  // checks the indices
  const CurveIndex index(network, tolerance);
  Welder welder(network, tolerance);
  // Ends first: they must not be moved away by a crossing beside them.
  std::vector<int> degree(at(static_cast<int>(network.positions.rows())), 0);
  for (const NetworkCurve& curve : network.curves)
    for (size_t k = 1; k < curve.vertices.size(); ++k) {
      ++degree[at(curve.vertices[k])];
      ++degree[at(curve.vertices[k - 1])];
    }
  std::vector<Vector> ends;
  for (int c = 0; c < static_cast<int>(network.curves.size()); ++c) {
    const NetworkCurve& curve = network.curves[at(c)];
    if (curve.closed()) continue;
    for (const bool at_last : {false, true}) {
      const int vertex = at_last ? curve.vertices.back() : curve.vertices.front();
      if (degree[at(vertex)] != 1) continue;
      if (const auto place = index.nearest_other(c, at_last, tolerance)) {
        welder.unite(vertex, welder.vertex_at(*place, vertex));
        ends.emplace_back(network.positions.row(vertex));
      }
    }
  }
  for (const Contact& contact : index.contacts()) {
    if (contact.joined) continue;
    const Vector& where = contact.first.point;
    if (std::any_of(ends.begin(), ends.end(),
                    [&](const Vector& end) { return (end - where).norm() <= 2 * tolerance; }))
      continue;
    welder.unite(welder.vertex_at(contact.first), welder.vertex_at(contact.second));
  }
  return welder.result();
}

}  // namespace batten
