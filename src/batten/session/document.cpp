#include "batten/session/document.hpp"

#include <algorithm>
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

EditReport run_tool(PolylineMesh& mesh, const Edit& edit) {
  EditReport report = std::visit(
      Overloaded{
          [&](const InsertEdit& e) { return insert_curve(mesh, e.stroke, e.options); },
          [&](const DeleteEdit& e) { return delete_curve(mesh, e.curve); },
          [&](const SharpnessEdit& e) { return set_curve_sharpness(mesh, e.curve, e.value, e.between); },
          [&](const MirrorEdit& e) {
            return e.curve >= 0 ? mirror_curve(mesh, e.curve, e.axis, e.options)
                                : mirror_stroke(mesh, e.stroke, e.axis, e.options);
          },
          [&](const HoleEdit& e) { return cut_hole(mesh, e.stroke, e.options); },
          [&](const GlueEdit& e) { return glue_borders(mesh, e.first, e.second, e.halves, e.options); },
          [&](const SkinEdit& e) { return skin_profiles(mesh, e.profiles, e.spines, e.options); },
          [&](const AlignEdit& e) { return align_model(mesh, e.reference, e.stroke); },
          [&](const TransformEdit& e) { return transform_model(mesh, e.matrix); },
          [&](const UndoEdit&) -> EditReport { throw std::logic_error("undo is no tool"); },
          [&](const RedoEdit&) -> EditReport { throw std::logic_error("redo is no tool"); },
      },
      edit);
  if (const std::string problem = mesh.broken_by_edit(); !problem.empty()) throw std::logic_error(problem);
  return report;
}

EditOutcome Document::apply(const Edit& edit, const Confirm& confirm) {
  EditOutcome outcome;
  if (std::holds_alternative<UndoEdit>(edit)) {
    if (!can_undo()) throw RefusedEdit("there is nothing to undo", "make an edit first");
    if (confirm) confirm(edit);
    mesh_.undo(history_[--n_done_]);
  } else if (std::holds_alternative<RedoEdit>(edit)) {
    if (!can_redo())
      throw RefusedEdit("there is nothing to redo",
                        "undo an edit first; a new edit ends what could be redone");
    if (confirm) confirm(edit);
    mesh_.redo(history_[n_done_++]);
  } else {
    const size_t n_vertices = mesh_.vertices().size();
    mesh_.begin();
    try {
      outcome.report = run_tool(mesh_, edit);
      if (confirm) confirm(edit);
    } catch (...) {
      mesh_.roll_back();
      throw;
    }
    for (size_t v = n_vertices; v < mesh_.vertices().size(); ++v)
      if (mesh_.vertices()[v].alive) outcome.vertices.push_back(static_cast<int>(v));
    history_.resize(n_done_);
    history_.push_back(mesh_.commit());
    ++n_done_;
  }
  log_.push_back(edit);
  return outcome;
}

SurfaceUpdate Document::update_surface(const DiffusionOptions& options, const Progress& progress) {
  if (!kept_.surface || kept_.options != options) {
    kept_.surface = std::make_unique<EditedSurface>(options);
    kept_.options = options;
  }
  return kept_.surface->update(mesh_, progress);
}

DiffusionSurface Document::surface(const DiffusionOptions& options, const Progress& progress) {
  update_surface(options, progress);
  return kept_.surface->surface(mesh_);
}

Document Document::restored(PolylineMesh mesh, std::vector<Edit> log) {
  Document document;
  document.mesh_ = std::move(mesh);
  document.log_ = std::move(log);
  return document;
}

}  // namespace batten
