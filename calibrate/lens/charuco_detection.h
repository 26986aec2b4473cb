// Corners of a ChArUco board in the pictures of a dual-fisheye camera.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calibrate/lens/calibrate_lens.h"
#include "calibrate/lens/lens_features.h"

namespace raywalk::calibrate {

struct BoardCorner {
  bool back = false;  // seen by which lens
  PixelPosition seen{};
  // On the board, metres: x to the right, y up as the board is drawn, z = 0, from its top left.
  Eigen::Vector3d on_board_m{0, 0, 0};
};

struct BoardView {
  std::vector<BoardCorner> corners{};
  // Of the board in the camera's frame, by the starting lenses: p_camera = turn p_board + shift.
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  Eigen::Vector3d shift_m{0, 0, 0};
};

// Throws UsageError for a dictionary that OpenCV does not have, and sizes that cannot be.
void require_valid(const CharucoBoard& board);

// Looks through both lenses by pinhole views cut out with the starting lenses: straight lines are
// straight there, which the detection of markers builds on. Made once for many pictures. Safe to
// use from several threads at once.
class BoardFinder {
 public:
  // `board` has to be valid.
  BoardFinder(const DualFisheyeCamera& start, const CharucoBoard& board);
  ~BoardFinder();

  // A corner seen in several views is taken from the one whose middle it is nearest to. None where
  // no view shows six corners.
  std::optional<BoardView> find(const LensPictures& pictures) const;

 private:
  struct View;

  DualFisheyeCamera start_;
  CharucoBoard board_;
  std::vector<View> views_;
};

}  // namespace raywalk::calibrate
