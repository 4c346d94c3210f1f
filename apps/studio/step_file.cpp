#include "studio/step_file.hpp"

#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/pipeline/step_surface.hpp"
#include "batten/subdivision/bspline_blocks.hpp"
#include "batten/subdivision/bspline_surface.hpp"
#include "batten/subdivision/step.hpp"

namespace batten::studio {

std::string step_file(const RequestResult& made, const std::string& unit, const Progress& progress) {
  require_step();
  const Length one = parse_length(unit.empty() ? "1m" : "1" + unit);
  if (one.kind != Length::Kind::Metres)
    throw InvalidInput(concat("STEP files hold millimetres, and the unit of this object is '", unit,
                              "'; set it to m, cm, mm or in first"));
  StepOptions options;
  options.millimetres_per_unit = 1000 * one.value;
  if (const auto* model = std::get_if<ModelSurface>(&made)) {
    if (model->cage.mesh.n_faces() == 0)
      throw InvalidInput("the filled network has no cage that STEP could hold; take another method");
    return format_step(joined_bsplines(limit_bsplines(model->cage, {}, progress), progress), options);
  }
  const auto* curves = std::get_if<CurvesSurface>(&made);
  if (curves == nullptr) throw InvalidInput("only surfaces of curves can be saved as STEP");
  StepSurfaceOptions wanted;
  wanted.step = options;
  wanted.network = &curves->network;
  StepSurface step = step_surface(curves->surface.mesh, curves->surface.patch_of_triangle, wanted, progress);
  if (!step.flaws.empty()) throw InvalidInput(step.flaws.front());
  return std::move(step.text);
}

}  // namespace batten::studio
