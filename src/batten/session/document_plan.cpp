#include <limits>
#include <stdexcept>

#include "batten/core/text.hpp"
#include "batten/session/document_plan_detail.hpp"
#include "batten/session/json_detail.hpp"

namespace batten::detail {

namespace {

std::string label(ObjectId id, const Object& object) {
  return concat("o", id.number, " '", object.name, "'");
}

void check_unit(const std::string& unit) {
  if (!is_utf8(unit)) throw RefusedEdit("the unit is not UTF-8", "give a text such as \"mm\"");
}

void check_content(const Content& content) {
  if (const auto found = problem(content)) throw RefusedEdit(*found, "give content that holds together");
}

}  // namespace

Plan DocumentPlanner::plan(Edit& edit) const {
  return std::visit(
      [this](auto& e) -> Plan {
        if constexpr (requires { this->plan_of(e); })
          return plan_of(e);
        else
          throw std::logic_error("undo, redo and checkpoints have no plan");
      },
      edit);
}

const Object& DocumentPlanner::require(ObjectId id) const {
  const Object* object = document_.find(id);
  if (!object)
    throw RefusedEdit(concat("there is no object o", id.number), "name one of the objects that there are");
  return *object;
}

ObjectId DocumentPlanner::number_for(ObjectId wanted) const {
  if (wanted.number == 0) return {document_.next_number()};
  if (wanted.number < document_.next_number())
    throw RefusedEdit(concat("the number o", wanted.number, " is given already"),
                      concat("take o", document_.next_number(), " or a higher one"));
  if (wanted.number == std::numeric_limits<int>::max())
    throw RefusedEdit("the number of the object is too large", "take a lower one");
  return wanted;
}

void DocumentPlanner::check_name(const std::string& name) const {
  if (name.empty()) throw RefusedEdit("an object needs a name", "give a text that is not empty");
  if (!is_utf8(name)) throw RefusedEdit("the name is not UTF-8", "give a text in UTF-8");
  if (const ObjectId other = document_.find(name); other.number != 0)
    throw RefusedEdit(concat("o", other.number, " has the name '", name, "' already"), "give another name");
}

void DocumentPlanner::check_request(const Object& source, const Request& request) const {
  const RequestKind kind = kind_of(request);
  if (source_kind(kind) != source.kind())
    throw RefusedEdit(concat("the request ", word_of(kind), " starts from a ", word_of(source_kind(kind)),
                             ", and '", source.name, "' is a ", word_of(source.kind())),
                      concat("name a ", word_of(source_kind(kind))));
  if (const auto found = problem(request)) throw RefusedEdit(*found, "change that option");
}

Plan DocumentPlanner::added(ObjectId id, Object object) const {
  Plan plan;
  plan.object = id;
  plan.next = id.number + 1;
  plan.objects.push_back({id, std::make_shared<const Object>(std::move(object)), true});
  return plan;
}

Plan DocumentPlanner::changed(ObjectId id, std::shared_ptr<const Object> object) const {
  Plan plan;
  plan.object = id;
  plan.objects.push_back({id, std::move(object), true});
  for (const ObjectId other : document_.derived_from(id))
    plan.objects.push_back({other, document_.shared(other), true});
  return plan;
}

Plan DocumentPlanner::changed(ObjectId id, Object object) const {
  return changed(id, std::make_shared<const Object>(std::move(object)));
}

Plan DocumentPlanner::plan_of(AddEdit& edit) const {
  check_name(edit.name);
  check_unit(edit.unit);
  edit.object = number_for(edit.object);
  const auto* model = std::get_if<SharedModel>(&edit.content);
  if (!model) {
    check_content(edit.content);
    return added(edit.object, {edit.name, edit.unit, edit.content});
  }
  Plan plan = added(edit.object, {edit.name, edit.unit, Content(SharedModel())});
  plan.model = *model ? **model : PolylineMesh();
  return plan;
}

Plan DocumentPlanner::plan_of(DeriveEdit& edit) const {
  check_name(edit.name);
  edit.object = number_for(edit.object);
  check_request(require(edit.source), edit.request);
  return added(edit.object,
               {edit.name, "", Derived{edit.source, std::make_shared<const Request>(edit.request)}});
}

Plan DocumentPlanner::plan_of(const RemoveEdit& edit) const {
  const Object& object = require(edit.object);
  const std::vector<ObjectId> derived = document_.derived_from(edit.object);
  if (!derived.empty() && !edit.with_derived)
    throw RefusedEdit(
        concat(label(derived[0], document_.object(derived[0])), " is made of ", label(edit.object, object)),
        "remove that first, or both at once");
  Plan plan;
  plan.object = edit.object;
  plan.objects.push_back({edit.object, nullptr, true});
  for (const ObjectId other : derived) plan.objects.push_back({other, nullptr, true});
  return plan;
}

Plan DocumentPlanner::plan_of(const RenameEdit& edit) const {
  Object object = require(edit.object);
  if (object.name != edit.name) check_name(edit.name);
  object.name = edit.name;
  Plan plan;
  plan.object = edit.object;
  plan.objects.push_back({edit.object, std::make_shared<const Object>(std::move(object)), false});
  return plan;
}

Plan DocumentPlanner::plan_of(const UnitEdit& edit) const {
  Object object = require(edit.object);
  check_unit(edit.unit);
  if (const Derived* derived = object.derived())
    throw RefusedEdit(
        concat("the lengths of ", label(edit.object, object), " are those of what it is made of"),
        concat("set the unit of o", derived->source.number));
  object.unit = edit.unit;
  return changed(edit.object, std::move(object));
}

Plan DocumentPlanner::plan_of(const ReplaceEdit& edit) const {
  Object object = require(edit.object);
  if (kind_of(edit.content) != object.kind())
    throw RefusedEdit(concat(label(edit.object, object), " is a ", word_of(object.kind()),
                             ", the new content a ", word_of(kind_of(edit.content))),
                      "add another object instead");
  if (object.kind() == ObjectKind::Model)
    throw RefusedEdit("a model is not replaced", "use its tools, or add another model");
  check_content(edit.content);
  object.unit = document_.unit(edit.object);
  object.body = edit.content;
  return changed(edit.object, std::move(object));
}

Plan DocumentPlanner::plan_of(const ScanCurveEdit& edit) const {
  const Object& object = require(edit.object);
  if (object.kind() != ObjectKind::Scan)
    throw RefusedEdit(concat(label(edit.object, object), " is no scan"), "name a scan");
  const std::vector<ScanCurve>& curves = std::get<SharedScan>(*object.content())->curves;
  if (edit.curve < 0 || static_cast<std::size_t>(edit.curve) >= curves.size())
    throw RefusedEdit(concat("there is no curve ", edit.curve, " in ", label(edit.object, object)),
                      concat("give an index below ", curves.size()));
  if (!edit.content) throw RefusedEdit("there is no curve", "give one");
  if (const auto found = problem(*edit.content, static_cast<std::size_t>(edit.curve)))
    throw RefusedEdit(*found, "give a curve that holds together");
  return changed(edit.object, document_.shared(edit.object));
}

Plan DocumentPlanner::plan_of(RequestEdit& edit) const {
  Object object = require(edit.object);
  const Derived* before = object.derived();
  if (!before)
    throw RefusedEdit(concat(label(edit.object, object), " is given and made of nothing"),
                      "add an object that is made of it");
  check_request(document_.object(before->source), edit.request);
  if (result_kind(kind_of(edit.request)) != object.kind())
    throw RefusedEdit(
        concat("the request ", word_of(kind_of(edit.request)), " gives no ", word_of(object.kind())),
        "add another object instead");
  share_lists(edit.request, *before->request);  // in the log too
  std::vector<std::string> options = changed_options(*before->request, edit.request);
  object.body = Derived{before->source, std::make_shared<const Request>(edit.request)};
  Plan plan = changed(edit.object, std::move(object));
  plan.options = std::move(options);
  return plan;
}

Plan DocumentPlanner::plan_of(const ViewEdit& edit) const {
  Object object = require(edit.object);
  if (object.kind() != ObjectKind::View)
    throw RefusedEdit(concat(label(edit.object, object), " is no view"), "name a view");
  const Content content = edit.view;
  check_content(content);
  object.body = content;
  return changed(edit.object, std::move(object));
}

Plan DocumentPlanner::plan_of(const ModelEdit& edit) const {
  const Object& object = require(edit.object);
  if (object.kind() != ObjectKind::Model)
    throw RefusedEdit(concat(label(edit.object, object), " is no model"),
                      "name a model, or add one to draw in");
  return changed(edit.object, document_.shared(edit.object));
}

}  // namespace batten::detail
