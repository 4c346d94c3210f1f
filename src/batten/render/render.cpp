#include "batten/render/render.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/parallel.hpp"
#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/operators/curvature.hpp"
#include "batten/render/colour_scale_detail.hpp"
#include "batten/render/corner_normals.hpp"
#include "batten/render/lettering.hpp"
#include "batten/render/light_detail.hpp"
#include "batten/render/palette_detail.hpp"
#include "batten/render/porcupine.hpp"
#include "batten/render/rasteriser.hpp"

namespace batten {

using detail::ColourScale;
using detail::ColourTable;
using Eigen::Vector3d;
using Eigen::Vector3f;

namespace {

using detail::kBorderCurve, detail::kClay, detail::kCurve, detail::kGrey, detail::kInk, detail::kInside,
    detail::kPale;

Colour background(double y) {
  return (1 - static_cast<float>(y)) * hex_colour(0xffffff) + static_cast<float>(y) * hex_colour(0xeef1f5);
}

// ---- normals ----------------------------------------------------------------------------------------------

Points given_corner_normals(const TriangleMesh& mesh) {
  if (mesh.normals.rows() != mesh.n_vertices())
    throw InvalidInput("the mesh has no normals of its own; leave out --normals given");
  Points corners(3 * mesh.n_triangles(), 3);
  for (Eigen::Index i = 0; i < corners.rows(); ++i)
    corners.row(i) = mesh.normals.row(mesh.triangles(i / 3, i % 3));
  return corners;
}

// ---- scenes -----------------------------------------------------------------------------------------------

double line_radius(const RenderOptions& options, double factor = 1) {
  return factor * std::max(0.55, 0.0021 * std::min(options.width, options.height));
}

void add_points(Points& all, const Points& more) {
  const Eigen::Index n = all.rows();
  all.conservativeResize(n + more.rows(), 3);
  all.bottomRows(more.rows()) = more;
}

void check_network(const CurveNetwork& network) {
  for (std::size_t c = 0; c < network.curves.size(); ++c)
    for (const int v : network.curves[c].vertices)
      if (v < 0 || v >= network.positions.rows())
        throw InvalidInput(concat("curve ", c, " names vertex ", v, ", but the vertices run from 0 to ",
                                  network.positions.rows() - 1));
}

void check_mesh(const TriangleMesh& mesh) {
  if (mesh.n_triangles() == 0) throw InvalidInput("the mesh has no faces to draw");
  if (mesh.triangles.minCoeff() < 0 || mesh.triangles.maxCoeff() >= mesh.n_vertices())
    throw InvalidInput("a face of the mesh names a vertex that does not exist");
  for (Eigen::Index i = 0; i < mesh.n_vertices(); ++i)
    if (!mesh.positions.row(i).allFinite())
      throw InvalidInput(concat("vertex ", i, " has a coordinate that is not finite"));
}

/// Curves as tubes, borders in another colour, nodes as balls; with `values` in the colours of `table`.
void add_tubes(Scene& scene, const CurveNetwork& network, double radius, const Eigen::VectorXd* values,
               const ColourTable* table) {
  for (const NetworkCurve& curve : network.curves)
    for (std::size_t i = 0; i + 1 < curve.vertices.size(); ++i) {
      const int a = curve.vertices[i], b = curve.vertices[i + 1];
      const Colour colour = values != nullptr ? (*table)(0.5 * ((*values)[a] + (*values)[b]))
                            : curve.boundary  ? kBorderCurve
                                              : kCurve;
      scene.tubes.push_back({network.positions.row(a), network.positions.row(b), radius, colour});
    }
  if (values != nullptr) return;
  for (const int v : network_topology(network).nodes)
    scene.tubes.push_back({network.positions.row(v), network.positions.row(v), 2.3 * radius, kInk});
}

/// Adds the quills and the line through their tips. @return the tips, for the camera.
Points add_porcupine(Scene& scene, const CurveNetwork& network, double radius, double size) {
  const std::vector<Quills> plot = porcupine(network);
  std::vector<double> bends;
  for (const Quills& quills : plot)
    for (const double k : quills.curvature) bends.push_back(std::abs(k));
  const double typical = percentile(bends, 0.98);
  const double length = typical > 0 ? 0.10 * size / typical : 0;
  std::vector<Vector3d> tips;
  for (const Quills& quills : plot) {
    // At most some 90 quills per diameter, so that they stay apart in the picture.
    double since = std::numeric_limits<double>::infinity();
    Vector3d previous = Vector3d::Zero();
    for (Eigen::Index i = 0; i < quills.roots.rows(); ++i) {
      const Vector3d root = quills.roots.row(i);
      const double k = std::clamp(quills.curvature[i], -2 * typical, 2 * typical);
      const Vector3d tip = root + length * k * quills.directions.row(i).transpose();
      if (i > 0) {
        scene.tubes.push_back({previous, tip, 0.7 * radius, hex_colour(0xa8342e)});
        since += (root - quills.roots.row(i - 1).transpose()).norm();
      }
      if (since > size / 90) {
        scene.tubes.push_back({root, tip, 0.45 * radius, hex_colour(0xd98b7f)});
        since = 0;
      }
      previous = tip;
      tips.push_back(tip);
    }
  }
  Points points(static_cast<Eigen::Index>(tips.size()), 3);
  for (std::size_t i = 0; i < tips.size(); ++i) points.row(static_cast<Eigen::Index>(i)) = tips[i];
  return points;
}

/// A ball of unit radius: a cube of n × n squares per side, pushed out.
TriangleMesh ball(int n) {
  TriangleMesh mesh;
  mesh.positions.resize(6 * (n + 1) * (n + 1), 3);
  mesh.triangles.resize(12 * n * n, 3);
  int v = 0, t = 0;
  for (int side = 0; side < 6; ++side) {
    const Vector3d axis = (side % 2 == 0 ? 1.0 : -1.0) * Vector3d::Unit(side / 2);
    const Vector3d u = Vector3d::Unit((side / 2 + 1) % 3), w = axis.cross(u);
    const int first = v;
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= n; ++j)
        mesh.positions.row(v++) =
            (axis + std::tan(kPi / 4 * (2.0 * i / n - 1)) * u + std::tan(kPi / 4 * (2.0 * j / n - 1)) * w)
                .normalized();
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const int a = first + i * (n + 1) + j;
        mesh.triangles.row(t++) << a, a + n + 1, a + n + 2;
        mesh.triangles.row(t++) << a, a + n + 2, a + 1;
      }
  }
  return mesh;
}

