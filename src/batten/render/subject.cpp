#include "batten/render/render.hpp"

namespace batten {

const Eigen::VectorXd& Subject::amounts(Shading shading) const {
  if (shading == Shading::Error) return errors;
  if (uncertainty.size() > 0 || mesh == nullptr) return uncertainty;
  const auto found = mesh->vertex_values.find("uncertainty");
  return found == mesh->vertex_values.end() ? uncertainty : found->second;
}

}  // namespace batten
