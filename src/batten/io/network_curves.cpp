#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/curves/bspline.hpp"
#include "batten/io/mesh_formats_detail.hpp"
#include "batten/io/network_formats_detail.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten::detail {

namespace {

/// Reads a text as one stream of numbers; a number may stand on any line.
class NumberStream {
 public:
  explicit NumberStream(LineReader& reader) : reader_(reader) {}

  double number(std::string_view what) {
    fetch(what);
    return read_finite(one_, reader_, what);
  }
  long integer(std::string_view what, long low, long high) {
    fetch(what);
    return read_integer(one_, reader_, what, low, high);
  }
  bool at_end() {
    std::string_view token;
    while (true) {
      Tokens ahead = line_;
      if (ahead.next(token)) return false;
      std::string_view line;
      if (!reader_.next(line)) return true;
      text_ = without_comment(line);
      line_ = Tokens(text_);
    }
  }

 private:
  void fetch(std::string_view what) {
    if (at_end())
      reader_.fail(concat("the file ends before ", what, "; it is truncated or its counts are wrong"));
    std::string_view token;
    line_.next(token);
    one_ = Tokens(token);
  }

  LineReader& reader_;
  std::string text_;  // the line being read
  Tokens line_{""}, one_{""};
};

Points to_points(const std::vector<Eigen::RowVector3d>& rows) {
  Points points(static_cast<Eigen::Index>(rows.size()), 3);
  for (size_t i = 0; i < rows.size(); ++i) points.row(static_cast<Eigen::Index>(i)) = rows[i];
  return points;
}

}  // namespace

RawNetwork parse_curve_text(std::string content, const std::string& path) {
  RawNetwork raw;
  LineReader reader(std::move(content), path);
  std::string_view line, word;
  std::vector<Eigen::RowVector3d> points;
  const auto finish_curve = [&] {
    if (raw.network.curves.empty()) return;
    NetworkCurve& curve = raw.network.curves.back();
    if (curve.vertices.size() < 2) reader.fail(concat(curve.name, " has fewer than two points; remove it"));
    const Eigen::RowVector3d last = points.back();
    if (curve.vertices.size() > 3 && last == points[static_cast<size_t>(curve.vertices.front())]) {
      points.pop_back();  // closed: the first point is repeated
      curve.vertices.back() = curve.vertices.front();
    }
  };
  while (reader.next(line)) {
    line = trim(without_comment(line));
    if (line.empty()) continue;
    Tokens tokens(line);
    Tokens ahead = tokens;
    ahead.next(word);
    if (word == "CURVE") {
      finish_curve();
      raw.network.curves.emplace_back();
      raw.network.curves.back().name = line;
      continue;
    }
    if (raw.network.curves.empty()) reader.fail("expected 'CURVE k' before the first point");
    Eigen::RowVector3d point;
    for (int k = 0; k < 3; ++k) point(k) = read_finite(tokens, reader, "a coordinate");
    if (tokens.next(word)) reader.fail("expected three numbers x y z on the line");
    raw.network.curves.back().vertices.push_back(static_cast<int>(points.size()));
    points.push_back(point);
  }
  finish_curve();
  raw.network.positions = to_points(points);
  return raw;
}

RawNetwork parse_bsplines(std::string content, const std::string& path) {
  constexpr int kPerSpan = 32;    // samples of a knot span
  constexpr double kJoin = 1e-6;  // of the diameter: ends this close are the same point
  constexpr long kMostNumbers = 100000;
  LineReader reader(std::move(content), path);
  NumberStream in(reader);
  RawNetwork raw;
  std::vector<std::vector<Eigen::RowVector3d>> curves;
  std::vector<Eigen::RowVector3d> controls;
  std::vector<long> lines;
  const long n_curves = in.integer("the number of curves", 1, kMostNumbers);
  for (long c = 0; c < n_curves; ++c) {
    BSplineCurve spline;
    spline.degree = static_cast<size_t>(in.integer(concat("the degree of curve ", c), 1, 20));
    const long n_knots = in.integer(concat("the number of knots of curve ", c), 4, kMostNumbers);
    for (long k = 0; k < n_knots; ++k) {
      spline.knots.push_back(in.number(concat("a knot of curve ", c)));
      if (k > 0 && spline.knots.back() < spline.knots[static_cast<size_t>(k - 1)])
        reader.fail(concat("the knots of curve ", c, " decrease"));
    }
    const long n_points = in.integer(concat("the number of control points of curve ", c), 2, kMostNumbers);
    if (n_knots != n_points + static_cast<long>(spline.degree) + 1)
      reader.fail(concat("curve ", c, " has ", n_knots, " knots, expected ",
                         n_points + static_cast<long>(spline.degree) + 1, " (control points + degree + 1)"));
    for (long p = 0; p < n_points; ++p) {
      Eigen::RowVector3d point;
      for (int k = 0; k < 3; ++k)
        point(k) = in.number(concat("a coordinate of a control point of curve ", c));
      spline.points.push_back(point);
    }
    controls.insert(controls.end(), spline.points.begin(), spline.points.end());
    std::vector<Eigen::RowVector3d> samples;
    for (size_t span = spline.degree; span < spline.points.size(); ++span) {
      const double low = spline.knots[span], high = spline.knots[span + 1];
      if (!(high > low)) continue;
      for (int k = samples.empty() ? 0 : 1; k <= kPerSpan; ++k) {
        const Eigen::RowVector3d point = spline.at(low + (high - low) * k / kPerSpan, span);
        if (samples.empty() || point != samples.back()) samples.push_back(point);
      }
    }
    if (samples.size() < 2)
      reader.fail(concat("curve ", c, " is a point; check its knots and control points"));
    curves.push_back(std::move(samples));
    lines.push_back(reader.line_number());
  }
  if (!in.at_end())
    reader.fail(concat("more numbers follow than the ", n_curves, " curves announced; correct the count"));
  // The curves follow each other round the loop: each begins where the one before ends.
  const double join = kJoin * bounding_box_diagonal(to_points(controls));
  std::vector<Eigen::RowVector3d> points;
  for (size_t c = 0; c < curves.size(); ++c) {
    const size_t before = (c + curves.size() - 1) % curves.size();
    const double gap = (curves[c].front() - curves[before].back()).norm();
    if (gap > join)
      throw FileError(path, lines[c],
                      concat("curve ", c, " begins ", gap, " away from the end of curve ", before,
                             "; the curves must follow each other round the loop"));
    NetworkCurve curve;
    curve.boundary = true;  // of the patch that the loop bounds
    for (size_t k = 0; k + 1 < curves[c].size(); ++k) {
      curve.vertices.push_back(static_cast<int>(points.size()));
      points.push_back(curves[c][k]);
    }
    raw.network.curves.push_back(std::move(curve));
  }
  for (size_t c = 0; c < curves.size(); ++c) {
    const int next = raw.network.curves[(c + 1) % curves.size()].vertices.front();
    raw.network.curves[c].vertices.push_back(next);
    raw.network.tagged_nodes.push_back(raw.network.curves[c].vertices.front());
  }
  raw.network.positions = to_points(points);
  raw.warnings.push_back(concat("the B-splines were sampled at ", kPerSpan, " points per knot span"));
  return raw;
}

}  // namespace batten::detail
