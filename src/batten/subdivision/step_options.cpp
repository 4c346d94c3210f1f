#include <cmath>

#include "batten/core/text.hpp"
#include "batten/subdivision/step.hpp"

// Apart from step.cpp, which is left out where Open Cascade is missing.
namespace batten {

std::optional<std::string> StepOptions::problem() const {
  if (!(millimetres_per_unit > 0) || !std::isfinite(millimetres_per_unit))
    return concat("millimetres_per_unit must be > 0, got ", millimetres_per_unit);
  return std::nullopt;
}

std::optional<CadFormat> cad_format(std::string_view extension) {
  if (extension == "step" || extension == "stp") return CadFormat::Step;
  if (extension == "iges" || extension == "igs") return CadFormat::Iges;
  return std::nullopt;
}

std::string format_cad(CadFormat format, const BsplineSurface& surface, const StepOptions& options) {
  return format == CadFormat::Iges ? format_iges(surface, options) : format_step(surface, options);
}

}  // namespace batten
