#include "batten/render/render.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/parallel.hpp"
#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/normals.hpp"
#include "batten/operators/curvature.hpp"
#include "batten/render/lettering.hpp"
#include "batten/render/porcupine.hpp"
#include "batten/render/rasteriser.hpp"

namespace batten {

using Eigen::Vector3d;
using Eigen::Vector3f;

namespace {

struct ShadingName {
  Shading shading;
  std::string_view name;
};
constexpr ShadingName kShadings[] = {{Shading::Shaded, "shaded"},
                                     {Shading::Wireframe, "wireframe"},
                                     {Shading::Isophotes, "isophotes"},
                                     {Shading::ReflectionLines, "reflection-lines"},
                                     {Shading::NormalMap, "normal-map"},
                                     {Shading::MeanCurvature, "mean-curvature"},
                                     {Shading::GaussianCurvature, "gaussian-curvature"},
                                     {Shading::GaussMap, "gauss-map"},
                                     {Shading::Porcupine, "porcupine"},
                                     {Shading::Error, "error"}};

const Colour kInk = hex_colour(0x2b2f36), kCurve = hex_colour(0x1c4a86), kBorderCurve = hex_colour(0xc25a1c),
             kClay = hex_colour(0xc3cad6), kInside = hex_colour(0xc7a78f), kPale = hex_colour(0xe9ebee),
             kGrey = hex_colour(0x9aa0a8);

Colour background(double y) {
  return (1 - static_cast<float>(y)) * hex_colour(0xffffff) + static_cast<float>(y) * hex_colour(0xeef1f5);
}

// ---- light ------------------------------------------------------------------------------------------------

/// Lights fixed to the camera: a large warm one from above left, a cool one from the right, a faint one from
/// behind, and a sky that is brighter above. Large lights reach round the edge (wrap), so shadows are soft.
struct Lighting {
  Vector3f key = Vector3f(-0.42F, 0.62F, 0.66F).normalized(),
           fill = Vector3f(0.85F, 0.05F, 0.52F).normalized(),
           back = Vector3f(0.1F, 0.55F, -0.83F).normalized();
  Vector3f up;  ///< the world's up in camera coordinates

  static float wrapped(const Vector3f& n, const Vector3f& light, float wrap) {
    return std::max(0.0F, (n.dot(light) + wrap) / (1 + wrap));
  }

  Colour diffuse(const Vector3f& n) const {
    const float sky = 0.5F + 0.5F * n.dot(up);
    Colour light = (0.07F + 0.19F * sky) * Colour(0.94F, 0.97F, 1.0F);
    light += 0.74F * wrapped(n, key, 0.10F) * Colour(1.0F, 0.975F, 0.94F);
    light += 0.17F * wrapped(n, fill, 0.3F) * Colour(0.90F, 0.95F, 1.0F);
    light += 0.12F * wrapped(n, back, 0.1F) * Colour(1.0F, 1.0F, 1.0F);
    return light;
  }
  float specular(const Vector3f& n, const Vector3f& viewer, float shininess) const {
    const float s = std::max(0.0F, n.dot((key + viewer).normalized()));
    return std::pow(s, shininess);
  }
  Colour matt(const Vector3f& n, const Vector3f& viewer, const Colour& material) const {
    const float fresnel = std::pow(1 - std::max(0.0F, n.dot(viewer)), 4.0F);
    return 1.10F * diffuse(n).cwiseProduct(material) +
           Colour::Constant(0.06F * specular(n, viewer, 18) + 0.05F * specular(n, viewer, 90) +
                            0.06F * fresnel);
  }
  /// Shading that leaves the colours of a map readable.
  Colour mapped(const Vector3f& n, const Colour& colour) const {
    return (0.66F + 0.40F * diffuse(n)[1]) * colour;
  }
};

// ---- normals ----------------------------------------------------------------------------------------------

/// Three normals per triangle: smooth over the vertex except across creases.
Points corner_normals(const TriangleMesh& mesh, const RenderOptions& options) {
  const Eigen::Index m = mesh.n_triangles();
  Points corners(3 * m, 3);
  if (options.given_normals) {
    if (mesh.normals.rows() != mesh.n_vertices())
      throw InvalidInput("the mesh has no normals of its own; leave out --normals given");
    for (Eigen::Index t = 0; t < m; ++t)
      for (int k = 0; k < 3; ++k) corners.row(3 * t + k) = mesh.normals.row(mesh.triangles(t, k));
    return corners;
  }
  const Points faces = face_normals(mesh.positions, mesh.triangles);
  std::vector<int> first(mesh.n_vertices() + 1, 0), around(3 * m);
  for (Eigen::Index i = 0; i < 3 * m; ++i) ++first[mesh.triangles.data()[i] + 1];
  for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
  std::vector<int> next(first.begin(), first.end() - 1);
  for (Eigen::Index i = 0; i < 3 * m; ++i) around[next[mesh.triangles.data()[i]]++] = static_cast<int>(i);
  Eigen::VectorXd angles(3 * m);
  for (Eigen::Index t = 0; t < m; ++t)
    for (int k = 0; k < 3; ++k) {
      const Vector3d p = mesh.positions.row(mesh.triangles(t, k));
      const Vector3d u = mesh.positions.row(mesh.triangles(t, (k + 1) % 3)).transpose() - p,
                     v = mesh.positions.row(mesh.triangles(t, (k + 2) % 3)).transpose() - p;
      angles[3 * t + k] = std::atan2(u.cross(v).norm(), u.dot(v));
    }
  const double crease = std::cos(radians(options.crease_angle_deg));
  parallel_for(m, 4096, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index t = begin; t < end; ++t)
      for (int k = 0; k < 3; ++k) {
        const int v = mesh.triangles(t, k);
        Vector3d sum = Vector3d::Zero();
        for (int i = first[v]; i < first[v + 1]; ++i) {
          const int other = around[i] / 3;
          if (faces.row(other).dot(faces.row(t)) >= crease)
            sum += angles[around[i]] * faces.row(other).transpose();
        }
        const double length = sum.norm();
        corners.row(3 * t + k) = length > 0 ? Vector3d(sum / length) : Vector3d(faces.row(t));
      }
  });
  return corners;
}

