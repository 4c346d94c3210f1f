#include "batten/io/pen_io.hpp"

#include <string>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

std::string error_of(const std::string& text) {
  try {
    parse_pen(text, "pen.json");
  } catch (const FileError& error) {
    return error.what();
  }
  return {};
}

TEST(PenIo, ReadsBackWhatItWrites) {
  CalibratedPen pen;
  pen.pen.tip_offset = 1.0 / 17;
  pen.pen.leds = {0, 0.07, 0.11, 0.16 + 1e-17};
  pen.led_sigma = {0, 1e-5, 2e-5, 1.0 / 3e5};
  pen.residual = 1e-4;
  const std::string text = format_pen(pen);
  EXPECT_EQ(format_pen(parse_pen(text, "pen.json")), text);
  EXPECT_EQ(parse_pen(text, "pen.json").pen.tip_offset, 1.0 / 17);
  EXPECT_EQ(
      parse_pen(R"({"format":"batten pen","version":1,"tip_offset_m":0.06,"leds_m":[0,0.1,0.2,0.4]})", "p")
          .pen.leds[3],
      0.4);
}

TEST(PenIo, NamesWhatIsWrong) {
  EXPECT_NE(error_of("{").find("batten pen calibrate"), std::string::npos);
  EXPECT_NE(error_of("{}").find("is no pen"), std::string::npos);
  EXPECT_NE(error_of(R"({"format":"batten pen","version":9})").find("newer batten"), std::string::npos);
  for (const char* version : {"1.5", "-1", "2000000"})
    EXPECT_NE(error_of(std::string(R"({"format":"batten pen","version":)") + version + "}")
                  .find("a whole number from 0 to 1000000"),
              std::string::npos)
        << version;
  EXPECT_NE(
      error_of(R"({"format":"batten pen","version":1,"tip_offset_m":0.06,"leds_m":[0,1]})").find("4 numbers"),
      std::string::npos);
  EXPECT_NE(error_of(R"({"format":"batten pen","version":1,"tip_offset_m":0.06,"leds_m":[0,0.2,0.1,0.3]})")
                .find("leds[2]"),
            std::string::npos);
}

}  // namespace
}  // namespace batten
