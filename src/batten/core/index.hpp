#pragma once
#include <cassert>
#include <concepts>
#include <cstddef>

namespace batten {

/// The place in a container of the element number `i`: meshes and networks count in int (and Eigen in
/// Eigen::Index) so that −1 can mean "none", std::vector in size_t. Written `edges[at(e)]`. Costs nothing.
/// @pre i is at least 0; asserted in debug builds, where −1 would otherwise become a place far outside.
template <std::signed_integral Index>
constexpr std::size_t at(Index i) {
  assert(i >= 0);
  return static_cast<std::size_t>(i);
}

}  // namespace batten
