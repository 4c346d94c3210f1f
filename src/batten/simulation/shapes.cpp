#include "batten/simulation/shapes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"

namespace batten {

namespace {

using Eigen::Vector3d;

// Knots of the traced curves, in diameters: small against every radius of curvature of the shapes.
constexpr double kTraceStep = 0.005;
// Crossings are searched at this spacing, in diameters; no two of a curve with one plane are nearer.
constexpr double kSearchStep = 0.02;

// --- The surfaces ----------------------------------------------------------------------------------------

const Vector3d kEllipsoidAxes(1.5, 1, 0.7);
constexpr double kTorusRadius = 4;
constexpr double kTubeRadius = 2;
constexpr double kConeSlope = 0.25;  // radius kConeSlope · (kConeTip − z)
constexpr double kConeTip = 2;
constexpr double kConeBottom = 0.1;
constexpr double kConeTop = 1.7;

double cone_radius(double z) {
  return kConeSlope * (kConeTip - z);
}

/// Height and its derivatives of the height fields.
struct Height {
  double z, dx, dy;
};

Height saddle_height(double x, double y) {
  return {0.35 * (x * x - y * y), 0.7 * x, -0.7 * y};
}

Height waves_height(double x, double y) {
  return {0.12 * std::sin(3 * x) * std::cos(2.5 * y) + 0.2 * x * x,
          0.36 * std::cos(3 * x) * std::cos(2.5 * y) + 0.4 * x, -0.3 * std::sin(3 * x) * std::sin(2.5 * y)};
}

Height dish_height(double x, double y) {
  // cos(3φ) r³ = x³ − 3 x y²
  return {0.18 * (x * x * x - 3 * x * y * y) + 0.12 * (x * x + y * y),
          0.18 * (3 * x * x - 3 * y * y) + 0.24 * x, -1.08 * x * y + 0.24 * y};
}

using HeightField = Height (*)(double, double);

HeightField height_field(AnalyticShape shape) {
  if (shape == AnalyticShape::Saddle) return saddle_height;
  if (shape == AnalyticShape::Waves) return waves_height;
  return dish_height;
}

ImplicitFunction below_height(HeightField height) {
  return [height](const Vector3d& x, Vector3d& gradient) {
    const Height h = height(x.x(), x.y());
    gradient = {-h.dx, -h.dy, 1};
    return x.z() - h.z;
  };
}

double bumpy_cube(const Vector3d& x, Vector3d& gradient) {
  const Vector3d c = (3 * x.array()).cos();
  const Vector3d s = (3 * x.array()).sin();
  gradient = 4 * x.array().cube();
  gradient -= 0.36 * Vector3d(s.x() * c.y() * c.z(), c.x() * s.y() * c.z(), c.x() * c.y() * s.z());
  return x.array().square().square().sum() - 1 + 0.12 * c.prod();
}

// --- The curves ------------------------------------------------------------------------------------------

ImplicitFunction plane(const Vector3d& normal, double offset) {
  return [normal, offset](const Vector3d& x, Vector3d& gradient) {
    gradient = normal;
    return normal.dot(x) - offset;
  };
}

ImplicitFunction unit_cylinder() {
  return [](const Vector3d& x, Vector3d& gradient) {
    gradient = {2 * x.x(), 2 * x.y(), 0};
    return x.head<2>().squaredNorm() - 1;
  };
}

/// A curve to be traced.
struct Section {
  std::string name;
  bool boundary;
  ImplicitFunction cut;
  Vector3d start;
  Vector3d towards;
  bool closed = true;
  Vector3d end{0, 0, 0};
};

const char* axis_name(int axis) {
  return axis == 0 ? "x" : axis == 1 ? "y" : "z";
}

/// The closed section of a star-shaped surface with the plane (axis) = value. `start` need only be near.
Section closed_section(int axis, double value, Vector3d start) {
  start[axis] = value;
  const Vector3d normal = Vector3d::Unit(axis);
  // Counter-clockwise about the axis.
  return {concat(axis_name(axis), " = ", value), false, plane(normal, value), start, normal.cross(start)};
}

/// The piece of a height field over the line from `a` to `b` in the plane z = 0.
Section line_section(HeightField height, const std::string& name, bool boundary, Eigen::Vector2d a,
                     Eigen::Vector2d b) {
  const Eigen::Vector2d d = (b - a).normalized();
  const Vector3d normal(-d.y(), d.x(), 0);
  const Vector3d start(a.x(), a.y(), height(a.x(), a.y()).z);
  const Vector3d end(b.x(), b.y(), height(b.x(), b.y()).z);
  return {name, boundary, plane(normal, normal.dot(start)), start, {d.x(), d.y(), 0}, false, end};
}

std::vector<Section> square_sections(HeightField height, const std::vector<double>& lines) {
  std::vector<Section> sections = {line_section(height, "border y = -1", true, {-1, -1}, {1, -1}),
                                   line_section(height, "border x = 1", true, {1, -1}, {1, 1}),
                                   line_section(height, "border y = 1", true, {1, 1}, {-1, 1}),
                                   line_section(height, "border x = -1", true, {-1, 1}, {-1, -1})};
  for (const double x : lines)
    sections.push_back(line_section(height, concat("x = ", x), false, {x, -1}, {x, 1}));
  for (const double y : lines)
    sections.push_back(line_section(height, concat("y = ", y), false, {-1, y}, {1, y}));
  return sections;
}

std::vector<Section> dish_sections() {
  std::vector<Section> sections;
  sections.push_back({"border", true, unit_cylinder(), {1, 0, dish_height(1, 0).z}, {0, 1, 0}});
  for (const double x : {-0.4, 0.35}) {
    const double y = std::sqrt(1 - x * x);
    sections.push_back(line_section(dish_height, concat("x = ", x), false, {x, -y}, {x, y}));
  }
  for (const double y : {-0.45, 0.1}) {
    const double x = std::sqrt(1 - y * y);
    sections.push_back(line_section(dish_height, concat("y = ", y), false, {-x, y}, {x, y}));
  }
  return sections;
}

std::vector<Section> star_sections(const std::vector<double>& values, double radius) {
  std::vector<Section> sections;
  for (int axis = 0; axis < 3; ++axis)
    for (const double value : values) {
      Vector3d start = Vector3d::Zero();
      start[(axis + 1) % 3] = radius;
      sections.push_back(closed_section(axis, value, start));
    }
  return sections;
}

std::vector<Section> ellipsoid_sections() {
  std::vector<Section> sections = {closed_section(0, -0.6, {0, 0.9, 0}), closed_section(0, 0.6, {0, 0.9, 0}),
                                   closed_section(1, 0, {1.5, 0, 0}), closed_section(2, 0, {1.5, 0, 0})};
  sections.push_back({"y + z = 0", false, plane(Vector3d(0, 1, 1).normalized(), 0), {1.5, 0, 0}, {0, 1, -1}});
  return sections;
}

std::vector<Section> torus_sections() {
  std::vector<Section> sections;
  for (const double z : {0.0, 1.2, -1.2})
    for (const double side : {1.0, -1.0}) {
      const double radius = kTorusRadius + side * std::sqrt(kTubeRadius * kTubeRadius - z * z);
      Section circle = closed_section(2, z, {radius, 0, 0});
      circle.name = concat(side > 0 ? "outer" : "inner", " circle z = ", z);
      sections.push_back(circle);
    }
  for (int k = 0; k < 6; ++k) {
    const double phi = k * kPi / 3;
    const Vector3d out(std::cos(phi), std::sin(phi), 0);
    const Vector3d across(-out.y(), out.x(), 0);
    sections.push_back({concat("meridian ", 60 * k, " degrees"),
                        false,
                        plane(across, 0),
                        (kTorusRadius + kTubeRadius) * out,
                        {0, 0, 1}});
  }
  return sections;
}

std::vector<Section> cone_sections() {
  // The border runs with the surface on its left, seen from outside.
  Section bottom = closed_section(2, kConeBottom, {cone_radius(kConeBottom), 0, 0});
  Section top = closed_section(2, kConeTop, {cone_radius(kConeTop), 0, 0});
  bottom.name = "bottom";
  top.name = "top";
  top.towards = -top.towards;
  bottom.boundary = top.boundary = true;
  std::vector<Section> sections = {bottom, top};
  for (int k = 0; k < 3; ++k) {
    const double phi = 0.2 + k * 2 * kPi / 3;
    const Vector3d out(std::cos(phi), std::sin(phi), 0);
    const Vector3d up(0, 0, 1);
    sections.push_back({concat("generator ", k + 1), false, plane(Vector3d(-out.y(), out.x(), 0), 0),
                        cone_radius(kConeBottom) * out + kConeBottom * up, up, false,
                        cone_radius(kConeTop) * out + kConeTop * up});
  }
  return sections;
}

std::vector<Section> sections_of(AnalyticShape shape) {
  switch (shape) {
    case AnalyticShape::Sphere:
      return star_sections({0}, 1);
    case AnalyticShape::Sphere6:
      return star_sections({-0.45, 0.45}, 0.9);
    case AnalyticShape::Ellipsoid:
      return ellipsoid_sections();
    case AnalyticShape::Torus:
      return torus_sections();
    case AnalyticShape::BumpyCube:
      return star_sections({-0.5, 0, 0.5}, 1);
    case AnalyticShape::Saddle:
      return square_sections(saddle_height, {-0.33, 0.33});
    case AnalyticShape::Waves:
      return square_sections(waves_height, {-0.5, 0, 0.5});
    case AnalyticShape::Dish:
      return dish_sections();
    case AnalyticShape::Cone:
      return cone_sections();
  }
  throw InvalidInput("unknown shape");
}

// --- The crossings ---------------------------------------------------------------------------------------

/// A closed curve that begins elsewhere.
class ShiftedCurve : public ArcLengthCurve {
 public:
  ShiftedCurve(std::shared_ptr<const ArcLengthCurve> base, double shift)
      : base_(std::move(base)), shift_(shift) {}
  double length() const override { return base_->length(); }
  CurvePoint at(double distance) const override {
    const double s = std::clamp(distance, 0.0, length()) + shift_;
    return base_->at(s > length() ? s - length() : s);
  }

