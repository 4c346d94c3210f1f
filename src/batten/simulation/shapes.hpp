#pragma once
#include "batten/core/choices.hpp"
#include "batten/simulation/traced_curve.hpp"

namespace batten {

/// Surfaces given by formulas, with a network of plane sections each. The definitions are in
/// docs/simulate.md; the planes are those of the exact networks that the acceptance tests use.
enum class AnalyticShape { Sphere, Sphere6, Ellipsoid, Torus, BumpyCube, Saddle, Waves, Dish, Cone };

/// Their words, with other spellings as aliases.
constexpr auto choices_of(AnalyticShape) {
  return choices<AnalyticShape>("shape", {{AnalyticShape::Sphere, "sphere"},
                                          {AnalyticShape::Sphere, "sphere3"},
                                          {AnalyticShape::Sphere6, "sphere6"},
                                          {AnalyticShape::Ellipsoid, "ellipsoid"},
                                          {AnalyticShape::Ellipsoid, "ellipsoid5"},
                                          {AnalyticShape::Torus, "torus"},
                                          {AnalyticShape::BumpyCube, "bumpycube"},
                                          {AnalyticShape::BumpyCube, "bumpy-cube"},
                                          {AnalyticShape::Saddle, "saddle"},
                                          {AnalyticShape::Waves, "waves"},
                                          {AnalyticShape::Dish, "dish"},
                                          {AnalyticShape::Cone, "cone"}});
}

/// The curves of a shape, traced exactly.
TracedNetwork trace_shape(AnalyticShape shape);

/// A triangle mesh of a shape; every vertex lies on the surface to rounding and carries the exact normal.
/// @param edge_length of the triangles, about, in diameters; (0, 0.2].
/// @throws InvalidInput when edge_length is out of range, or would give more than 20 million triangles.
TriangleMesh shape_mesh(AnalyticShape shape, double edge_length = 0.004);

/// f(x) of the surface f = 0; positive outside (above, for height fields), ∇f outward.
ImplicitFunction shape_function(AnalyticShape shape);

}  // namespace batten
