#pragma once
#include "random_edits.hpp"

#include <limits>
#include <string>
#include <vector>

#include "batten/core/random.hpp"
#include "batten/session/document.hpp"

// Edits of every kind without a plan, for tests of properties.
namespace batten::test {

class RandomProject {
 public:
  explicit RandomProject(std::uint64_t seed) : random_(seed) {}

  /// Any edit of a project, with arguments that most often suit it.
  Edit edit(const Document& document) {
    constexpr std::size_t kMany = 12;
    // A drag that goes on: left to chance, a run of 500 edits may have none.
    const auto* turned = document.log().empty() ? nullptr : std::get_if<ViewEdit>(&document.log().back());
    if (turned && turned->drag != 0 && random_.uniform() < 0.3)
      return ViewEdit{turned->object, view_state(), turned->drag};
    const double kind = random_.uniform();
    if (document.objects().size() > kMany && kind < 0.24) return RemoveEdit{any(document), true};
    if (document.objects().empty() || kind < 0.1) return AddEdit{{}, name(), unit(), content()};
    if (kind < 0.2) return derive(document);
    if (kind < 0.24) return RemoveEdit{any(document), random_.uniform() < 0.7};
    if (kind < 0.3) return RenameEdit{any(document), name()};
    if (kind < 0.34) return UnitEdit{any(document), unit()};
    if (kind < 0.38) return ReplaceEdit{any(document), content()};
    if (kind < 0.43) return curve(document);
    if (kind < 0.55) return request(document);
    if (kind < 0.65) return view(document);
    if (kind < 0.8) return tool(document);
    if (kind < 0.92) return UndoEdit{};
    return RedoEdit{};
  }

  /// Any options of any request.
  Request random_request() {
    switch (random_.below(9)) {
      case 0:
        return network_request();
      case 1:
        return surface_request();
      case 2:
        return model_surface_request();
      case 3:
        return fair_request();
      case 4:
        return remesh_request();
      case 5:
        return simplify_request();
      case 6:
        return subdivide_request();
      case 7:
        return repair_request();
      default:
        return deform_request();
    }
  }

  Request network_request() {
    NetworkRequest request;
    request.options.weights = WeightChoice::Given;
    request.options.lambda = number();
    request.options.mu = number();
    request.options.sigma = random_.uniform(0.1, 1);
    request.options.robust = flag();
    if (flag()) request.options.step = Length{random_.uniform(0.01, 0.1), Length::Kind::Metres};
    if (flag()) request.options.step.reset();
    request.options.energy = flag() ? RegressionEnergy::Scaled : RegressionEnergy::Thesis;
    return request;
  }

  Request surface_request() {
    SurfaceRequest request;
    request.strokes.reach = random_.uniform(0.01, 0.05);
    request.surface.surface.map = flag() ? PatchMap::Circle : PatchMap::Polygon;
    request.surface.surface.soft_constraints = flag();
    request.surface.surface.soft_weight = number();
    if (flag()) request.surface.edge_length = Length{number(), Length::Kind::Plain};
    return request;
  }

  Request model_surface_request() {
    ModelSurfaceRequest request;
    request.options.method = flag() ? ModelSurfaceMethod::Coons : ModelSurfaceMethod::Filled;
    request.options.levels = static_cast<int>(random_.below(6));
    request.options.diffusion.time_step = number();
    request.options.coons.scheme = flag() ? FinalScheme::Nuliss : FinalScheme::CatmullClark;
    return request;
  }

  Request fair_request() {
    FairRequest request;
    request.options.method = flag() ? FairingMethod::Taubin : FairingMethod::Automatic;
    request.options.noise = flag() ? number() : -1;
    request.options.iterations = static_cast<int>(random_.below(50));
    request.options.keep_boundary = flag();
    return request;
  }

  Request remesh_request() {
    RemeshRequest request;
    request.options.remesh.method = flag() ? RemeshMethod::Adaptive : RemeshMethod::LaplacianFlow;
    request.options.remesh.adaptivity = random_.uniform();
    if (flag()) request.options.edge_length = Length{number(), Length::Kind::Relative};
    if (flag()) request.sizes = "quality";
    return request;
  }

  Request simplify_request() {
    SimplifyRequest request;
    if (flag())
      request.options.simplify.remove = random_.uniform(0.1, 0.9);
    else
      request.options.max_error = Length{number(), Length::Kind::Relative};
    request.options.simplify.flow.weight = flag() ? FlowWeight::Uniform : FlowWeight::Curvature;
    if (flag()) request.options.simplify.flow.fidelity = number();
    return request;
  }