 private:
  std::shared_ptr<const ArcLengthCurve> base_;
  double shift_;
};

/// Where a curve passes through the zeros of `cut`: distances along the curve.
std::vector<double> passages(const ArcLengthCurve& path, bool closed, const ImplicitFunction& cut,
                             double step, double tolerance) {
  const double length = path.length();
  const int pieces = std::max(8, static_cast<int>(std::ceil(length / step)));
  const auto value_at = [&](double s, double& slope) {
    const CurvePoint point = path.at(s);
    Vector3d gradient;
    const double value = cut(point.position, gradient);
    slope = gradient.dot(point.tangent);
    return value / gradient.norm();
  };
  std::vector<double> found;
  const auto add = [&](double s) {
    for (const double other : found) {
      const double gap = std::abs(s - other);
      if (gap < tolerance || (closed && length - gap < tolerance)) return;
    }
    found.push_back(s);
  };
  double slope = 0;
  double low = 0;
  const double value_at_start = value_at(0, slope);
  double value_low = value_at_start;
  // Ends of open curves lie on the curve that they end at; rounding decides on the sign there.
  if (!closed && std::abs(value_low) < tolerance) add(0);
  if (!closed && std::abs(value_at(length, slope)) < tolerance) add(length);
  for (int i = 1; i <= pieces; ++i) {
    const double high = length * i / pieces;
    // Back at the start of a closed curve the value must be that of the start, or rounding could hide a
    // passage just there.
    const double value_high = closed && i == pieces ? value_at_start : value_at(high, slope);
    if ((value_low < 0) != (value_high < 0)) {
      double a = low;
      double b = high;
      double s = low + (high - low) * value_low / (value_low - value_high);
      for (int iteration = 0; iteration < 60; ++iteration) {  // Newton, kept inside by bisection
        const CurvePoint point = path.at(s);
        Vector3d gradient;
        const double value = cut(point.position, gradient);
        ((value < 0) == (value_low < 0) ? a : b) = s;
        double next = s - value / gradient.dot(point.tangent);
        if (!(next >= a && next <= b)) next = (a + b) / 2;
        const double change = std::abs(next - s);
        s = next;
        if (change <= 1e-15 * length) break;
      }
      add(s);
    }
    low = high;
    value_low = value_high;
  }
  std::sort(found.begin(), found.end());
  return found;
}

/// Finds the nodes: points where two curves pass through each other's cuts.
void find_nodes(TracedNetwork& traced, const std::vector<Section>& sections,
                const ImplicitFunction& surface) {
  const double tolerance = 1e-9 * traced.diameter;
  const size_t n = traced.curves.size();
  struct Candidate {
    size_t curve, other;
    double distance;
    Vector3d position;
  };
  std::vector<Candidate> candidates;
  for (size_t a = 0; a < n; ++a)
    for (size_t b = 0; b < n; ++b) {
      if (a == b) continue;
      const TracedCurve& curve = traced.curves[a];
      const std::vector<double> distances =
          passages(*curve.path, curve.closed, sections[b].cut, kSearchStep * traced.diameter, tolerance);
      for (const double s : distances) candidates.push_back({a, b, s, curve.path->at(s).position});
    }
  std::vector<Vector3d> nodes;
  std::vector<std::vector<std::pair<double, int>>> on_curve(n);
  for (const Candidate& one : candidates) {
    const bool meets = std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& two) {
      return two.curve == one.other && two.other == one.curve &&
             (two.position - one.position).norm() < tolerance;
    });
    if (!meets) continue;  // the plane cuts the other curve elsewhere
    const auto same = std::find_if(nodes.begin(), nodes.end(), [&](const Vector3d& node) {
      return (node - one.position).norm() < tolerance;
    });
    const int id = static_cast<int>(same - nodes.begin());
    if (same == nodes.end()) nodes.push_back(one.position);
    auto& list = on_curve[one.curve];
    const bool listed =
        std::any_of(list.begin(), list.end(), [id](const auto& entry) { return entry.second == id; });
    if (!listed) list.emplace_back(one.distance, id);
  }
  traced.node_positions.resize(static_cast<Eigen::Index>(nodes.size()), 3);
  traced.node_normals.resize(static_cast<Eigen::Index>(nodes.size()), 3);
  for (size_t v = 0; v < nodes.size(); ++v) {
    Vector3d gradient;
    surface(nodes[v], gradient);
    traced.node_positions.row(static_cast<Eigen::Index>(v)) = nodes[v];
    traced.node_normals.row(static_cast<Eigen::Index>(v)) = gradient.normalized();
  }
  for (size_t c = 0; c < n; ++c) {
    TracedCurve& curve = traced.curves[c];
    auto& list = on_curve[c];
    std::sort(list.begin(), list.end());
    if (list.empty()) continue;
    const double shift = curve.closed ? list.front().first : 0;
    if (shift > 0) curve.path = std::make_shared<ShiftedCurve>(curve.path, shift);
    for (const auto& [distance, id] : list) {
      curve.node_distances.push_back(distance - shift);
      curve.node_ids.push_back(id);
    }
    if (curve.closed) {
      curve.node_distances.push_back(curve.path->length());
      curve.node_ids.push_back(list.front().second);
    }
  }
}

