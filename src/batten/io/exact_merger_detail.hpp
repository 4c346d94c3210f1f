#pragma once
#include <cstdint>
#include <cstring>
#include <unordered_map>

#include "batten/io/mesh_formats_detail.hpp"

// Private to the room.
namespace batten::detail {

/// For formats that repeat the corners of every triangle, or of every face that looks otherwise: those with
/// the same coordinates, bit for bit, are one vertex.
class ExactMerger {
 public:
  explicit ExactMerger(RawMesh& mesh) : mesh_(mesh) {}

  /// The number of the vertex there, which is added to the mesh where there is none.
  int vertex(double x, double y, double z) {
    const Key key{x + 0.0, y + 0.0, z + 0.0};  // −0 becomes +0
    const auto [place, fresh] = numbers_.try_emplace(key, static_cast<int>(mesh_.positions.size() / 3));
    if (fresh) mesh_.positions.insert(mesh_.positions.end(), {key.x, key.y, key.z});
    return place->second;
  }

 private:
  struct Key {
    double x, y, z;
    bool operator==(const Key&) const = default;
  };
  struct Hash {
    size_t operator()(const Key& key) const {
      std::uint64_t hash = 0x9E3779B97F4A7C15ull;
      for (const double value : {key.x, key.y, key.z}) {
        std::uint64_t bits = 0;
        std::memcpy(&bits, &value, sizeof bits);
        hash = (hash ^ bits) * 0xD6E8FEB86659FD93ull;
        hash ^= hash >> 32;
      }
      return static_cast<size_t>(hash);
    }
  };
  RawMesh& mesh_;
  std::unordered_map<Key, int, Hash> numbers_;
};

}  // namespace batten::detail
