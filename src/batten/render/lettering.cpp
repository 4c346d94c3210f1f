#include "batten/render/lettering.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace batten {

namespace {

/// A glyph as strokes of points "xy" on a grid: x from 0, y with the foot of the letters at 4, the height of
/// a small x at c (12) and of a capital at g (16), digits continued by letters. '~' before a stroke rounds
/// its corners, '@' closes and rounds it.
struct Glyph {
  char character;
  int width;
  const char* strokes;
};

constexpr Glyph kGlyphs[] = {
    {'0', 8, "@04 84 8g 0g"},
    {'1', 5, "0d 3g 34"},
    {'2', 8, "~0d 0g 8g 8b 04|04 84"},
    {'3', 8, "~0f 2g 8g 8a 3a|~3a 8a 84 14 05"},
    {'4', 8, "64 6g 08 88"},
    {'5', 8, "7g 1g 0a|~0a 2b 8c 84 14 05"},
    {'6', 8, "@04 84 8b 0b|~08 0f 7g"},
    {'7', 8, "0g 8g 34"},
    {'8', 8, "@1a 7a 7g 1g|@04 84 8a 0a"},
    {'9', 8, "@09 89 8g 0g|~8c 85 14"},
    {'a', 7, "@04 74 7c 0c|7c 74"},
    {'b', 7, "0g 04|@04 74 7c 0c"},
    {'c', 7, "~7b 5c 0c 04 54 75"},
    {'d', 7, "7g 74|@04 74 7c 0c"},
    {'e', 7, "08 78|~78 7c 0c 04 54 75"},
    {'f', 5, "~6g 2g 2b 24|0c 5c"},
    {'g', 7, "@04 74 7c 0c|~7c 70 10 02"},
    {'h', 7, "0g 04|~09 0c 7c 74"},
    {'i', 2, "14 1c|1f 1g"},
    {'j', 3, "~2c 20 00|2f 2g"},
    {'k', 7, "0g 04|6c 08|29 74"},
    {'l', 2, "1g 14"},
    {'m', 10, "0c 04|~09 0c 5c 54|~59 5c ac a4"},
    {'n', 7, "0c 04|~09 0c 7c 74"},
    {'o', 7, "@04 74 7c 0c"},
    {'p', 7, "0c 00|@04 74 7c 0c"},
    {'q', 7, "7c 70|@04 74 7c 0c"},
    {'r', 5, "0c 04|~09 0c 5c"},
    {'s', 6, "~6b 5c 0c 08 68 64 14 05"},
    {'t', 5, "~2f 28 24 54|0c 5c"},
    {'u', 7, "~0c 04 74 77|7c 74"},
    {'v', 7, "0c 34 6c"},
    {'w', 10, "0c 24 5b 84 ac"},
    {'x', 7, "0c 74|7c 04"},
    {'y', 7, "0c 44|7c 20 00"},
    {'z', 7, "0c 7c 04 74"},
    {'A', 8, "04 4g 84|28 68"},
    {'B', 8, "0g 04|~0g 7g 7a 0a|~0a 8a 84 04"},
    {'C', 8, "~8e 7g 0g 04 74 86"},
    {'D', 8, "0g 04|~0g 8g 84 04"},
    {'E', 7, "7g 0g 04 74|0a 6a"},
    {'F', 7, "7g 0g 04|0a 6a"},
    {'G', 8, "~8e 7g 0g 04 84 8a|8a 5a"},
    {'H', 8, "0g 04|8g 84|0a 8a"},
    {'I', 4, "0g 4g|2g 24|04 44"},
    {'J', 6, "~6g 64 04 07"},
    {'K', 8, "0g 04|8g 09|2b 84"},
    {'L', 7, "0g 04 74"},
    {'M', 10, "04 0g 59 ag a4"},
    {'N', 8, "04 0g 84 8g"},
    {'O', 9, "@04 94 9g 0g"},
    {'P', 8, "04 0g|~0g 8g 89 09"},
    {'Q', 9, "@04 94 9g 0g|57 94"},
    {'R', 8, "04 0g|~0g 8g 8a 0a|4a 84"},
    {'S', 8, "~8e 7g 0g 0a 8a 84 14 06"},
    {'T', 8, "0g 8g|4g 44"},
    {'U', 8, "~0g 04 84 8g"},
    {'V', 8, "0g 44 8g"},
    {'W', 12, "0g 34 6e 94 cg"},
    {'X', 8, "0g 84|8g 04"},
    {'Y', 8, "0g 4a 8g|4a 44"},
    {'Z', 8, "0g 8g 04 84"},
    {'.', 2, "14 15"},
    {',', 2, "15 02"},
    {':', 2, "14 15|1a 1b"},
    {'-', 6, "09 69"},
    {'+', 6, "09 69|36 3c"},
    {'=', 6, "07 67|0b 6b"},
    {'%', 10, "14 9g|@0b 4b 4g 0g|@64 a4 a9 69"},
    {'/', 6, "03 6h"},
    {'(', 4, "~3h 0e 06 33"},
    {')', 4, "~0h 3e 36 03"},
};

constexpr double kUnitsPerCap = 12, kFoot = 4, kBlank = 5, kGap = 3.2;

const Glyph* glyph_of(char character) {
  for (const Glyph& glyph : kGlyphs)
    if (glyph.character == character) return &glyph;
  return nullptr;
}

using Stroke = std::vector<Eigen::Vector2d>;

/// Corner cutting [chaikin1974], which keeps the ends of an open stroke.
Stroke rounded(const Stroke& corners, bool closed) {
  Stroke points = corners;
  for (int round = 0; round < 4; ++round) {
    Stroke next;
    const std::size_t n = points.size();
    if (!closed) next.push_back(points.front());
    for (std::size_t i = 0; i + (closed ? 0 : 1) < n; ++i) {
      const Eigen::Vector2d& p = points[i];
      const Eigen::Vector2d& q = points[(i + 1) % n];
      next.emplace_back(0.75 * p + 0.25 * q);
      next.emplace_back(0.25 * p + 0.75 * q);
    }
    if (!closed) next.push_back(points.back());
    points = std::move(next);
  }
  if (closed) points.push_back(points.front());
  return points;
}

std::vector<Stroke> strokes_of(const Glyph& glyph) {
  std::vector<Stroke> strokes;
  const auto digit = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  const std::string_view text = glyph.strokes;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('|', at), text.size());
    char kind = 0;
    if (text[at] == '~' || text[at] == '@') kind = text[at++];
    Stroke corners;
    for (; at < end; at += 3) corners.emplace_back(digit(text[at]), digit(text[at + 1]));
    strokes.push_back(kind == 0 ? corners : rounded(corners, kind == '@'));
    at = end + 1;
  }
  return strokes;
}