// --- The meshes ------------------------------------------------------------------------------------------

/// Appends the two triangles of the quadrilateral a b c d, counter-clockwise.
void add_quad(std::vector<Eigen::Vector3i>& triangles, int a, int b, int c, int d) {
  triangles.emplace_back(a, b, c);
  triangles.emplace_back(a, c, d);
}

/// Arrays under construction.
struct MeshBuilder {
  std::vector<Vector3d> positions;
  std::vector<Eigen::Vector3i> triangles;

  int add(const Vector3d& p) {
    positions.push_back(p);
    return static_cast<int>(positions.size()) - 1;
  }

  TriangleMesh finish(const ImplicitFunction& surface) const {
    TriangleMesh mesh;
    mesh.positions.resize(static_cast<Eigen::Index>(positions.size()), 3);
    mesh.normals.resize(static_cast<Eigen::Index>(positions.size()), 3);
    for (size_t v = 0; v < positions.size(); ++v) {
      Vector3d gradient;
      surface(positions[v], gradient);
      mesh.positions.row(static_cast<Eigen::Index>(v)) = positions[v];
      mesh.normals.row(static_cast<Eigen::Index>(v)) = gradient.normalized();
    }
    mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
    for (size_t f = 0; f < triangles.size(); ++f)
      mesh.triangles.row(static_cast<Eigen::Index>(f)) = triangles[f];
    return mesh;
  }
};

