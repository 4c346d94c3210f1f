#include "batten/session/document.hpp"

#include <algorithm>
#include <atomic>
#include <set>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/session/document_plan_detail.hpp"

namespace batten {

EditOutcome Document::apply(const Edit& edit, const Confirm& confirm) {
  if (std::holds_alternative<UndoEdit>(edit)) return go_back(edit, confirm);
  if (std::holds_alternative<RedoEdit>(edit)) return go_on(edit, confirm);
  if (std::holds_alternative<CheckpointEdit>(edit)) {
    if (confirm) confirm(edit, LogPlace::Append);
    history_.clear();
    n_done_ = 0;
    for (auto model = models_.begin(); model != models_.end();)
      model = find(model->first) ? std::next(model) : models_.erase(model);
    edited_scans_.clear();
    log_.push_back(edit);
    return {};
  }
  return carry_out(edit, confirm);
}

EditOutcome Document::go_back(const Edit& edit, const Confirm& confirm) {
  if (!can_undo()) throw RefusedEdit("there is nothing to undo", "make an edit first");
  if (confirm) confirm(edit, LogPlace::Append);
  const Step& step = history_[--n_done_];
  put(step, false);
  log_.push_back(edit);
  return outcome_of(step);
}

EditOutcome Document::go_on(const Edit& edit, const Confirm& confirm) {
  if (!can_redo())
    throw RefusedEdit("there is nothing to redo", "undo an edit first; a new edit ends what could be redone");
  if (confirm) confirm(edit, LogPlace::Append);
  const Step& step = history_[n_done_++];
  put(step, true);
  log_.push_back(edit);
  return outcome_of(step);
}

/// What a drag that goes on has changed when this edit is done; nothing where the edit does not go on with
/// the last one.
std::optional<std::vector<std::string>> Document::options_of_drag(const Edit& edit) const {
  if (log_.empty() || n_done_ == 0 || can_redo() || !within_one_drag(log_.back(), edit)) return std::nullopt;
  std::vector<std::string> options = history_[n_done_ - 1].options;
  // A drag that has changed nothing so far may change anything.
  if (const auto* change = std::get_if<RequestEdit>(&edit); change && !options.empty())
    for (const std::string& option :
         changed_options(*object(change->object).derived()->request, change->request))
      if (std::find(options.begin(), options.end(), option) == options.end()) return std::nullopt;
  return options;
}

EditOutcome Document::carry_out(Edit edit, const Confirm& confirm) {
  auto options = options_of_drag(edit);
  if (!options) return do_edit(std::move(edit), confirm, LogPlace::Append, {});
  // The last edit makes room for this one, which starts where the drag began.
  Step last = std::move(history_.back());
  history_.pop_back();
  --n_done_;
  put(last, false);
  try {
    EditOutcome outcome = do_edit(std::move(edit), confirm, LogPlace::ReplaceLast, std::move(*options));
    outcome.merged = true;
    return outcome;
  } catch (...) {
    put(last, true);
    history_.push_back(std::move(last));
    ++n_done_;
    throw;
  }
}

EditOutcome Document::do_edit(Edit edit, const Confirm& confirm, LogPlace place,
                              std::vector<std::string> options) {
  detail::Plan plan = detail::DocumentPlanner(*this).plan(edit);
  Step step;
  step.object = plan.object;
  step.options = options.empty() ? std::move(plan.options) : std::move(options);
  step.next_before = next_;
  step.next_after = std::max(next_, plan.next);
  for (detail::PlannedObject& planned : plan.objects) {
    const auto slot = slots_.find(planned.id);
    const Slot before = slot == slots_.end() ? Slot() : slot->second;
    step.slots.push_back(
        {planned.id,
         before,
         {std::move(planned.object), planned.new_version ? ++last_version_ : before.version}});
  }
  if (const auto* drawn = std::get_if<ScanCurveEdit>(&edit)) {
    const auto index = static_cast<std::size_t>(drawn->curve);
    const ScanCurve& now = std::get<SharedScan>(*object(drawn->object).content())->curves[index];
    step.curve = {index, std::make_shared<const ScanCurve>(now), drawn->content};
    for (SlotChange& change : step.slots)
      if (change.id == step.object) change.before.object = change.after.object = nullptr;
  }
  EditReport report;
  std::vector<int> vertices;
  if (const auto* sketch = std::get_if<ModelEdit>(&edit)) {
    PolylineMesh& model = models_.at(step.object);
    const std::size_t n_vertices = model.vertices().size();
    model.begin();
    try {
      report = run_patiently(model, sketch->edit);
      if (confirm) confirm(edit, place);
    } catch (...) {
      model.roll_back();
      throw;
    }
    for (std::size_t v = n_vertices; v < model.vertices().size(); ++v)
      if (model.vertices()[v].alive) vertices.push_back(static_cast<int>(v));
    step.model = model.commit();
  } else {
    if (confirm) confirm(edit, place);
    if (plan.model) models_[step.object] = std::move(*plan.model);
  }
  set_slots(step, true);
  history_.resize(n_done_);
  history_.push_back(std::move(step));
  ++n_done_;
  if (place == LogPlace::ReplaceLast) log_.pop_back();
  log_.push_back(std::move(edit));
  EditOutcome outcome = outcome_of(history_.back());
  outcome.object = history_.back().object;
  outcome.report = std::move(report);
  outcome.vertices = std::move(vertices);
  return outcome;
}

void Document::set_slots(const Step& step, bool forwards) {
  for (const SlotChange& change : step.slots) {
    const Slot& slot = forwards ? change.after : change.before;
    if (step.curve && change.id == step.object)
      slots_.at(change.id).version = slot.version;
    else if (slot.object)
      slots_[change.id] = slot;
    else
      slots_.erase(change.id);
  }
  next_ = forwards ? step.next_after : step.next_before;
  if (step.curve)
    put_curve(step.object, step.curve->index, forwards ? *step.curve->after : *step.curve->before);
}

void Document::put_curve(ObjectId id, std::size_t index, const ScanCurve& curve) {
  Slot& slot = slots_.at(id);
  const SharedScan& held = std::get<SharedScan>(*slot.object->content());
  std::shared_ptr<Scan>& own = edited_scans_[id];
  // The scan is ours alone where the object is in its slot only, and the scan in that object and here.
  if (held != own || slot.object.use_count() > 1 || own.use_count() > 2) {
    own = std::make_shared<Scan>(*held);
    Object object{slot.object->name, slot.object->unit, Content(SharedScan(own))};
    slot.object = std::make_shared<const Object>(std::move(object));
  } else {
    // Who held it before has read it before.
    std::atomic_thread_fence(std::memory_order_acquire);
  }
  own->curves[index] = curve;
}

void Document::put(const Step& step, bool forwards) {
  set_slots(step, forwards);
  if (!step.model) return;
  PolylineMesh& model = models_.at(step.object);
  if (forwards)
    model.redo(*step.model);
  else
    model.undo(*step.model);
}

EditOutcome Document::outcome_of(const Step& step) const {
  EditOutcome outcome;
  for (const SlotChange& change : step.slots) {
    if (change.before.object != change.after.object || change.id == step.object)
      outcome.changed.push_back(change.id);
    const Object* object = find(change.id);
    if (object && object->derived() && change.before.version != change.after.version)
      outcome.outdated.push_back(change.id);
  }
  return outcome;
}

std::vector<ObjectId> Document::objects() const {
  std::vector<ObjectId> ids;
  ids.reserve(slots_.size());
  for (const auto& [id, slot] : slots_) ids.push_back(id);
  return ids;
}

const Object* Document::find(ObjectId id) const {
  const auto slot = slots_.find(id);
  return slot == slots_.end() ? nullptr : slot->second.object.get();
}

ObjectId Document::find(std::string_view name) const {
  for (const auto& [id, slot] : slots_)
    if (slot.object->name == name) return id;
  return {};
}

const Object& Document::object(ObjectId id) const {
  const Object* object = find(id);
  if (!object) throw InvalidInput(concat("there is no object o", id.number));
  return *object;
}

std::shared_ptr<const Object> Document::shared(ObjectId id) const {
  const auto slot = slots_.find(id);
  return slot == slots_.end() ? nullptr : slot->second.object;
}

const PolylineMesh& Document::model(ObjectId id) const {
  if (object(id).kind() != ObjectKind::Model) throw InvalidInput(concat("o", id.number, " is no model"));
  return models_.at(id);
}

const std::string& Document::unit(ObjectId id) const {
  const Object* object = &this->object(id);
  while (const Derived* derived = object->derived()) object = &this->object(derived->source);
  return object->unit;
}

std::uint64_t Document::version(ObjectId id) const {
  object(id);
  return slots_.at(id).version;
}

std::vector<ObjectId> Document::out_of_date(const std::map<ObjectId, std::uint64_t>& made) const {
  std::vector<ObjectId> ids;
  for (const auto& [id, slot] : slots_) {
    if (!slot.object->derived()) continue;
    const auto known = made.find(id);
    if (known == made.end() || known->second != slot.version) ids.push_back(id);
  }
  return ids;
}

std::vector<ObjectId> Document::derived_from(ObjectId id) const {
  std::set<ObjectId> reached{id};
  std::vector<ObjectId> ids;
  for (const auto& [other, slot] : slots_) {  // sources have lower numbers
    const Derived* derived = slot.object->derived();
    if (!derived || reached.count(derived->source) == 0) continue;
    reached.insert(other);
    ids.push_back(other);
  }
  return ids;
}

Document Document::restored(const std::map<ObjectId, Object>& objects,
                            const std::map<ObjectId, SharedModel>& models) {
  Document document;
  for (const auto& [id, object] : objects) {
    if (const Derived* derived = object.derived()) {
      document.apply(DeriveEdit{id, object.name, derived->source, *derived->request});
      continue;
    }
    const auto model = models.find(id);
    document.apply(AddEdit{id, object.name, object.unit,
                           model == models.end() ? *object.content() : Content(model->second)});
  }
  document.apply(CheckpointEdit{});
  return document;
}

bool Document::operator==(const Document& other) const {
  if (slots_.size() != other.slots_.size()) return false;
  for (auto a = slots_.begin(), b = other.slots_.begin(); a != slots_.end(); ++a, ++b) {
    if (a->first != b->first || !(*a->second.object == *b->second.object)) return false;
    if (a->second.object->kind() == ObjectKind::Model &&
        !(models_.at(a->first) == other.models_.at(b->first)))
      return false;
  }
  return true;
}

}  // namespace batten
