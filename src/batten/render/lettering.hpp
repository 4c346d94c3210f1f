#pragma once
#include <string_view>

#include "batten/render/image.hpp"

namespace batten {

/// Width in pixels of a line of text of the given cap height.
double text_width(std::string_view text, double cap_height);

/// Where draw_text() puts the text with respect to x.
enum class Align { Left, Centre, Right };

/// Draws a line of text in a plain stroke font (letters, digits and the signs . , : - + = % / ( ) of ASCII;
/// other characters become blanks), smoothed.
/// @param baseline y of the foot of the letters, pixels from the top.
/// @param cap_height of a capital letter, pixels; 8 is the smallest that reads well.
void draw_text(Image& image, double x, double baseline, std::string_view text, double cap_height,
               const Colour& colour, Align align = Align::Left);

/// A straight stroke with round ends.
void draw_line(Image& image, double x0, double y0, double x1, double y1, double width, const Colour& colour);

}  // namespace batten
