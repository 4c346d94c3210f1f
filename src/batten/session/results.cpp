#include "batten/session/results.hpp"

#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/control_cage.hpp"

namespace batten {

namespace {

ControlCage smooth_cage(const TriangleMesh& mesh) {
  ControlCage cage;
  cage.mesh.positions = mesh.positions;
  cage.mesh.corners.assign(mesh.triangles.data(), mesh.triangles.data() + mesh.triangles.size());
  cage.mesh.offsets.resize(static_cast<std::size_t>(mesh.n_triangles()) + 1);
  for (std::size_t f = 0; f < cage.mesh.offsets.size(); ++f) cage.mesh.offsets[f] = static_cast<int>(3 * f);
  return cage;
}

/// Does each kind of request.
class Runner {
 public:
  Runner(const Content& source, const Progress& progress) : source_(source), progress_(progress) {}

  RequestResult operator()(const NetworkRequest& request) const {
    return network_from_scan(get<SharedScan>(), request.options, progress_);
  }
  RequestResult operator()(const SurfaceRequest& request) const {
    return curves_surface(get<SharedNetwork>(), request.strokes, request.surface, progress_);
  }
  RequestResult operator()(const ModelSurfaceRequest& request) const {
    return model_surface(get<SharedModel>(), request.options, progress_);
  }
  RequestResult operator()(const FairRequest& request) const {
    return faired_mesh(mesh(), request.options, progress_);
  }
  RequestResult operator()(const RemeshRequest& request) const {
    RemeshedMeshOptions options = request.options;
    if (!request.sizes.empty()) {
      const auto found = mesh().vertex_values.find(request.sizes);
      if (found == mesh().vertex_values.end())
        throw InvalidInput(concat("the mesh has no value '", request.sizes, "' per vertex"));
      options.remesh.sizes = found->second;
    }
    return remeshed_mesh(mesh(), options, progress_);
  }
  RequestResult operator()(const SimplifyRequest& request) const {
    return simplified_mesh(mesh(), request.options, progress_);
  }
  RequestResult operator()(const SubdivideRequest& request) const {
    return subdivided_cage(smooth_cage(mesh()), request.options, progress_);
  }
  RequestResult operator()(const DeformRequest& request) const {
    return deformed_mesh(mesh(), request.handles(), request.options, progress_);
  }
  RequestResult operator()(const RepairRequest& request) const {
    return repaired_mesh(mesh(), request.options, progress_);
  }

 private:
  /// What the source holds.
  template <typename Shared>
  const typename Shared::element_type& get() const {
    return *std::get<Shared>(source_);
  }
  const TriangleMesh& mesh() const { return get<SharedMesh>(); }

  const Content& source_;
  const Progress& progress_;
};

/// Where a result keeps its network or mesh.
const CurveNetwork& held(const ScanNetwork& result) {
  return result.network;
}
const TriangleMesh& held(const CurvesSurface& result) {
  return result.surface.mesh;
}
const TriangleMesh& held(const SimplifiedMesh& result) {
  return result.simplified.mesh;
}
const TriangleMesh& held(const SubdividedCage& result) {
  return result.refined->triangles;
}
template <typename Result>
const TriangleMesh& held(const Result& result) {
  return result.mesh;
}

std::vector<std::string> warnings_in(const ScanNetwork& result) {
  return result.report.warnings;
}
std::vector<std::string> warnings_in(const CurvesSurface& result) {
  std::vector<std::string> warnings;
  if (result.strokes) warnings = result.strokes->warnings;
  const std::vector<std::string>& more = result.surface.warnings;
  warnings.insert(warnings.end(), more.begin(), more.end());
  return warnings;
}
std::vector<std::string> warnings_in(const RepairedMesh& result) {
  std::vector<std::string> warnings = result.warnings;
  warnings.insert(warnings.end(), result.flaws.begin(), result.flaws.end());
  return warnings;
}
template <typename Result>
std::vector<std::string> warnings_in(const Result& result) {
  return result.warnings;
}

StageTimes times_in(const ScanNetwork& result) {
  return result.report.times;
}
StageTimes times_in(const CurvesSurface& result) {
  StageTimes times;
  if (result.strokes) times.add(result.strokes->times);
  times.add(result.surface.times);
  return times;
}
template <typename Result>
StageTimes times_in(const Result& result) {
  return result.times;
}

}  // namespace

RequestResult run(const Request& request, const Content& source, const Progress& progress) {
  const ObjectKind needed = source_kind(kind_of(request));
  if (kind_of(source) != needed)
    throw InvalidInput(concat("the request ", word_of(kind_of(request)), " starts from a ", word_of(needed),
                              ", not from a ", word_of(kind_of(source))));
  if (const auto found = problem(request)) throw InvalidInput(*found);
  return std::visit(Runner(source, progress), request);
}

Content content_of(const std::shared_ptr<const RequestResult>& result) {
  return std::visit(
      [&](const auto& one) -> Content {
        const auto& content = held(one);
        return std::shared_ptr<const std::decay_t<decltype(content)>>(result, &content);
      },
      *result);
}

std::vector<std::string> warnings_of(const RequestResult& result) {
  return std::visit([](const auto& one) { return warnings_in(one); }, result);
}

StageTimes times_of(const RequestResult& result) {
  return std::visit([](const auto& one) { return times_in(one); }, result);
}

std::shared_ptr<const RequestResult> Results::get(const Document& document, ObjectId id,
                                                  const Progress& progress) {
  const Object& object = document.object(id);
  const Derived* derived = object.derived();
  if (!derived) throw InvalidInput(concat("'", object.name, "' is given and not made by a request"));
  const std::uint64_t version = document.version(id);
  const auto kept = kept_.find(id);
  if (kept != kept_.end() && kept->second.version == version) return kept->second.result;
  Content source;
  if (document.object(derived->source).kind() == ObjectKind::Model)
    // Not owned: it lives in the document, which outlives this call.
    source = SharedModel(SharedModel(), &document.model(derived->source));
  else
    source = content(document, derived->source, progress);
  try {
    auto result = std::make_shared<const RequestResult>(run(*derived->request, source, progress));
    kept_.insert_or_assign(id, Kept{version, result});
    return result;
  } catch (const InvalidInput& error) {
    throw InvalidInput(concat("'", object.name, "': ", error.what()));
  }
}

Content Results::content(const Document& document, ObjectId id, const Progress& progress) {
  const Content* given = document.object(id).content();
  return given ? *given : content_of(get(document, id, progress));
}

std::map<ObjectId, std::uint64_t> Results::versions() const {
  std::map<ObjectId, std::uint64_t> versions;
  for (const auto& [id, kept] : kept_) versions[id] = kept.version;
  return versions;
}

}  // namespace batten
