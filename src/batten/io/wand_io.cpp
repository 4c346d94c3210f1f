#include "batten/io/wand_io.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include <nlohmann/json.hpp>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/file.hpp"

namespace batten {

namespace {

using Json = nlohmann::json;

constexpr const char* kWandFormat = "batten blobs";
constexpr int kWandVersion = 1;
constexpr std::size_t kMostBlobs = 1000;  // in one image; more are no lights

struct BlobFrame {
  double time = 0;
  bool is_right = false;
  std::vector<Eigen::Vector2d> blobs;
};

double number(const Json& value, const LineReader& reader, const char* what) {
  if (!value.is_number() || !std::isfinite(value.get<double>()) || std::abs(value.get<double>()) > 1e12)
    reader.fail(concat(what, " must be a finite number"));
  return value.get<double>();
}

void check_format(const Json& row, const LineReader& reader) {
  if (row["format"] != kWandFormat) reader.fail("is no file of blobs: expected \"format\": \"batten blobs\"");
  const Json version = row.value("version", Json());
  if (version.is_number() && version.get<double>() > kWandVersion)
    reader.fail(concat("is of a newer version than ", kWandVersion,
                       ", which this program knows; use a newer batten"));
}

/// A row of blobs, or nothing for a row of another kind.
std::optional<BlobFrame> parse_row(std::string_view line, const LineReader& reader) {
  Json row;
  try {
    row = Json::parse(line);
  } catch (const nlohmann::json::exception&) {
    reader.fail("is not valid JSON; every line must be one object");
  }
  if (!row.is_object()) reader.fail("must be an object");
  if (row.contains("format")) check_format(row, reader);
  if (!row.contains("blobs")) return {};
  BlobFrame frame;
  frame.time = number(row.value("time", Json()), reader, "time");
  const Json camera = row.value("camera", Json());
  if (camera != "left" && camera != "right") reader.fail("camera must be \"left\" or \"right\"");
  frame.is_right = camera == "right";
  const Json& blobs = row["blobs"];
  if (!blobs.is_array() || blobs.size() > kMostBlobs)
    reader.fail(concat("blobs must be a list of at most ", kMostBlobs, " blobs"));
  for (const Json& blob : blobs) {
    if (!blob.is_array() || blob.size() < 2) reader.fail("a blob must be a list [u, v, …]");
    frame.blobs.emplace_back(number(blob[0], reader, "u"), number(blob[1], reader, "v"));
  }
  return frame;
}

std::vector<WandFrame> read_lines(LineReader& reader, double most_apart) {
  std::vector<BlobFrame> left, right;
  std::string_view line;
  while (reader.next(line)) {
    if (trim(line).empty()) continue;
    if (auto frame = parse_row(line, reader)) (frame->is_right ? right : left).push_back(std::move(*frame));
  }
  if (left.empty() || right.empty())
    throw FileError(reader.path(), 0,
                    concat("holds no frames of the ", left.empty() ? "left" : "right", " camera"));
  const auto earlier = [](const BlobFrame& a, const BlobFrame& b) { return a.time < b.time; };
  std::stable_sort(left.begin(), left.end(), earlier);
  std::stable_sort(right.begin(), right.end(), earlier);
  std::vector<WandFrame> frames;
  std::size_t next = 0;
  for (const BlobFrame& frame : left) {
    while (next + 1 < right.size() &&
           std::abs(right[next + 1].time - frame.time) <= std::abs(right[next].time - frame.time))
      ++next;
    if (std::abs(right[next].time - frame.time) <= most_apart)
      frames.push_back({frame.time, frame.blobs, right[next].blobs});
  }
  if (frames.empty())
    throw FileError(reader.path(), 0,
                    concat("holds no two frames of both cameras within ", most_apart,
                           " s; the cameras must be synchronised for this"));
  return frames;
}

}  // namespace

std::vector<WandFrame> read_wand(const std::string& path, double most_apart) {
  LineReader reader(path);
  return read_lines(reader, most_apart);
}

std::vector<WandFrame> parse_wand(std::string text, const std::string& name, double most_apart) {
  LineReader reader(std::move(text), name);
  return read_lines(reader, most_apart);
}

}  // namespace batten
