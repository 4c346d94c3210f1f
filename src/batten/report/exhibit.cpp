#include "batten/report/exhibit.hpp"

#include "batten/render/render.hpp"

namespace batten {

namespace {

struct Picture {
  Shading shading;
  const char* title;
  const char* caption;
};

constexpr Picture kMeshPictures[] = {
    {Shading::Isophotes, "Isophotes",
     "Stripes of equal slope to the light. A kink in a stripe is a kink of the surface."},
    {Shading::ReflectionLines, "Reflection lines",
     "Parallel lamps mirrored in the surface. A kink shows a break of curvature."},
    {Shading::NormalMap, "Normal map",
     "The hemisphere of normals as circles about the viewer; regular on a fair surface."},
    {Shading::MeanCurvature, "Mean curvature",
     "Half the sum of the principal curvatures, positive on a sphere."},
    {Shading::GaussianCurvature, "Gaussian curvature", "The product of the principal curvatures."},
    {Shading::Wireframe, "Wireframe", "The triangles."},
};

constexpr Picture kNetworkPictures[] = {
    {Shading::Porcupine, "Porcupine plot", "Normals along the curves, scaled by the curvature of the curve."},
    {Shading::GaussMap, "Gauss map",
     "The normals as points of the unit sphere. Curves that meet must meet here too."},
};

}  // namespace

std::vector<ReportPicture> exhibit_pictures(const Exhibit& exhibit, const Progress& progress) {
  std::vector<ReportPicture> pictures;
  const auto add = [&](const Subject& subject, const Picture& picture, bool wide) {
    RenderOptions options;
    options.shading = picture.shading;
    options.width = wide ? 1200 : 800;
    options.height = wide ? 750 : 600;
    pictures.push_back(
        {picture.title, picture.caption, encode_png(render(subject, options, progress)), wide});
  };
  const TriangleMesh* mesh = exhibit.mesh ? &*exhibit.mesh : nullptr;
  const CurveNetwork* network = exhibit.network ? &*exhibit.network : nullptr;
  if (mesh != nullptr && mesh->n_triangles() == 0) mesh = nullptr;
  if (mesh == nullptr && network == nullptr) return pictures;

  Subject subject{.mesh = mesh, .network = network};
  add(subject, {Shading::Shaded, mesh != nullptr ? "The surface" : "The network", ""}, true);
  if (exhibit.errors.size() > 0) {
    subject.errors = exhibit.errors;
    subject.error_unit = "error, % of size";
    add(subject, {Shading::Error, "Distance to the truth", "In per cent of the diameter of the truth."},
        true);
  }
  if (mesh != nullptr && mesh->vertex_values.count("uncertainty") > 0)
    add(subject,
        {Shading::Uncertainty, "How sure", "Standard deviation across the surface, in the unit of the file."},
        true);
  if (mesh != nullptr) {
    for (const Picture& picture : kMeshPictures) add({.mesh = mesh}, picture, false);
  }
  if (network != nullptr && network->has_normals()) {
    for (const Picture& picture : kNetworkPictures) add({.network = network}, picture, false);
  }
  return pictures;
}

}  // namespace batten
