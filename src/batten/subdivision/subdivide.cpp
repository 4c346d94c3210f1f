#include "batten/subdivision/subdivide.hpp"

#include <cmath>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/subdivision/cage_topology_detail.hpp"
#include "batten/subdivision/catmull_clark_detail.hpp"
#include "batten/subdivision/interpolatory_detail.hpp"

namespace batten {

namespace {

constexpr int kMostLevels = 12;

/// What is sharp in the cage, one level per refinement less, along the pieces of its edges.
void keep_sharpness(const ControlCage& cage, const detail::CageTopology& topology, int levels,
                    SubdividedSurface& surface) {
  const std::vector<double> of_edges = detail::edge_sharpness(cage, topology);
  for (size_t e = 0; e < of_edges.size(); ++e) {
    const double left = detail::sharpness_after(of_edges[e], levels);
    if (left <= 0) continue;
    const Eigen::Index row = static_cast<Eigen::Index>(e);
    for (Eigen::Index k = 0; k + 1 < surface.edge_chains.cols(); ++k)
      surface.cage.sharp_edges.push_back(
          {surface.edge_chains(row, k), surface.edge_chains(row, k + 1), left});
  }
  const std::vector<double> of_vertices = detail::vertex_sharpness(cage);
  for (size_t v = 0; v < of_vertices.size(); ++v) {
    const double left = detail::sharpness_after(of_vertices[v], levels);
    if (left > 0) surface.cage.sharp_vertices.push_back({static_cast<int>(v), left});
  }
}

}  // namespace

std::optional<std::string> SubdivisionOptions::problem() const {
  if (levels < 0 || levels > kMostLevels)
    return concat("levels must be 0 to ", kMostLevels, ", got ", levels);
  if (!(knot_exponent >= 0 && knot_exponent <= 1))
    return concat("knot_exponent must be 0 to 1, got ", knot_exponent);
  return std::nullopt;
}

SubdividedSurface subdivide(const ControlCage& cage, const SubdivisionOptions& options,
                            const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  progress.report("subdivide", 0);
  const double n_faces =
      options.levels == 0 ? static_cast<double>(cage.mesh.n_faces())
                          : static_cast<double>(cage.mesh.corners.size()) * std::pow(4.0, options.levels - 1);
  if (n_faces > detail::kMostFaces)
    throw InvalidInput(concat(options.levels, " levels would make ", n_faces,
                              " faces; take fewer levels, at most ", detail::kMostFaces, " faces are made"));
  const detail::CageTopology topology = detail::cage_topology(cage.mesh);
  SubdividedSurface surface;
  if (options.scheme == SubdivisionScheme::CatmullClark)
    detail::refine_catmull_clark(cage, topology, options, surface, progress);
  else
    detail::refine_interpolatory(cage, topology, options, surface, progress);
  keep_sharpness(cage, topology, options.levels, surface);
  progress.report("subdivide", 1);
  return surface;
}

}  // namespace batten
