// Corners of a ChArUco board in the pictures of a dual-fisheye camera.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calibrate/lens/calibrate_lens.h"
#include "calibrate/lens/lens_features.h"

namespace raywalk::calibrate {

struct BoardCorner {
  bool back = false;  // which lens
  PixelPosition seen{};
  // Position on the board, metres, from its top left: x to the right, y up as the board is drawn,
  // z = 0.
  Eigen::Vector3d on_board_m{0, 0, 0};
};

struct BoardView {
  std::vector<BoardCorner> corners{};
  // Initial pose of the board, by the starting lenses: p_camera = turn p_board + shift_m.
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  Eigen::Vector3d shift_m{0, 0, 0};
};

// Throws UsageError for a dictionary unknown to OpenCV and for invalid sizes.
void require_valid(const CharucoBoard& board);

// Finds the board in pinhole views that are cut from both fisheye pictures with the starting
// lenses: the detection of markers relies on straight lines. Construct once for many pictures.
// Thread-safe.
class BoardFinder {
 public:
  // `board` must be valid (require_valid).
  BoardFinder(const DualFisheyeCamera& start, const CharucoBoard& board);
  ~BoardFinder();

  // A corner seen in several views is taken from the one whose middle it is nearest to. nullopt if
  // no view shows six corners.
  std::optional<BoardView> find(const LensPictures& pictures) const;

 private:
  struct View;

  DualFisheyeCamera start_;
  CharucoBoard board_;
  std::vector<View> views_;
};

}  // namespace raywalk::calibrate
