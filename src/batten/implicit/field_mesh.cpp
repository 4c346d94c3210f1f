#include "batten/implicit/field_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"

namespace batten {

namespace {

constexpr double kSeedGap = 0.8;  // between vertices on strokes, in edges
constexpr double kOnStroke =
    0.05;                        // a stroke nearer than this to f = 0 is a row of vertices itself, in edges
constexpr double kMargin = 0.2;  // how far the surface may leave the box of the strokes, in diameters

/// The points, but for those nearer than `gap` to one before them.
std::vector<int> spread(const Points& points, double gap) {
  std::map<std::array<long, 3>, std::vector<int>> cells;
  std::vector<int> kept;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    std::array<long, 3> cell;
    for (int k = 0; k < 3; ++k) cell[at(k)] = static_cast<long>(std::floor(points(i, k) / gap));
    bool is_near = false;
    for (long dx = -1; dx <= 1 && !is_near; ++dx)
      for (long dy = -1; dy <= 1 && !is_near; ++dy)
        for (long dz = -1; dz <= 1 && !is_near; ++dz) {
          const auto found = cells.find({cell[0] + dx, cell[1] + dy, cell[2] + dz});
          if (found == cells.end()) continue;
          for (const int j : found->second)
            is_near = is_near || (points.row(i) - points.row(j)).squaredNorm() < gap * gap;
        }
    if (is_near) continue;
    cells[cell].push_back(static_cast<int>(i));
    kept.push_back(static_cast<int>(i));
  }
  return kept;
}

/// Vertices along the strokes.
Points seeds_of(const StrokeSamples& samples, const StrokeField& field, double edge) {
  Points feet(samples.positions.rows(), 3);
  for (Eigen::Index i = 0; i < feet.rows(); ++i) {
    Eigen::Vector3d x = samples.positions.row(i), gradient;
    for (int step = 0; step < 3; ++step) {
      const double f = field.value(x, gradient);
      const Eigen::Vector3d move = -f / std::max(gradient.squaredNorm(), 0.1) * gradient;
      if (step == 0 && move.norm() < kOnStroke * edge) break;
      x += move;
    }
    feet.row(i) = x;
  }
  const std::vector<int> kept = spread(feet, kSeedGap * edge);
  Points seeds(static_cast<Eigen::Index>(kept.size()), 3);
  for (std::size_t k = 0; k < kept.size(); ++k) seeds.row(static_cast<Eigen::Index>(k)) = feet.row(kept[k]);
  return seeds;
}

}  // namespace

TriangleMesh field_mesh(const StrokeField& field, const StrokeSamples& samples,
                        const LevelSetOptions& options, const Progress& progress) {
  if (const auto problem = options.problem()) throw InvalidInput(*problem);
  return level_set({[&](const Eigen::Vector3d& x) { return field.value(x); },
                    [&](const Eigen::Vector3d& x) {
                      Eigen::Vector3d gradient;
                      field.value(x, gradient);
                      return gradient;
                    }},
                   seeds_of(samples, field, options.edge_length), kMargin * field.diameter(), options,
                   progress);
}

}  // namespace batten
