#pragma once
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

/// OpenMesh's decimater with quadrics and a bound on flipped normals (ModQuadric, ModNormalFlipping).
struct OpenMeshDecimation {
  TriangleMesh mesh;
  double seconds = 0, cpu_seconds = 0;  ///< of the decimation alone
};
OpenMeshDecimation decimate_with_openmesh(const TriangleMesh& mesh, Eigen::Index n_faces);

}  // namespace batten
