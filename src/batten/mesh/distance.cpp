#include "batten/mesh/distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/parallel.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/spatial_order.hpp"

namespace batten {

using Eigen::Vector3d;

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kWidth = 4;  ///< children of a node: two binary levels in one, tested in one run of arithmetic
constexpr int kLeafSize = 4;  ///< most elements of a leaf
constexpr int kBins = 12;     ///< candidates per axis of the surface area heuristic
/// Below this depth ranges are halved by count, which bounds the depth of the whole and so the stack.
constexpr int kMaxHeuristicDepth = 40;
constexpr int kStackSize = kWidth * (kMaxHeuristicDepth + 34);
/// Boxes are skipped only when clearly further than the best element, so that every element at exactly the
/// best distance is seen and the lowest index among them wins, whatever the order of the visit.
constexpr double kTieMargin = 1 + 1e-12;

struct ElementBox {
  Vector3d low = Vector3d::Constant(kInfinity);
  Vector3d high = Vector3d::Constant(-kInfinity);

  void extend(const ElementBox& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
  }
  void extend(const Vector3d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  double half_area() const {
    const Vector3d d = high - low;
    return d.x() < 0 ? 0 : d.x() * d.y() + d.y() * d.z() + d.z() * d.x();
  }
};

/// Four children with their boxes by coordinate, so that the four distances are one run of arithmetic.
struct ElementNode {
  double low[3][kWidth];
  double high[3][kWidth];
  std::int32_t child[kWidth];  ///< of a leaf the first element, else the node
  std::int32_t count[kWidth];  ///< elements of a leaf; 0 for an inner node; −1 for an empty slot
};

struct BoxTree {
  std::vector<ElementNode> nodes;
  std::vector<std::int32_t> order;  ///< elements in the order of the leaves
};

class BoxTreeBuilder {
 public:
  explicit BoxTreeBuilder(const std::vector<ElementBox>& boxes) : boxes_(boxes) {
    const std::size_t n = boxes.size();
    centres_.resize(n);
    tree_.order.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      centres_[i] = 0.5 * (boxes[i].low + boxes[i].high);
      tree_.order[i] = static_cast<std::int32_t>(i);
    }
  }

  BoxTree build() {
    add_node({0, static_cast<std::int32_t>(boxes_.size()), 0});
    return std::move(tree_);
  }

 private:
  struct Range {
    std::int32_t begin, end, depth;
    std::int32_t size() const { return end - begin; }
  };

  std::int32_t add_node(const Range& whole) {
    std::array<Range, kWidth> ranges{whole};
    int n = 1;
    while (n < kWidth) {  // split the largest until there are four or all are leaves
      int largest = 0;
      for (int i = 1; i < n; ++i)
        if (ranges[i].size() > ranges[largest].size()) largest = i;
      if (ranges[largest].size() <= kLeafSize) break;
      const Range range = ranges[largest];
      const std::int32_t middle = split(range);
      ranges[largest] = {range.begin, middle, range.depth + 1};
      ranges[n++] = {middle, range.end, range.depth + 1};
    }
    const auto index = static_cast<std::int32_t>(tree_.nodes.size());
    tree_.nodes.emplace_back();
    for (int i = 0; i < kWidth; ++i) {
      ElementBox box;
      if (i < n)
        for (std::int32_t e = ranges[i].begin; e < ranges[i].end; ++e) box.extend(boxes_[tree_.order[e]]);
      for (int k = 0; k < 3; ++k) {
        tree_.nodes[index].low[k][i] = box.low[k];
        tree_.nodes[index].high[k][i] = box.high[k];
      }
      const bool leaf = i < n && ranges[i].size() <= kLeafSize;
      tree_.nodes[index].count[i] = i >= n ? -1 : leaf ? ranges[i].size() : 0;
      // The recursion may move the nodes: write through the index afterwards.
      const std::int32_t child = i >= n ? 0 : leaf ? ranges[i].begin : add_node(ranges[i]);
      tree_.nodes[index].child[i] = child;
    }
    return index;
  }

