#include "batten/strokes/stroke_symmetry.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "batten/core/error.hpp"
#include "batten/core/statistics.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

namespace {

constexpr double kInPlane = 0.01;              // of a stroke that lies in the plane, in diameters
constexpr double kImage = 0.02, kShare = 0.9;  // how near how much of the strokes lies to their image

Segments segments_of(const CurveNetwork& strokes) {
  std::vector<std::pair<int, int>> pairs;
  for (const NetworkCurve& curve : strokes.curves)
    for (std::size_t k = 1; k < curve.vertices.size(); ++k)
      pairs.emplace_back(curve.vertices[k - 1], curve.vertices[k]);
  Segments segments(static_cast<Eigen::Index>(pairs.size()), 2);
  for (std::size_t i = 0; i < pairs.size(); ++i)
    segments.row(static_cast<Eigen::Index>(i)) << pairs[i].first, pairs[i].second;
  return segments;
}

Points mirrored(Points points, const MirrorPlane& plane) {
  points.col(plane.axis) = 2 * plane.position - points.col(plane.axis).array();
  return points;
}

}  // namespace

CurveNetwork with_mirrored_strokes(const CurveNetwork& strokes, const MirrorPlane& plane) {
  CurveNetwork both = strokes;
  const auto n = static_cast<int>(strokes.positions.rows());
  if (n == 0 || strokes.curves.empty()) return both;
  const double near = kInPlane * bounding_box_diagonal(strokes.positions);
  const SegmentTree tree(strokes.positions, segments_of(strokes));
  both.positions.conservativeResize(2 * n, 3);
  both.positions.bottomRows(n) = mirrored(strokes.positions, plane);
  for (const NetworkCurve& curve : strokes.curves) {
    const bool is_there = std::all_of(curve.vertices.begin(), curve.vertices.end(), [&](int v) {
      return tree.closest(Eigen::Vector3d(both.positions.row(n + v).transpose())).squared_distance <=
             near * near;
    });
    if (is_there) continue;
    NetworkCurve image = curve;
    for (int& v : image.vertices) v += n;
    both.curves.push_back(std::move(image));
  }
  return both;
}

std::optional<MirrorPlane> find_mirror_plane(const CurveNetwork& strokes) {
  const double diameter = bounding_box_diagonal(strokes.positions);
  if (!(diameter > 0) || strokes.curves.empty()) throw InvalidInput("the strokes have no extent");
  const Segments segments = segments_of(strokes);
  const SegmentTree tree(strokes.positions, segments);
  // Middles of segments stand for length: drawing programs sample evenly.
  Points middles(segments.rows(), 3);
  for (Eigen::Index i = 0; i < segments.rows(); ++i)
    middles.row(i) = 0.5 * (strokes.positions.row(segments(i, 0)) + strokes.positions.row(segments(i, 1)));
  std::optional<MirrorPlane> best;
  double least = kImage * diameter;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = middles.col(axis).minCoeff(), high = middles.col(axis).maxCoeff();
    if (high - low < kImage * diameter) continue;
    const MirrorPlane plane{axis, 0.5 * (low + high)};
    const Eigen::VectorXd distance = distances(tree.closest(mirrored(middles, plane)));
    std::vector<double> sorted(distance.data(), distance.data() + distance.size());
    if (const double off = percentile(sorted, kShare); off < least) {
      least = off;
      best = plane;
    }
  }
  return best;
}

}  // namespace batten
