#pragma once
#include <optional>
#include <string>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"

namespace batten {

/// Options of the two-step normal filters of the literature. The defaults are those of the published
/// programs.
struct NormalFilterOptions {
  /// r of exp(−|N − N'|²/2r²), a difference of unit normals (0.35 is 20°).
  double range = 0.35;
  int iterations = 20;         ///< of the filter
  int vertex_iterations = 10;  ///< of the vertex update
  bool keep_boundary = false;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Bilateral filter of the normals of triangles over their neighbours ([zheng2011], local form).
/// @return m × 3 unit normals.
Points bilateral_normals(const Points& positions, const Triangles& triangles,
                         const NormalFilterOptions& options = {}, const Progress& progress = {});

/// Joint bilateral filter guided by the most consistent patch around each triangle [zhang2015].
/// @return m × 3 unit normals.
Points guided_normals(const Points& positions, const Triangles& triangles,
                      const NormalFilterOptions& options = {}, const Progress& progress = {});

/// Moves the vertices until the triangles stand perpendicular to given normals: gradient descent with equal
/// weights [sun2007]. Sideways moves included, nothing holds the volume.
Points move_to_normals(const Points& positions, const Triangles& triangles, const Points& face_normals,
                       int iterations, bool keep_boundary = false);

/// The least-squares refit of the positions to given normals with fidelity, H section 2.1.5 step 2 with
/// normals in the place of curvature normals: min Σ cot (n_f · (x_i − x_j))² + λ‖X − X0‖².
/// @param fidelity λ > 0, no unit.
Points refit_to_normals(const Points& positions, const Triangles& triangles, const Points& face_normals,
                        double fidelity, bool keep_boundary = false, const Progress& progress = {});

}  // namespace batten
