#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>

#include "batten/core/error.hpp"
#include "batten/core/index.hpp"
#include "batten/core/text.hpp"
#include "batten/io/file.hpp"
#include "batten/io/rig_io.hpp"
#include "batten/io/scan_text_detail.hpp"

namespace batten {

namespace {

/// From the convention of the file, where the centre of the first pixel is (0, 0), to ours.
constexpr double kShift = 0.5;

/// Places of the fields in a row; −1: not there.
struct Columns {
  int pair = 0, camera = 1, column = 2, row = 3, u = 4, v = 5;
  int n = 6;
};

/// Columns by their names, or nothing where the line names none.
std::optional<Columns> columns_of(std::string_view line) {
  line = line.substr(0, line.find(';'));
  const std::vector<std::string_view> names = split_fields(line, ',');
  Columns columns{-1, -1, -1, -1, -1, -1, static_cast<int>(names.size())};
  const std::pair<int*, std::vector<std::string_view>> known[] = {{&columns.pair, {"pair"}},
                                                                  {&columns.camera, {"camera", "side"}},
                                                                  {&columns.column, {"col", "column"}},
                                                                  {&columns.row, {"row"}},
                                                                  {&columns.u, {"x_px", "u", "x", "u_px"}},
                                                                  {&columns.v, {"y_px", "v", "y", "v_px"}}};
  for (int i = 0; i < columns.n; ++i)
    for (const auto& [place, words] : known)
      if (std::find(words.begin(), words.end(), lower_case(names[at(i)])) != words.end()) *place = i;
  for (const auto& [place, words] : known)
    if (*place < 0) return {};
  return columns;
}

/// The smallest of the usual sizes of images that holds a pixel.
ImageSize usual_size(double u, double v) {
  constexpr ImageSize kUsual[] = {{128, 96},    {160, 120},   {320, 240},   {640, 480},   {752, 480},
                                  {800, 600},   {1024, 768},  {1280, 720},  {1280, 960},  {1280, 1024},
                                  {1600, 1200}, {1920, 1080}, {1920, 1200}, {2048, 1536}, {2592, 1944},
                                  {3840, 2160}, {4096, 3072}};
  for (const ImageSize& size : kUsual)
    if (u <= size.width && v <= size.height) return size;
  return {static_cast<int>(std::ceil(u)), static_cast<int>(std::ceil(v))};
}

/// Reads the rows of a file.
class CornersParser {
 public:
  CornersParser(LineReader& reader, const Board& board) : reader_(reader), board_(board) {}

  void parse_line(std::string_view line) {
    line = trim(line);
    if (line.empty()) return;
    const bool is_comment = line.front() == '#';
    if (is_comment) line = trim(line.substr(1));
    if (const auto named = columns_of(line)) {
      if (!pairs_.empty()) reader_.fail("names the columns after the first row; name them once, before it");
      columns_ = *named;
    } else if (is_comment) {
      parse_comment(line);
    } else {
      parse_row(line);
    }
  }

  /// @param size empty: as CornersOptions::size.
  BoardPairs finish(std::optional<ImageSize> size, std::vector<std::string>* warnings) {
    if (pairs_.empty())
      throw FileError(reader_.path(), 0,
                      "holds no corners; expected rows pair,camera,corner,col,row,x_px,y_px");
    if (!size) size = size_;
    if (!size) {
      size = usual_size(largest_.x(), largest_.y());
      if (warnings != nullptr)
        warnings->push_back(concat(reader_.path(), " does not say how large the images are; ", size->width,
                                   "x", size->height, " is taken, --image-size says otherwise"));
    }
    BoardPairs result;
    result.board = board_;
    result.left_width = result.right_width = size->width;
    result.left_height = result.right_height = size->height;
    for (auto& [number, pair] : pairs_) result.pairs.push_back(std::move(pair));
    if (const auto found = problem(result)) throw FileError(reader_.path(), 0, *found);
    return result;
  }

 private:
  void parse_comment(std::string_view line) {
    constexpr std::string_view kSize = "image_size:";
    if (line.substr(0, kSize.size()) != kSize) return;
    try {
      size_ = parse_image_size(std::string(trim(line.substr(kSize.size()))));
    } catch (const InvalidInput& error) {
      reader_.fail(error.what());
    }
  }

  long integer(std::string_view field, const char* name, long least, long most) const {
    long value = 0;
    if (!parse_integer(field, value) || value < least || value > most)
      reader_.fail(concat(name, " must be a whole number from ", least, " to ", most, ", got ",
                          detail::quoted(field)));
    return value;
  }

  double coordinate(std::string_view field, const char* name) const {
    double value = 0;
    if (!parse_number(field, value) || !std::isfinite(value) || std::abs(value) > 1e5)
      reader_.fail(concat(name, " must be a number of pixels, got ", detail::quoted(field)));
    return value + kShift;
  }