/// The unit sphere as an octahedron whose edges are split into n, each vertex moved by `place`.
MeshBuilder star_mesh(int n, const std::function<Vector3d(const Vector3d&)>& place) {
  MeshBuilder mesh;
  // Latitude ring k of 0 … 2n has 4 min(k, 2n − k) vertices, one at each pole.
  std::vector<int> first(static_cast<size_t>(2 * n) + 2, 0);
  const auto ring_size = [n](int k) { return k == 0 || k == 2 * n ? 1 : 4 * std::min(k, 2 * n - k); };
  for (int k = 0; k <= 2 * n; ++k) {
    const int size = ring_size(k);
    first[static_cast<size_t>(k) + 1] = first[static_cast<size_t>(k)] + size;
    const int side = std::max(1, size / 4);
    for (int j = 0; j < size; ++j) {
      // A point of the octahedron |x| + |y| + |z| = n, walking round the square of the ring.
      const int quarter = j / side;
      const double along = j % side;
      const double reach = size == 1 ? 0 : side;
      const double x[4] = {reach - along, -along, along - reach, along};
      const double y[4] = {along, reach - along, -along, along - reach};
      const Vector3d p(size == 1 ? 0 : x[quarter], size == 1 ? 0 : y[quarter], n - k);
      mesh.add(place(p.normalized()));
    }
  }
  // Two neighbouring rings are zipped quarter by quarter.
  const auto zip = [&](int inner, int outer, bool up) {  // up: the inner ring is nearer to the north pole
    const int inner_size = ring_size(inner);
    const int outer_size = ring_size(outer);
    const int side = outer_size / 4;
    const auto vertex = [&](int ring, int size, int j) {
      return first[static_cast<size_t>(ring)] + j % size;
    };
    for (int q = 0; q < 4; ++q)
      for (int j = 0; j < side; ++j) {
        const int o0 = vertex(outer, outer_size, q * side + j);
        const int o1 = vertex(outer, outer_size, q * side + j + 1);
        const int i0 = vertex(inner, inner_size, q * (side - 1) + j);
        if (up)
          mesh.triangles.emplace_back(o0, o1, i0);
        else
          mesh.triangles.emplace_back(o0, i0, o1);
        if (j + 1 == side) continue;
        const int i1 = vertex(inner, inner_size, q * (side - 1) + j + 1);
        if (up)
          mesh.triangles.emplace_back(i0, o1, i1);
        else
          mesh.triangles.emplace_back(i0, i1, o1);
      }
  };
  for (int k = 0; k < n; ++k) zip(k, k + 1, true);
  for (int k = 2 * n; k > n; --k) zip(k, k - 1, false);
  return mesh;
}

