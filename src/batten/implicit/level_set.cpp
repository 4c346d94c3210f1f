#include "batten/implicit/level_set.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include <CGAL/Complex_2_in_triangulation_3.h>
#include <CGAL/Implicit_surface_3.h>
#include <CGAL/Surface_mesh_default_triangulation_3.h>
#include <CGAL/make_surface_mesh.h>
#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/mesh/adjacency.hpp"
#include "batten/mesh/mending.hpp"

namespace batten {

namespace {

/// A vertex or cell that knows when it was made, so that sets of them are in that order and not in that of
/// memory: the same field gives the same triangles.
template <typename Base>
class Stamped : public Base {
 public:
  using Base::Base;
  template <typename Structure>
  struct Rebind_TDS {  // NOLINT(readability-identifier-naming): a name of CGAL
    using Other = Stamped<typename Base::template Rebind_TDS<Structure>::Other>;
  };
  using Has_timestamp = CGAL::Tag_true;  // NOLINT(readability-identifier-naming)
  std::size_t time_stamp() const { return stamp_; }
  void set_time_stamp(std::size_t stamp) { stamp_ = stamp; }

 private:
  std::size_t stamp_ = std::size_t(-1);
};

// CGAL's Surface_mesh_default_triangulation_3, stamped.
using Traits = CGAL::Robust_circumcenter_traits_3<CGAL::Exact_predicates_inexact_constructions_kernel>;
using Cell =
    CGAL::Delaunay_triangulation_cell_base_with_circumcenter_3<Traits,
                                                               CGAL::Surface_mesh_cell_base_3<Traits>>;
using Triangulation = CGAL::Delaunay_triangulation_3<
    Traits,
    CGAL::Triangulation_data_structure_3<Stamped<CGAL::Surface_mesh_vertex_base_3<Traits>>, Stamped<Cell>>>;
using Complex = CGAL::Complex_2_in_triangulation_3<Triangulation>;
using Kernel = Triangulation::Geom_traits;

/// How near the mesher goes to f = 0 by halving, ÷ radius of its sphere, and the Newton steps after that.
constexpr double kPrecision = 1e-4;
constexpr int kNewtonSteps = 2;
/// Values of f for each triangle, as measured; progress is told by them.
constexpr double kValuesPerTriangle = 200;
constexpr long kValuesPerReport = 2000;
/// The surface of a body, ÷ square of its diameter, when nothing else is known.
constexpr double kUsualArea = 1.2;
/// Radius of the circle around an equilateral triangle ÷ its edge, and what refinement leaves of a bound on
/// it.
constexpr double kRadiusOfEdge = 0.577, kRefined = 1.35;

/// Refinement that took so many times the usual number of values of f does not end: it splits triangles of
/// angles that it cannot mend, where f = 0 meets itself or the border.
constexpr double kMostValues = 2;

struct TooManyValues {};

/// The field as the mesher asks for it: a third of the questions come again soon, at the centres of cells.
class Asked {
 public:
  Asked(const ScalarField& field, double expected, const Progress& progress)
      : field_(&field), expected_(expected), progress_(&progress), answers_(kKept) {}

  Kernel::FT operator()(const Kernel::Point_3& p) const {
    Answer& answer = answers_[place_of(p)];
    if (answer.x == p.x() && answer.y == p.y() && answer.z == p.z()) return answer.value;
    if (++count_ % kValuesPerReport == 0) {
      progress_->report("mesh", std::min(1.0, static_cast<double>(count_) / expected_));
      if (static_cast<double>(count_) > kMostValues * expected_) throw TooManyValues{};
    }
    answer = {p.x(), p.y(), p.z(), field_->value({p.x(), p.y(), p.z()})};
    return answer.value;
  }

 private:
  struct Answer {
    double x = std::numeric_limits<double>::quiet_NaN(), y = 0, z = 0, value = 0;
  };
  static constexpr std::size_t kKept = 1U << 15U;
  static std::size_t place_of(const Kernel::Point_3& p) {
    const std::hash<double> hash;
    return (hash(p.x()) ^ (3 * hash(p.y())) ^ (5 * hash(p.z()))) % kKept;
  }