  Request subdivide_request() {
    SubdivideRequest request;
    SubdivisionOptions& subdivision = request.options.subdivision;
    subdivision.scheme = flag() ? SubdivisionScheme::Linear : SubdivisionScheme::Nuliss;
    subdivision.levels = static_cast<int>(random_.below(4));
    subdivision.limit = flag();
    if (flag()) request.options.first_schemes = {SubdivisionScheme::Nuliss, SubdivisionScheme::Linear};
    return request;
  }

  Request repair_request() {
    RepairRequest request;
    request.options.weld = flag();
    if (flag()) request.options.weld_length = Length{number(), Length::Kind::Metres};
    request.options.orient = flag();
    request.options.fill_holes = flag() ? kAllHoles : 0;
    return request;
  }

  Request deform_request() {
    DeformRequest request;
    DeformedMeshOptions& options = request.options;
    options.deform.energy = flag() ? DeformationEnergy::Bend : DeformationEnergy::Stretch;
    options.deform.detail = flag() ? DetailPreservation::None : DetailPreservation::ShapeMatching;
    options.multiresolution = flag();
    if (flag()) request.fixed = std::make_shared<const std::vector<int>>(vertices());
    MovedVertices& moved = request.moved.emplace_back();
    moved.vertices = std::make_shared<const std::vector<int>>(vertices());
    moved.translation = random_.normal3();
    moved.angle = random_.normal();
    if (flag()) moved.targets = std::make_shared<const Points>(rows(std::ssize(*moved.vertices)));
    return request;
  }

  Content content() {
    switch (random_.below(6)) {
      case 0:
        return std::make_shared<const Scan>(scan());
      case 1:
        return std::make_shared<const CurveNetwork>(network());
      case 2:
        return SharedModel();
      case 3:
        return std::make_shared<const TriangleMesh>(mesh());
      case 4: {
        Calibration calibration;
        calibration.accelerometer.offset = random_.normal3();
        calibration.magnetometer.matrix(0, 1) = random_.normal();
        calibration.gyroscope_bias = random_.normal3();
        return calibration;
      }
      default:
        return view_state();
    }
  }

  Random& random() { return random_; }

