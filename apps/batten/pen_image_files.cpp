#include "pen_image_files.hpp"

#include <cstdio>
#include <filesystem>

#include "batten/core/error.hpp"
#include "batten/core/parallel.hpp"
#include "batten/core/text.hpp"
#include "batten/io/blobs_io.hpp"
#include "batten/io/file.hpp"
#include "batten/pipeline/image_blobs.hpp"
#include "batten/render/photograph.hpp"

namespace batten::cli {

namespace {

namespace fs = std::filesystem;

std::string image_name(CameraSide camera, int number) {
  char name[32];
  std::snprintf(name, sizeof name, "%s-%05d.pgm", camera == CameraSide::Left ? "left" : "right", number);
  return name;
}

std::string pgm_of(const GreyImage& image) {
  std::string bytes = concat("P5\n", image.width, " ", image.height, "\n255\n");
  bytes.append(image.pixels.begin(), image.pixels.end());
  return bytes;
}

/// Refuses what read_photograph() would turn into grey levels that a sensor has not measured.
void check_pen_image(const std::string& bytes, const std::string& path) {
  constexpr std::size_t kDepth = 24, kColour = 25;  // of a PNG's header
  if (bytes.rfind("\xff\xd8", 0) == 0)
    throw FileError(path, 0, "is a JPEG, whose losses move spots of light; record PNG or PGM");
  if (bytes.rfind("P6", 0) == 0)
    throw FileError(path, 0, "is an image in colour; record grey levels of 8 bits (PNG or PGM)");
  if (bytes.rfind("\x89PNG", 0) != 0 || bytes.size() <= kColour) return;
  if (bytes[kDepth] != 8)
    throw FileError(path, 0,
                    concat("is a PNG of ", static_cast<int>(bytes[kDepth]),
                           " bits per pixel; record grey levels of 8 bits"));
  if (bytes[kColour] != 0)
    throw FileError(path, 0, "is an image in colour; record grey levels of 8 bits (PNG or PGM)");
}

Json side_json(const ImagedSide& side) {
  return {{"images", side.images},
          {"blobs", side.blobs},
          {"refused",
           {{"cut", side.refused.cut},
            {"size", side.refused.size},
            {"shape", side.refused.shape},
            {"bright", side.refused.bright}}},
          {"background", side.background},
          {"noise", side.noise},
          {"clipped", side.clipped}};
}

}  // namespace

void write_pen_images(const SimulatedPen& simulated, std::uint64_t seed, const std::string& folder,
                      const Progress& progress) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) throw FileError(folder, 0, concat("cannot be made: ", failed.message()));
  BlobRecording list = simulated.recording;
  int numbers[2] = {0, 0};
  for (BlobFrame& frame : list.frames) {
    frame.blobs.clear();
    frame.image = image_name(frame.camera, numbers[frame.camera == CameraSide::Right ? 1 : 0]++);
  }
  const auto draw = [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index i = begin; i < end; ++i) {
      const BlobFrame& frame = list.frames[static_cast<std::size_t>(i)];
      const bool right = frame.camera == CameraSide::Right;
      // Each camera looks at another wall.
      const std::uint64_t room = 2 * seed + (right ? 1 : 0);
      const GreyImage image =
          pen_image(right ? simulated.actual.right : simulated.actual.left,
                    simulated.lights[static_cast<std::size_t>(i)], room, static_cast<std::uint64_t>(i));
      write_file((fs::path(folder) / frame.image).string(), pgm_of(image));
    }
  };
  parallel_for(static_cast<Eigen::Index>(list.frames.size()), 1, draw, progress);
  write_blobs(list, (fs::path(folder) / kImageList).string());
}

BlobRecording read_pen_recording(const std::string& input, const StereoRig& rig, Outcome& outcome,
                                 const Progress& progress) {
  std::string path = input;
  if (fs::is_directory(input)) {
    path = (fs::path(input) / kImageList).string();
    if (!fs::exists(path))
      throw FileError(input, 0, concat("holds no ", kImageList, ", the list of its images with their times"));
  }
  BlobRecording recording;
  {
    const ScopedStage stage(outcome.times, "read");
    recording = read_blobs(path, &outcome.warnings);
  }
  bool has_images = false;
  for (const BlobFrame& frame : recording.frames) has_images = has_images || !frame.image.empty();
  if (!has_images) return recording;
  const ScopedStage stage(outcome.times, "blobs");
  const fs::path folder = fs::path(path).parent_path();
  const auto read = [&](const std::string& name) {
    const std::string file = (folder / name).string();
    const std::string bytes = read_file(file);
    check_pen_image(bytes, file);
    return parse_photograph(bytes, file);
  };
  ImageBlobs found;
  try {
    found = blobs_of_images(std::move(recording), rig, read, progress);
  } catch (const FileError&) {
    throw;
  } catch (const InvalidInput& error) {
    throw FileError(input, 0, error.what());
  }
  outcome.warnings.insert(outcome.warnings.end(), found.warnings.begin(), found.warnings.end());
  outcome.figures["images"] = {{"left", side_json(found.sides[0])}, {"right", side_json(found.sides[1])}};
  const ImagedSide &left = found.sides[0], &right = found.sides[1];
  outcome.lines.push_back(concat(left.blobs + right.blobs, " blobs in ", left.images + right.images,
                                 " images; ", left.refused.total() + right.refused.total(),
                                 " bright spots are no LEDs"));
  return std::move(found.recording);
}

}  // namespace batten::cli
