#include "batten/session/object.hpp"

#include <cmath>

#include "batten/core/text.hpp"
#include "batten/session/content_json_detail.hpp"
#include "batten/session/json_detail.hpp"

namespace batten {

namespace {

std::optional<std::string> problem_of(const SharedScan& scan) {
  if (!scan) return "there is no scan";
  for (std::size_t c = 0; c < scan->curves.size(); ++c)
    if (auto found = problem(scan->curves[c], c)) return found;
  return std::nullopt;
}

std::optional<std::string> problem_of(const SharedNetwork& network) {
  if (!network) return "there is no network";
  if (network->normals.rows() != 0 && network->normals.rows() != network->positions.rows())
    return "the network has other numbers of normals than of positions";
  for (std::size_t c = 0; c < network->curves.size(); ++c)
    if (!detail::is_utf8(network->curves[c].name)) return concat("the name of curve ", c, " is not UTF-8");
  return std::nullopt;
}

std::optional<std::string> problem_of(const SharedMesh& mesh) {
  if (!mesh) return "there is no mesh";
  if (mesh->normals.rows() != 0 && mesh->normals.rows() != mesh->n_vertices())
    return "the mesh has other numbers of normals than of vertices";
  for (const auto& [name, values] : mesh->vertex_values) {
    if (!detail::is_utf8(name)) return "the name of a value per vertex is not UTF-8";
    if (values.size() != mesh->n_vertices())
      return concat("the mesh has other numbers of the value '", name, "' than of vertices");
  }
  return std::nullopt;
}

std::optional<std::string> problem_of(const ViewState& view) {
  constexpr double kQuarter = kPi / 2;
  if (!std::isfinite(view.azimuth)) return "the azimuth of the view is not finite";
  if (!(std::abs(view.elevation) <= kQuarter))
    return concat("the elevation of the view must be −π/2 to π/2, got ", view.elevation);
  if (!(view.zoom > 0 && std::isfinite(view.zoom)))
    return concat("the zoom of the view must be above 0, got ", view.zoom);
  if (view.target && !view.target->allFinite()) return "the target of the view is not finite";
  return std::nullopt;
}

std::optional<std::string> problem_of(const SharedModel&) {
  return std::nullopt;
}

std::optional<std::string> problem_of(const Calibration& calibration) {
  for (const SensorCalibration* sensor : {&calibration.accelerometer, &calibration.magnetometer})
    if (!sensor->matrix.allFinite() || !sensor->offset.allFinite())
      return "a number of the calibration is not finite";
  if (!calibration.gyroscope_bias.allFinite()) return "the bias of the gyroscope is not finite";
  return std::nullopt;
}

/// The pointer behind a content, null for those that are held by value.
const void* shared_of(const Content& content) {
  return std::visit(
      [](const auto& held) -> const void* {
        if constexpr (requires { held.get(); })
          return held.get();
        else
          return nullptr;
      },
      content);
}

}  // namespace

std::optional<std::string> problem(const ScanCurve& curve, std::size_t index) {
  if (!detail::is_utf8(curve.name)) return concat("the name of curve ", index + 1, " is not UTF-8");
  if (curve.tangents.rows() != curve.n_readings() || curve.normals.rows() != curve.n_readings())
    return concat("curve ", index + 1, " has other numbers of directions than of distances");
  if (curve.node_ids.size() != curve.node_readings.size())
    return concat("curve ", index + 1, " has other numbers of nodes than of their readings");
  return std::nullopt;
}

ObjectKind kind_of(const Content& content) {
  return static_cast<ObjectKind>(content.index());
}

ObjectKind Object::kind() const {
  const Derived* made = derived();
  return made ? result_kind(kind_of(*made->request)) : kind_of(*content());
}

std::optional<std::string> problem(const Content& content) {
  return std::visit([](const auto& held) { return problem_of(held); }, content);
}

bool same_content(const Content& a, const Content& b) {
  if (a.index() != b.index()) return false;
  if (shared_of(a) && shared_of(a) == shared_of(b)) return true;
  if (const auto* model = std::get_if<SharedModel>(&a)) {
    const auto& other = std::get<SharedModel>(b);
    return *model && other ? **model == *other : !*model && !other;
  }
  return detail::json_of(a) == detail::json_of(b);
}

bool operator==(const Object& a, const Object& b) {
  if (a.name != b.name || a.unit != b.unit || a.body.index() != b.body.index()) return false;
  if (const Derived* made = a.derived())
    return made->source == b.derived()->source && same_request(*made->request, *b.derived()->request);
  return same_content(*a.content(), *b.content());
}

}  // namespace batten
