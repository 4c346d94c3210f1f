#include <mutex>

#include <dlfcn.h>

#include "batten/linalg/serial_blas_detail.hpp"

// Present when the BLAS in use is OpenBLAS.
extern "C" void openblas_set_num_threads(int n) __attribute__((weak));
extern "C" int openblas_get_num_threads() __attribute__((weak));

namespace batten::linalg_detail {

namespace {

/// OpenBLAS has one setting for the whole process: the first to come keeps what it finds, the last to go puts
/// it back.
struct OpenBlas {
  std::mutex mutex;
  int users = 0, threads = 1;

  void enter() {
    if (openblas_set_num_threads == nullptr || openblas_get_num_threads == nullptr) return;
    const std::lock_guard<std::mutex> lock(mutex);
    if (users++ > 0) return;
    threads = openblas_get_num_threads();
    if (threads != 1) openblas_set_num_threads(1);
  }
  void leave() {
    if (openblas_set_num_threads == nullptr || openblas_get_num_threads == nullptr) return;
    const std::lock_guard<std::mutex> lock(mutex);
    if (--users == 0 && threads != 1) openblas_set_num_threads(threads);
  }
};

OpenBlas& open_blas() {
  static OpenBlas instance;
  return instance;
}

// Looked up because only CHOLMOD itself is linked with OpenMP. The setting belongs to the calling thread.
template <typename Function>
Function open_mp(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_DEFAULT, name));
}

}  // namespace

SerialBlas::SerialBlas() {
  static const auto get_levels = open_mp<int (*)()>("omp_get_max_active_levels");
  static const auto set_levels = open_mp<void (*)(int)>("omp_set_max_active_levels");
  open_blas().enter();
  if (get_levels == nullptr || set_levels == nullptr) return;
  levels_ = get_levels();
  set_levels(0);
}

SerialBlas::~SerialBlas() {
  static const auto set_levels = open_mp<void (*)(int)>("omp_set_max_active_levels");
  if (levels_ >= 0) set_levels(levels_);
  open_blas().leave();
}

}  // namespace batten::linalg_detail
