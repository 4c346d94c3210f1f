#include "batten/deformation/multiresolution.hpp"

#include <algorithm>

#include <Eigen/Geometry>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/deformation/local_rotations.hpp"
#include "batten/mesh/distance.hpp"
#include "batten/operators/laplacian.hpp"
#include "batten/simplification/simplify.hpp"

namespace batten {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Where a fine vertex lies relative to the base: on a triangle, and off it.
struct Binding {
  int corner[3];
  double weight[3];
};

/// The rigid motion that best carries the points a to b, applied to x. Fewer than three points have none but
/// their mean translation.
Vector3d carried(const Vector3d& x, const Points& a, const Points& b) {
  const Eigen::RowVector3d from = a.colwise().mean(), to = b.colwise().mean();
  Matrix3d R = Matrix3d::Identity();
  if (a.rows() >= 3) {
    Matrix3d C = (b.rowwise() - to).transpose() * (a.rowwise() - from);
    // Points on a line leave the turn about it open: the least one, then.
    C.diagonal().array() += 1e-6 * C.norm();
    R = nearest_rotation(C);
  }
  return to.transpose() + R * (x - from.transpose());
}

/// Per constrained vertex, by place in the list, the places of its constrained neighbours.
std::vector<std::vector<int>> constrained_neighbours(const Triangles& triangles,
                                                     const std::vector<int>& constrained, Eigen::Index n) {
  std::vector<int> place(n, -1);
  for (std::size_t c = 0; c < constrained.size(); ++c) place[constrained[c]] = static_cast<int>(c);
  std::vector<std::vector<int>> result(constrained.size());
  for (Eigen::Index f = 0; f < triangles.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = place[triangles(f, k)], b = place[triangles(f, (k + 1) % 3)];
      if (a < 0 || b < 0) continue;
      result[a].push_back(b);
      result[b].push_back(a);
    }
  return result;
}

/// Adds the neighbours of a set to it.
void widen(const std::vector<std::vector<int>>& neighbours, std::vector<int>& set) {
  const std::vector<int> before = set;
  for (const int c : before) set.insert(set.end(), neighbours[c].begin(), neighbours[c].end());
  std::sort(set.begin(), set.end());
  set.erase(std::unique(set.begin(), set.end()), set.end());
}

}  // namespace

struct MultiresolutionDeformer::Implementation {
  MultiresolutionOptions options;
  Points rest;
  TriangleMesh base;
  SparseMatrix base_stiffness;
  /// Per constrained vertex of the base, the rows of the fine targets that it stands for.
  std::vector<int> base_constrained;
  std::vector<std::vector<int>> rows;
  Points constrained_rest;           ///< of the fine mesh, in the order of the targets
  std::vector<Binding> bindings;     ///< per fine vertex
  std::unique_ptr<Deformer> coarse;  ///< null where the mesh is its own base
  std::unique_ptr<Deformer> fine;

  Points base_targets(const Points& targets) const {
    Points result(static_cast<Eigen::Index>(base_constrained.size()), 3);
    for (std::size_t c = 0; c < base_constrained.size(); ++c) {
      Points a(static_cast<Eigen::Index>(rows[c].size()), 3), b(a.rows(), 3);
      for (std::size_t i = 0; i < rows[c].size(); ++i) {
        a.row(static_cast<Eigen::Index>(i)) = constrained_rest.row(rows[c][i]);
        b.row(static_cast<Eigen::Index>(i)) = targets.row(rows[c][i]);
      }
      result.row(static_cast<Eigen::Index>(c)) =
          carried(base.positions.row(base_constrained[c]), a, b).transpose();
    }
    return result;
  }

  /// The fine vertices carried by the base: every corner of its base triangle carries a vertex along as its
  /// own one-ring turns; the three are mixed by the weights.
  Points with_detail(const Points& deformed_base) const {
    std::vector<Matrix3d> rotations;
    fit_local_rotations(base_stiffness, base.positions, deformed_base, rotations);
    Points result(rest.rows(), 3);
    for (Eigen::Index v = 0; v < rest.rows(); ++v) {
      Vector3d sum = Vector3d::Zero();
      for (int k = 0; k < 3; ++k) {
        const int c = bindings[v].corner[k];
        const Vector3d arm = rest.row(v) - base.positions.row(c), at = deformed_base.row(c);
        sum += bindings[v].weight[k] * (at + rotations[c] * arm);
      }
      result.row(v) = sum.transpose();
    }
    return result;
  }
};

std::optional<std::string> MultiresolutionOptions::problem() const {
  if (base_vertices < 50) return concat("base_vertices must be at least 50, got ", base_vertices);
  if (fine_iterations < 1) return concat("fine_iterations must be at least 1, got ", fine_iterations);
  return deform.problem();
}

