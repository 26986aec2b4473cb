// A ChArUco board by OpenCV: its corners, found in a picture, and its picture to print.
//
// OpenCV 4.7 moved this from its contributed module aruco (charuco_markers_aruco.cc, Debian 12) to
// objdetect (charuco_markers_objdetect.cc, Debian 13).
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace cv::aruco {
class CharucoBoard;
}

namespace raywalk::calibrate {

// corners[i] is the board's corner ids[i], pixels of the picture. OpenCV 4.6 and 4.10 count them
// from the outer edge of the first pixel, not from its centre.
struct CharucoCorners {
  std::vector<cv::Point2f> corners{};
  std::vector<int> ids{};
};

// Safe to use from several threads at once.
class CharucoMarkers {
 public:
  // `dictionary` is OpenCV's number of a predefined one.
  CharucoMarkers(cv::Size squares, float square_m, float marker_m, int dictionary);

  // Where the inner corners of the chessboard are on the board, by id; metres from its top left, x
  // to the right, y down, z = 0.
  const std::vector<cv::Point3f>& board_m() const { return board_m_; }

  // In a picture of CV_8UC1, within about a pixel.
  CharucoCorners find(const cv::Mat& grey) const;

  // CV_8UC1, as large as it fits into `size` pixels.
  cv::Mat draw(cv::Size size) const;

 private:
  cv::Ptr<cv::aruco::CharucoBoard> board_;
  std::vector<cv::Point3f> board_m_;
};

}  // namespace raywalk::calibrate
