#pragma once
#include "batten/render/colour.hpp"

// The colours of pictures. Private to the room.
namespace batten::detail {

inline const Colour kInk = hex_colour(0x2b2f36), kCurve = hex_colour(0x1c4a86),
                    kBorderCurve = hex_colour(0xc25a1c), kClay = hex_colour(0xc3cad6),
                    kInside = hex_colour(0xc7a78f), kPale = hex_colour(0xe9ebee),
                    kGrey = hex_colour(0x9aa0a8);

}  // namespace batten::detail