// ---- colour bars ------------------------------------------------------------------------------------------

std::vector<double> finite_values(const Eigen::VectorXd& values) {
  std::vector<double> list;
  for (const double value : values)
    if (std::isfinite(value)) list.push_back(value);
  return list;
}

struct ColourScale {
  double low = 0, high = 1;
  bool diverging = false;
  std::string title;  ///< above the bar
  std::string note;   ///< below the bar

  Colour colour(double value) const {
    if (!std::isfinite(value)) return kGrey;
    const double t = (value - low) / (high - low);
    return diverging ? diverging_colour(t) : sequential_colour(t);
  }
};

/// Colours looked up per sample: the conversion from Lab is too slow there.
class ColourTable {
 public:
  explicit ColourTable(const ColourScale& scale)
      : low_(scale.low), factor_((kSize - 1) / (scale.high - scale.low)) {
    for (int i = 0; i < kSize; ++i) table_.push_back(scale.colour(scale.low + i / factor_));
  }
  Colour operator()(double value) const {
    if (!std::isfinite(value)) return kGrey;
    return table_[static_cast<std::size_t>(std::clamp((value - low_) * factor_ + 0.5, 0.0, kSize - 1.0))];
  }

 private:
  static constexpr int kSize = 1024;
  double low_, factor_;
  std::vector<Colour> table_;
};

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

ColourScale error_scale(const Eigen::VectorXd& values, const std::string& unit, double range) {
  ColourScale scale;
  std::vector<double> list = finite_values(values);
  double largest = 0;
  for (const double value : list) largest = std::max(largest, value);
  scale.high = range > 0 ? range : percentile(list, 0.99);
  if (!(scale.high > 0)) scale.high = largest > 0 ? largest : 1;
  scale.title = unit;
  scale.note = concat("max ", short_number(largest));
  return scale;
}

ColourScale curvature_scale(const Eigen::VectorXd& values, const std::string& title, double range) {
  ColourScale scale;
  std::vector<double> sizes;
  for (const double value : finite_values(values)) sizes.push_back(std::abs(value));
  scale.high = range > 0 ? range : percentile(sizes, 0.97);
  if (!(scale.high > 0)) scale.high = 1;
  scale.low = -scale.high;
  scale.diverging = true;
  scale.title = title;
  return scale;
}

/// Round numbers between the ends of a scale, some five of them.
std::vector<double> ticks(double low, double high) {
  const double rough = (high - low) / 5;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double factor : {1.0, 2.0, 5.0})
    if (rough <= factor * power) {
      step = factor * power;
      break;
    }
  std::vector<double> list;
  for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k)
    list.push_back(k * step + 0.0);  // never minus zero
  return list;
}

