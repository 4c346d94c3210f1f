#include <chrono>
#include <memory>
#include <utility>

#include "batten/core/background_work.hpp"
#include "batten/linalg/background_detail.hpp"

namespace batten::linalg_detail {

namespace {

constexpr std::chrono::milliseconds kBetweenReports{50};

}  // namespace

bool run_in_background(std::function<bool()> work, const Progress& progress) {
  const auto result = std::make_shared<bool>(false);
  BackgroundWork background([result, work = std::move(work)] { *result = work(); });
  while (!background.wait(kBetweenReports)) progress.report("factorisation", 0);
  background.finish();
  return *result;
}

}  // namespace batten::linalg_detail