  /// Reorders the range into two parts by the surface area heuristic over bins, or by count where the centres
  /// coincide. @return the first of the second part; both parts are not empty.
  std::int32_t split(const Range& range) {
    ElementBox centres;
    for (std::int32_t e = range.begin; e < range.end; ++e) centres.extend(centres_[tree_.order[e]]);
    const Vector3d extent = centres.high - centres.low;
    int widest = 0;
    extent.maxCoeff(&widest);
    const auto first = tree_.order.begin() + range.begin, last = tree_.order.begin() + range.end;

    int best_axis = -1;
    int best_bin = 0;
    if (range.depth < kMaxHeuristicDepth && range.size() > 2 * kLeafSize) {
      double best_cost = kInfinity;
      for (int axis = 0; axis < 3; ++axis) {
        if (!(extent[axis] > 1e-3 * extent[widest])) continue;
        std::array<ElementBox, kBins> box;
        std::array<int, kBins> count{};
        const double scale = kBins / extent[axis];
        for (auto e = first; e != last; ++e) {
          const int bin = bin_of(*e, axis, centres.low[axis], scale);
          box[bin].extend(boxes_[*e]);
          ++count[bin];
        }
        std::array<double, kBins> right_cost{};
        ElementBox right;
        int n_right = 0;
        for (int b = kBins - 1; b > 0; --b) {
          right.extend(box[b]);
          n_right += count[b];
          right_cost[b] = right.half_area() * n_right;
        }
        ElementBox left;
        int n_left = 0;
        for (int b = 1; b < kBins; ++b) {
          left.extend(box[b - 1]);
          n_left += count[b - 1];
          if (n_left == 0 || n_left == range.size()) continue;
          const double cost = left.half_area() * n_left + right_cost[b];
          if (cost < best_cost) {
            best_cost = cost;
            best_axis = axis;
            best_bin = b;
          }
        }
      }
    }
    if (best_axis >= 0) {
      const double low = centres.low[best_axis], scale = kBins / extent[best_axis];
      const auto middle = std::stable_partition(
          first, last, [&](std::int32_t e) { return bin_of(e, best_axis, low, scale) < best_bin; });
      return static_cast<std::int32_t>(middle - tree_.order.begin());
    }
    const auto middle = first + range.size() / 2;
    std::nth_element(first, middle, last, [&](std::int32_t a, std::int32_t b) {
      const double ca = centres_[a][widest], cb = centres_[b][widest];
      return ca < cb || (ca == cb && a < b);
    });
    return static_cast<std::int32_t>(middle - tree_.order.begin());
  }

  int bin_of(std::int32_t element, int axis, double low, double scale) const {
    return std::min(kBins - 1, static_cast<int>((centres_[element][axis] - low) * scale));
  }

  const std::vector<ElementBox>& boxes_;
  std::vector<Vector3d> centres_;
  BoxTree tree_;
};

/// Barycentric weights of the point of the triangle (a, a + ab, a + ac) nearest to q; false when the triangle
/// has no area. After [ericson2005], 5.1.5: the Voronoi regions of the
/// corners and edges are told apart by six dot products.
inline bool triangle_weights(const Vector3d& ap, const Vector3d& ab, const Vector3d& ac, double& v,
                             double& w) {
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) {
    v = w = 0;
    return true;
  }
  const Vector3d bp = ap - ab;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) {
    v = 1;
    w = 0;
    return true;
  }
  const Vector3d cp = ap - ac;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) {
    v = 0;
    w = 1;
    return true;
  }
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) {
    v = d1 / (d1 - d3);
    w = 0;
    return true;
  }
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) {
    v = 0;
    w = d2 / (d2 - d6);
    return true;
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6 && (d4 - d3) + (d5 - d6) > 0) {
    w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    v = 1 - w;
    return true;
  }
  const double sum = va + vb + vc;
  if (!(sum > 0)) return false;
  v = vb / sum;
  w = vc / sum;
  return true;
}

/// Twice the area over the square of the longest edge below which a triangle counts as its longest edge: its
/// normal is then lost in rounding.
constexpr double kFlat = 1e-13;

bool is_flat(const Vector3d& ab, const Vector3d& ac) {
  const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()});
  return !(ab.cross(ac).norm() > kFlat * longest);
}

double segment_parameter(const Vector3d& q, const Vector3d& a, const Vector3d& ab) {
  const double length2 = ab.squaredNorm();
  return length2 > 0 ? std::clamp(ab.dot(q - a) / length2, 0.0, 1.0) : 0.0;
}

struct TriangleElement {
  Vector3d a, ab, ac;
  bool flat;