/// The normals of the subject on the unit sphere: the curves' as lines, those of a mesh as dots.
void add_gauss_map(Scene& scene, const Subject& subject, double radius) {
  const TriangleMesh globe = ball(24);
  scene.positions = 0.99 * globe.positions;
  scene.triangles = globe.triangles;
  if (subject.network != nullptr) {
    const CurveNetwork& network = *subject.network;
    if (!network.has_normals()) throw InvalidInput("the shading gauss-map needs a network with normals");
    for (const NetworkCurve& curve : network.curves)
      for (std::size_t i = 0; i + 1 < curve.vertices.size(); ++i)
        scene.tubes.push_back({network.normals.row(curve.vertices[i]),
                               network.normals.row(curve.vertices[i + 1]), radius,
                               curve.boundary ? kBorderCurve : kCurve});
    return;
  }
  const Points normals = vertex_normals(subject.mesh->positions, subject.mesh->triangles);
  const Eigen::Index step = std::max<Eigen::Index>(1, normals.rows() / 20000);
  for (Eigen::Index i = 0; i < normals.rows(); i += step)
    if (normals.row(i).squaredNorm() > 0)
      scene.tubes.push_back({normals.row(i), normals.row(i), 1.3 * radius, kCurve});
}

/// Curvature of the vertices; on borders, where the operators say nothing, the mean of the neighbours inside.
Eigen::VectorXd curvature_values(const TriangleMesh& mesh, bool gaussian) {
  const Curvatures curvatures = discrete_curvatures(mesh.positions, mesh.triangles);
  Eigen::VectorXd values = gaussian ? curvatures.gaussian : curvatures.mean;
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(values.size()), counts = sums;
  for (Eigen::Index t = 0; t < mesh.n_triangles(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int v = mesh.triangles(t, k);
      for (const int other : {mesh.triangles(t, (k + 1) % 3), mesh.triangles(t, (k + 2) % 3)})
        if (curvatures.on_border[v] != 0 && curvatures.on_border[other] == 0) {
          sums[v] += values[other];
          counts[v] += 1;
        }
    }
  for (Eigen::Index v = 0; v < values.size(); ++v)
    if (curvatures.on_border[v] != 0)
      values[v] = counts[v] > 0 ? sums[v] / counts[v] : std::numeric_limits<double>::quiet_NaN();
  return values;
}

void require(bool given, Shading shading, const char* what) {
  if (!given) throw InvalidInput(concat("the shading ", word_of(shading), " needs ", what));
}

/// Refuses what the shading cannot show.
void check(const Subject& subject, const RenderOptions& options) {
  const Shading shading = options.shading;
  const TriangleMesh* mesh = subject.mesh;
  const CurveNetwork* network = subject.network;
  if (mesh == nullptr && network == nullptr) throw InvalidInput("there is nothing to draw");
  if (mesh != nullptr) check_mesh(*mesh);
  if (network != nullptr) check_network(*network);
  const bool needs_mesh = shading == Shading::Wireframe || shading == Shading::Isophotes ||
                          shading == Shading::ReflectionLines || shading == Shading::NormalMap ||
                          shading == Shading::MeanCurvature || shading == Shading::GaussianCurvature;
  if (needs_mesh) require(mesh != nullptr, shading, "a mesh, and there is only a network");
  if (shading == Shading::Porcupine) require(network != nullptr, shading, "a network (--network)");
  if (shading == Shading::Error || shading == Shading::Uncertainty) {
    const bool error = shading == Shading::Error;
    require(subject.amounts(shading).size() > 0, shading,
            error ? "a truth to measure against (--against)" : "a file written with --uncertainty");
    const Eigen::Index n = mesh != nullptr ? mesh->n_vertices() : network->positions.rows();
    require(subject.amounts(shading).size() == n, shading, "one value per vertex");
  }
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
}

/// Values per vertex that are shown as colours.
struct Mapping {
  Eigen::VectorXd values;
  ColourScale scale;
  ColourTable table;
};

std::optional<Mapping> mapping_of(const Subject& subject, const RenderOptions& options) {
  const Shading shading = options.shading;
  Eigen::VectorXd values;
  ColourScale scale;
  if (shading == Shading::Error || shading == Shading::Uncertainty) {
    const bool error = shading == Shading::Error;
    values = subject.amounts(shading) * (error ? subject.error_scale : 1);
    scale = detail::error_scale(values, error ? subject.error_unit : "deviation", options.range);
  } else if (shading == Shading::MeanCurvature || shading == Shading::GaussianCurvature) {
    const bool gaussian = shading == Shading::GaussianCurvature;
    values = curvature_values(*subject.mesh, gaussian);
    scale =
        detail::curvature_scale(values, gaussian ? "Gaussian curvature" : "mean curvature", options.range);
  } else {
    return std::nullopt;
  }
  return Mapping{std::move(values), scale, ColourTable(scale)};
}

/// What is drawn, and what the camera must show of it.
struct Picture {
  Scene scene;
  Points normals{0, 3};  ///< three per triangle of the scene; none for the Gauss map
  Points framed{0, 3};

  void add_mesh(const TriangleMesh& mesh, const RenderOptions& options) {
    scene.positions = mesh.positions;
    scene.triangles = mesh.triangles;
    normals = options.given_normals ? given_corner_normals(mesh)
                                    : corner_normals(mesh, radians(options.crease_angle_deg));
    std::vector<char> used(static_cast<std::size_t>(mesh.n_vertices()), 0);
    for (Eigen::Index i = 0; i < mesh.triangles.size(); ++i) used[at(mesh.triangles.data()[i])] = 1;
    framed.resize(mesh.n_vertices(), 3);
    Eigen::Index n = 0;
    for (Eigen::Index v = 0; v < mesh.n_vertices(); ++v)
      if (used[at(v)] != 0) framed.row(n++) = mesh.positions.row(v);
    framed.conservativeResize(n, 3);
  }

  void add_network(const Subject& subject, Shading shading, const std::optional<Mapping>& mapping,
                   double radius) {
    const CurveNetwork& network = *subject.network;
    Points on_curves(0, 3);
    for (const NetworkCurve& curve : network.curves) {
      Points points(static_cast<Eigen::Index>(curve.vertices.size()), 3);
      for (std::size_t i = 0; i < curve.vertices.size(); ++i)
        points.row(static_cast<Eigen::Index>(i)) = network.positions.row(curve.vertices[i]);
      add_points(on_curves, points);
    }
    add_points(framed, on_curves);
    const bool coloured = mapping && subject.mesh == nullptr;
    add_tubes(scene, network, (subject.mesh == nullptr ? 1.5 : 1.0) * radius,
              coloured ? &mapping->values : nullptr, coloured ? &mapping->table : nullptr);
    if (shading == Shading::Porcupine)
      add_points(framed, add_porcupine(scene, network, radius, bounding_box_diagonal(on_curves)));
  }
};

/// The colour of what a ray meets.
class SurfaceShader {
 public:
  SurfaceShader(const Picture& picture, const RenderOptions& options, const std::optional<Mapping>& mapping,
                const PictureCamera& camera, double edge_half_width)
      : scene_(picture.scene),
        normals_(picture.normals),
        options_(options),
        mapping_(mapping),
        to_camera_(camera.rotation()),
        edge_half_width_(edge_half_width) {
    lighting_.up = (to_camera_ * Vector3d::Unit(options.view.up_axis)).cast<float>();
  }

  Colour operator()(const Hit& hit) const {
    const Vector3f viewer = hit.viewer.cast<float>();
    if (hit.tube >= 0)
      return lighting_.matt(hit.normal.cast<float>(), viewer, 1.1F * scene_.tubes[at(hit.tube)].colour);
    // The side that is seen decides; a normal that leans away at the outline is kept, as on a smooth surface.
    const bool inside = hit.normal.dot(hit.viewer) < 0;
    Vector3d smooth = smooth_normal(hit);
    smooth.normalize();
    if (inside) smooth = -smooth;
    const Vector3f n = smooth.cast<float>();
    switch (options_.shading) {
      case Shading::Shaded:
        return lighting_.matt(n, viewer, inside ? kInside : kClay);
      case Shading::Porcupine:
      case Shading::GaussMap:
        return lighting_.matt(n, viewer, kPale);
      case Shading::Wireframe: {
        const float line = edge_cover(hit);
        const Colour surface = lighting_.matt(n, viewer, inside ? kInside : kPale);
        return (1 - 0.85F * line) * surface + 0.85F * line * hex_colour(0x33445c);
      }
      case Shading::Isophotes:
        return detail::isophote(n, lighting_, options_.stripes);
      case Shading::ReflectionLines:
        return detail::reflection(n, viewer, lighting_, options_.stripes);
      case Shading::NormalMap:
        return detail::normal_circles(n, viewer);
      case Shading::MeanCurvature:
      case Shading::GaussianCurvature:
      case Shading::Error:
      case Shading::Uncertainty:
        return lighting_.mapped(n, mapping_->table(value(hit)));
    }
    return kGrey;
  }

 private:
  /// In camera coordinates, of any length.
  Vector3d smooth_normal(const Hit& hit) const {
    if (options_.shading == Shading::GaussMap)
      return to_camera_ * (hit.weights[0] * scene_.positions.row(scene_.triangles(hit.triangle, 0)) +
                           hit.weights[1] * scene_.positions.row(scene_.triangles(hit.triangle, 1)) +
                           hit.weights[2] * scene_.positions.row(scene_.triangles(hit.triangle, 2)))
                              .transpose();
    const Eigen::RowVector3d n = hit.weights[0] * normals_.row(3 * hit.triangle) +
                                 hit.weights[1] * normals_.row(3 * hit.triangle + 1) +
                                 hit.weights[2] * normals_.row(3 * hit.triangle + 2);
    return n.squaredNorm() > 0 ? Vector3d(to_camera_ * n.transpose()) : hit.normal;
  }

  /// How much of the sample an edge covers. By the distance to the nearest edge in pixels from the heights of
  /// the triangle, so that every line has the same width and is hidden exactly where its triangle is.
  float edge_cover(const Hit& hit) const {
    double nearest = std::numeric_limits<double>::infinity();
    const Vector3d corners[3] = {scene_.positions.row(scene_.triangles(hit.triangle, 0)),
                                 scene_.positions.row(scene_.triangles(hit.triangle, 1)),
                                 scene_.positions.row(scene_.triangles(hit.triangle, 2))};
    const double area2 = (corners[1] - corners[0]).cross(corners[2] - corners[0]).norm();
    for (int k = 0; k < 3; ++k) {
      const double edge = (corners[(k + 2) % 3] - corners[(k + 1) % 3]).norm();
      if (!(edge > 0)) continue;
      // Foreshortened by the slope across the edge.
      const Vector3d along = to_camera_ * (corners[(k + 2) % 3] - corners[(k + 1) % 3]) / edge;
      const Vector3d across = hit.normal.cross(along);
      const double lean = across.dot(hit.viewer);
      const double height = hit.weights[k] * area2 / edge * std::sqrt(std::max(0.0, 1 - lean * lean));
      nearest = std::min(nearest, height / hit.pixel_size);
    }
    return static_cast<float>(std::clamp(edge_half_width_ + 0.5 - nearest, 0.0, 1.0));
  }

  double value(const Hit& hit) const {
    const Eigen::VectorXd& values = mapping_->values;
    return hit.weights[0] * values[scene_.triangles(hit.triangle, 0)] +
           hit.weights[1] * values[scene_.triangles(hit.triangle, 1)] +
           hit.weights[2] * values[scene_.triangles(hit.triangle, 2)];
  }

  const Scene& scene_;
  const Points& normals_;
  const RenderOptions& options_;
  const std::optional<Mapping>& mapping_;
  const Eigen::Matrix3d& to_camera_;
  double edge_half_width_;
  detail::Lighting lighting_;
};

}  // namespace

