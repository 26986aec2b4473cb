// Lenses from pictures of a ChArUco board.
#pragma once

#include "calibrate/lens/calibrate_lens.h"

namespace raywalk::calibrate {

// Reads the pictures, finds the board in them and fits both lenses, the pose of the back lens and
// the pose of the board in every picture to its corners. Fills all of LensFit. If no picture shows
// the board to both lenses, the pose of the back lens stays that of the start. Throws Error for
// pictures of different sizes or of another aspect ratio than the start's, and if too few show the
// board, or too little of it; Interrupted.
LensFit fit_to_board(const DualFisheyeCamera& start, const LensOptions& options);

}  // namespace raywalk::calibrate
