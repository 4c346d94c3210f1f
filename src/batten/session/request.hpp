#pragma once
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "batten/fairing/fair.hpp"
#include "batten/mesh/handles.hpp"
#include "batten/modelling/model_surface.hpp"
#include "batten/pipeline/deformed_mesh.hpp"
#include "batten/pipeline/network_surface.hpp"
#include "batten/pipeline/remeshed_mesh.hpp"
#include "batten/pipeline/repaired_mesh.hpp"
#include "batten/pipeline/simplified_mesh.hpp"
#include "batten/pipeline/subdivided_cage.hpp"
#include "batten/scan/reconstruct.hpp"
#include "batten/strokes/stroke_network.hpp"

// What a project asks to be made of one of its objects. A project keeps requests and hands them out; run()
// and Results (results.hpp) call the functions named here.
namespace batten {

/// The kinds of objects in a project, in the order of object.hpp.
enum class ObjectKind { Scan, Network, Model, Mesh, Calibration, View };
constexpr auto choices_of(ObjectKind) {
  return choices<ObjectKind>("kind of object", {{ObjectKind::Scan, "scan"},
                                                {ObjectKind::Network, "network"},
                                                {ObjectKind::Model, "model"},
                                                {ObjectKind::Mesh, "mesh"},
                                                {ObjectKind::Calibration, "calibration"},
                                                {ObjectKind::View, "view"}});
}

/// The network of a scan: network_from_scan().
struct NetworkRequest {
  ScanOptions options;
};

/// The surface of a network, or of strokes without normals: curves_surface().
struct SurfaceRequest {
  StrokeNetworkOptions strokes;
  NetworkSurfaceOptions surface;
};

/// The surface of a model: model_surface(), or EditedSurface where it follows edits.
struct ModelSurfaceRequest {
  ModelSurfaceOptions options;
};

/// A mesh without its noise: faired_mesh().
struct FairRequest {
  FairingOptions options;
};

/// New triangles for a mesh: remeshed_mesh().
struct RemeshRequest {
  RemeshedMeshOptions options;  ///< `sizes` of its remeshing are left empty: see below
  /// The name of the value per vertex of the mesh that holds the wanted sizes; empty: none.
  std::string sizes;
};

/// A mesh with fewer faces: simplified_mesh().
struct SimplifyRequest {
  SimplifiedMeshOptions options;
};

/// A mesh as the cage of a subdivision surface: subdivided_cage().
struct SubdivideRequest {
  SubdividedCageOptions options;  ///< with its refined mesh and without patches, which no object holds
};

/// Vertices of a mesh, by number. Shared, so that hundreds of edits of one handle hold one list.
using SharedVertices = std::shared_ptr<const std::vector<int>>;

/// Vertices that move together; see HandleMotion.
struct MovedVertices {
  SharedVertices vertices;  ///< null: none
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit
  double angle = 0;                                 ///< radians
  Eigen::Vector3d about = Eigen::Vector3d::Zero();
  std::shared_ptr<const Points> targets;  ///< null: the motion above holds
};

/// A mesh bent by handles: deformed_mesh().
struct DeformRequest {
  DeformedMeshOptions options;
  SharedVertices fixed;  ///< null: none
  std::vector<MovedVertices> moved;

  /// The handles of deformed_mesh().
  Handles handles() const;
};

/// A mesh mended: repaired_mesh().
struct RepairRequest {
  RepairedMeshOptions options;
};

using Request = std::variant<NetworkRequest, SurfaceRequest, ModelSurfaceRequest, FairRequest, RemeshRequest,
                             SimplifyRequest, SubdivideRequest, DeformRequest, RepairRequest>;

/// Which request it is, for choices and files.
enum class RequestKind { Network, Surface, ModelSurface, Fair, Remesh, Simplify, Subdivide, Deform, Repair };
constexpr auto choices_of(RequestKind) {
  return choices<RequestKind>("request", {{RequestKind::Network, "network"},
                                          {RequestKind::Surface, "surface"},
                                          {RequestKind::ModelSurface, "model-surface"},
                                          {RequestKind::Fair, "fair"},
                                          {RequestKind::Remesh, "remesh"},
                                          {RequestKind::Simplify, "simplify"},
                                          {RequestKind::Subdivide, "subdivide"},
                                          {RequestKind::Deform, "deform"},
                                          {RequestKind::Repair, "repair"}});
}
/// Which request it is.
RequestKind kind_of(const Request& request);
/// A request with default options.
Request default_request(RequestKind kind);

ObjectKind source_kind(RequestKind kind);  ///< what it starts from
ObjectKind result_kind(RequestKind kind);  ///< what it gives

/// The first problem of the options, naming field and value, or nothing.
std::optional<std::string> problem(const Request& request);

/// Equal in every option, numbers bit for bit.
bool same_request(const Request& a, const Request& b);

/// The options in which two requests of one kind differ, as they are called in journals ("sigma",
/// "surface.edge_length"); "request" where the kinds differ.
std::vector<std::string> changed_options(const Request& before, const Request& after);

/// Lets a request hold the lists of another one where they are equal. Costs as much as comparing them.
void share_lists(Request& request, const Request& with);

}  // namespace batten
