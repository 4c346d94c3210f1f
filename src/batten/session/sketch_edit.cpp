#include "batten/session/sketch_edit.hpp"

#include <stdexcept>

namespace batten {

namespace {

template <typename... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <typename... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

}  // namespace

EditReport run_tool(PolylineMesh& model, const SketchEdit& edit) {
  EditReport report = std::visit(
      Overloaded{
          [&](const InsertEdit& e) { return insert_curve(model, e.stroke, e.options); },
          [&](const DeleteEdit& e) { return delete_curve(model, e.curve); },
          [&](const SharpnessEdit& e) { return set_curve_sharpness(model, e.curve, e.value, e.between); },
          [&](const MirrorEdit& e) {
            return e.curve >= 0 ? mirror_curve(model, e.curve, e.axis, e.options)
                                : mirror_stroke(model, e.stroke, e.axis, e.options);
          },
          [&](const HoleEdit& e) { return cut_hole(model, e.stroke, e.options); },
          [&](const GlueEdit& e) { return glue_borders(model, e.first, e.second, e.halves, e.options); },
          [&](const SkinEdit& e) { return skin_profiles(model, e.profiles, e.spines, e.options); },
          [&](const AlignEdit& e) { return align_model(model, e.reference, e.stroke); },
          [&](const TransformEdit& e) { return transform_model(model, e.matrix); },
      },
      edit);
  if (const std::string problem = model.broken_by_edit(); !problem.empty()) throw std::logic_error(problem);
  return report;
}

EditReport run_patiently(PolylineMesh& model, const SketchEdit& edit) {
  const auto options_of = [](SketchEdit& one) -> InsertOptions* {
    return std::visit(
        [](auto& e) -> InsertOptions* {
          if constexpr (requires { e.options; })
            return &e.options;
          else
            return nullptr;
        },
        one);
  };
  try {
    return run_tool(model, edit);
  } catch (const RefusedEdit&) {
    SketchEdit patient = edit;
    InsertOptions* options = options_of(patient);
    if (!options || options->snap != 0) throw;
    constexpr double kReach = 4;
    for (const double factor : {1.0, 1.5, 2.2, 3.2}) {
      options->snap_factor = factor;
      options->reach_factor = kReach;
      model.roll_back();
      model.begin();
      try {
        return run_tool(model, patient);
      } catch (const RefusedEdit&) {
      }
    }
    throw;
  }
}

bool sets_the_same(const SketchEdit& first, const SketchEdit& second) {
  const auto *a = std::get_if<SharpnessEdit>(&first), *b = std::get_if<SharpnessEdit>(&second);
  if (a && b) return a->curve == b->curve && a->between == b->between;
  return std::holds_alternative<TransformEdit>(first) && std::holds_alternative<TransformEdit>(second);
}

}  // namespace batten