/// A grid of nu × nv cells; closed directions wrap around. `place` maps (i / nu, j / nv), and its partial
/// derivatives in this order make a right hand with the outward normal.
MeshBuilder grid_mesh(int nu, int nv, bool wrap_u, bool wrap_v,
                      const std::function<Vector3d(double, double)>& place) {
  MeshBuilder mesh;
  const int columns = wrap_u ? nu : nu + 1;
  const int rows = wrap_v ? nv : nv + 1;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i)
      mesh.add(place(static_cast<double>(i) / nu, static_cast<double>(j) / nv));
  const auto vertex = [=](int i, int j) { return (j % rows) * columns + i % columns; };
  for (int j = 0; j < nv; ++j)
    for (int i = 0; i < nu; ++i)
      add_quad(mesh.triangles, vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1));
  return mesh;
}

/// The unit disc as `rings` rings of 6, 12, 18 … vertices.
MeshBuilder disc_mesh(int rings, const std::function<Vector3d(double, double)>& place) {
  MeshBuilder mesh;
  mesh.add(place(0, 0));
  const auto vertex = [](int ring, int j) {
    return ring == 0 ? 0 : 1 + 3 * ring * (ring - 1) + j % (6 * ring);
  };
  for (int ring = 1; ring <= rings; ++ring) {
    const double r = static_cast<double>(ring) / rings;
    for (int j = 0; j < 6 * ring; ++j) {
      const double phi = kPi * j / (3 * ring);
      mesh.add(place(r * std::cos(phi), r * std::sin(phi)));
    }
    for (int sector = 0; sector < 6; ++sector)
      for (int j = 0; j < ring; ++j) {
        const int o0 = vertex(ring, sector * ring + j);
        const int o1 = vertex(ring, sector * ring + j + 1);
        const int i0 = vertex(ring - 1, sector * (ring - 1) + j);
        mesh.triangles.emplace_back(o0, o1, i0);
        if (j + 1 < ring) mesh.triangles.emplace_back(i0, o1, vertex(ring - 1, sector * (ring - 1) + j + 1));
      }
  }
  return mesh;
}

