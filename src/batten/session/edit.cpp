#include "batten/session/edit.hpp"

namespace batten {

namespace {

/// Both edits of one kind with a drag, of one object.
template <typename E>
bool go_together(const E* a, const E* b) {
  return a && b && a->drag != 0 && a->drag == b->drag && a->object == b->object;
}

}  // namespace

std::string name_of_op(const Edit& edit) {
  constexpr const char* kTools[] = {"insert", "delete", "sharpness", "mirror",   "hole",
                                    "glue",   "skin",   "align",     "transform"};
  constexpr const char* kNames[] = {"add",     "derive", "remove", "rename", "unit", "replace",   "curve",
                                    "request", "view",   "",       "undo",   "redo", "checkpoint"};
  if (const auto* model = std::get_if<ModelEdit>(&edit)) return kTools[model->edit.index()];
  return kNames[edit.index()];
}

bool within_one_drag(const Edit& first, const Edit& second) {
  const auto *a = std::get_if<ModelEdit>(&first), *b = std::get_if<ModelEdit>(&second);
  if (a && b) return go_together(a, b) && sets_the_same(a->edit, b->edit);
  const auto *c = std::get_if<RequestEdit>(&first), *d = std::get_if<RequestEdit>(&second);
  if (c && d) return go_together(c, d) && c->request.index() == d->request.index();
  const auto *e = std::get_if<ScanCurveEdit>(&first), *f = std::get_if<ScanCurveEdit>(&second);
  if (e && f) return go_together(e, f) && e->curve == f->curve;
  return go_together(std::get_if<ViewEdit>(&first), std::get_if<ViewEdit>(&second));
}

}  // namespace batten
