#include "rig_input.hpp"

#include <cctype>
#include <filesystem>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/file.hpp"
#include "batten/io/rig_io.hpp"
#include "batten/pipeline/calibrated_rig.hpp"
#include "batten/render/photograph.hpp"

namespace batten::cli {

namespace {

bool is_image(const std::string& path) {
  const std::string extension = file_extension(path);
  return extension == "png" || extension == "jpg" || extension == "jpeg" || extension == "pgm";
}

/// Side and number of a pair from the name of an image; the folder does not count.
BoardPhotograph named_photograph(const std::string& path) {
  BoardPhotograph photograph;
  photograph.name = path;
  const std::string stem = lower_case(std::filesystem::path(path).stem().string());
  const bool is_left = stem.find("left") != std::string::npos;
  photograph.is_right = stem.find("right") != std::string::npos;
  const auto is_digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  std::size_t end = stem.size();
  while (end > 0 && !is_digit(stem[end - 1])) --end;
  std::size_t begin = end;
  while (begin > 0 && is_digit(stem[begin - 1])) --begin;
  long number = 0;
  if (is_left == photograph.is_right || begin == end || end - begin > 6 ||
      !parse_integer(std::string_view(stem).substr(begin, end - begin), number))
    throw FileError(path, 0,
                    "does not say by its name to which pair and camera it belongs; call images left01.png, "
                    "right01.png and so on");
  photograph.pair = static_cast<int>(number);
  return photograph;
}

}  // namespace

BoardPairs read_board_pairs(const std::vector<std::string>& inputs, const Board& board,
                            const std::string& image_size, std::vector<std::string>& warnings,
                            const Progress& progress) {
  if (inputs.size() == 1 && !is_image(inputs[0])) {
    CornersOptions options{.board = board, .size = {}};
    if (!image_size.empty()) options.size = parse_image_size(image_size);
    return read_corners(inputs[0], options, &warnings);
  }
  std::vector<BoardPhotograph> photographs;
  for (const std::string& path : inputs) {
    if (!is_image(path))
      throw FileError(path, 0, "is neither an image nor alone; give one file of corners, or images");
    BoardPhotograph photograph = named_photograph(path);
    photograph.image = read_photograph(path);
    photographs.push_back(std::move(photograph));
  }
  FoundBoards found = boards_in_images(photographs, board, {}, progress);
  warnings.insert(warnings.end(), found.warnings.begin(), found.warnings.end());
  return std::move(found.pairs);
}

}  // namespace batten::cli