/// The point of the bumpy cube in a direction; it is star-shaped about the origin.
Vector3d on_bumpy_cube(const Vector3d& direction) {
  double r = 1.1;
  for (int iteration = 0; iteration < 50; ++iteration) {
    Vector3d gradient;
    const double value = bumpy_cube(r * direction, gradient);
    const double change = value / gradient.dot(direction);
    r -= change;
    if (std::abs(change) < 1e-15) break;
  }
  return r * direction;
}

/// The mesh with edges of about `edge`, in the unit of the shape.
MeshBuilder build_mesh(AnalyticShape shape, double edge) {
  // Even numbers of cells put vertices on the symmetry planes, so that the box is met exactly.
  const auto cells = [edge](double length) {
    return std::max(8, 4 * static_cast<int>(std::ceil(length / edge / 4)));
  };
  switch (shape) {
    case AnalyticShape::Sphere:
    case AnalyticShape::Sphere6:
      return star_mesh(cells(kPi / 2), [](const Vector3d& d) { return d; });
    case AnalyticShape::Ellipsoid:
      return star_mesh(cells(kPi / 2 * kEllipsoidAxes.maxCoeff()),
                       [](const Vector3d& d) { return Vector3d(d.cwiseProduct(kEllipsoidAxes)); });
    case AnalyticShape::BumpyCube:
      return star_mesh(cells(2.0), on_bumpy_cube);
    case AnalyticShape::Torus:
      return grid_mesh(cells(2 * kPi * (kTorusRadius + kTubeRadius)), cells(2 * kPi * kTubeRadius), true,
                       true, [](double u, double v) {
                         const double phi = 2 * kPi * u;
                         const double rho = kTorusRadius + kTubeRadius * std::cos(2 * kPi * v);
                         return Vector3d(rho * std::cos(phi), rho * std::sin(phi),
                                         kTubeRadius * std::sin(2 * kPi * v));
                       });
    case AnalyticShape::Saddle:
    case AnalyticShape::Waves:
      return grid_mesh(cells(2), cells(2), false, false, [shape](double u, double v) {
        const double x = 2 * u - 1;
        const double y = 2 * v - 1;
        return Vector3d(x, y, height_field(shape)(x, y).z);
      });
    case AnalyticShape::Dish:
      return disc_mesh(cells(1), [](double x, double y) { return Vector3d(x, y, dish_height(x, y).z); });
    case AnalyticShape::Cone:
      return grid_mesh(cells(2 * kPi * cone_radius(kConeBottom)), cells((kConeTop - kConeBottom) * 1.03),
                       true, false, [](double u, double v) {
                         const double phi = 2 * kPi * u;
                         const double z = kConeBottom + v * (kConeTop - kConeBottom);
                         const double r = cone_radius(z);
                         return Vector3d(r * std::cos(phi), r * std::sin(phi), z);
                       });
  }
  throw InvalidInput("unknown shape");
}

