#include "batten/io/blobs_io.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <nlohmann/json.hpp>

#include "batten/core/text.hpp"
#include "batten/io/file.hpp"

namespace batten {

namespace {

using Json = nlohmann::json;

constexpr const char* kBlobsFormat = "batten blobs";
constexpr int kBlobsVersion = 1;
constexpr double kMostPixels = 1e6;

/// Takes lines into a recording; every error names the line.
class BlobReader {
 public:
  explicit BlobReader(LineReader& lines) : lines_(lines) {}

  BlobRecording read(std::vector<std::string>* notes) {
    std::string_view line;
    std::optional<long> torn;
    while (lines_.next(line)) {
      if (trim(line).empty()) continue;
      // Only the last line may be one that its writer did not finish.
      if (torn) fail_at(*torn, "the line is no JSON object");
      const Json object = Json::parse(line.begin(), line.end(), nullptr, false);
      if (object.is_discarded())
        torn = lines_.line_number();
      else
        take(object);
    }
    if (!has_header_)
      throw FileError(lines_.path(), 0, "the file holds no line {\"format\":\"batten blobs\",…}");
    if (torn && notes)
      notes->push_back(concat(lines_.path(), ": line ", *torn, " was not finished and is left out"));
    const auto by_time = [](const auto& a, const auto& b) { return a.time < b.time; };
    std::stable_sort(recording_.frames.begin(), recording_.frames.end(), by_time);
    std::stable_sort(recording_.inertial.begin(), recording_.inertial.end(), by_time);
    std::stable_sort(recording_.buttons.begin(), recording_.buttons.end(), by_time);
    return std::move(recording_);
  }

 private:
  [[noreturn]] void fail_at(long line, const std::string& problem) const {
    throw FileError(lines_.path(), line, problem);
  }

  void take(const Json& object) {
    if (!object.is_object()) lines_.fail("the line is no JSON object");
    if (!has_header_) {
      take_header(object);
      return;
    }
    const double time = number(object, "time");
    if (object.contains("camera")) {
      take_frame(object, time);
    } else if (object.contains("button")) {
      if (!object.at("button").is_string() || !object.contains("down") || !object.at("down").is_boolean())
        lines_.fail("an event of a button is {\"time\":s,\"button\":\"draw\",\"down\":true}");
      recording_.buttons.push_back(
          {time, object.at("button").get<std::string>(), object.at("down").get<bool>()});
    } else if (object.contains("gyroscope")) {
      recording_.inertial.push_back({time, vector(object, "gyroscope"), vector(object, "accelerometer")});
    } else {
      lines_.fail(
          "the line is neither a frame (camera, blobs) nor a reading (gyroscope, accelerometer) nor an "
          "event (button, down)");
    }
  }

  void take_header(const Json& object) {
    if (!object.contains("format") || object.at("format") != kBlobsFormat)
      lines_.fail(concat("the first line is {\"format\":\"", kBlobsFormat,
                         "\",\"version\":1}; this is another file"));
    const double version = number(object, "version");
    if (version > kBlobsVersion)
      lines_.fail(concat("the file has version ", version, ", this program reads up to ", kBlobsVersion,
                         "; take a newer batten"));
    if (version != kBlobsVersion) lines_.fail("version must be 1");
    recording_.width = size(object, "width");
    recording_.height = size(object, "height");
    has_header_ = true;
  }

  int size(const Json& object, const char* field) const {
    if (!object.contains(field)) return 0;
    const double value = number(object, field);
    if (!(value >= 0 && value <= kMostPixels) || value != std::floor(value))
      lines_.fail(concat(field, " must be a number of pixels"));
    return static_cast<int>(value);
  }

  double number(const Json& object, const char* field) const {
    if (!object.contains(field) || !object.at(field).is_number())
      lines_.fail(concat(field, " must be a number"));
    const double value = object.at(field).get<double>();
    if (!std::isfinite(value)) lines_.fail(concat(field, " must be finite"));
    return value;
  }

