#pragma once
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/engine/reply_detail.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/network/curve_network.hpp"
#include "batten/session/object.hpp"
#include "batten/session/results.hpp"
#include "batten/sketch/polyline_mesh.hpp"

// Private to the room: what objects look like to whoever draws them.
namespace batten::detail {

/// A mesh whose vertices are split where its triangles meet in a crease, so that one normal a vertex is
/// enough.
struct SplitMesh {
  std::vector<int> vertex;  ///< of the mesh, for each vertex here; those of the mesh come first, in order
  Points normals;
  Triangles triangles;

  /// A value per vertex of the mesh as one per vertex here.
  Eigen::VectorXd spread(const Eigen::VectorXd& values) const;
  Points spread(const Points& points) const;
};
SplitMesh split_at_creases(const TriangleMesh& mesh);

/// The middle of the bounding box of what is finite; zero where nothing is.
Eigen::RowVector3d middle_of(const Points& points);

/// Adds the arrays positions, normals, triangles and, where vertices were split, vertex; the figures of the
/// mesh under "mesh".
void draw_mesh(Draft& draft, const TriangleMesh& mesh, const Eigen::RowVector3d& origin);

/// Adds the arrays network.positions, network.normals (where there are any), network.vertices (of all curves,
/// one after the other) and network.nodes; the curves under "curves".
void draw_network(Draft& draft, const CurveNetwork& network, const Eigen::RowVector3d& origin);

/// The drawn curves of a model, a curve for every edge, that share no vertices.
CurveNetwork curves_of(const PolylineMesh& model);

/// The same of the drawn curves of a model, a piece for every edge. @return their middle, which is the
/// origin.
Eigen::RowVector3d draw_model(Draft& draft, const PolylineMesh& model);

/// What making a result reported: the weights and figures of a scan under "report", what was mended in a mesh
/// under "done", "flaws" and "warnings", seconds of each stage under "times".
void add_report(Draft& draft, const RequestResult& result);

/// The whole reply for an object that has content. Its origin is the middle of what is shown.
void draw(Draft& draft, const Content& content);

}  // namespace batten::detail
