#include "batten/io/pen_io.hpp"

#include "batten/io/file.hpp"
#include "batten/io/json_reader_detail.hpp"

namespace batten {

namespace {

using detail::JsonReader;
using OrderedJson = JsonReader::Json;

constexpr const char* kPenFormat = "batten pen";
constexpr int kPenVersion = 1;

std::array<double, kPenLeds> leds_of(const JsonReader& reader, const OrderedJson& list,
                                     const std::string& where) {
  std::array<double, kPenLeds> leds{};
  if (!list.is_array() || list.size() != leds.size())
    reader.fail(concat(where, " must be a list of 4 numbers"));
  for (std::size_t i = 0; i < leds.size(); ++i) {
    if (!list[i].is_number()) reader.fail(concat(where, " must be a list of 4 numbers"));
    leds[i] = list[i].get<double>();
    if (!std::isfinite(leds[i])) reader.fail(concat(where, " must be finite"));
  }
  return leds;
}

}  // namespace

CalibratedPen read_pen(const std::string& path) {
  return parse_pen(read_file(path), path);
}

CalibratedPen parse_pen(const std::string& text, const std::string& name) {
  const JsonReader reader(name, "write the file with batten pen calibrate");
  const OrderedJson document = reader.parse(text);
  if (!document.is_object() || document.value("format", OrderedJson()) != kPenFormat)
    reader.fail("is no pen: expected \"format\": \"batten pen\"; write it with batten pen calibrate");
  if (const int version = reader.count(document, "version", ""); version > kPenVersion)
    reader.fail(concat("is a pen of version ", version, ", this program knows up to ", kPenVersion,
                       "; use a newer batten, or calibrate again"));
  CalibratedPen result;
  result.pen.tip_offset = reader.number(document, "tip_offset_m", "");
  result.pen.leds = leds_of(reader, reader.member(document, "leds_m", ""), "leds_m");
  if (const std::string found = problem(result.pen); !found.empty())
    reader.fail(concat(found, "; calibrate again"));
  if (!document.contains("calibration")) return result;
  const OrderedJson& figures = document.at("calibration");
  result.tip_offset_sigma = reader.number(figures, "tip_offset_sigma_m", "calibration.");
  result.led_sigma =
      leds_of(reader, reader.member(figures, "led_sigma_m", "calibration."), "calibration.led_sigma_m");
  result.residual = reader.number(figures, "residual_m", "calibration.");
  return result;
}

std::string format_pen(const CalibratedPen& pen) {
  if (const std::string found = problem(pen.pen); !found.empty()) throw InvalidInput(found);
  OrderedJson document = {
      {"format", kPenFormat}, {"version", kPenVersion}, {"tip_offset_m", pen.pen.tip_offset}};
  document["leds_m"] = pen.pen.leds;
  document["calibration"] = {{"tip_offset_sigma_m", pen.tip_offset_sigma},
                             {"led_sigma_m", pen.led_sigma},
                             {"residual_m", pen.residual}};
  return document.dump(2) + "\n";
}

void write_pen(const CalibratedPen& pen, const std::string& path) {
  write_file(path, format_pen(pen));
}

}  // namespace batten
