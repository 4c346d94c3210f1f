#include "batten/pipeline/carried_values.hpp"

#include <algorithm>
#include <cmath>

#include "batten/mesh/distance.hpp"
#include "batten/mesh/normals.hpp"

namespace batten {

ValueKind value_kind(const std::string& name, const Eigen::VectorXd& values) {
  // Comparisons with NaN are false: values with gaps are amounts.
  const bool whole =
      std::all_of(values.begin(), values.end(), [](double value) { return std::floor(value) == value; });
  if (!whole || values.size() == 0) return ValueKind::Amount;
  const bool is_channel = name == "red" || name == "green" || name == "blue" || name == "alpha";
  return is_channel && values.minCoeff() >= 0 && values.maxCoeff() <= 255 ? ValueKind::Channel
                                                                          : ValueKind::Label;
}

void carry_values(const TriangleMesh& from, TriangleMesh& to, const Progress& progress) {
  if (from.normals.rows() > 0) to.normals = vertex_normals(to.positions, to.triangles);
  if (from.vertex_values.empty()) return;
  const std::vector<ClosestPoint> closest =
      TriangleTree(from.positions, from.triangles).closest(to.positions, progress);
  for (const auto& [name, values] : from.vertex_values) {
    if (to.vertex_values.count(name) > 0) continue;
    const ValueKind kind = value_kind(name, values);
    Eigen::VectorXd carried(to.n_vertices());
    for (Eigen::Index v = 0; v < to.n_vertices(); ++v) {
      const ClosestPoint& at = closest[static_cast<std::size_t>(v)];
      Eigen::Index nearest = 0;
      at.weights.maxCoeff(&nearest);
      double sum = 0;
      for (int k = 0; k < 3; ++k)
        if (at.weights[k] > 0) sum += at.weights[k] * values(from.triangles(at.element, k));
      if (kind == ValueKind::Label)
        sum = values(from.triangles(at.element, nearest));
      else if (kind == ValueKind::Channel)
        sum = std::round(sum);
      carried(v) = sum;
    }
    to.vertex_values[name] = std::move(carried);
  }
}

}  // namespace batten
