#include <algorithm>
#include <map>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "batten/core/text.hpp"
#include "batten/simulation/polyline_crossings_detail.hpp"

namespace batten::detail {

namespace {

using Eigen::Vector3d;

class CrossingFinder {
 public:
  explicit CrossingFinder(const std::vector<MeshPolyline>& lines) : lines_(lines) {
    found_.places.resize(lines.size());
  }

  PolylineCrossings find() {
    find_between_sections();
    find_at_borders();
    for (auto& list : found_.places)
      std::sort(list.begin(), list.end(), [](const CrossingPlace& a, const CrossingPlace& b) {
        return std::pair(a.piece, a.fraction) < std::pair(b.piece, b.fraction);
      });
    return std::move(found_);
  }

 private:
  void add(const Vector3d& position, const Vector3d& normal, size_t line_a, CrossingPlace a, size_t line_b,
           CrossingPlace b) {
    a.node = b.node = static_cast<int>(found_.crossings.size());
    found_.crossings.push_back({position, normal});
    found_.places[line_a].push_back(a);
    found_.places[line_b].push_back(b);
  }

  void find_between_sections() {
    std::unordered_map<int, std::vector<std::pair<size_t, size_t>>> pieces_of_face;
    for (size_t a = 0; a < lines_.size(); ++a)
      for (size_t k = 0; k < lines_[a].faces.size(); ++k) {
        auto& here = pieces_of_face[lines_[a].faces[k]];
        for (const auto& [b, m] : here) {
          if (lines_[b].axis == lines_[a].axis) continue;
          const MeshPolyline& one = lines_[a];
          const MeshPolyline& two = lines_[b];
          // Heights of the first piece's ends over the second's plane, and the other way round.
          const double h0 = one.points[k][two.axis] - two.offset;
          const double h1 = one.next(k)[two.axis] - two.offset;
          const double g0 = two.points[m][one.axis] - one.offset;
          const double g1 = two.next(m)[one.axis] - one.offset;
          if ((h0 < 0) == (h1 < 0) || (g0 < 0) == (g1 < 0)) continue;
          const double u = h0 / (h0 - h1);
          const double v = g0 / (g0 - g1);
          const Vector3d normal = (1 - u) * one.normals[k] + u * one.normals[(k + 1) % one.points.size()];
          add((1 - u) * one.points[k] + u * one.next(k), normal.normalized(), a, {k, u, 0}, b, {m, v, 0});
        }
        here.emplace_back(a, k);
      }
  }

  void find_at_borders() {
    std::map<MeshEdge, std::pair<size_t, size_t>> border_edges;
    for (size_t b = 0; b < lines_.size(); ++b)
      if (lines_[b].boundary)
        for (size_t k = 0; k < lines_[b].edges.size(); ++k) border_edges[lines_[b].edges[k]] = {b, k};
    for (size_t a = 0; a < lines_.size(); ++a) {
      const MeshPolyline& line = lines_[a];
      if (line.boundary || line.closed) continue;
      for (const size_t end : {size_t{0}, line.points.size() - 1}) {
        const auto place = border_edges.find(line.edges[end]);
        if (place == border_edges.end()) continue;
        const auto [b, k] = place->second;
        const MeshPolyline& border = lines_[b];
        const double u =
            (line.points[end] - border.points[k]).norm() / (border.next(k) - border.points[k]).norm();
        const CrossingPlace on_line =
            end == 0 ? CrossingPlace{0, 0, 0} : CrossingPlace{line.n_pieces() - 1, 1, 0};
        add(line.points[end], line.normals[end], a, on_line, b, {k, u, 0});
      }
    }
  }

  const std::vector<MeshPolyline>& lines_;
  PolylineCrossings found_;
};

}  // namespace

PolylineCrossings find_crossings(const std::vector<MeshPolyline>& lines) {
  return CrossingFinder(lines).find();
}

void keep_connected(std::vector<MeshPolyline>& lines, std::vector<std::string>& warnings) {
  const PolylineCrossings found = find_crossings(lines);
  std::vector<size_t> root(lines.size());
  std::iota(root.begin(), root.end(), size_t{0});
  const auto find = [&root](size_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  std::vector<size_t> line_of_node(found.crossings.size(), lines.size());
  for (size_t c = 0; c < lines.size(); ++c)
    for (const CrossingPlace& place : found.places[c]) {
      size_t& first = line_of_node[static_cast<size_t>(place.node)];
      if (first == lines.size())
        first = c;
      else
        root[find(c)] = find(first);
    }
  std::map<size_t, double> lengths;
  for (size_t c = 0; c < lines.size(); ++c) lengths[find(c)] += lines[c].length();
  const auto longest = std::max_element(lengths.begin(), lengths.end(),
                                        [](const auto& a, const auto& b) { return a.second < b.second; });
  std::vector<MeshPolyline> kept;
  size_t borders = 0;
  for (size_t c = 0; c < lines.size(); ++c) {
    if (find(c) == longest->first)
      kept.push_back(std::move(lines[c]));
    else
      borders += lines[c].boundary ? 1 : 0;
  }
  if (kept.size() < lines.size())
    warnings.push_back(concat(lines.size() - kept.size(), " of ", lines.size(), " curves (", borders,
                              " of them borders) meet no other part of the network and are left out: a scan "
                              "cannot tell where separate parts lie; lay more planes to join them"));
  lines = std::move(kept);
}

}  // namespace batten::detail