  static TriangleElement make(const Points& positions, const Triangles& triangles, Eigen::Index t) {
    const Vector3d a = positions.row(triangles(t, 0)), b = positions.row(triangles(t, 1)),
                   c = positions.row(triangles(t, 2));
    return {a, b - a, c - a, is_flat(b - a, c - a)};
  }
  ElementBox box() const {
    ElementBox box;
    box.extend(a);
    box.extend(a + ab);
    box.extend(a + ac);
    return box;
  }
  /// Weights of the second and third corner.
  void nearest(const Vector3d& q, double& v, double& w) const {
    if (!flat && triangle_weights(q - a, ab, ac, v, w)) return;
    const double l_ab = ab.squaredNorm(), l_ac = ac.squaredNorm(), l_bc = (ac - ab).squaredNorm();
    v = w = 0;
    if (l_ab >= l_ac && l_ab >= l_bc) {
      v = segment_parameter(q, a, ab);
    } else if (l_ac >= l_bc) {
      w = segment_parameter(q, a, ac);
    } else {
      w = segment_parameter(q, a + ab, ac - ab);
      v = 1 - w;
    }
  }
  Vector3d point(double v, double w) const { return a + v * ab + w * ac; }
};

struct SegmentElement {
  Vector3d a, ab;

  static SegmentElement make(const Points& positions, const Segments& segments, Eigen::Index s) {
    const Vector3d a = positions.row(segments(s, 0)), b = positions.row(segments(s, 1));
    return {a, b - a};
  }
  ElementBox box() const {
    ElementBox box;
    box.extend(a);
    box.extend(a + ab);
    return box;
  }
  void nearest(const Vector3d& q, double& v, double& w) const {
    v = segment_parameter(q, a, ab);
    w = 0;
  }
  Vector3d point(double v, double /*w*/) const { return a + v * ab; }
};

template <typename Element>
ClosestPoint nearest_on(const Element& element, const Vector3d& q, Eigen::Index index) {
  double v = 0, w = 0;
  element.nearest(q, v, w);
  const Vector3d p = element.point(v, w);
  return {p, index, Vector3d(std::max(0.0, 1 - v - w), v, w), (p - q).squaredNorm()};
}

/// The search common to triangles and segments.
template <typename Element>
struct Search {
  BoxTree tree;
  std::vector<Element> elements;  ///< in the order of the leaves

  template <typename Indices>
  Search(const Points& positions, const Indices& indices, const char* what) {
    const Eigen::Index m = indices.rows(), n = positions.rows();
    if (m == 0) throw InvalidInput(concat("there is no ", what, " to measure the distance to"));
    if (m > std::numeric_limits<std::int32_t>::max() / 2) throw InvalidInput("more than 10⁹ elements");
    std::vector<ElementBox> boxes(m);
    for (Eigen::Index e = 0; e < m; ++e) {
      for (Eigen::Index k = 0; k < indices.cols(); ++k) {
        const int v = indices(e, k);
        if (v < 0 || v >= n)
          throw InvalidInput(
              concat(what, " ", e, " names vertex ", v, ", but the vertices run from 0 to ", n - 1));
        if (!positions.row(v).allFinite())
          throw InvalidInput(
              concat("vertex ", v, " of ", what, " ", e, " has a coordinate that is not finite"));
      }
      boxes[e] = Element::make(positions, indices, e).box();
    }
    tree = BoxTreeBuilder(boxes).build();
    elements.reserve(m);
    for (const std::int32_t e : tree.order) elements.push_back(Element::make(positions, indices, e));
  }

  /// @param start an element (in leaf order) whose distance bounds the search from above, or −1.
  /// @return in leaf order, so that it can start the next search.
  std::int32_t find(const Vector3d& q, std::int32_t start, double& best_v, double& best_w,
                    double& best) const {
    best = kInfinity;
    std::int32_t found = -1;
    const auto consider = [&](std::int32_t e) {
      double v = 0, w = 0;
      elements[e].nearest(q, v, w);
      const double d2 = (elements[e].point(v, w) - q).squaredNorm();
      if (d2 < best || (d2 == best && (found < 0 || tree.order[e] < tree.order[found]))) {
        best = d2;
        best_v = v;
        best_w = w;
        found = e;
      }
    };
    if (start >= 0) consider(start);
    struct Entry {
      double distance;
      std::int32_t child, count;
    };
    Entry stack[kStackSize];
    int top = 0;
    stack[top++] = {0, 0, 0};
    while (top > 0) {
      const Entry entry = stack[--top];
      if (entry.distance > best * kTieMargin) continue;
      if (entry.count > 0) {
        for (std::int32_t e = entry.child; e < entry.child + entry.count; ++e) consider(e);
        continue;
      }
      const ElementNode& node = tree.nodes[entry.child];
      // As arrays of Eigen, which come out as instructions on several numbers at a time.
      using Four = Eigen::Array<double, kWidth, 1>;
      Four squared = Four::Zero();
      for (int k = 0; k < 3; ++k) {
        const Eigen::Map<const Four> low(node.low[k]), high(node.high[k]);
        squared += (low - q[k]).max(q[k] - high).max(0.0).square();
      }
      double distance[kWidth];
      Eigen::Map<Four>{distance} = squared;
      const int base = top;
      for (int i = 0; i < kWidth; ++i) {
        if (node.count[i] < 0 || distance[i] > best * kTieMargin) continue;
        int at = top++;  // furthest first, so that the nearest is popped next
        while (at > base && stack[at - 1].distance < distance[i]) {
          stack[at] = stack[at - 1];
          --at;
        }
        stack[at] = {distance[i], node.child[i], node.count[i]};
      }
    }
    return found;
  }

