#pragma once
#include <string>
#include <utility>
#include <vector>

#include "batten/mesh/triangle_mesh.hpp"

namespace batten::meshlab {

/// One filter of a MeshLab script, by the name that MeshLab 2020.09 gives it.
struct Filter {
  enum class Kind { Bool, Int, Float, Length };
  struct Parameter {
    Kind kind;
    std::string name, value;
  };
  std::string name;
  /// All of them: the server of the distribution ends on a script that leaves one out.
  std::vector<Parameter> parameters;
};

/// Quadric edge collapse to `n_faces`, all else as MeshLab proposes it.
Filter quadric_edge_collapse(Eigen::Index n_faces);
/// Isotropic explicit remeshing, 10 iterations, all else as MeshLab proposes it. @param length in the unit of
/// the mesh. @param diameter diagonal of the bounding box: MeshLab proposes a hundredth of it as tolerance.
Filter isotropic_remeshing(double length, double diameter);
/// Two-step smoothing and Taubin smoothing as MeshLab proposes them.
Filter two_step_smoothing();
Filter taubin_smoothing(int steps = 10);

/// Whether meshlabserver is installed, and a display or xvfb-run for it: it needs OpenGL even to read files.
bool is_available();

struct Result {
  TriangleMesh mesh;  ///< positions in single precision, as MeshLab writes them
  double seconds = 0, cpu_seconds = 0;
};

/// Applies one filter. The times are those of the program less the median of three runs with one step of
/// Taubin smoothing, which stands for start, reading and writing; below a tenth of a second they only say
/// "little".
/// @throws InvalidInput with the last line that MeshLab printed, when it fails.
Result apply(const Filter& filter, const TriangleMesh& mesh);

}  // namespace batten::meshlab
