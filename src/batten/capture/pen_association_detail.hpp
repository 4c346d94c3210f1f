#pragma once
#include "batten/capture/pen_filter_detail.hpp"
#include "batten/capture/pen_identification.hpp"

// Private to the room: which blob of a frame is which LED, for a pen whose motion is known.
namespace batten::detail {

/// The assignment of blobs to LEDs that explains most at least misfit: of all assignments of blobs within 4 σ
/// of where an LED is predicted, that with the greatest 16 · count − νᵀ S⁻¹ ν, the innovations of all LEDs
/// taken together: a blob that fits its own LED but not the others' places is left out.
LedBlobs associate(const StereoRig& rig, const Pen& pen, const BlobFrame& frame, const Belief& predicted,
                   double blob_floor);

}  // namespace batten::detail
