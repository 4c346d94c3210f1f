#include "batten/core/text.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/random.hpp"

namespace batten {
namespace {

TEST(Text, ExactDecimalReadsBackAsTheSameNumber) {
  for (const double value : {0.0, 0.1, 1.0 / 3, -2.5e-300, 1e22, 123456789.123456789, 5e-324}) {
    double back = 0;
    ASSERT_TRUE(parse_number(exact_decimal(value), back));
    EXPECT_EQ(back, value);
  }
  EXPECT_EQ(exact_decimal(0.1), "0.1");
}

TEST(Text, ParseNumberTakesWholeTokensOnly) {
  double value = 0;
  EXPECT_TRUE(parse_number("+1.5e3", value));
  EXPECT_EQ(value, 1500);
  EXPECT_TRUE(parse_number("nan", value));
  EXPECT_TRUE(std::isnan(value));
  for (const char* bad : {"", " 1", "1 ", "1.5x", "--1", "1,5"})
    EXPECT_FALSE(parse_number(bad, value)) << bad;
  EXPECT_FALSE(parse_number(std::string(500, '1'), value));
}

// Both ways of reading (the short one and strtod) must round alike: strtod is the reference.
TEST(Text, ParseNumberAgreesWithTheStandardLibraryBitForBit) {
  Random random(5);
  for (int i = 0; i < 20000; ++i) {
    char text[40];
    const int digits = 1 + static_cast<int>(random.below(18));
    const int exponent = static_cast<int>(random.below(60)) - 30;
    std::snprintf(text, sizeof text, i % 2 ? "%.*e" : "%.*g", digits,
                  random.normal() * std::pow(10.0, exponent));
    double value = 0;
    ASSERT_TRUE(parse_number(text, value)) << text;
    EXPECT_EQ(value, std::strtod(text, nullptr)) << text;
  }
  double value = 1;
  ASSERT_TRUE(parse_number("-0.0", value));
  EXPECT_TRUE(std::signbit(value));
  for (const char* bad : {".", "-", "e5", "1e", "1e+", "1e5.0", "1.2.3", "+-1"})
    EXPECT_FALSE(parse_number(bad, value)) << bad;
}

TEST(Text, ParseIntegerRefusesFractionsAndOverflow) {
  long value = 0;
  EXPECT_TRUE(parse_integer("-12", value));
  EXPECT_EQ(value, -12);
  for (const char* bad : {"", "1.0", "12a", "99999999999999999999"})
    EXPECT_FALSE(parse_integer(bad, value)) << bad;
}

TEST(Text, SplitsOnBlanksAndOnSeparators) {
  EXPECT_EQ(split_blanks("  a\tbc \r\n"), (std::vector<std::string_view>{"a", "bc"}));
  EXPECT_EQ(split_fields("1, ,2,", ','), (std::vector<std::string_view>{"1", "", "2", ""}));
}

TEST(Text, LowerCaseKeepsWhatIsNoLetterOfAscii) {
  EXPECT_EQ(lower_case("SOLID @[`{ é Part_7"), "solid @[`{ é part_7");
}

TEST(Error, FileErrorNamesFileAndLine) {
  EXPECT_STREQ(FileError("a.net", 3, "no vertices").what(), "a.net:3: no vertices");
  EXPECT_STREQ(FileError("a.net", 0, "no vertices").what(), "a.net: no vertices");
}

}  // namespace
}  // namespace batten
