#pragma once
#include "batten/core/progress.hpp"
#include "batten/implicit/level_set.hpp"
#include "batten/implicit/stroke_field.hpp"
#include "batten/mesh/triangle_mesh.hpp"

namespace batten {

/// Triangles of the surface where a field of strokes vanishes: level_set() with vertices along the strokes,
/// on them where the field passes within a twentieth of an edge, else on their feet.
/// @param options lengths in the unit of the strokes. @throws InvalidInput as level_set(); Cancelled.
TriangleMesh field_mesh(const StrokeField& field, const StrokeSamples& samples,
                        const LevelSetOptions& options, const Progress& progress = {});

}  // namespace batten
