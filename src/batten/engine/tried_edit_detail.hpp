#pragma once
#include "batten/engine/reply_detail.hpp"
#include "batten/session/sketch_edit.hpp"
#include "batten/sketch/polyline_mesh.hpp"

// Private to the room: what a stroke would become, before it is one.
namespace batten::detail {

/// Does an edit on a copy of the model. Adds `accepted`; with it `pieces` (each `first` and `n` in the array
/// positions, which are less the origin; of the curves that are new), `meets` (where they meet curves that
/// were there: `at` and `curve`) and `faces`, how many more there would be; without it `reason` and `remedy`.
void add_tried(Draft& draft, const PolylineMesh& model, const SketchEdit& edit);

}  // namespace batten::detail
