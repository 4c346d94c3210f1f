#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "batten/simulation/traced_curve.hpp"

namespace batten {

/// Surfaces given by formulas, with a network of plane sections each. The definitions are in
/// docs/simulate.md; the planes are those of the exact networks that the acceptance tests use.
enum class Shape { Sphere, Sphere6, Ellipsoid, Torus, BumpyCube, Saddle, Waves, Dish, Cone };

/// The names of the shapes as the command line takes them, in the order of the enumeration.
const std::vector<std::string>& shape_names();
/// By name or alias (sphere3, ellipsoid5, bumpy-cube). False when there is no such shape.
bool find_shape(std::string_view name, Shape& shape);

/// The curves of a shape, traced exactly.
TracedNetwork trace_shape(Shape shape);

/// A triangle mesh of a shape; every vertex lies on the surface to rounding and carries the exact normal.
/// @param edge_length of the triangles, about, in diameters; (0, 0.2].
/// @throws InvalidInput when edge_length is out of range.
TriangleMesh shape_mesh(Shape shape, double edge_length = 0.004);

/// f(x) of the surface f = 0; positive outside (above, for height fields), ∇f outward.
ImplicitFunction shape_function(Shape shape);

}  // namespace batten
