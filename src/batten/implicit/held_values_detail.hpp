#pragma once
#include <set>
#include <vector>

#include "batten/implicit/hermite_field.hpp"

namespace batten {

/// Points off the strokes and the values of f there.
struct HeldValues {
  Points points = Points(0, 3);
  Eigen::VectorXd values;
  Eigen::VectorXd smoothing;  ///< of FieldConditions

  Eigen::Index size() const { return points.rows(); }
  HeldValues part(const std::set<int>& rows) const;
  void append(const HeldValues& more);
};

/// Points around the samples of strokes, in diameters, and how far they are from a closed surface at least.
HeldValues points_outside(const Points& samples);

/// Adds the rows that a field does not leave outside by half their values; whether there are new ones.
bool add_not_outside(const HeldValues& outside, const HermiteField& field, std::set<int>& rows);

/// Conditions at sites on strokes and the held values.
FieldConditions with_held(const FieldConditions& on_strokes, const HeldValues& held);

/// Chosen rows, in that order.
Points rows_of(const Points& points, const std::vector<int>& rows);

}  // namespace batten
