#include "batten/simulation/shapes.hpp"

#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/simulation/section_nodes_detail.hpp"
#include "batten/simulation/shape_meshes_detail.hpp"
#include "batten/simulation/shape_sections_detail.hpp"

namespace batten {

namespace {

// Knots of the traced curves, in diameters: small against every radius of curvature of the shapes.
constexpr double kTraceStep = 0.005;

constexpr double kCoarseEdge = 0.03;  // in the unit of the shapes, which are 1.7 to 17 across
// As surface_network() refuses by default; they take 2 GB.
constexpr double kMostTriangles = 20e6;

TriangleMesh coarse_mesh(AnalyticShape shape) {
  return detail::build_mesh(shape, kCoarseEdge).finish(shape_function(shape));
}

}  // namespace

TracedNetwork trace_shape(AnalyticShape shape) {
  TracedNetwork traced;
  traced.name = word_of(shape);
  traced.diameter = bounding_box_diagonal(coarse_mesh(shape).positions);
  const ImplicitFunction surface = shape_function(shape);
  const std::vector<detail::ShapeSection> sections = detail::sections_of(shape);
  std::vector<ImplicitFunction> cuts;
  for (const detail::ShapeSection& section : sections) {
    TraceRequest request;
    request.surface = surface;
    request.cut = section.cut;
    request.start = section.start;
    request.towards = section.towards;
    request.closed = section.closed;
    request.end = section.end;
    request.step = kTraceStep * traced.diameter;
    TracedCurve curve;
    curve.name = section.name;
    curve.boundary = section.boundary;
    curve.closed = section.closed;
    curve.path = trace_intersection(request);
    traced.curves.push_back(std::move(curve));
    cuts.push_back(section.cut);
  }
  detail::find_nodes(traced, cuts, surface);
  return traced;
}

TriangleMesh shape_mesh(AnalyticShape shape, double edge_length) {
  if (!(edge_length > 0 && edge_length <= 0.2))
    throw InvalidInput(
        concat("the edge length of a shape's mesh must lie in (0, 0.2] diameters, got ", edge_length));
  const TriangleMesh coarse = coarse_mesh(shape);
  const double length = edge_length * bounding_box_diagonal(coarse.positions);
  const double ratio = kCoarseEdge / length;
  if (const double n = static_cast<double>(coarse.n_triangles()) * ratio * ratio; n > kMostTriangles)
    throw InvalidInput(concat("edges of ", edge_length, " diameters would give the true mesh about ", n,
                              " triangles, more than ", kMostTriangles, "; use longer ones"));
  return detail::build_mesh(shape, length).finish(shape_function(shape));
}

}  // namespace batten
