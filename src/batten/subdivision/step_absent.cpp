// Stands in for step.cpp where Open Cascade is missing.
#include "batten/core/error.hpp"
#include "batten/subdivision/step.hpp"

namespace batten {

namespace {

[[noreturn]] void refuse() {
  throw InvalidInput(
      "this build of batten has no Open Cascade and neither writes nor reads STEP and IGES; get it with "
      "tools/setup step && tools/build program");
}

}  // namespace

bool has_step() {
  return false;
}

void require_step() {
  refuse();
}

std::string format_step(const BsplineSurface&, const StepOptions&) {
  refuse();
}

std::string format_iges(const BsplineSurface&, const StepOptions&) {
  refuse();
}

StepModel read_step(const std::string&) {
  refuse();
}

StepModel read_iges(const std::string&) {
  refuse();
}

}  // namespace batten