double distance_to(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d d = b - a;
  const double length2 = d.squaredNorm();
  const double t = length2 > 0 ? std::clamp(d.dot(p - a) / length2, 0.0, 1.0) : 0.0;
  return (a + t * d - p).norm();
}

/// Draws strokes in pixels as one shape, so that their joints are not darker.
void draw_strokes(Image& image, const std::vector<Stroke>& strokes, double width, const Colour& colour) {
  Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  for (const Stroke& stroke : strokes)
    for (const Eigen::Vector2d& p : stroke) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  const double reach = width / 2 + 1;
  const int x0 = std::max(0, static_cast<int>(std::floor(low.x() - reach))),
            x1 = std::min(image.width - 1, static_cast<int>(std::ceil(high.x() + reach))),
            y0 = std::max(0, static_cast<int>(std::floor(low.y() - reach))),
            y1 = std::min(image.height - 1, static_cast<int>(std::ceil(high.y() + reach)));
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const Eigen::Vector2d p(x + 0.5, y + 0.5);
      double nearest = 1e9;
      for (const Stroke& stroke : strokes)
        for (std::size_t i = 0; i + 1 < stroke.size(); ++i)
          nearest = std::min(nearest, distance_to(p, stroke[i], stroke[i + 1]));
      image.blend(x, y, colour, static_cast<float>(std::clamp(width / 2 + 0.5 - nearest, 0.0, 1.0)));
    }
}

double advance(char character) {
  const Glyph* glyph = glyph_of(character);
  return glyph != nullptr ? glyph->width + kGap : kBlank;
}

}  // namespace

double text_width(std::string_view text, double cap_height) {
  double width = 0;
  for (const char c : text) width += advance(c);
  return std::max(0.0, width - kGap) * cap_height / kUnitsPerCap;
}

void draw_text(Image& image, double x, double baseline, std::string_view text, double cap_height,
               const Colour& colour, Align align) {
  const double unit = cap_height / kUnitsPerCap;
  if (align != Align::Left) x -= text_width(text, cap_height) * (align == Align::Right ? 1 : 0.5);
  for (const char c : text) {
    if (const Glyph* glyph = glyph_of(c)) {
      std::vector<Stroke> strokes = strokes_of(*glyph);
      for (Stroke& stroke : strokes)
        for (Eigen::Vector2d& p : stroke)
          p = Eigen::Vector2d(x + unit * p.x(), baseline - unit * (p.y() - kFoot));
      draw_strokes(image, strokes, std::max(1.0, 0.13 * cap_height), colour);
    }
    x += unit * advance(c);
  }
}

void draw_line(Image& image, double x0, double y0, double x1, double y1, double width, const Colour& colour) {
  draw_strokes(image, {{Eigen::Vector2d(x0, y0), Eigen::Vector2d(x1, y1)}}, width, colour);
}

}  // namespace batten