 private:
  bool flag() { return random_.uniform() < 0.5; }
  /// Above 0, of any size.
  double number() { return std::exp(8 * random_.normal()); }
  std::string name() {
    static const std::vector<std::string> kNames{"hull", "Boot 7", "κ \"quoted\"", "a\\b\n", "船"};
    return kNames[random_.below(kNames.size())] + (flag() ? "" : std::to_string(random_.below(20)));
  }
  std::string unit() { return flag() ? "mm" : flag() ? "m" : ""; }
  ObjectId any(const Document& document) {
    const std::vector<ObjectId> objects = document.objects();
    if (random_.uniform() < 0.03) return {static_cast<int>(random_.below(100))};
    return objects[random_.below(objects.size())];
  }
  std::vector<ObjectId> of_kind(const Document& document, ObjectKind kind) {
    std::vector<ObjectId> found;
    for (const ObjectId id : document.objects())
      if (document.object(id).kind() == kind) found.push_back(id);
    return found;
  }
  /// Numbers with what is hard to write: both zeros, no numbers, infinities, the smallest.
  Points rows(std::ptrdiff_t n) {
    Points points(n, 3);
    for (std::ptrdiff_t i = 0; i < n; ++i) points.row(i) = random_.normal3().transpose();
    constexpr double kSpecial[] = {-0.0,   0.0,     std::numeric_limits<double>::infinity(),
                                   5e-324, 1.0 / 3, 1e300};
    if (n > 0) points(0, 1) = kSpecial[random_.below(6)];
    if (n > 1 && flag()) points(1, 2) = std::numeric_limits<double>::quiet_NaN();
    return points;
  }
  std::vector<int> vertices() {
    std::vector<int> numbers;
    for (int v = static_cast<int>(random_.below(5)); v < 120; v += 1 + static_cast<int>(random_.below(9)))
      numbers.push_back(v);
    return numbers;
  }
  Scan scan() {
    Scan scan;
    scan.tangents = flag() ? TangentConvention::ToNext : TangentConvention::Auto;
    for (int c = 0; c < 2; ++c) {
      ScanCurve& curve = scan.curves.emplace_back();
      const auto n = static_cast<std::ptrdiff_t>(2 + random_.below(40));
      curve.name = flag() ? name() : "";
      curve.boundary = flag();
      curve.closed = flag();
      curve.node_readings = {0, static_cast<int>(n) - 1};
      curve.node_ids = {c, c + 1};
      curve.distances = rows(n).col(0);
      curve.tangents = rows(n);
      curve.normals = rows(n);
    }
    return scan;
  }
  CurveNetwork network() {
    CurveNetwork network;
    network.positions = rows(30);
    network.normals = flag() ? rows(30) : Points(0, 3);
    network.curves = {{name(), flag(), {0, 3, 5}}, {"", flag(), {5, 7}}};
    if (flag()) network.tagged_nodes = {3};
    return network;
  }
  TriangleMesh mesh() {
    TriangleMesh mesh;
    mesh.positions = rows(40);
    mesh.triangles.resize(50, 3);
    for (Eigen::Index i = 0; i < mesh.triangles.size(); ++i)
      mesh.triangles.data()[i] = static_cast<int>(random_.below(40));
    if (flag()) mesh.normals = rows(40);
    if (flag()) mesh.vertex_values["quality"] = rows(40).col(1);
    return mesh;
  }
  ViewState view_state() {
    ViewState view;
    view.azimuth = random_.normal();
    view.elevation = random_.uniform(-1.5, 1.5);
    view.zoom = number();
    view.up = flag() ? UpAxis::Y : UpAxis::Z;
    view.perspective = flag();
    view.shading = flag() ? ViewShading::Isophotes : ViewShading::Error;
    if (flag()) view.target = random_.normal3();
    if (flag()) view.hidden = {ObjectId{3}, ObjectId{7}};
    return view;
  }
  Edit derive(const Document& document) {
    const Request request = random_request();
    const std::vector<ObjectId> sources = of_kind(document, source_kind(kind_of(request)));
    if (sources.empty()) return UndoEdit{};
    return DeriveEdit{{}, name(), sources[random_.below(sources.size())], request};
  }
  Edit request(const Document& document) {
    std::vector<ObjectId> derived;
    for (const ObjectId id : document.objects())
      if (document.object(id).derived()) derived.push_back(id);
    if (derived.empty()) return RedoEdit{};
    const ObjectId id = derived[random_.below(derived.size())];
    Request request = *document.object(id).derived()->request;
    // A slider of one option, or another request altogether.
    if (auto* network = std::get_if<NetworkRequest>(&request))
      network->options.sigma = random_.uniform(0.1, 1);
    else if (auto* fair = std::get_if<FairRequest>(&request))
      fair->options.noise = number();
    else if (auto* deform = std::get_if<DeformRequest>(&request); deform && !deform->moved.empty())
      deform->moved[0].translation = random_.normal3();
    if (random_.uniform() < 0.4) request = random_request();
    return RequestEdit{id, request, static_cast<int>(random_.below(3))};
  }
  Edit curve(const Document& document) {
    const std::vector<ObjectId> scans = of_kind(document, ObjectKind::Scan);
    if (scans.empty()) return AddEdit{{}, name(), unit(), std::make_shared<const Scan>(scan())};
    return ScanCurveEdit{scans[random_.below(scans.size())], static_cast<int>(random_.below(2)),
                         std::make_shared<const ScanCurve>(scan().curves[1]),
                         static_cast<int>(random_.below(3))};
  }
  Edit view(const Document& document) {
    const std::vector<ObjectId> views = of_kind(document, ObjectKind::View);
    if (views.empty()) return AddEdit{{}, name(), "", view_state()};
    return ViewEdit{views[random_.below(views.size())], view_state(), static_cast<int>(random_.below(3))};
  }
  Edit tool(const Document& document) {
    const std::vector<ObjectId> models = of_kind(document, ObjectKind::Model);
    if (models.empty()) return AddEdit{{}, name(), unit(), SharedModel()};
    const ObjectId id = models[random_.below(models.size())];
    Edit edit = strokes::random_edit(document.model(id), random_);
    if (auto* sketch = std::get_if<ModelEdit>(&edit)) {
      sketch->object = id;
      sketch->drag = static_cast<int>(random_.below(3));
    }
    return edit;
  }

  Random random_;
};

}  // namespace batten::test
