#include "batten/engine/opened_file.hpp"

#include <memory>
#include <string_view>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/io/file.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/io/network_io.hpp"
#include "batten/io/scan_io.hpp"
#include "batten/io/sensor_log_io.hpp"
#include "batten/io/standard_streams.hpp"

namespace batten {

namespace {

std::string stem_of(std::string_view name) {
  const std::size_t slash = name.find_last_of("/\\");
  if (slash != std::string_view::npos) name.remove_prefix(slash + 1);
  if (name.ends_with(".gz")) name.remove_suffix(3);
  const std::size_t dot = name.find_last_of('.');
  if (dot != std::string_view::npos && dot > 0) name = name.substr(0, dot);
  return std::string(name.empty() ? "object" : name);
}

bool is_calibration(std::string_view text) {
  return text.substr(0, 4096).find("\"batten calibration\"") != std::string_view::npos;
}

template <typename T>
std::shared_ptr<const T> shared(T value) {
  return std::make_shared<const T>(std::move(value));
}

}  // namespace

OpenedFile open_file(std::string bytes, const std::string& name) {
  OpenedFile file;
  file.name = stem_of(name);
  std::string extension = file_extension(name);
  if (extension.empty() || (extension == "txt" && extension_of_content(bytes) == "csv"))
    extension = extension_of_content(bytes);
  const auto network = [&] {
    CurveNetwork curves = parse_network(std::move(bytes), name, &file.warnings);
    file.unit = curves.unit;
    file.content = shared(std::move(curves));
  };
  if (extension == "rawnet" || extension == "csv") {
    LogScan read = parse_scan(std::move(bytes), name);
    file.warnings = std::move(read.warnings);
    file.unit = read.scan.unit;
    file.content = shared(std::move(read.scan));
  } else if (extension == "json" && is_calibration(bytes)) {
    file.content = parse_calibration(bytes, name);
  } else if (holds_network(extension, bytes)) {
    network();
  } else {
    file.content = shared(parse_mesh(std::move(bytes), name, &file.warnings));
  }
  return file;
}

}  // namespace batten
