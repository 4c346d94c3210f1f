#pragma once
#include <vector>

#include "batten/core/arrays.hpp"

namespace batten {

/// The rows of `points` along a space-filling curve (Morton's), so that work in this order finds its
/// neighbours' data still in the cache. Points in the same cell of 1024 per axis follow their numbers.
/// @pre every coordinate is finite.
std::vector<int> spatial_order(const Points& points);

}  // namespace batten
