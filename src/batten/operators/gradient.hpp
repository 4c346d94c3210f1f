#pragma once
#include "batten/core/arrays.hpp"
#include "batten/linalg/sparse_cholesky.hpp"

namespace batten {

/// Gradient of piecewise linear functions: G is 3m × n, rows 3f … 3f + 2 hold the vector of triangle f, which
/// lies in its plane. Rows of a triangle without area are zero. H (1.5–1.7)
SparseMatrix face_gradient(const Points& positions, const Triangles& triangles);

/// Integrated divergence of vectors per triangle: D = −Gᵀ diag(area), n × 3m, so that D G = −K (cotangent)
/// and ⟨D u, f⟩ = −⟨u, G f⟩ with areas, exactly.
SparseMatrix face_divergence(const Points& positions, const Triangles& triangles);

/// Gradient per vertex: the area-weighted mean over its triangles, 3n × n. H (1.9)
SparseMatrix vertex_gradient(const Points& positions, const Triangles& triangles);

/// Divergence per vertex of vectors per vertex: the area-weighted mean over its triangles, n × 3n, columns
/// 3v … 3v + 2 for the vector of vertex v; a density, not integrated. The same numbers as vertex_gradient(),
/// and minus its adjoint only in the limit of small triangles. H (1.11–1.12)
SparseMatrix vertex_divergence(const Points& positions, const Triangles& triangles);

}  // namespace batten
