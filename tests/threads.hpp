#pragma once
#include "batten/core/parallel.hpp"

namespace batten::test {

/// Sets the number of threads as long as it lives, also where a test is left early. On one thread a work
/// makes the same reports every time; on several the calling one reports the chunks that it happens to take.
class Threads {
 public:
  explicit Threads(int n) { set_thread_count(n); }
  ~Threads() { set_thread_count(0); }
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;
};

}  // namespace batten::test