  Eigen::Vector3d vector(const Json& object, const char* field) const {
    const auto wrong = [&] { lines_.fail(concat(field, " must be a list of 3 numbers")); };
    if (!object.contains(field) || !object.at(field).is_array() || object.at(field).size() != 3) wrong();
    Eigen::Vector3d v;
    for (int k = 0; k < 3; ++k) {
      const Json& entry = object.at(field)[static_cast<std::size_t>(k)];
      if (!entry.is_number()) wrong();
      v[k] = entry.get<double>();
    }
    if (!v.allFinite()) wrong();
    return v;
  }

  void take_frame(const Json& object, double time) {
    BlobFrame frame;
    frame.time = time;
    const Json& camera = object.at("camera");
    if (camera == "left")
      frame.camera = CameraSide::Left;
    else if (camera == "right")
      frame.camera = CameraSide::Right;
    else
      lines_.fail("camera must be \"left\" or \"right\"");
    if (object.contains("image") && !object.contains("blobs")) {
      const Json& image = object.at("image");
      if (!image.is_string() || image.get_ref<const std::string&>().empty())
        lines_.fail("image must be the name of a file");
      frame.image = image.get<std::string>();
      recording_.frames.push_back(std::move(frame));
      return;
    }
    if (!object.contains("blobs") || !object.at("blobs").is_array())
      lines_.fail("blobs must be a list, or image the name of a file");
    for (const Json& entry : object.at("blobs")) frame.blobs.push_back(blob(entry));
    recording_.frames.push_back(std::move(frame));
  }

  Blob blob(const Json& entry) const {
    if (!entry.is_array() || (entry.size() != 2 && entry.size() != 5))
      lines_.fail("a blob is [u, v] or [u, v, suu, suv, svv]");
    std::array<double, 5> n = {0, 0, kPlainVariance, 0, kPlainVariance};
    for (std::size_t k = 0; k < entry.size(); ++k) {
      if (!entry[k].is_number()) lines_.fail("a blob holds something that is no number");
      n[k] = entry[k].get<double>();
      if (!(std::abs(n[k]) <= kMostPixels)) lines_.fail("a blob holds a number that is no pixel");
    }
    Blob result;
    result.pixel << n[0], n[1];
    result.covariance << n[2], n[3], n[3], n[4];
    if (!(n[2] > kLeastVariance && n[4] > kLeastVariance &&
          n[2] * n[4] - n[3] * n[3] > kLeastVariance * kLeastVariance))
      lines_.fail(concat("the covariance ", n[2], " ", n[3], " ", n[4], " of a blob is not positive"));
    return result;
  }

