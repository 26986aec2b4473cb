// charuco_markers.h over OpenCV 4.7 and later (Debian 13 has 4.10).

#include <opencv2/objdetect/charuco_detector.hpp>

#include "calibrate/lens/charuco_markers.h"

namespace raywalk::calibrate {

CharucoMarkers::CharucoMarkers(cv::Size squares, float square_m, float marker_m, int dictionary)
    : board_(cv::makePtr<cv::aruco::CharucoBoard>(squares, square_m, marker_m,
                                                  cv::aruco::getPredefinedDictionary(dictionary))),
      board_m_(board_->getChessboardCorners()) {}

CharucoCorners CharucoMarkers::find(const cv::Mat& grey) const {
  const cv::aruco::CharucoDetector detector(*board_);
  CharucoCorners found;
  detector.detectBoard(grey, found.corners, found.ids);
  return found;
}

cv::Mat CharucoMarkers::draw(cv::Size size) const {
  cv::Mat picture;
  board_->generateImage(size, picture);
  return picture;
}

}  // namespace raywalk::calibrate
