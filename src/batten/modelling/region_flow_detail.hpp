#pragma once
#include "batten/core/progress.hpp"
#include "batten/modelling/diffusion_surface.hpp"
#include "batten/modelling/surface_records_detail.hpp"

// The flow on a region of a surface, with the faces around it held. Private to the room.
namespace batten::detail {

/// Moves the vertices of a region that nothing holds.
/// @param surroundings the region and the faces around it; a surface, see SurfaceRecords::close_fans().
/// @param start stale faces begin on a plate or a Coons patch first. Where they began is kept in
/// records.started; frozen faces go back there.
/// @param diameter of the model.
/// @param last gets the rounds and the last move.
/// @return the largest move of a vertex of the region's outermost faces, ÷ diameter; 0 where the region has
/// no rim.
/// @throws Cancelled, SolverFailure.
double move_region(SurfaceRecords& records, const FaceSet& region, const FaceSet& surroundings, bool start,
                   const PolylineMesh& mesh, double diameter, SurfaceUpdate& last, const Progress& progress);

/// Freezes the faces of the region that fold or cross others, and puts it back to where the flow began.
/// @return false where there are none, or all of them are frozen already.
bool freeze_folded(SurfaceRecords& records, const FaceSet& region, const PolylineMesh& mesh);

}  // namespace batten::detail
