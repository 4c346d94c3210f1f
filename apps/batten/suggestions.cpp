#include "suggestions.hpp"

#include <algorithm>

namespace batten::cli {

namespace {

/// Optimal string alignment distance [damerau1964].
std::size_t slips_between(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_last, last(b.size() + 1), now(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      now[j] = std::min({last[j] + 1, now[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        now[j] = std::min(now[j], before_last[j - 2] + 1);
    }
    before_last = last;
    last = now;
  }
  return last[b.size()];
}

}  // namespace

std::string nearest_name(std::string_view given, const std::vector<std::string>& names) {
  std::string nearest;
  std::size_t fewest = std::min<std::size_t>(3, std::max<std::size_t>(1, given.size() / 3)) + 1;
  for (const std::string& name : names)
    if (const std::size_t slips = slips_between(given, name); slips < fewest) {
      fewest = slips;
      nearest = name;
    }
  return nearest;
}

}  // namespace batten::cli
