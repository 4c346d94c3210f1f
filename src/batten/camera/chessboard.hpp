#pragma once
#include <optional>
#include <string>

#include "batten/camera/board.hpp"
#include "batten/camera/grey_image.hpp"

namespace batten {

/// Options of find_chessboard().
struct ChessboardOptions {
  /// Half the difference of bright and dark squares, grey levels of 255, below which an image is too dark; at
  /// least 2. Lower finds boards in the dark, with less exact corners.
  double contrast = 10.0;
  /// Blur of the image as the standard deviation of a Gaussian, in sides of a square, above which it is
  /// refused; 0.01 to 0.5. A blur of 2 pixels is never refused.
  double blur = 0.08;
  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// Result of find_chessboard(): all corners of the board, or why there are none.
struct ChessboardSearch {
  std::optional<BoardCorners> corners;  ///< n_corners × 2, pixels from the outer corner of the first
  std::string reason;                   ///< a sentence with the remedy where `corners` is empty
  double contrast = 0;  ///< half the difference of bright and dark squares, grey levels, median
  double blur = 0;      ///< of the image, standard deviation in pixels, median
};

/// Finds the inner corners of a chessboard, all of them or none.
///
/// Saddle points of the blurred image are candidates; from a square of four whose sides have dark on one side
/// and bright on the other, the grid grows by local affine prediction, each new side with dark and bright
/// exchanged. Corners are the saddle points of quadrics fitted to round windows [lucchese2002]. Several
/// widths of the blur are tried, the finest first.
///
/// Corner (0, 0) and the direction of the rows are those for which columns and rows turn as x and y of the
/// image do, and the square before the first corner, beyond which the board ends, is dark: the same corner of
/// the board in every image. Where corners are missing, or a grid of another size is found, the image is
/// refused with the count; an image in which the board is dark or blurred as well. Cost: some 50 operations
/// per pixel.
/// @throws InvalidInput as problem() of board and options.
ChessboardSearch find_chessboard(const GreyImage& image, const Board& board,
                                 const ChessboardOptions& options = {});

}  // namespace batten