std::optional<std::string> RenderOptions::problem() const {
  if (samples < 1 || samples > 8) return concat("samples must lie between 1 and 8, got ", samples);
  if (stripes < 1 || stripes > 1000) return concat("stripes must lie between 1 and 1000, got ", stripes);
  return std::nullopt;
}

std::optional<ShownValues> shown_values(const Subject& subject, const RenderOptions& options) {
  check(subject, options);
  std::optional<Mapping> mapping = mapping_of(subject, options);
  if (!mapping) return std::nullopt;
  return ShownValues{std::move(mapping->values), mapping->scale.low, mapping->scale.high,
                     mapping->scale.title};
}

Image render(const Subject& subject, const RenderOptions& options, const Progress& progress) {
  check(subject, options);
  Image image(options.width, options.height, background(0));
  const std::optional<Mapping> mapping = mapping_of(subject, options);
  const double radius = line_radius(options);
  Picture picture;
  if (options.shading == Shading::GaussMap) {
    add_gauss_map(picture.scene, subject, radius);
    picture.framed = ball(8).positions;
  } else {
    if (subject.mesh != nullptr) picture.add_mesh(*subject.mesh, options);
    if (subject.network != nullptr) picture.add_network(subject, options.shading, mapping, radius);
  }
  const double margin = 0.05 * std::min(options.width, options.height);
  const double room = mapping ? detail::bar_width(options.width, options.height) : 0;
  const PictureCamera camera(picture.framed, options.view, margin, margin, options.width - 2 * margin - room,
                             options.height - 2 * margin);
  const SurfaceShader shader(picture, options, mapping, camera, 0.32 * radius);
  rasterise(image, picture.scene, camera, options.samples, shader, background, progress);
  if (mapping) detail::draw_bar(image, mapping->scale);
  return image;
}

