#pragma once
#include <vector>

#include "batten/core/arrays.hpp"

// Private to the room.
namespace batten::detail {

/// Fixed points x = g(x) from the last few steps: the combination of them whose residuals g(x) − x cancel
/// best [anderson1965] [walker2011]. Where plain steps creep or swing this converges like a quasi-Newton
/// method.
class AndersonAcceleration {
 public:
  /// @param depth how many steps are looked back on.
  explicit AndersonAcceleration(int depth) : depth_(depth) {}

  void forget() { past_.clear(); }

  /// Moves x to where g is to be evaluated next. @param g what g(x) was. @param damping of the step, (0, 1].
  void advance(Points& x, const Points& g, double damping);

 private:
  /// Differences of one step and of the residuals at its ends; for the last entry, where it began.
  struct Step {
    Points x, residual;
  };
  int depth_;
  std::vector<Step> past_;
};

}  // namespace batten::detail
