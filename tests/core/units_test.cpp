#include "batten/core/units.hpp"

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

TEST(Units, AnglesAndFractions) {
  EXPECT_DOUBLE_EQ(parse_angle("180deg"), kPi);
  EXPECT_DOUBLE_EQ(parse_angle("90"), kPi / 2);
  EXPECT_DOUBLE_EQ(parse_angle("0.5rad"), 0.5);
  EXPECT_DOUBLE_EQ(parse_fraction("0.3%"), 0.003);
  EXPECT_DOUBLE_EQ(parse_fraction("0.25"), 0.25);
}

TEST(Units, SaysWhatWouldHaveBeenRight) {
  for (const char* bad : {"", "mm", "1 furlong", "nan", "inf%", "1..2"}) {
    EXPECT_THROW(parse_length(bad), InvalidInput) << bad;
  }
  EXPECT_THROW(parse_angle("2mm"), InvalidInput);
  EXPECT_THROW(parse_fraction("2deg"), InvalidInput);
}

}  // namespace
}  // namespace batten
