// Lenses from pictures of a ChArUco board.
#pragma once

#include <vector>

#include "calibrate/lens/calibrate_lens.h"
#include "calibrate/lens/charuco_detection.h"

namespace raywalk::calibrate {

// Fits both lenses, the pose of the back lens and the pose of the board in every picture to the
// corners. Fills all of LensFit. If no picture shows the board to both lenses, the pose of the back
// lens stays that of the start. Throws Error for fewer than `kLeastBoardCorners` corners of a lens.
inline constexpr int kLeastBoardCorners = 40;
LensFit fit_to_corners(const std::vector<BoardView>& views, const DualFisheyeCamera& start);

// Reads the pictures, finds the board in them and fits. Throws Error for pictures of different
// sizes or of another aspect ratio than the start's, and if too few show the board; Interrupted.
LensFit fit_to_board(const DualFisheyeCamera& start, const LensOptions& options);

}  // namespace raywalk::calibrate
