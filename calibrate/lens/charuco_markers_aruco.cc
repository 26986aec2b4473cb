// charuco_markers.h over OpenCV 4.6 (Debian 12).

#include <opencv2/aruco/charuco.hpp>

#include "calibrate/lens/charuco_markers.h"

namespace raywalk::calibrate {

CharucoMarkers::CharucoMarkers(cv::Size squares, float square_m, float marker_m, int dictionary)
    : board_(cv::aruco::CharucoBoard::create(squares.width, squares.height, square_m, marker_m,
                                             cv::aruco::getPredefinedDictionary(dictionary))),
      board_m_(board_->chessboardCorners) {}

CharucoCorners CharucoMarkers::find(const cv::Mat& grey) const {
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> marker_ids;
  cv::aruco::detectMarkers(grey, board_->dictionary, markers, marker_ids);
  CharucoCorners found;
  if (marker_ids.empty()) return found;
  cv::aruco::interpolateCornersCharuco(markers, marker_ids, grey, board_, found.corners, found.ids);
  return found;
}

cv::Mat CharucoMarkers::draw(cv::Size size) const {
  cv::Mat picture;
  board_->draw(size, picture);
  return picture;
}

}  // namespace raywalk::calibrate