Image contact_sheet(const Subject& subject, const std::vector<Shading>& shadings,
                    const RenderOptions& options, const Progress& progress) {
  if (shadings.empty()) throw InvalidInput("a contact sheet needs at least one shading");
  const auto n = static_cast<int>(shadings.size());
  int columns = 1;
  // The division whose cells come closest to the shape of the whole.
  double best = 0;
  for (int c = 1; c <= n; ++c) {
    const int rows = (n + c - 1) / c;
    const double cell = std::min(options.width / (1.15 * c), static_cast<double>(options.height) / rows);
    if (cell > best * 1.001) {
      best = cell;
      columns = c;
    }
  }
  const int rows = (n + columns - 1) / columns;
  const int width = options.width / columns, height = options.height / rows;
  const double cap = std::max(8.0, 0.026 * std::min(width, height));
  const int caption = static_cast<int>(2.6 * cap);
  Image sheet(options.width, options.height, hex_colour(0xffffff));
  for (int i = 0; i < n; ++i) {
    RenderOptions cell = options;
    cell.shading = shadings[i];
    cell.width = width;
    cell.height = std::max(1, height - caption);
    const int x = i % columns * width, y = i / columns * height;
    sheet.paste(render(subject, cell, progress), x, y);
    std::string name(word_of(shadings[i]));
    std::replace(name.begin(), name.end(), '-', ' ');
    draw_text(sheet, x + 0.5 * width, y + height - 0.8 * cap, name, cap, kInk, Align::Centre);
  }
  return sheet;
}

}  // namespace batten
