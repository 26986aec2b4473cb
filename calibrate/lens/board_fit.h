// Lenses from pictures of a ChArUco board.
#pragma once

#include <vector>

#include "calibrate/lens/calibrate_lens.h"
#include "calibrate/lens/charuco_detection.h"

namespace raywalk::calibrate {

// Fits lenses, the pose of the second, and where the board was in every picture, to the corners.
// Fills all of LensFit; where no picture shows the board to both lenses, the pose of the back lens
// stays as it is in the start. Throws Error for fewer than `kLeastBoardCorners` corners of a lens.
inline constexpr int kLeastBoardCorners = 40;
LensFit fit_to_corners(const std::vector<BoardView>& views, const DualFisheyeCamera& start);

// Reads the pictures, finds the board in them and fits. Throws Error for pictures of different
// sizes or another proportion than the start's, and for too few that show the board; Interrupted.
LensFit fit_to_board(const DualFisheyeCamera& start, const LensOptions& options);

}  // namespace raywalk::calibrate
