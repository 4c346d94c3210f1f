#pragma once
#include <string>
#include <vector>

#include "batten/camera/board.hpp"
#include "batten/core/progress.hpp"

namespace batten::cli {

/// Pairs of a board from one file of corners, or from images, in which it is looked for. The last number in
/// the name of an image is that of its pair, and `left` or `right` in its name its side.
/// @param image_size "640x480", or empty; for corners alone.
/// @throws FileError; InvalidInput where names say nothing, or too few pairs remain; Cancelled.
BoardPairs read_board_pairs(const std::vector<std::string>& inputs, const Board& board,
                            const std::string& image_size, std::vector<std::string>& warnings,
                            const Progress& progress);

}  // namespace batten::cli