  static constexpr double kPlainVariance = 0.1 * 0.1;  // pixels², of blobs that come without
  static constexpr double kLeastVariance = 1e-10;      // pixels²
  LineReader& lines_;
  BlobRecording recording_;
  bool has_header_ = false;
};

void append_vector(std::string& text, const Eigen::Vector3d& v) {
  text += concat("[", exact_decimal(v.x()), ",", exact_decimal(v.y()), ",", exact_decimal(v.z()), "]");
}

}  // namespace

BlobRecording read_blobs(const std::string& path, std::vector<std::string>* notes) {
  LineReader lines(path);
  return BlobReader(lines).read(notes);
}

BlobRecording parse_blobs(std::string text, const std::string& name, std::vector<std::string>* notes) {
  LineReader lines(std::move(text), name);
  return BlobReader(lines).read(notes);
}

std::string format_blobs(const BlobRecording& recording) {
  std::string text = concat("{\"format\":\"", kBlobsFormat, "\",\"version\":", kBlobsVersion);
  if (recording.width > 0) text += concat(",\"width\":", recording.width, ",\"height\":", recording.height);
  text += "}\n";
  for (const BlobFrame& frame : recording.frames) {
    text += "{\"time\":" + exact_decimal(frame.time);
    text += frame.camera == CameraSide::Left ? ",\"camera\":\"left\"" : ",\"camera\":\"right\"";
    if (!frame.image.empty()) {
      text += ",\"image\":" + Json(frame.image).dump() + "}\n";
      continue;
    }
    text += ",\"blobs\":[";
    for (std::size_t b = 0; b < frame.blobs.size(); ++b) {
      const Blob& blob = frame.blobs[b];
      text += b > 0 ? ",[" : "[";
      const double numbers[5] = {blob.pixel.x(), blob.pixel.y(), blob.covariance(0, 0), blob.covariance(0, 1),
                                 blob.covariance(1, 1)};
      for (int k = 0; k < 5; ++k) (text += k > 0 ? "," : "") += exact_decimal(numbers[k]);
      text += "]";
    }
    text += "]}\n";
  }
  for (const PenInertialReading& reading : recording.inertial) {
    text += "{\"time\":" + exact_decimal(reading.time) + ",\"gyroscope\":";
    append_vector(text, reading.gyroscope);
    text += ",\"accelerometer\":";
    append_vector(text, reading.accelerometer);
    text += "}\n";
  }
  for (const ButtonEvent& event : recording.buttons)
    text += "{\"time\":" + exact_decimal(event.time) + ",\"button\":" + Json(event.button).dump() +
            (event.down ? ",\"down\":true}\n" : ",\"down\":false}\n");
  return text;
}

void write_blobs(const BlobRecording& recording, const std::string& path) {
  write_file(path, format_blobs(recording));
}

std::vector<TimedPose> read_pen_poses(const std::string& path) {
  return parse_pen_poses(read_file(path), path);
}

std::vector<TimedPose> parse_pen_poses(std::string text, const std::string& name) {
  constexpr const char* kColumns[] = {"time_s", "x", "y", "z", "dx", "dy", "dz", "drawing"};
  LineReader lines(std::move(text), name);
  std::string_view line;
  if (!lines.next(line)) throw FileError(name, 0, "the file is empty; its first line names the columns");
  std::array<std::size_t, std::size(kColumns)> places{};
  const std::vector<std::string_view> names = split_fields(line, ',');
  for (std::size_t c = 0; c < std::size(kColumns); ++c) {
    const auto found = std::find(names.begin(), names.end(), kColumns[c]);
    if (found == names.end()) lines.fail(concat("there is no column ", kColumns[c]));
    places[c] = static_cast<std::size_t>(found - names.begin());
  }
  std::vector<TimedPose> poses;
  const std::size_t n_names = names.size();
  while (lines.next(line)) {
    if (trim(line).empty()) continue;
    const std::vector<std::string_view> fields = split_fields(line, ',');
    if (fields.size() != n_names)
      lines.fail(concat("the row has ", fields.size(), " cells; expected ", n_names));
    std::array<double, std::size(kColumns)> n{};
    if (fields[places[1]].empty()) continue;
    for (std::size_t c = 0; c < n.size(); ++c)
      if (!parse_number(fields[places[c]], n[c]) || !std::isfinite(n[c]))
        lines.fail(concat("'", fields[places[c]], "' in column ", kColumns[c], " is no number"));
    TimedPose pose{n[0], {{n[1], n[2], n[3]}, {n[4], n[5], n[6]}}, n[7] != 0};
    if (!(pose.pose.direction.norm() > 1e-6)) lines.fail("the direction has no length");
    pose.pose.direction.normalize();
    if (!poses.empty() && pose.time < poses.back().time) lines.fail("times must not decrease");
    poses.push_back(pose);
  }
  return poses;
}

std::string format_pen_poses(const std::vector<TimedPose>& poses) {
  std::string text = "time_s,x,y,z,dx,dy,dz,drawing\n";
  for (const TimedPose& pose : poses) {
    text += exact_decimal(pose.time);
    for (const double value : pose.pose.tip) (text += ',') += exact_decimal(value);
    for (const double value : pose.pose.direction) (text += ',') += exact_decimal(value);
    text += pose.drawing ? ",1\n" : ",0\n";
  }
  return text;
}

}  // namespace batten