  const ScalarField* field_;
  double expected_;
  const Progress* progress_;
  mutable long count_ = 0;
  mutable std::vector<Answer> answers_;
};

/// @param seeds of the vertices, which stay where they are; the others go the rest of the way to f = 0.
TriangleMesh mesh_of(const Complex& complex, const ScalarField& field,
                     const std::unordered_set<const void*>& seeds) {
  std::unordered_map<const void*, int> number;
  std::vector<Eigen::Vector3d> positions;
  const auto number_of = [&](const Triangulation::Vertex_handle& v) {
    const auto [at, is_new] = number.try_emplace(&*v, static_cast<int>(positions.size()));
    if (is_new) {
      Eigen::Vector3d x(v->point().x(), v->point().y(), v->point().z());
      for (int step = 0; step < kNewtonSteps && seeds.count(&*v) == 0; ++step) {
        const Eigen::Vector3d gradient = field.gradient(x);
        if (gradient.squaredNorm() > 0) x -= field.value(x) / gradient.squaredNorm() * gradient;
      }
      positions.push_back(x);
    }
    return at->second;
  };
  std::vector<Eigen::Vector3i> triangles;
  for (auto facet = complex.facets_begin(); facet != complex.facets_end(); ++facet) {
    Eigen::Vector3i corners;
    for (int k = 0; k < 3; ++k) corners[k] = number_of(facet->first->vertex((facet->second + 1 + k) % 4));
    triangles.push_back(corners);
  }
  TriangleMesh mesh;
  mesh.positions.resize(static_cast<Eigen::Index>(positions.size()), 3);
  for (std::size_t v = 0; v < positions.size(); ++v)
    mesh.positions.row(static_cast<Eigen::Index>(v)) = positions[v];
  mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t f = 0; f < triangles.size(); ++f) {
    Eigen::Vector3i t = triangles[f];
    const Eigen::Vector3d &a = positions[at(t[0])], &b = positions[at(t[1])], &c = positions[at(t[2])];
    if ((b - a).cross(c - a).dot(field.gradient((a + b + c) / 3)) < 0) std::swap(t[1], t[2]);
    mesh.triangles.row(static_cast<Eigen::Index>(f)) = t;
  }
  return mesh;
}

/// Nothing where refinement does not end.
/// @param Manifold CGAL's tag of what the triangles are to be.
template <typename Manifold>
std::optional<TriangleMesh> refined_mesh(const ScalarField& field, const Points& seeds, double margin,
                                         const LevelSetOptions& options, double expected_values,
                                         const Progress& progress) {
  Triangulation triangulation;
  std::unordered_set<const void*> seed_vertices;
  for (const auto& seed : seeds.rowwise())
    seed_vertices.insert(&*triangulation.insert(Kernel::Point_3(seed[0], seed[1], seed[2])));
  if (triangulation.dimension() < 3) throw InvalidInput("the seeds of a level set lie in a plane");
  Complex complex(triangulation);
  const Eigen::Vector3d middle = 0.5 * (seeds.colwise().minCoeff() + seeds.colwise().maxCoeff()).transpose();
  const double radius = bounding_box_diagonal(seeds) / 2 + margin;
  const CGAL::Implicit_surface_3<Kernel, Asked> surface(
      Asked(field, expected_values, progress),
      Kernel::Sphere_3({middle[0], middle[1], middle[2]}, radius * radius), kPrecision);
  const CGAL::Surface_mesh_default_criteria_3<Triangulation> criteria(
      options.smallest_angle, kRadiusOfEdge * kRefined * options.edge_length,
      options.flatness * options.edge_length);
  try {
    CGAL::make_surface_mesh(complex, surface, criteria, Manifold(), 0);
  } catch (const TooManyValues&) {
    return std::nullopt;
  }
  return mesh_of(complex, field, seed_vertices);
}

}  // namespace

std::optional<std::string> LevelSetOptions::problem() const {
  if (!(edge_length > 0) || !std::isfinite(edge_length))
    return concat("edge_length must be positive, got ", edge_length);
  if (!(flatness > 0) || !std::isfinite(flatness)) return concat("flatness must be positive, got ", flatness);
  if (!(smallest_angle >= 0 && smallest_angle <= 30))
    return concat("smallest_angle must be 0 to 30 degrees, got ", smallest_angle);
  if (!(max_triangles > 0)) return concat("max_triangles must be positive, got ", max_triangles);
  return std::nullopt;
}

TriangleMesh level_set(const ScalarField& field, const Points& seeds, double margin,
                       const LevelSetOptions& options, const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  if (seeds.rows() < 4) throw InvalidInput(concat("a level set needs 4 seeds or more, got ", seeds.rows()));
  const double diameter = bounding_box_diagonal(seeds);
  const double expected =
      kUsualArea * diameter * diameter / (std::sqrt(3.0) / 4 * options.edge_length * options.edge_length);
  if (expected > options.max_triangles)
    throw InvalidInput(concat("edges of ", options.edge_length, " would give about ", expected,
                              " triangles; at most ", options.max_triangles,
                              " are made (longer edges, or a higher limit)"));
  const double values = kValuesPerTriangle * expected;
  std::optional<TriangleMesh> refined =
      refined_mesh<CGAL::Manifold_with_boundary_tag>(field, seeds, margin, options, values, progress);
  if (!refined) {
    LevelSetOptions uneven = options;
    uneven.smallest_angle = 0;
    refined = refined_mesh<CGAL::Manifold_with_boundary_tag>(field, seeds, margin, uneven, values, progress);
  }
  if (!refined)
    throw InvalidInput(
        concat("triangles with edges of ", options.edge_length,
               " do not follow the surface, which meets itself or frays at its border; shorter edges or "
               "strokes around the whole body are needed"));
  // Triangles that close every opening are asked for only where there is one: that need not end.
  if (options.closed && mesh_topology(refined->triangles, refined->n_vertices()).n_boundary_edges > 0)
    if (auto closed = refined_mesh<CGAL::Manifold_tag>(field, seeds, margin, options, values, progress))
      refined = std::move(closed);
  TriangleMesh mesh = std::move(*refined);
  if (mesh.n_triangles() == 0) return mesh;
  // Where the surface turns within a triangle its gradient may point back; neighbours know better.
  if (!mesh_topology(mesh.triangles, mesh.n_vertices()).is_oriented()) {
    MendingOptions mending;
    mending.weld = false;
    mesh = mended_mesh(mesh, mending).mesh;
  }
  return mesh;
}

}  // namespace batten
