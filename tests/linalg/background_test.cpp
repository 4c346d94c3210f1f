// Private to the room, and there with CHOLMOD alone.
#ifdef BATTEN_HAS_CHOLMOD
#include <dlfcn.h>
#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/linalg/background_detail.hpp"
#include "batten/linalg/serial_blas_detail.hpp"

namespace batten::linalg_detail {
namespace {

// What the work returns or throws on its thread is what the caller gets, as if it had called it.
TEST(RunInBackground, PassesOnWhatTheWorkReturnsAndThrows) {
  const Progress heard([](std::string_view, double) { return true; });
  EXPECT_TRUE(run_in_background([] { return true; }, heard));
  EXPECT_FALSE(run_in_background([] { return false; }, heard));
  EXPECT_THROW(run_in_background([]() -> bool { throw SolverFailure("work", 3); }, heard), SolverFailure);
}

// The settings are the process's: while one user is left they stay serial.
TEST(SerialBlas, StaysSerialUntilTheLastHasGone) {
  const auto threads = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_num_threads"));
  const auto set_threads = reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
  if (threads == nullptr || set_threads == nullptr) GTEST_SKIP() << "the BLAS in use is not OpenBLAS";
  const int before = threads();
  set_threads(2);
  {
    const SerialBlas outer;
    {
      const SerialBlas inner;
      EXPECT_EQ(threads(), 1);
    }
    EXPECT_EQ(threads(), 1);
  }
  EXPECT_EQ(threads(), 2);
  set_threads(before);
}

}  // namespace
}  // namespace batten::linalg_detail
#endif
