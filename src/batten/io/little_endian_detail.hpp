#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>

// Numbers as binary files hold them, lowest byte first, whatever the machine. Private to the room.
namespace batten::detail {

/// The unsigned integer of as many bytes as a number has.
template <std::size_t Size>
using Bits =
    std::conditional_t<Size == 1, std::uint8_t,
                       std::conditional_t<Size == 2, std::uint16_t,
                                          std::conditional_t<Size == 4, std::uint32_t, std::uint64_t>>>;

template <typename Value>
requires std::is_arithmetic_v<Value>
void append_little_endian(std::string& bytes, Value value) {
  Bits<sizeof(Value)> bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  for (std::size_t k = 0; k < sizeof value; ++k) bytes += static_cast<char>(bits >> (8 * k) & 255);
}

/// @pre sizeof(Value) bytes are there.
template <typename Value>
requires std::is_arithmetic_v<Value> Value little_endian(const char* bytes) {
  Bits<sizeof(Value)> bits = 0;
  for (std::size_t k = sizeof(Value); k-- > 0;)
    bits = static_cast<Bits<sizeof(Value)>>(std::uint64_t{bits} << 8 | static_cast<unsigned char>(bytes[k]));
  Value value{};
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

}  // namespace batten::detail