double bar_width(int width, int height) {
  return 0.13 * std::min(width, height) + 40;
}

void draw_bar(Image& image, const ColourScale& scale) {
  const double cap = std::max(8.0, 0.0165 * std::min(image.width, image.height));
  const double room = bar_width(image.width, image.height);
  const double x0 = image.width - room + 0.1 * room, x1 = x0 + 0.17 * room;
  const double y0 = 0.16 * image.height, y1 = 0.86 * image.height;
  for (int y = static_cast<int>(y0); y < static_cast<int>(y1); ++y) {
    const double value = scale.high - (scale.high - scale.low) * (y + 0.5 - y0) / (y1 - y0);
    const Colour colour = scale.colour(value);
    for (int x = static_cast<int>(x0); x < static_cast<int>(x1); ++x) image.blend(x, y, colour, 1);
  }
  for (const double value : ticks(scale.low, scale.high)) {
    const double y = y1 - (y1 - y0) * (value - scale.low) / (scale.high - scale.low);
    draw_line(image, x1 - 0.3 * (x1 - x0), y, x1 - 1, y, 1,
              kInk);  // inside: beside the number it would be a minus
    draw_text(image, x1 + 0.6 * cap, y + 0.5 * cap, short_number(value), cap, kInk);
  }
  draw_text(image, image.width - 0.1 * room, y0 - 1.8 * cap, scale.title, cap, kInk, Align::Right);
  draw_text(image, x0, y1 + 2.2 * cap, scale.note, cap, kInk);
}

// ---- patterns ---------------------------------------------------------------------------------------------

/// The red and blue circles of S fig. 4.24 for a normal in camera coordinates.
Colour normal_circles(const Vector3f& n, const Vector3f& viewer) {
  constexpr float kRings = 9;  ///< of each colour over the hemisphere
  const float angle = std::acos(std::clamp(n.dot(viewer), -1.0F, 1.0F)) / static_cast<float>(kPi / 2);
  const float at = angle * kRings;
  const bool red = at - std::floor(at) < 0.5F;
  const Colour colour = red ? hex_colour(0xd2342e) : hex_colour(0x27489e);
  // Light falls on the hemisphere from above left: left and right, up and down can be told apart.
  const float light = 0.78F + 0.22F * n.dot(Vector3f(-0.5F, 0.7F, 0.5F));
  return light * colour;
}

/// 0 or 1 in stripes of equal width, softened where they are narrower than a few samples.
float stripe(double phase) {
  return phase - std::floor(phase) < 0.5 ? 1.0F : 0.0F;
}

Colour isophote(const Vector3f& n, const Lighting& lighting, int stripes) {
  // A light beside the viewer: its rings are not the outline again.
  const Vector3f light = Vector3f(-0.35F, 0.50F, 0.79F).normalized();
  const double angle = std::acos(std::clamp(n.dot(light), -1.0F, 1.0F));
  const float white = stripe(angle / kPi * stripes);
  const Colour colour = white * hex_colour(0xf3f4f6) + (1 - white) * hex_colour(0x343b47);
  return lighting.mapped(n, colour);
}

Colour reflection(const Vector3f& n, const Vector3f& viewer, const Lighting& lighting, int stripes) {
  // Lamps are lines along the camera's x axis, tilted a little; the angle of the mirrored ray about that axis
  // tells which lamp is seen.
  const Vector3f mirrored = 2 * n.dot(viewer) * n - viewer;
  const Vector3f axis = Vector3f(0.93F, 0.12F, 0.34F).normalized();
  const Vector3f across = axis.cross(Vector3f::UnitZ()).normalized(), along = axis.cross(across);
  const double angle = std::atan2(mirrored.dot(across), mirrored.dot(along));
  const float lamp = stripe(angle / (2 * kPi) * stripes);
  const float fresnel = 0.25F + 0.75F * std::pow(1 - std::max(0.0F, n.dot(viewer)), 3.0F);
  const Colour body = lighting.diffuse(n).cwiseProduct(hex_colour(0x35527a));
  return body + lamp * (0.55F + 0.3F * fresnel) * hex_colour(0xf4f7fb);
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

/// Curves as tubes, borders in another colour, nodes as balls. `colour_of` may recolour a stretch.
void add_network(Scene& scene, const CurveNetwork& network, double radius, const Eigen::VectorXd* values,
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
  if (!given) throw InvalidInput(concat("the shading ", shading_name(shading), " needs ", what));
}

}  // namespace

