#include "batten/engine/engine.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <new>
#include <stdexcept>
#include <utility>
#include <vector>

#include "batten/core/choices.hpp"
#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/engine/engine_state_detail.hpp"
#include "batten/engine/opened_file.hpp"
#include "batten/engine/saved_file.hpp"
#include "batten/engine/shown_object_detail.hpp"
#include "batten/render/colour.hpp"
#include "batten/session/edit_json.hpp"
#include "batten/session/journal.hpp"
#include "batten/session/playing.hpp"
#include "batten/session/project.hpp"
#include "batten/sketch/stroke.hpp"

namespace batten {

using detail::Draft;
using detail::field;
using detail::flag_of;
using detail::Json;
using detail::json_of;
using detail::number_of;
using detail::text_of;

namespace {

// An edge length where a message does not give it: that of a preview.
constexpr double kLiveEdgeLength = 0.02;

std::string id_text(ObjectId id) {
  return concat("o", id.number);
}

Json ids_of(const std::vector<ObjectId>& ids) {
  Json list = Json::array();
  for (const ObjectId id : ids) list.push_back(id_text(id));
  return list;
}

/// Whether what a request makes is a surface of patches, which programs for CAD take.
bool is_surface(const Request& request) {
  return std::holds_alternative<SurfaceRequest>(request) ||
         std::holds_alternative<ModelSurfaceRequest>(request);
}

Json failure(const char* kind, const std::string& message) {
  return {{"ok", false}, {"kind", kind}, {"message", message}};
}

}  // namespace

ObjectId Engine::State::object_of(const Json& message, const char* name) const {
  const std::string text = text_of(message, name);
  long number = 0;
  if (text.size() < 2 || text[0] != 'o' || !parse_integer(std::string_view(text).substr(1), number))
    throw InvalidInput(concat("'", name, "' must be the id of an object, such as \"o3\", got '", text, "'"));
  const ObjectId id{static_cast<int>(number)};
  if (document.find(id) == nullptr) throw InvalidInput(concat("there is no object '", text, "'"));
  return id;
}

SharedMesh Engine::State::mesh(ObjectId id, const Progress& progress) {
  if (document.object(id).kind() != ObjectKind::Mesh)
    throw InvalidInput(concat("'", document.object(id).name, "' is a ", word_of(document.object(id).kind()),
                              "; this needs a mesh"));
  return std::get<SharedMesh>(content(id, progress));
}

std::shared_ptr<const CurveNetwork> Engine::State::curves_of(const Json& message, const Progress& progress) {
  const ObjectId id = object_of(message, message.contains("curves") ? "curves" : "object");
  const Object& object = document.object(id);
  if (object.kind() == ObjectKind::Network) return std::get<SharedNetwork>(content(id, progress));
  if (object.kind() == ObjectKind::Model)
    return std::make_shared<CurveNetwork>(detail::curves_of(document.model(id)));
  if (const Derived* derived = object.derived()) {
    if (document.object(derived->source).kind() == ObjectKind::Model)
      return std::make_shared<CurveNetwork>(detail::curves_of(document.model(derived->source)));
    const std::shared_ptr<const RequestResult> result = results.get(document, id, progress);
    if (const auto* made = std::get_if<CurvesSurface>(result.get())) return {result, &made->network};
  }
  throw InvalidInput(
      concat("'", object.name, "' was not made of curves; name the network of its curves as 'curves'"));
}

Eigen::RowVector3d Engine::State::origin_of(ObjectId id, const Progress& progress) {
  const Object& object = document.object(id);
  if (object.kind() == ObjectKind::Model)
    return detail::middle_of(detail::curves_of(document.model(id)).positions);
  if (const Derived* derived = object.derived()) {
    if (document.object(derived->source).kind() == ObjectKind::Model)
      return origin_of(derived->source, progress);
    const std::shared_ptr<const RequestResult> result = results.get(document, id, progress);
    if (const auto* made = std::get_if<CurvesSurface>(result.get()))
      return detail::middle_of(made->network.positions);
  }
  const Content shown = content(id, progress);
  if (const auto* network = std::get_if<SharedNetwork>(&shown))
    return detail::middle_of((*network)->positions);
  if (const auto* mesh = std::get_if<SharedMesh>(&shown)) return detail::middle_of((*mesh)->positions);
  return Eigen::RowVector3d::Zero();
}

void Engine::State::apply(Draft& draft, const Edit& edit) {
  const EditOutcome outcome = document.apply(edit);
  draft.json["object"] = outcome.object.number == 0 ? Json() : Json(id_text(outcome.object));
  draft.json["changed"] = ids_of(outcome.changed);
  draft.json["outdated"] = ids_of(outcome.outdated);
}

void Engine::State::replace(Draft& draft, Document other, Json warnings) {
  document = std::move(other);
  results = {};
  live = {};
  held = {};
  draft.json["warnings"] = std::move(warnings);
  draft.json["replaced"] = true;
}

std::string Engine::State::free_name(const std::string& wanted) const {
  std::string name = wanted;
  for (int k = 2; document.find(name).number != 0; ++k) name = concat(wanted, " ", k);
  return name;
}

/// A recorded session as the project that it makes; edits that are refused are warnings, as in `batten
/// sketch`.
void Engine::State::play(Draft& draft, const std::string& name, std::string_view bytes,
                         const Progress& progress) {
  const Session session = parse_session(std::string(bytes), name);
  Document played;
  Json warnings = Json::array();
  for (const PlayedEdit& edit : play_session(session, played, progress))
    if (!edit.done)
      warnings.push_back(
          concat("line ", session.edits[edit.index].line, " refused: ", edit.reason, "; ", edit.remedy));
  if (session.torn) warnings.push_back(session.warning(name));
  replace(draft, std::move(played), std::move(warnings));
}

void Engine::State::open(Draft& draft, const Json& message, std::string_view bytes,
                         const Progress& progress) {
  const std::string name = text_of(message, "name");
  if (bytes.substr(0, 2) == "PK" && name.ends_with(".batten")) {
    ProjectFile file = parse_project(std::string(bytes), name);
    return replace(draft, std::move(file.document), file.warnings);
  }
  if (name.ends_with(".jsonl")) return play(draft, name, bytes, progress);
  OpenedFile file = open_file(std::string(bytes), name);
  draft.json["warnings"] = file.warnings;
  apply(draft, AddEdit{{}, free_name(file.name), file.unit, std::move(file.content)});
}

void Engine::State::edit(Draft& draft, const Json& message) {
  Edit edit = parse_edit(field(message, "edit").dump());
  const int drag = static_cast<int>(number_of(message, "drag", 0));
  std::visit(
      [drag](auto& one) {
        if constexpr (requires { one.drag; }) one.drag = drag;
      },
      edit);
  if (auto* derive = std::get_if<DeriveEdit>(&edit)) derive->name = free_name(derive->name);
  apply(draft, edit);
}

void Engine::State::describe(Draft& draft) const {
  Json list = Json::array();
  const std::vector<ObjectId> outdated = document.out_of_date(results.versions());
  for (const ObjectId id : document.objects()) {
    const Object& object = document.object(id);
    Json entry = {{"id", id_text(id)},
                  {"name", object.name},
                  {"kind", word_of(object.kind())},
                  {"unit", document.unit(id)},
                  {"version", document.version(id)},
                  {"formats", formats_of(object.kind())}};
    if (const Derived* derived = object.derived()) {
      if (format_step && is_surface(*derived->request)) entry["formats"].push_back("step");
      entry["source"] = id_text(derived->source);
      // The line of a journal is where the options of a request have their names.
      entry["request"] = Json::parse(format_edit(RequestEdit{id, *derived->request, 0}))["request"];
    }
    list.push_back(std::move(entry));
  }
  draft.json["objects"] = std::move(list);
  draft.json["outdated"] = ids_of(outdated);
  draft.json["can_undo"] = document.can_undo();
  draft.json["can_redo"] = document.can_redo();
  Json log = Json::array();
  for (const Edit& edit : document.log()) log.push_back(name_of_op(edit));
  draft.json["log"] = std::move(log);
}

void Engine::State::show(Draft& draft, const Json& message, const Progress& progress) {
  const ObjectId id = object_of(message);
  const Object& object = document.object(id);
  draft.json["kind"] = word_of(object.kind());
  draft.json["unit"] = document.unit(id);
  draft.json["version"] = document.version(id);
  if (object.kind() == ObjectKind::Model && object.derived() == nullptr) {
    detail::draw_model(draft, document.model(id));
    return;
  }
  if (object.derived() == nullptr) {
    detail::draw(draft, *object.content());
    return;
  }
  const std::shared_ptr<const RequestResult> result = results.get(document, id, progress);
  draft.json["warnings"] = warnings_of(*result);
  if (const auto* made = std::get_if<CurvesSurface>(result.get())) {
    const Eigen::RowVector3d origin = detail::middle_of(made->network.positions);
    draft.json["origin"] = json_of(origin);
    detail::draw_mesh(draft, made->surface.mesh, origin);
    detail::draw_network(draft, made->network, origin);
    draft.json["flaws"] = made->surface.flaws;
    draft.json["n_patches"] = made->surface.n_cycles;
  } else if (const auto* modelled = std::get_if<ModelSurface>(result.get())) {
    const Eigen::RowVector3d origin = detail::draw_model(draft, document.model(object.derived()->source));
    detail::draw_mesh(draft, modelled->mesh, origin);
    if (modelled->soundness && !modelled->soundness->is_sound())
      draft.json["flaws"] = {modelled->soundness->sentence()};
  } else {
    detail::draw(draft, content_of(result));
  }
  detail::add_report(draft, *result);
}

void Engine::State::follow(Draft& draft, const Json& message, const Progress& progress) {
  const ObjectId id = object_of(message);
  const Derived* surface = document.object(id).derived();
  const Derived* network = surface == nullptr ? nullptr : document.object(surface->source).derived();
  const auto* surface_request =
      surface == nullptr ? nullptr : std::get_if<SurfaceRequest>(surface->request.get());
  const auto* network_request =
      network == nullptr ? nullptr : std::get_if<NetworkRequest>(network->request.get());
  if (surface_request == nullptr || network_request == nullptr)
    throw InvalidInput(
        concat("'", document.object(id).name, "' is no surface of a scan; 'follow' shows those alone"));
  const Content scan = content(network->source, progress);
  const auto fineness = flag_of(message, "fine") ? detail::LiveDetail::Fine : detail::LiveDetail::Coarse;
  const detail::LiveSurface::Shown shown =
      live.show(std::get<SharedScan>(scan), network_request->options, surface_request->surface, fineness,
                number_of(message, "edge_length", kLiveEdgeLength), flag_of(message, "moving"), progress);
  const Eigen::RowVector3d origin = detail::middle_of(shown.network->positions);
  draft.json["origin"] = json_of(origin);
  draft.json["rebuilt"] = shown.rebuilt;
  draft.json["lambda"] = json_of(shown.report->lambda);
  draft.json["mu"] = json_of(shown.report->mu);
  draft.json["misfit"] = json_of(shown.report->closure_misfit);
  draft.json["n_triangles"] = shown.surface->mesh.n_triangles();
  draft.add_points("positions", shown.surface->mesh.positions, origin);
  draft.add_points("normals", shown.surface->mesh.normals, Eigen::RowVector3d::Zero());
  if (shown.rebuilt || flag_of(message, "triangles"))
    draft.add_triangles("triangles", shown.surface->mesh.triangles);
  detail::draw_network(draft, *shown.network, origin);
}

void Engine::State::save(Draft& draft, const Json& message, const Progress& progress) {
  if (!message.contains("object")) {
    draft.add_bytes("file", format_project(document));
    return;
  }
  const ObjectId id = object_of(message);
  const Derived* derived = document.object(id).derived();
  if (format_step && derived != nullptr && is_surface(*derived->request) &&
      text_of(message, "format") == "step") {
    draft.json["warnings"] = Json::array();
    draft.add_bytes("file", format_step(*results.get(document, id, progress), document.unit(id), progress));
    return;
  }
  const SavedFile file = save_file(content(id, progress), text_of(message, "format"), document.unit(id));
  draft.json["warnings"] = file.warnings;
  draft.add_bytes("file", file.bytes);
}

void Engine::State::colours(Draft& draft) const {
  constexpr int kSteps = 256;
  Points sequential(kSteps, 3), diverging(kSteps, 3);
  for (int i = 0; i < kSteps; ++i) {
    const double t = static_cast<double>(i) / (kSteps - 1);
    sequential.row(i) = sequential_colour(t).cast<double>().transpose();
    diverging.row(i) = diverging_colour(t).cast<double>().transpose();
  }
  draft.add_points("sequential", sequential, Eigen::RowVector3d::Zero());
  draft.add_points("diverging", diverging, Eigen::RowVector3d::Zero());
}

void Engine::State::length(Draft& draft, const Json& message) const {
  const Length length = parse_length(text_of(message, "text"));
  draft.json["value"] = json_of(length.value);
  draft.json["length_kind"] = word_of(length.kind);
}

void Engine::State::carry_out(Draft& draft, std::string_view text, std::string_view bytes,
                              const Progress& progress) {
  const Json message = Json::parse(text, nullptr, false);
  if (!message.is_object()) throw InvalidInput("the message is no JSON object");
  const std::string op = text_of(message, "op");
  using Handler = void (*)(State&, Draft&, const Json&, std::string_view, const Progress&);
  static const std::map<std::string, Handler> handlers = {
      {"open",
       [](State& s, Draft& d, const Json& m, std::string_view b, const Progress& p) { s.open(d, m, b, p); }},
      {"edit", [](State& s, Draft& d, const Json& m, std::string_view, const Progress&) { s.edit(d, m); }},
      {"document", [](State& s, Draft& d, const Json&, std::string_view, const Progress&) { s.describe(d); }},
      {"show",
       [](State& s, Draft& d, const Json& m, std::string_view, const Progress& p) { s.show(d, m, p); }},
      {"follow",
       [](State& s, Draft& d, const Json& m, std::string_view, const Progress& p) { s.follow(d, m, p); }},
      {"values",
       [](State& s, Draft& d, const Json& m, std::string_view, const Progress& p) { s.values(d, m, p); }},
      {"continuity",
       [](State& s, Draft& d, const Json& m, std::string_view, const Progress& p) { s.continuity(d, m, p); }},
      {"distances",
       [](State& s, Draft& d, const Json& m, std::string_view, const Progress& p) { s.distances(d, m, p); }},
      {"combs",
       [](State& s, Draft& d, const Json& m, std::string_view, const Progress& p) { s.combs(d, m, p); }},
      {"directions",
       [](State& s, Draft& d, const Json& m, std::string_view, const Progress& p) { s.directions(d, m, p); }},
      {"section",
       [](State& s, Draft& d, const Json& m, std::string_view, const Progress& p) { s.section(d, m, p); }},
      {"grab",
       [](State& s, Draft& d, const Json& m, std::string_view, const Progress& p) { s.grab(d, m, p); }},
      {"pull",
       [](State& s, Draft& d, const Json& m, std::string_view, const Progress& p) { s.pull(d, m, p); }},
      {"try", [](State& s, Draft& d, const Json& m, std::string_view, const Progress&) { s.try_edit(d, m); }},
      {"save",
       [](State& s, Draft& d, const Json& m, std::string_view, const Progress& p) { s.save(d, m, p); }},
      {"colours", [](State& s, Draft& d, const Json&, std::string_view, const Progress&) { s.colours(d); }},
      {"length",
       [](State& s, Draft& d, const Json& m, std::string_view, const Progress&) { s.length(d, m); }},
  };
  const auto handler = handlers.find(op);
  if (handler == handlers.end()) {
    std::string known;
    for (const auto& [name, unused] : handlers) known += (known.empty() ? "" : ", ") + name;
    throw InvalidInput(concat("unknown op '", op, "'; known are ", known));
  }
  handler->second(*this, draft, message, bytes, progress);
}

Engine::Engine(FormatStep format_step) : state_(std::make_unique<State>()) {
  state_->format_step = std::move(format_step);
}
Engine::~Engine() = default;
Engine::Engine(Engine&&) noexcept = default;
Engine& Engine::operator=(Engine&&) noexcept = default;

Reply Engine::handle(std::string_view message, std::string_view bytes, const Progress& progress) {
  Draft draft;
  try {
    draft.json["ok"] = true;
    state_->carry_out(draft, message, bytes, progress);
  } catch (const RefusedEdit& error) {
    draft = {};
    draft.json = failure("refused", error.reason());
    draft.json["remedy"] = error.remedy();
  } catch (const Cancelled& error) {
    draft = {};
    draft.json = failure("cancelled", error.what());
  } catch (const Error& error) {
    draft = {};
    draft.json = failure("error", error.what());
  } catch (const std::bad_alloc&) {
    draft = {};
    draft.json = failure("memory",
                         "there is not enough memory for this; take a larger edge length or a smaller model");
  } catch (const std::exception& error) {
    draft = {};
    draft.json = failure("fault", concat("a fault of the program: ", error.what()));
  }
  return {draft.json.dump(-1, ' ', false, Json::error_handler_t::replace), std::move(draft.arrays)};
}

}  // namespace batten
