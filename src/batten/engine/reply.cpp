#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>

#include "batten/engine/reply_detail.hpp"

namespace batten::detail {

namespace {

template <typename T>
ReplyArray array_of(std::string name, ElementType type, int columns, const T* values, std::size_t n) {
  ReplyArray array{std::move(name), type, columns, std::vector<std::byte>(n * sizeof(T))};
  if (n > 0) std::memcpy(array.bytes.data(), values, array.bytes.size());
  return array;
}

}  // namespace

void Draft::add_points(std::string name, const Points& points, const Eigen::RowVector3d& origin) {
  std::vector<float> values;
  values.reserve(static_cast<std::size_t>(points.size()));
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    for (int k = 0; k < 3; ++k) values.push_back(static_cast<float>(points(i, k) - origin[k]));
  arrays.push_back(array_of(std::move(name), ElementType::Float32, 3, values.data(), values.size()));
}

void Draft::add_values(std::string name, const Eigen::VectorXd& values) {
  const Eigen::VectorXf single = values.cast<float>();
  arrays.push_back(array_of(std::move(name), ElementType::Float32, 1, single.data(),
                            static_cast<std::size_t>(single.size())));
}

void Draft::add_indices(std::string name, const std::vector<int>& indices) {
  static_assert(sizeof(int) == sizeof(std::uint32_t));
  arrays.push_back(array_of(std::move(name), ElementType::Uint32, 1, indices.data(), indices.size()));
}

void Draft::add_triangles(std::string name, const Triangles& triangles) {
  static_assert(Triangles::IsRowMajor);
  arrays.push_back(array_of(std::move(name), ElementType::Uint32, 3, triangles.data(),
                            static_cast<std::size_t>(triangles.size())));
}

void Draft::add_bytes(std::string name, const std::string& bytes) {
  arrays.push_back(array_of(std::move(name), ElementType::Uint8, 1, bytes.data(), bytes.size()));
}

Json json_of(const Eigen::RowVector3d& point) {
  return Json::array({json_of(point[0]), json_of(point[1]), json_of(point[2])});
}

Json json_of(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

}  // namespace batten::detail