std::string_view shading_name(Shading shading) {
  for (const ShadingName& entry : kShadings)
    if (entry.shading == shading) return entry.name;
  return "";
}

const std::vector<Shading>& all_shadings() {
  static const std::vector<Shading> all = [] {
    std::vector<Shading> list;
    for (const ShadingName& entry : kShadings) list.push_back(entry.shading);
    return list;
  }();
  return all;
}

Shading parse_shading(std::string_view name) {
  std::string names;
  for (const ShadingName& entry : kShadings) {
    if (entry.name == name) return entry.shading;
    names += concat(names.empty() ? "" : ", ", entry.name);
  }
  throw InvalidInput(concat("there is no shading '", name, "'; choose from ", names));
}

std::optional<std::string> RenderOptions::problem() const {
  if (samples < 1 || samples > 8) return concat("samples must lie between 1 and 8, got ", samples);
  if (stripes < 1 || stripes > 1000) return concat("stripes must lie between 1 and 1000, got ", stripes);
  return std::nullopt;
}

Image render(const Subject& subject, const RenderOptions& options, const Progress& progress) {
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
  if (shading == Shading::Error) {
    require(subject.errors.size() > 0, shading, "a truth to measure against (--against)");
    require(subject.errors.size() == (mesh != nullptr ? mesh->n_vertices() : network->positions.rows()),
            shading, "one error per vertex");
  }
  if (const auto problem = options.problem()) throw InvalidInput(*problem);

  Image image(options.width, options.height, background(0));
  Scene scene;
  Points framed(0, 3);  // what the camera must show
  const double radius = line_radius(options);

  // Values to be mapped to colours.
  Eigen::VectorXd values;
  ColourScale scale;
  bool with_bar = true;
  if (shading == Shading::Error) {
    values = subject.errors * subject.error_scale;
    scale = error_scale(values, subject.error_unit, options.range);
  } else if (shading == Shading::MeanCurvature || shading == Shading::GaussianCurvature) {
    const bool gaussian = shading == Shading::GaussianCurvature;
    values = curvature_values(*mesh, gaussian);
    scale = curvature_scale(values, gaussian ? "Gaussian curvature" : "mean curvature", options.range);
  } else {
    with_bar = false;
  }
  const ColourTable table(scale);

  Points normals;
  const bool gauss_map = shading == Shading::GaussMap;
  if (gauss_map) {
    add_gauss_map(scene, subject, radius);
    framed = ball(8).positions;
  } else {
    if (mesh != nullptr) {
      scene.positions = mesh->positions;
      scene.triangles = mesh->triangles;
      normals = corner_normals(*mesh, options);
      std::vector<char> used(mesh->n_vertices(), 0);
      for (Eigen::Index i = 0; i < mesh->triangles.size(); ++i) used[mesh->triangles.data()[i]] = 1;
      framed.resize(mesh->n_vertices(), 3);
      Eigen::Index n = 0;
      for (Eigen::Index v = 0; v < mesh->n_vertices(); ++v)
        if (used[v] != 0) framed.row(n++) = mesh->positions.row(v);
      framed.conservativeResize(n, 3);
    }
    if (network != nullptr) {
      Points on_curves(0, 3);
      for (const NetworkCurve& curve : network->curves) {
        Points points(static_cast<Eigen::Index>(curve.vertices.size()), 3);
        for (std::size_t i = 0; i < curve.vertices.size(); ++i)
          points.row(static_cast<Eigen::Index>(i)) = network->positions.row(curve.vertices[i]);
        add_points(on_curves, points);
      }
      add_points(framed, on_curves);
      const bool coloured = shading == Shading::Error && mesh == nullptr;
      add_network(scene, *network, (mesh == nullptr ? 1.5 : 1.0) * radius, coloured ? &values : nullptr,
                  coloured ? &table : nullptr);
      if (shading == Shading::Porcupine)
        add_points(framed, add_porcupine(scene, *network, radius, bounding_box_diagonal(on_curves)));
    }
  }

  const double margin = 0.05 * std::min(options.width, options.height);
  const double room = with_bar ? bar_width(options.width, options.height) : 0;
  const Camera camera(framed, options.view, margin, margin, options.width - 2 * margin - room,
                      options.height - 2 * margin);

  Lighting lighting;
  lighting.up = (camera.rotation() * Vector3d::Unit(options.view.up_axis)).cast<float>();
  const Eigen::Matrix3d& to_camera = camera.rotation();
  const double edge_half_width = 0.32 * radius;

  const Shader shader = [&](const Hit& hit) -> Colour {
    const Vector3f viewer = hit.viewer.cast<float>();
    if (hit.tube >= 0)
      return lighting.matt(hit.normal.cast<float>(), viewer, 1.1F * scene.tubes[hit.tube].colour);
    // The side that is seen decides; a normal that leans away at the outline is kept, as on a smooth surface.
    const bool inside = hit.normal.dot(hit.viewer) < 0;
    Vector3d smooth = hit.normal;
    if (gauss_map) {
      smooth = to_camera * (hit.weights[0] * scene.positions.row(scene.triangles(hit.triangle, 0)) +
                            hit.weights[1] * scene.positions.row(scene.triangles(hit.triangle, 1)) +
                            hit.weights[2] * scene.positions.row(scene.triangles(hit.triangle, 2)))
                               .transpose();
    } else {
      const Eigen::RowVector3d n = hit.weights[0] * normals.row(3 * hit.triangle) +
                                   hit.weights[1] * normals.row(3 * hit.triangle + 1) +
                                   hit.weights[2] * normals.row(3 * hit.triangle + 2);
      if (n.squaredNorm() > 0) smooth = to_camera * n.transpose();
    }
    smooth.normalize();
    if (inside) smooth = -smooth;
    const Vector3f n = smooth.cast<float>();
    switch (shading) {
      case Shading::Shaded:
        return lighting.matt(n, viewer, inside ? kInside : kClay);
      case Shading::Porcupine:
      case Shading::GaussMap:
        return lighting.matt(n, viewer, kPale);
      case Shading::Wireframe: {
        // Distance to the nearest edge in pixels from the heights of the triangle, so that every line has the
        // same width and is hidden exactly where its triangle is.
        double nearest = std::numeric_limits<double>::infinity();
        const Vector3d corners[3] = {scene.positions.row(scene.triangles(hit.triangle, 0)),
                                     scene.positions.row(scene.triangles(hit.triangle, 1)),
                                     scene.positions.row(scene.triangles(hit.triangle, 2))};
        const double area2 = (corners[1] - corners[0]).cross(corners[2] - corners[0]).norm();
        for (int k = 0; k < 3; ++k) {
          const double edge = (corners[(k + 2) % 3] - corners[(k + 1) % 3]).norm();
          if (!(edge > 0)) continue;
          // Foreshortened by the slope across the edge.
          const Vector3d along = to_camera * (corners[(k + 2) % 3] - corners[(k + 1) % 3]) / edge;
          const Vector3d across = hit.normal.cross(along);
          const double lean = across.dot(hit.viewer);
          const double height = hit.weights[k] * area2 / edge * std::sqrt(std::max(0.0, 1 - lean * lean));
          nearest = std::min(nearest, height / hit.pixel_size);
        }
        const auto line = static_cast<float>(std::clamp(edge_half_width + 0.5 - nearest, 0.0, 1.0));
        const Colour surface = lighting.matt(n, viewer, inside ? kInside : kPale);
        return (1 - 0.85F * line) * surface + 0.85F * line * hex_colour(0x33445c);
      }
      case Shading::Isophotes:
        return isophote(n, lighting, options.stripes);
      case Shading::ReflectionLines:
        return reflection(n, viewer, lighting, options.stripes);
      case Shading::NormalMap:
        return normal_circles(n, viewer);
      case Shading::MeanCurvature:
      case Shading::GaussianCurvature:
      case Shading::Error: {
        const double value = hit.weights[0] * values[scene.triangles(hit.triangle, 0)] +
                             hit.weights[1] * values[scene.triangles(hit.triangle, 1)] +
                             hit.weights[2] * values[scene.triangles(hit.triangle, 2)];
        return lighting.mapped(n, table(value));
      }
    }
    return kGrey;
  };
  rasterise(image, scene, camera, options.samples, shader, background, progress);
  if (with_bar) draw_bar(image, scale);
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
    std::string name(shading_name(shadings[i]));
    std::replace(name.begin(), name.end(), '-', ' ');
    draw_text(sheet, x + 0.5 * width, y + height - 0.8 * cap, name, cap, kInk, Align::Centre);
  }
  return sheet;
}

}  // namespace batten
