#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace batten::cli {

/// The name among `names` that `given` is most likely a slip of: fewest letters to insert, leave out, replace
/// or swap with a neighbour, at most a third of them and three. Empty where none is near.
std::string nearest_name(std::string_view given, const std::vector<std::string>& names);

}  // namespace batten::cli
