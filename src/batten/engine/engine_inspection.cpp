#include <algorithm>

#include "batten/core/choices.hpp"
#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/engine/engine_state_detail.hpp"
#include "batten/engine/inspection_detail.hpp"
#include "batten/engine/shown_object_detail.hpp"
#include "batten/engine/tried_edit_detail.hpp"
#include "batten/render/render.hpp"
#include "batten/session/edit_json.hpp"

namespace batten {

using detail::Draft;
using detail::field;
using detail::Json;
using detail::json_of;
using detail::number_of;
using detail::point_of;
using detail::text_of;

namespace {

// An angle where a message does not give it; that of `batten render`.
constexpr double kContinuityTolerance = radians(0.5);
// Crosses of principal directions where a message does not say: as many as can be told apart.
constexpr double kMostDirections = 4000;

}  // namespace

TriangleMesh Engine::State::with_uncertainty(ObjectId id, const Progress& progress) {
  const Derived* surface = document.object(id).derived();
  const Derived* network = surface == nullptr ? nullptr : document.object(surface->source).derived();
  const auto* asked = surface == nullptr ? nullptr : std::get_if<SurfaceRequest>(surface->request.get());
  const auto* scanned = network == nullptr ? nullptr : std::get_if<NetworkRequest>(network->request.get());
  if (asked == nullptr || scanned == nullptr)
    throw InvalidInput(concat("how sure '", document.object(id).name,
                              "' is cannot be told: only surfaces made of a scan carry it"));
  ScanOptions options = scanned->options;
  options.uncertainty = true;
  if (options.weights != WeightChoice::Auto)
    throw InvalidInput(
        "how sure a surface is follows from automatic weights alone; set weights to automatic");
  const ScanNetwork made =
      network_from_scan(*std::get<SharedScan>(content(network->source, progress)), options, progress);
  NetworkSurface known = uncertain_surface(made.network, *made.uncertainty, asked->surface, progress);
  if (known.mesh.n_vertices() != mesh(id, progress)->n_vertices())
    throw InvalidInput(
        "the curves of this surface were mended, which leaves their uncertainty without places");
  return std::move(known.mesh);
}

void Engine::State::values(Draft& draft, const Json& message, const Progress& progress) {
  const ObjectId id = object_of(message);
  const SharedMesh surface = mesh(id, progress);
  const std::string shading = text_of(message, "shading");
  if (shading == word_of(Shading::Uncertainty) && !surface->vertex_values.contains("uncertainty")) {
    const TriangleMesh known = with_uncertainty(id, progress);
    detail::add_values(draft, known, shading);
    return;
  }
  detail::add_values(draft, *surface, shading);
}

void Engine::State::continuity(Draft& draft, const Json& message, const Progress& progress) {
  const ObjectId id = object_of(message);
  const SharedMesh surface = mesh(id, progress);
  const double tolerance = number_of(message, "tolerance", kContinuityTolerance);
  const std::shared_ptr<const CurveNetwork> curves = curves_of(message, progress);
  detail::add_continuity(draft, *surface, *curves, tolerance, origin_of(id, progress), progress);
}

void Engine::State::distances(Draft& draft, const Json& message, const Progress& progress) {
  detail::add_distances(draft, *mesh(object_of(message), progress),
                        *mesh(object_of(message, "truth"), progress), progress);
}

void Engine::State::combs(Draft& draft, const Json& message, const Progress& progress) {
  const Eigen::RowVector3d origin = origin_of(object_of(message), progress);
  draft.json["origin"] = json_of(origin);
  detail::add_combs(draft, *curves_of(message, progress), origin);
}

void Engine::State::directions(Draft& draft, const Json& message, const Progress& progress) {
  const ObjectId id = object_of(message);
  const Eigen::RowVector3d origin = origin_of(id, progress);
  draft.json["origin"] = json_of(origin);
  const double most = number_of(message, "most", kMostDirections);
  detail::add_directions(draft, *mesh(id, progress), static_cast<Eigen::Index>(std::clamp(most, 0.0, 1e9)),
                         origin);
}

void Engine::State::section(Draft& draft, const Json& message, const Progress& progress) {
  const ObjectId id = object_of(message);
  const Eigen::RowVector3d origin = origin_of(id, progress);
  draft.json["origin"] = json_of(origin);
  CurveNetwork cut = detail::add_section(draft, *mesh(id, progress), point_of(message, "normal"),
                                         number_of(message, "offset", 0), origin);
  if (!message.contains("name")) return;
  if (cut.curves.empty()) throw InvalidInput("the plane does not cut the mesh; move it");
  const AddEdit add{{},
                    free_name(text_of(message, "name")),
                    document.unit(id),
                    std::make_shared<const CurveNetwork>(std::move(cut))};
  draft.json["edit"] = Json::parse(format_edit(add));
}

void Engine::State::grab(Draft& draft, const Json& message, const Progress& progress) {
  const auto energy = message.contains("energy") ? parse_choice<DeformationEnergy>(text_of(message, "energy"))
                                                 : DeformOptions{}.energy;
  held.grab(mesh(object_of(message), progress), point_of(message, "at"), number_of(message, "radius", 0),
            number_of(message, "reach", 0), energy, progress);
  held.add_grabbed(draft);
}

void Engine::State::pull(Draft& draft, const Json& message, const Progress& progress) {
  HandleMotion motion;
  motion.translation = point_of(message, "translation", motion.translation);
  motion.axis = point_of(message, "axis", motion.axis);
  motion.angle = number_of(message, "angle", 0);
  motion.about = point_of(message, "about", motion.about);
  held.pull(draft, motion, progress);
}

void Engine::State::try_edit(Draft& draft, const Json& message) const {
  const Edit edit = parse_edit(field(message, "edit").dump());
  const auto* drawn = std::get_if<ModelEdit>(&edit);
  if (drawn == nullptr) throw InvalidInput("only edits of models can be tried");
  detail::add_tried(draft, document.model(drawn->object), drawn->edit);
}

}  // namespace batten
