#include "batten/session/request.hpp"

#include "batten/core/text.hpp"
#include "batten/session/request_json_detail.hpp"

namespace batten {

namespace {

std::optional<std::string> problem_of_vertices(const SharedVertices& vertices) {
  if (!vertices) return std::nullopt;
  for (const int vertex : *vertices)
    if (vertex < 0) return concat("a handle names the vertex ", vertex);
  return std::nullopt;
}

std::optional<std::string> problem_of(const DeformRequest& request) {
  if (auto found = request.options.problem()) return found;
  if (auto found = problem_of_vertices(request.fixed)) return found;
  for (const MovedVertices& moved : request.moved) {
    if (auto found = problem_of_vertices(moved.vertices)) return found;
    const std::size_t n = moved.vertices ? moved.vertices->size() : 0;
    if (moved.targets && static_cast<std::size_t>(moved.targets->rows()) != n)
      return concat("a handle has ", n, " vertices and ", moved.targets->rows(), " targets");
  }
  return std::nullopt;
}

std::optional<std::string> problem_of(const RemeshRequest& request) {
  if (request.options.remesh.sizes.size() > 0)
    return "the sizes of a remeshing request are named, as a value per vertex of the mesh";
  return request.options.problem();
}

std::optional<std::string> problem_of(const SurfaceRequest& request) {
  if (auto found = request.strokes.problem()) return found;
  return request.surface.problem();
}

std::optional<std::string> problem_of(const SubdivideRequest& request) {
  if (!request.options.refine || request.options.patches)
    return "a subdivision request makes a mesh, and no patches";
  return request.options.problem();
}

template <typename AnyRequest>
std::optional<std::string> problem_of(const AnyRequest& request) {
  return request.options.problem();
}

/// Adds the members in which two objects differ; those of nested options by their own names.
void add_differences(const detail::Json& before, const detail::Json& after, const std::string& prefix,
                     std::vector<std::string>& names) {
  for (const auto& [name, value] : *after.get<detail::Json::Object>()) {
    const detail::Json* old = before.find(name);
    if (old && old->get<detail::Json::Object>() && value.get<detail::Json::Object>())
      add_differences(*old, value, prefix + name + ".", names);
    else if (!old || !(*old == value))
      names.push_back(prefix + name);
  }
}

template <typename T>
void share(std::shared_ptr<const T>& list, const std::shared_ptr<const T>& with) {
  const auto equal = [](const T& a, const T& b) {
    if constexpr (requires { a.rows(); })
      if (a.rows() != b.rows()) return false;  // matrices of different sizes cannot be compared
    return a == b;
  };
  if (list && with && list != with && equal(*list, *with)) list = with;
}

}  // namespace

Handles DeformRequest::handles() const {
  Handles handles;
  if (fixed) handles.fixed = *fixed;
  for (const MovedVertices& motion : moved) {
    HandleMotion& handle = handles.moved.emplace_back();
    if (motion.vertices) handle.vertices = *motion.vertices;
    handle.translation = motion.translation;
    handle.axis = motion.axis;
    handle.angle = motion.angle;
    handle.about = motion.about;
    handle.targets = motion.targets ? *motion.targets : Points(0, 3);
  }
  return handles;
}

RequestKind kind_of(const Request& request) {
  return static_cast<RequestKind>(request.index());
}

Request default_request(RequestKind kind) {
  switch (kind) {
    case RequestKind::Network:
      return NetworkRequest{};
    case RequestKind::Surface:
      return SurfaceRequest{};
    case RequestKind::ModelSurface:
      return ModelSurfaceRequest{};
    case RequestKind::Fair:
      return FairRequest{};
    case RequestKind::Remesh:
      return RemeshRequest{};
    case RequestKind::Simplify:
      return SimplifyRequest{};
    case RequestKind::Subdivide:
      return SubdivideRequest{};
    case RequestKind::Deform:
      return DeformRequest{};
    case RequestKind::Repair:
      break;
  }
  return RepairRequest{};
}

ObjectKind source_kind(RequestKind kind) {
  switch (kind) {
    case RequestKind::Network:
      return ObjectKind::Scan;
    case RequestKind::Surface:
      return ObjectKind::Network;
    case RequestKind::ModelSurface:
      return ObjectKind::Model;
    default:
      return ObjectKind::Mesh;
  }
}

ObjectKind result_kind(RequestKind kind) {
  return kind == RequestKind::Network ? ObjectKind::Network : ObjectKind::Mesh;
}

std::optional<std::string> problem(const Request& request) {
  return std::visit([](const auto& asked) { return problem_of(asked); }, request);
}

bool same_request(const Request& a, const Request& b) {
  return &a == &b || detail::json_of(a) == detail::json_of(b);
}

std::vector<std::string> changed_options(const Request& before, const Request& after) {
  if (before.index() != after.index()) return {"request"};
  std::vector<std::string> names;
  add_differences(detail::json_of(before), detail::json_of(after), "", names);
  return names;
}

void share_lists(Request& request, const Request& with) {
  auto* deform = std::get_if<DeformRequest>(&request);
  const auto* other = std::get_if<DeformRequest>(&with);
  if (!deform || !other) return;
  share(deform->fixed, other->fixed);
  for (std::size_t i = 0; i < std::min(deform->moved.size(), other->moved.size()); ++i) {
    share(deform->moved[i].vertices, other->moved[i].vertices);
    share(deform->moved[i].targets, other->moved[i].targets);
  }
}

}  // namespace batten
