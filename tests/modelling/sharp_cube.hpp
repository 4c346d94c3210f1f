#pragma once
#include "sketch/quadrics.hpp"

// Shared by the tests of surfaces of models.
namespace batten::strokes {

/// The unit cube with sharp edges around its top and two sharp uprights (H fig. 7.6).
inline PolylineMesh cube() {
  const Eigen::Vector3d x = kX, y = kY, z = kZ;
  return model({{{polygon({kO, x, x + y, y, kO}), true}, {}},
                {{polygon({kO, z, x + z, x}), false}, {.into = Into::Opening}},
                {{polygon({y, y + z, x + y + z, x + y}), false}, {}},
                {{polygon({z, y + z}), false}, {.sharpness = 1}},
                {{polygon({x + z, x + y + z}), false}, {.sharpness = 1}}});
}

}  // namespace batten::strokes