  ClosestPoint closest(const Vector3d& q) const {
    if (!q.allFinite()) throw InvalidInput("the distance of a point that is not finite was asked for");
    double v = 0, w = 0, d2 = 0;
    const std::int32_t e = find(q, -1, v, w, d2);
    return result(e, v, w, d2);
  }

  ClosestPoint result(std::int32_t e, double v, double w, double d2) const {
    return {elements[e].point(v, w), tree.order[e], Vector3d(std::max(0.0, 1 - v - w), v, w), d2};
  }

  std::vector<ClosestPoint> closest(const Points& queries, const Progress& progress) const;
};

template <typename Element>
std::vector<ClosestPoint> Search<Element>::closest(const Points& queries, const Progress& progress) const {
  for (Eigen::Index i = 0; i < queries.rows(); ++i)
    if (!queries.row(i).allFinite())
      throw InvalidInput(concat("point ", i, " has a coordinate that is not finite"));
  std::vector<ClosestPoint> results(queries.rows());
  if (results.empty()) return results;
  const std::vector<int> order = spatial_order(queries);
  const auto search = [&](Eigen::Index begin, Eigen::Index end) {
    std::int32_t previous = -1;  // the neighbour's element is a good first bound
    for (Eigen::Index k = begin; k < end; ++k) {
      double v = 0, w = 0, d2 = 0;
      previous = find(queries.row(order[k]), previous, v, w, d2);
      results[order[k]] = result(previous, v, w, d2);
    }
  };
  parallel_for(queries.rows(), 512, search, progress);
  return results;
}

}  // namespace

struct TriangleTree::Hierarchy : Search<TriangleElement> {
  using Search::Search;
};

struct SegmentTree::Hierarchy : Search<SegmentElement> {
  using Search::Search;
};

TriangleTree::TriangleTree(const Points& positions, const Triangles& triangles)
    : hierarchy_(std::make_shared<const Hierarchy>(positions, triangles, "triangle")) {}

ClosestPoint TriangleTree::closest(const Vector3d& query) const {
  return hierarchy_->closest(query);
}

std::vector<ClosestPoint> TriangleTree::closest(const Points& queries, const Progress& progress) const {
  return hierarchy_->closest(queries, progress);
}

SegmentTree::SegmentTree(const Points& positions, const Segments& segments)
    : hierarchy_(std::make_shared<const Hierarchy>(positions, segments, "segment")) {}

ClosestPoint SegmentTree::closest(const Vector3d& query) const {
  return hierarchy_->closest(query);
}

std::vector<ClosestPoint> SegmentTree::closest(const Points& queries, const Progress& progress) const {
  return hierarchy_->closest(queries, progress);
}

ClosestPoint closest_point_on_triangle(const Vector3d& q, const Vector3d& a, const Vector3d& b,
                                       const Vector3d& c) {
  return nearest_on(TriangleElement{a, b - a, c - a, is_flat(b - a, c - a)}, q, 0);
}

ClosestPoint closest_point_on_segment(const Vector3d& q, const Vector3d& a, const Vector3d& b) {
  return nearest_on(SegmentElement{a, b - a}, q, 0);
}

Eigen::VectorXd distances(const std::vector<ClosestPoint>& closest) {
  Eigen::VectorXd result(static_cast<Eigen::Index>(closest.size()));
  for (std::size_t i = 0; i < closest.size(); ++i)
    result[static_cast<Eigen::Index>(i)] = std::sqrt(closest[i].squared_distance);
  return result;
}

}  // namespace batten
