#pragma once
#include <cstdint>

// Numbers of glTF 2.0, the specification of the Khronos Group. Private to the room.
namespace batten::detail::gltf {

/// Of the binary form: its first four bytes, and the kinds of its chunks.
inline constexpr std::uint32_t kMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
/// Types of the components of an accessor.
inline constexpr int kFloat = 5126, kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123,
                     kUnsignedInt = 5125;
/// Modes of primitives.
inline constexpr int kTriangles = 4, kStrip = 5, kFan = 6;

}  // namespace batten::detail::gltf