MultiresolutionDeformer::MultiresolutionDeformer(const Points& positions, const Triangles& triangles,
                                                 std::vector<int> constrained,
                                                 const MultiresolutionOptions& options,
                                                 const Progress& progress)
    : implementation_(std::make_unique<Implementation>()) {
  Implementation& self = *implementation_;
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  self.options = options;
  self.rest = positions;
  DeformOptions fine = options.deform;
  if (positions.rows() > options.base_vertices) fine.max_iterations = options.fine_iterations;
  // Checks the input, too.
  self.fine = std::make_unique<Deformer>(positions, triangles, constrained, fine, progress);
  if (positions.rows() <= options.base_vertices) {
    self.base.positions = positions;
    self.base.triangles = triangles;
    return;
  }
  TriangleMesh mesh;
  mesh.positions = positions;
  mesh.triangles = triangles;
  SimplifyOptions simplification;
  simplification.faces = 2 * options.base_vertices;
  SimplifyResult simple = simplify(mesh, simplification, progress);
  self.base = std::move(simple.mesh);
  self.base_stiffness = cotangent_stiffness(self.base.positions, self.base.triangles);

  self.constrained_rest.resize(static_cast<Eigen::Index>(constrained.size()), 3);
  std::vector<std::vector<int>> rows(self.base.n_vertices());
  for (std::size_t c = 0; c < constrained.size(); ++c) {
    self.constrained_rest.row(static_cast<Eigen::Index>(c)) = positions.row(constrained[c]);
    const int at = simple.vertex_map[constrained[c]];
    if (at >= 0) rows[at].push_back(static_cast<int>(c));
  }
  // A turn needs some points that do not lie on a line: those that stand for one vertex may be fewer.
  const std::vector<std::vector<int>> beside =
      constrained_neighbours(triangles, constrained, positions.rows());
  for (std::size_t v = 0; v < rows.size(); ++v)
    if (!rows[v].empty()) {
      for (int ring = 0; ring < 2 && rows[v].size() < 6; ++ring) widen(beside, rows[v]);
      self.base_constrained.push_back(static_cast<int>(v));
      self.rows.push_back(std::move(rows[v]));
    }
  const std::vector<ClosestPoint> closest =
      TriangleTree(self.base.positions, self.base.triangles).closest(positions, progress);
  for (const ClosestPoint& point : closest) {
    Binding binding{};
    for (int k = 0; k < 3; ++k) {
      binding.corner[k] = self.base.triangles(point.element, k);
      binding.weight[k] = point.weights[k];
    }
    self.bindings.push_back(binding);
  }
  self.coarse = std::make_unique<Deformer>(self.base.positions, self.base.triangles, self.base_constrained,
                                           options.deform, progress);
}

MultiresolutionDeformer::~MultiresolutionDeformer() = default;
MultiresolutionDeformer::MultiresolutionDeformer(MultiresolutionDeformer&&) noexcept = default;
MultiresolutionDeformer& MultiresolutionDeformer::operator=(MultiresolutionDeformer&&) noexcept = default;

Deformer::Result MultiresolutionDeformer::deform(const Points& targets, const std::vector<Points>& stages,
                                                 const Progress& progress) const {
  const Implementation& self = *implementation_;
  const auto n = static_cast<Eigen::Index>(self.fine->constrained().size());
  std::vector<const Points*> way;
  way.reserve(stages.size() + 1);
  for (const Points& stage : stages) way.push_back(&stage);
  way.push_back(&targets);
  for (const Points* stage : way)
    if (stage->rows() != n)
      throw InvalidInput(
          concat("there are ", n, " constrained vertices, but ", stage->rows(), " targets of a stage"));
  const Deformer& first = self.coarse != nullptr ? *self.coarse : *self.fine;
  Deformer::Result result;
  for (std::size_t i = 0; i < way.size(); ++i) {
    const Points goal = self.coarse != nullptr ? self.base_targets(*way[i]) : *way[i];
    const Points start = result.positions;
    result = first.deform(goal, i > 0 ? &start : nullptr, progress);
  }
  if (self.coarse == nullptr) return result;
  const DeformReport report = result.report;
  const Points start = self.with_detail(result.positions);
  result = self.fine->deform(targets, &start, progress);
  // Whether the shape was found is the base's to say: the fine iterations are few by design.
  result.report.iterations += report.iterations;
  result.report.converged = report.converged;
  return result;
}

const TriangleMesh& MultiresolutionDeformer::base() const {
  return implementation_->base;
}
double MultiresolutionDeformer::curvature_term() const {
  return implementation_->fine->curvature_term();
}

}  // namespace batten
