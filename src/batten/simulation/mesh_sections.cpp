#include "batten/simulation/mesh_sections.hpp"

#include <algorithm>
#include <memory>
#include <set>
#include <utility>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/simulation/mesh_polylines_detail.hpp"
#include "batten/simulation/polyline_crossings_detail.hpp"
#include "batten/simulation/section_knots_detail.hpp"
#include "batten/simulation/spline_curve_detail.hpp"

namespace batten {

namespace {

using detail::MeshPolyline;
using detail::PolylineCrossings;
using detail::SectionKnots;
using detail::SplineCurve;

// Sections shorter than this have no room for readings and are left out (diameters).
constexpr double kShortestCurve = 0.02;

/// Lays planes over a mesh and collects its borders and the sections.
class PolylineCollector {
 public:
  PolylineCollector(const TriangleMesh& mesh, const MeshSectionOptions& options, double diameter)
      : mesh_(mesh),
        axes_(options.axes),
        diameter_(diameter),
        faces_(mesh),
        normals_(vertex_normals(mesh.positions, mesh.triangles)),
        lines_(detail::border_polylines(mesh, normals_, faces_)),
        n_borders_(lines_.size()) {
    for (const char letter : axes_) {
      const double low = mesh_.positions.col(letter - 'x').minCoeff();
      const double high = mesh_.positions.col(letter - 'x').maxCoeff();
      for (int k = 1; k <= options.planes; ++k)
        lay_plane(letter, low + (high - low) * k / (options.planes + 1));
    }
    cross_lost_borders();
  }

  bool has_sections() const { return lines_.size() > n_borders_; }
  std::vector<MeshPolyline> take() { return std::move(lines_); }

 private:
  void lay_plane(char letter, double wanted) {
    const int axis = letter - 'x';
    const double offset = detail::clear_offset(mesh_.positions.col(axis), wanted, diameter_);
    std::vector<MeshPolyline> sections = detail::plane_sections(mesh_, normals_, faces_, axis, offset);
    for (std::size_t part = 0; part < sections.size(); ++part) {
      if (sections[part].length() < kShortestCurve * diameter_ || sections[part].points.size() < 3) continue;
      sections[part].name = concat(letter, " = ", offset);
      if (sections.size() > 1) sections[part].name += concat(" part ", part + 1);
      lines_.push_back(std::move(sections[part]));
    }
  }

  /// A border that no plane meets would be lost; it gets a plane of its own across its longest side.
  void cross_lost_borders() {
    const auto places = detail::find_crossings(lines_).places;
    for (std::size_t b = 0; b < n_borders_; ++b) {
      if (!places[b].empty() || lines_[b].length() < kShortestCurve * diameter_) continue;
      Eigen::AlignedBox3d box;
      for (const Eigen::Vector3d& point : lines_[b].points) box.extend(point);
      char longest = axes_.front();
      for (const char letter : axes_)
        if (box.sizes()[letter - 'x'] > box.sizes()[longest - 'x']) longest = letter;
      lay_plane(longest, box.center()[longest - 'x']);
    }
  }

  const TriangleMesh& mesh_;
  const std::string& axes_;
  double diameter_;
  detail::MeshEdgeFaces faces_;
  Points normals_;
  std::vector<MeshPolyline> lines_;  // borders first
  std::size_t n_borders_;
};

/// The mean length of the sides of the triangles, within 0.5 % and 2 % of the diameter.
double default_spacing(const TriangleMesh& mesh, double diameter) {
  double sum = 0;
  for (Eigen::Index f = 0; f < mesh.n_triangles(); ++f)
    for (int k = 0; k < 3; ++k)
      sum += (mesh.positions.row(mesh.triangles(f, k)) - mesh.positions.row(mesh.triangles(f, (k + 1) % 3)))
                 .norm();
  return std::clamp(sum / (3.0 * static_cast<double>(mesh.n_triangles())), 0.005 * diameter, 0.02 * diameter);
}

void set_nodes(TracedNetwork& traced, const std::vector<detail::MeshCrossing>& crossings) {
  const auto n_nodes = static_cast<Eigen::Index>(crossings.size());
  traced.node_positions.resize(n_nodes, 3);
  traced.node_normals.resize(n_nodes, 3);
  for (Eigen::Index v = 0; v < n_nodes; ++v) {
    traced.node_positions.row(v) = crossings[static_cast<std::size_t>(v)].position;
    traced.node_normals.row(v) = crossings[static_cast<std::size_t>(v)].normal;
  }
}

TracedCurve traced_curve(const MeshPolyline& line, const SectionKnots& knots,
                         const std::shared_ptr<const SplineCurve>& path) {
  TracedCurve curve;
  curve.name = line.name;
  curve.boundary = line.boundary;
  curve.closed = line.closed;
  curve.path = path;
  for (std::size_t i = 0; i < knots.nodes.size(); ++i) {
    if (knots.nodes[i] < 0) continue;
    curve.node_distances.push_back(path->distance_of_knot(i));
    curve.node_ids.push_back(knots.nodes[i]);
  }
  if (curve.closed && !curve.node_ids.empty()) {  // the knots of a closed curve start at its first crossing
    curve.node_distances.push_back(path->length());
    curve.node_ids.push_back(curve.node_ids.front());
  }
  return curve;
}

}  // namespace

std::optional<std::string> MeshSectionOptions::problem() const {
  if (planes < 1 || planes > 100) return concat("planes must lie in 1 … 100, got ", planes);
  const std::set<char> distinct(axes.begin(), axes.end());
  if (distinct.size() != axes.size() || axes.size() < 2 || axes.find_first_not_of("xyz") != std::string::npos)
    return concat("axes must be two or three of x, y and z, got '", axes, "'");
  if (!(knot_spacing >= 0 && knot_spacing <= 0.2))
    return concat("knot_spacing must lie in [0, 0.2] diameters, got ", knot_spacing);
  return std::nullopt;
}

TracedNetwork trace_mesh(const TriangleMesh& mesh, const MeshSectionOptions& options) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  if (mesh.n_triangles() == 0) throw InvalidInput("the mesh has no faces; nothing can be scanned on it");
  TracedNetwork traced;
  traced.diameter = bounding_box_diagonal(mesh.positions);
  PolylineCollector collector(mesh, options, traced.diameter);
  if (!collector.has_sections()) throw InvalidInput("no plane meets the mesh; lay planes across other axes");
  std::vector<MeshPolyline> lines = collector.take();
  detail::keep_connected(lines, traced.warnings);
  PolylineCrossings found = detail::find_crossings(lines);
  if (found.crossings.empty() && lines.size() > 1)
    throw InvalidInput("the curves do not cross; lay more planes");

  const double spacing = options.knot_spacing > 0 ? options.knot_spacing * traced.diameter
                                                  : default_spacing(mesh, traced.diameter);
  std::vector<std::shared_ptr<SplineCurve>> paths;
  std::vector<SectionKnots> knots;
  for (std::size_t c = 0; c < lines.size(); ++c) {
    knots.push_back(detail::place_knots(lines[c], found.places[c], found.crossings, spacing));
    paths.push_back(std::make_shared<SplineCurve>(knots.back().points, lines[c].closed));
  }
  detail::set_consistent_normals(paths, knots, found.crossings, traced.warnings);
  set_nodes(traced, found.crossings);
  for (std::size_t c = 0; c < lines.size(); ++c)
    traced.curves.push_back(traced_curve(lines[c], knots[c], paths[c]));
  return traced;
}

}  // namespace batten
