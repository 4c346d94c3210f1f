#pragma once
#include <cstddef>
#include <span>

namespace batten {

// Order statistics. All reorder `values`, take O(n) in the mean, want no NaN among them, and depend on the
// values alone, not on their order.

/// The value before which `rank` others come in increasing order. @pre rank < values.size().
double order_statistic(std::span<double> values, std::size_t rank);

/// The middle value; of an even number the mean of both middle ones, so that reflected data has the reflected
/// median. 0 when there is none.
double median(std::span<double> values);

/// The middle value; of an even number the larger of both middle ones: one of the values in every case, at
/// half the cost of median(). For scales, where a half rank does not matter. 0 when there is none.
double upper_median(std::span<double> values);

/// The value of rank ⌊share (n − 1)⌋, without interpolation: share 0 is the smallest, 1 the largest. 0 when
/// there is none. @param share in [0, 1].
double percentile(std::span<double> values, double share);

/// Scale by which the median absolute deviation from the median becomes the standard deviation of a normal
/// distribution: 1 / 0.6745, the quartile of the standard normal.
constexpr double kMadToDeviation = 1.4826;

/// Standard deviation of normally distributed values, by their median absolute deviation from `centre`:
/// kMadToDeviation × upper_median(|values − centre|). Up to half of the values may be wild. Values become
/// their deviations. 0 when there is none.
double deviation_by_median(std::span<double> values, double centre);

}  // namespace batten
