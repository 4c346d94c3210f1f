#pragma once
#include "batten/scan/prefilter.hpp"

namespace batten {

/// The turns of a curve summed up, reading by reading; empty without gyroscope.
TurnPath turn_path(const ScanCurve& curve);

/// Gives the samples of a curve the turns between them: frames of the path between two readings lie on the
/// shortest turn from one to the other, in proportion to the distance.
/// @param source of the readings. @param clean the readings in order. @param curve with its parameters.
void set_turns(const ScanCurve& source, const CleanCurve& clean, SampledCurve& curve);

}  // namespace batten
