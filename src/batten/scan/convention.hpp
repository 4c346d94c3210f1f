#pragma once
#include <string>

#include "batten/scan/scan.hpp"

namespace batten {

/// What was found out about the tangents of a scan.
struct ConventionReport {
  TangentConvention convention = TangentConvention::AtSample;  ///< never Auto
  std::string reason;                                          ///< in words, with the figures it rests on
  /// Misfit of the loops with tangents to the next reading over the length of a curve; −1 where not measured.
  double forward_misfit = -1;
  bool uncertain = false;  ///< the two readings of the data fit about equally well
};

/// Tells whether tangents belong to the readings or point to the next one (docs/methods.md#positions). A
/// tangent that points along a chord is not at right angles to the normal at its reading, but to the mean of
/// the normals at both ends; and the steps of such a scan close exactly where those of frames at the readings
/// do not. What the scan itself states is taken as it is.
/// @pre check_scan() has passed.
ConventionReport tangent_convention(const Scan& scan);

/// A scan whose tangents point to the next reading, turned into frames at the readings: tangents interpolated
/// between the chords (cubic where steps are even), distances along chords made arc lengths.
Scan frames_at_samples(const Scan& scan);

}  // namespace batten
