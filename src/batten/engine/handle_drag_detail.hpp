#pragma once
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "batten/core/progress.hpp"
#include "batten/deformation/deformer.hpp"
#include "batten/engine/reply_detail.hpp"
#include "batten/engine/shown_object_detail.hpp"
#include "batten/mesh/handles.hpp"
#include "batten/session/object.hpp"

// Private to the room: a mesh while it is pulled at.
namespace batten::detail {

/// A place of a mesh that a pointer holds. What is shown while it moves is the linear solution of the wanted
/// energy, without the search that keeps detail: the matrix is factorised once, when hold is taken.
class HandleDrag {
 public:
  /// The vertices within `radius` of a place move together, those farther away than `reach` stay, and with
  /// them the parts of the mesh that none of the moved belong to.
  /// @throws InvalidInput where nothing would move or nothing stay, and on lengths that are none; as
  /// Deformer.
  void grab(SharedMesh mesh, const Eigen::Vector3d& place, double radius, double reach,
            DeformationEnergy energy, const Progress& progress);
  /// Adds the arrays moved and fixed, vertices of the mesh, and the mesh as it is to be drawn.
  void add_grabbed(Draft& draft) const;

  /// Adds positions and normals with the handle turned and moved so. The motion's vertices are not read.
  /// @throws InvalidInput where no place is held, or on numbers that are none.
  void pull(Draft& draft, const HandleMotion& motion, const Progress& progress);

 private:
  SharedMesh mesh_;
  SplitMesh split_;
  Eigen::RowVector3d origin_ = Eigen::RowVector3d::Zero();
  Handles handles_;
  std::unique_ptr<Deformer> deformer_;
};

}  // namespace batten::detail