  void parse_row(std::string_view line) {
    const std::vector<std::string_view> fields = split_fields(line, ',');
    if (fields.size() != at(columns_.n))
      reader_.fail(concat("expected ", columns_.n, " fields, got ", fields.size(),
                          "; name the columns before the first row: pair,camera,corner,col,row,x_px,y_px"));
    const int number = static_cast<int>(integer(fields[at(columns_.pair)], "pair", 0, 1000000));
    const std::string side = lower_case(fields[at(columns_.camera)]);
    if (side != "left" && side != "right")
      reader_.fail(concat("camera must be left or right, got ", detail::quoted(side)));
    const long column = integer(fields[at(columns_.column)], "col", 0, 1000000);
    const long row = integer(fields[at(columns_.row)], "row", 0, 1000000);
    if (column >= board_.columns || row >= board_.rows)
      reader_.fail(concat("corner (", column, ", ", row, ") is not on a board of ", board_.columns, "x",
                          board_.rows, " inner corners; --board says which board it is"));
    const Eigen::Vector2d pixel(coordinate(fields[at(columns_.u)], "x"),
                                coordinate(fields[at(columns_.v)], "y"));
    BoardPair& pair = pair_of(number);
    auto corner = (side == "left" ? pair.left : pair.right).row(row * board_.columns + column);
    if (corner.allFinite())
      reader_.fail(concat("corner (", column, ", ", row, ") of the ", side, " image of pair ", number,
                          " comes twice"));
    corner = pixel.transpose();
    largest_ = largest_.cwiseMax(pixel);
  }

  BoardPair& pair_of(int number) {
    constexpr std::size_t kMostPairs = 2000;  // nobody takes more, and a broken file would fill the memory
    const auto [place, is_new] = pairs_.try_emplace(number);
    if (is_new) {
      if (pairs_.size() > kMostPairs) reader_.fail(concat("more than ", kMostPairs, " pairs"));
      place->second.number = number;
      place->second.left =
          BoardCorners::Constant(board_.n_corners(), 2, std::numeric_limits<double>::quiet_NaN());
      place->second.right = place->second.left;
    }
    return place->second;
  }

  LineReader& reader_;
  const Board& board_;
  Columns columns_;
  std::optional<ImageSize> size_;
  std::map<int, BoardPair> pairs_;
  Eigen::Vector2d largest_ = Eigen::Vector2d::Zero();
};

BoardPairs read_lines(LineReader& reader, const CornersOptions& options, std::vector<std::string>* warnings) {
  if (const auto found = options.problem()) throw InvalidInput(*found);
  CornersParser parser(reader, options.board);
  std::string_view line;
  while (reader.next(line)) parser.parse_line(line);
  return parser.finish(options.size, warnings);
}

}  // namespace

std::optional<std::string> CornersOptions::problem() const {
  if (auto wrong = board.problem()) return wrong;
  if (size && (size->width < 1 || size->height < 1))
    return concat("size must be at least 1x1 pixels, got ", size->width, "x", size->height);
  return std::nullopt;
}

ImageSize parse_image_size(const std::string& text) {
  const std::size_t cross = text.find('x');
  long width = 0, height = 0;
  constexpr long kLargest = 100000;
  if (cross == std::string::npos || !parse_integer(std::string_view(text).substr(0, cross), width) ||
      !parse_integer(std::string_view(text).substr(cross + 1), height) || width < 1 || height < 1 ||
      width > kLargest || height > kLargest)
    throw InvalidInput(concat(detail::quoted(text), " is no size of an image; write it as 640x480"));
  return {static_cast<int>(width), static_cast<int>(height)};
}

BoardPairs read_corners(const std::string& path, const CornersOptions& options,
                        std::vector<std::string>* warnings) {
  LineReader reader(path);
  return read_lines(reader, options, warnings);
}

BoardPairs parse_corners(std::string text, const std::string& name, const CornersOptions& options,
                         std::vector<std::string>* warnings) {
  LineReader reader(std::move(text), name);
  return read_lines(reader, options, warnings);
}

void write_corners(const BoardPairs& pairs, const std::string& path) {
  if (const auto found = problem(pairs)) throw InvalidInput(*found);
  if (pairs.left_width != pairs.right_width || pairs.left_height != pairs.right_height)
    throw InvalidInput("a file of corners holds one size of images for both cameras");
  std::string text = concat("# image_size: ", pairs.left_width, "x", pairs.left_height,
                            "\n# pair,camera,corner,col,row,x_px,y_px ; ", pairs.board.columns, "x",
                            pairs.board.rows, " inner corners; the centre of the first pixel is (0, 0)\n");
  const auto add = [&](const BoardPair& pair, const BoardCorners& corners, const char* side) {
    for (int i = 0; i < pairs.board.n_corners(); ++i)
      if (corners.row(i).allFinite())
        text += concat(pair.number, ",", side, ",", i, ",", i % pairs.board.columns, ",",
                       i / pairs.board.columns, ",", exact_decimal(corners(i, 0) - kShift), ",",
                       exact_decimal(corners(i, 1) - kShift), "\n");
  };
  for (const BoardPair& pair : pairs.pairs) {
    add(pair, pair.left, "left");
    add(pair, pair.right, "right");
  }
  write_file(path, text);
}

}  // namespace batten
