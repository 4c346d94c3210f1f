#include "batten/core/units.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

TEST(Units, LengthsInTheUnitOfTheFile) {
  EXPECT_DOUBLE_EQ(parse_length("0.05").in_file_units(4), 0.05);
  EXPECT_DOUBLE_EQ(parse_length("2mm").in_file_units(4), 0.002);
  EXPECT_DOUBLE_EQ(parse_length("2 mm").in_file_units(4, 0.001), 2);
  EXPECT_DOUBLE_EQ(parse_length("1.6%").in_file_units(4), 0.064);
  EXPECT_DOUBLE_EQ(parse_length("1e-2m").in_file_units(4), 0.01);
}

// The inch is 25.4 mm by definition (1959), a foot 12 of them.
TEST(Units, EveryUnitOfLengthInMetres) {
  struct Known {
    const char* text;
    double metres;
  };
  for (const Known& known : {Known{"1um", 1e-6}, Known{"1mm", 1e-3}, Known{"1cm", 1e-2}, Known{"1m", 1.0},
                             Known{"1km", 1e3}, Known{"1in", 0.0254}, Known{"1ft", 12 * 0.0254}})
    EXPECT_DOUBLE_EQ(parse_length(known.text).in_file_units(4), known.metres) << known.text;
}

TEST(Units, AnglesAndFractions) {
  EXPECT_DOUBLE_EQ(parse_angle("180deg"), kPi);
  EXPECT_DOUBLE_EQ(parse_angle("90"), kPi / 2);
  EXPECT_DOUBLE_EQ(parse_angle("0.5rad"), 0.5);
  EXPECT_DOUBLE_EQ(parse_fraction("0.3%"), 0.003);
  EXPECT_DOUBLE_EQ(parse_fraction("0.25"), 0.25);
}

// A gram-force is 9.80665 mN by definition; 9.81 is that to three digits.
TEST(Units, UsualGravityIsTheStandardOneRounded) {
  EXPECT_EQ(kStandardGravity, 9.80665);
  EXPECT_EQ(kUsualGravity, std::round(100 * kStandardGravity) / 100);
}

TEST(Units, KindsOfLengthHaveTheirWords) {
  EXPECT_EQ(word_of(parse_length("2mm").kind), "metres");
  EXPECT_EQ(word_of(parse_length("2%").kind), "relative");
  EXPECT_EQ(parse_choice<Length::Kind>("plain"), parse_length("2").kind);
}

TEST(Units, SaysWhatWouldHaveBeenRight) {
  for (const char* bad : {"", "mm", "1 furlong", "nan", "inf%", "1..2", "1e999", "1e999mm"}) {
    EXPECT_THROW(parse_length(bad), InvalidInput) << bad;
  }
  EXPECT_THROW(parse_angle("2mm"), InvalidInput);
  EXPECT_THROW(parse_fraction("2deg"), InvalidInput);
}

}  // namespace
}  // namespace batten