double shape_diameter(AnalyticShape shape) {
  const TriangleMesh mesh = build_mesh(shape, 0.03).finish(shape_function(shape));
  return bounding_box_diagonal(mesh.positions);
}

}  // namespace

ImplicitFunction shape_function(AnalyticShape shape) {
  switch (shape) {
    case AnalyticShape::Sphere:
    case AnalyticShape::Sphere6:
      return [](const Vector3d& x, Vector3d& gradient) {
        gradient = 2 * x;
        return x.squaredNorm() - 1;
      };
    case AnalyticShape::Ellipsoid:
      return [](const Vector3d& x, Vector3d& gradient) {
        const Vector3d scaled = x.cwiseQuotient(kEllipsoidAxes);
        gradient = 2 * scaled.cwiseQuotient(kEllipsoidAxes);
        return scaled.squaredNorm() - 1;
      };
    case AnalyticShape::Torus:
      return [](const Vector3d& x, Vector3d& gradient) {
        const double rho = x.head<2>().norm();
        const double across = rho - kTorusRadius;
        gradient = {2 * across * x.x() / rho, 2 * across * x.y() / rho, 2 * x.z()};
        return across * across + x.z() * x.z() - kTubeRadius * kTubeRadius;
      };
    case AnalyticShape::BumpyCube:
      return bumpy_cube;
    case AnalyticShape::Saddle:
    case AnalyticShape::Waves:
    case AnalyticShape::Dish:
      return below_height(height_field(shape));
    case AnalyticShape::Cone:
      return [](const Vector3d& x, Vector3d& gradient) {
        const double r = cone_radius(x.z());
        gradient = {2 * x.x(), 2 * x.y(), 2 * kConeSlope * r};
        return x.head<2>().squaredNorm() - r * r;
      };
  }
  throw InvalidInput("unknown shape");
}

TracedNetwork trace_shape(AnalyticShape shape) {
  TracedNetwork traced;
  traced.name = word_of(shape);
  traced.diameter = shape_diameter(shape);
  const ImplicitFunction surface = shape_function(shape);
  const std::vector<Section> sections = sections_of(shape);
  for (const Section& section : sections) {
    TraceRequest request;
    request.surface = surface;
    request.cut = section.cut;
    request.start = section.start;
    request.towards = section.towards;
    request.closed = section.closed;
    request.end = section.end;
    request.step = kTraceStep * traced.diameter;
    TracedCurve curve;
    curve.name = section.name;
    curve.boundary = section.boundary;
    curve.closed = section.closed;
    curve.path = trace_intersection(request);
    traced.curves.push_back(std::move(curve));
  }
  find_nodes(traced, sections, surface);
  return traced;
}

TriangleMesh shape_mesh(AnalyticShape shape, double edge_length) {
  if (!(edge_length > 0 && edge_length <= 0.2))
    throw InvalidInput(
        concat("the edge length of a shape's mesh must lie in (0, 0.2] diameters, got ", edge_length));
  return build_mesh(shape, edge_length * shape_diameter(shape)).finish(shape_function(shape));
}

}  // namespace batten
