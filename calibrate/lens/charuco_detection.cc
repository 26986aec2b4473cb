#include "calibrate/lens/charuco_detection.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include "calibrate/lens/charuco_markers.h"
#include "calibrate/lens/image_circle.h"
#include "core/base/error.h"

namespace raywalk::calibrate {
namespace {

// In the order of OpenCV's enumeration, which starts at 0.
constexpr std::array<std::string_view, 17> kDictionaries{
    "DICT_4X4_50",   "DICT_4X4_100",       "DICT_4X4_250",  "DICT_4X4_1000", "DICT_5X5_50",
    "DICT_5X5_100",  "DICT_5X5_250",       "DICT_5X5_1000", "DICT_6X6_50",   "DICT_6X6_100",
    "DICT_6X6_250",  "DICT_6X6_1000",      "DICT_7X7_50",   "DICT_7X7_100",  "DICT_7X7_250",
    "DICT_7X7_1000", "DICT_ARUCO_ORIGINAL"};

constexpr std::size_t kLeastCorners = 6;

// Pinhole views: one along the axis, a ring around it half way out and a ring at the rim, each wide
// enough that a whole board lies in one of them.
constexpr double kViewHalfAngle_rad = radians_from_degrees(40.0);
constexpr double kMiddleRing_rad = radians_from_degrees(45.0);
constexpr double kOuterRing_rad = radians_from_degrees(75.0);
constexpr int kMiddleViews = 6;
constexpr int kOuterViews = 10;
// Resolution relative to the middle of the lens: the sub-pixel search for a corner needs some
// pixels of its edges, and pinhole views are finer at their borders anyway.
constexpr double kEnlarged = 1.5;

CharucoMarkers markers_of(const CharucoBoard& board) {
  const auto* name = std::find(kDictionaries.begin(), kDictionaries.end(), board.dictionary);
  return {{board.squares_x, board.squares_y},
          static_cast<float>(0.001 * board.square_mm),
          static_cast<float>(0.001 * board.marker_mm),
          static_cast<int>(name - kDictionaries.begin())};
}

// A pinhole view in a lens's frame: columns of `lens_from_view` are its right, up and forward.
struct PinholeView {
  bool back = false;
  Eigen::Matrix3d lens_from_view = Eigen::Matrix3d::Identity();
  double focal_px = 0.0;
  int side_px = 0;

  double centre_px() const { return 0.5 * (side_px - 1); }
  Eigen::Vector3d direction(double u, double v) const {
    return lens_from_view *
           Eigen::Vector3d((u - centre_px()) / focal_px, (centre_px() - v) / focal_px, 1.0);
  }
};

PinholeView view_towards(bool back, const FisheyeLens& lens, double off_axis_rad,
                         double azimuth_rad) {
  PinholeView view;
  view.back = back;
  view.focal_px = kEnlarged * lens.focal_px;
  view.side_px = static_cast<int>(std::ceil(2.0 * view.focal_px * std::tan(kViewHalfAngle_rad)));
  const Eigen::Vector3d forward(std::sin(off_axis_rad) * std::cos(azimuth_rad),
                                std::sin(off_axis_rad) * std::sin(azimuth_rad),
                                std::cos(off_axis_rad));
  view.lens_from_view =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), forward).toRotationMatrix();
  return view;
}

std::vector<PinholeView> views_through(bool back, const FisheyeLens& lens) {
  std::vector<PinholeView> views{view_towards(back, lens, 0.0, 0.0)};
  for (int i = 0; i < kMiddleViews; ++i) {
    views.push_back(view_towards(back, lens, kMiddleRing_rad, kTwoPi * i / kMiddleViews));
  }
  for (int i = 0; i < kOuterViews; ++i) {
    views.push_back(view_towards(back, lens, kOuterRing_rad, kTwoPi * i / kOuterViews));
  }
  return views;
}

// The positions of a view's pixels in the picture for cv::remap: CV_32FC2, outside of the picture
// beyond the lens's field of view.
cv::Mat map_of(const PinholeView& view, const FisheyeLens& lens) {
  cv::Mat map(view.side_px, view.side_px, CV_32FC2, cv::Scalar(-10.0, -10.0));
  for (int v = 0; v < view.side_px; ++v) {
    for (int u = 0; u < view.side_px; ++u) {
      if (const auto pixel = project(lens, view.direction(u, v))) {
        map.at<cv::Vec2f>(v, u) = {static_cast<float>(pixel->u), static_cast<float>(pixel->v)};
      }
    }
  }
  return map;
}

cv::Mat grey_of(const cv::Mat& picture) {
  cv::Mat grey;
  cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

// The distance to the nearest other corner: the apparent side of a square.
float square_side_px(const std::vector<cv::Point2f>& corners, std::size_t corner) {
  float nearest = std::numeric_limits<float>::infinity();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (i == corner) continue;
    nearest = std::min(
        nearest, std::hypot(corners[i].x - corners[corner].x, corners[i].y - corners[corner].y));
  }
  return nearest;
}

// OpenCV refines corners in a window of a pixel or two, with an offset of half a pixel to the right
// and down. Here the window is as wide as possible without reaching the markers.
void refine(const cv::Mat& view, const CharucoBoard& board, std::vector<cv::Point2f>* corners) {
  constexpr int kLeastWindow_px = 2, kLargestWindow_px = 12;
  const auto gap = static_cast<float>(0.5 * (1.0 - board.marker_mm / board.square_mm));
  const std::vector<cv::Point2f> found = *corners;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const float side_px = square_side_px(found, i);
    const int window_px = std::isfinite(side_px) ? std::clamp(static_cast<int>(gap * side_px),
                                                              kLeastWindow_px, kLargestWindow_px)
                                                 : kLeastWindow_px;
    std::vector<cv::Point2f> one{found[i] - cv::Point2f(0.5F, 0.5F)};
    cv::cornerSubPix(view, one, {window_px, window_px}, {-1, -1},
                     {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.005});
    (*corners)[i] = one[0];
  }
}

// OpenCV's frames are right-handed with y down; flipping y converts board, camera and the rotation
// between them to ours.
void set_pose(const PinholeView& view, const CharucoCorners& found,
              const std::vector<cv::Point3f>& board_m, const DualFisheyeLayout& layout,
              BoardView* result) {
  std::vector<cv::Point3f> on_board;
  for (const int id : found.ids) on_board.push_back(board_m[static_cast<std::size_t>(id)]);
  const cv::Matx33d pinhole(view.focal_px, 0, view.centre_px(), 0, view.focal_px, view.centre_px(),
                            0, 0, 1);
  cv::Vec3d turn, shift;
  cv::solvePnP(on_board, found.corners, pinhole, cv::noArray(), turn, shift);
  cv::Matx33d matrix;
  cv::Rodrigues(turn, matrix);
  Eigen::Matrix3d in_view;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) in_view(i, j) = ((i == 1) != (j == 1) ? -1.0 : 1.0) * matrix(i, j);
  }
  const Eigen::Vector3d shift_m(shift[0], -shift[1], shift[2]);
  const Eigen::Matrix3d camera_from_lens =
      view.back ? world_from_camera(layout.back_attitude) : Eigen::Matrix3d::Identity();
  const Eigen::Vector3d& lens_m = view.back ? layout.back_position_m : layout.front_position_m;
  result->turn = camera_from_lens * view.lens_from_view * in_view;
  result->shift_m = camera_from_lens * view.lens_from_view * shift_m + lens_m;
}

}  // namespace

void require_valid(const CharucoBoard& board) {
  if (std::find(kDictionaries.begin(), kDictionaries.end(), board.dictionary) ==
      kDictionaries.end()) {
    throw UsageError(board.dictionary +
                     ": unknown dictionary of ArUco markers; OpenCV's names are DICT_4X4_50 to "
                     "DICT_7X7_1000 and DICT_ARUCO_ORIGINAL");
  }
  if (board.squares_x < 3 || board.squares_y < 3) {
    throw UsageError(
        fmt::format("a ChArUco board of {} x {} squares has too few corners; it needs "
                    "at least 3 x 3",
                    board.squares_x, board.squares_y));
  }
  if (!(board.marker_mm > 0.0 && board.marker_mm < board.square_mm)) {
    throw UsageError(
        fmt::format("the markers of a ChArUco board are smaller than its squares, but {:g} "
                    "mm is not less than {:g} mm",
                    board.marker_mm, board.square_mm));
  }
}

struct BoardFinder::View {
  PinholeView pinhole{};
  cv::Mat map{};
};

BoardFinder::BoardFinder(const DualFisheyeCamera& start, const CharucoBoard& board)
    : start_(start), board_(board) {
  for (const bool back : {false, true}) {
    const FisheyeLens& lens = back ? start.layout.back : start.layout.front;
    for (const PinholeView& view : views_through(back, lens)) {
      views_.push_back({view, map_of(view, lens)});
    }
  }
}

BoardFinder::~BoardFinder() = default;

std::optional<BoardView> BoardFinder::find(const LensPictures& pictures) const {
  const CharucoMarkers markers = markers_of(board_);
  const std::array<cv::Mat, 2> grey{grey_of(pictures.front), grey_of(pictures.back)};
  BoardView result;
  // By lens and corner, with the distance from the middle of its view.
  std::map<std::pair<bool, int>, std::pair<double, BoardCorner>> nearest;
  std::size_t most = 0;
  for (const View& view : views_) {
    const bool back = view.pinhole.back;
    cv::Mat picture;
    cv::remap(grey[back ? 1 : 0], picture, view.map, cv::noArray(), cv::INTER_CUBIC,
              cv::BORDER_CONSTANT);
    CharucoCorners found = markers.find(picture);
    refine(picture, board_, &found.corners);
    if (found.ids.size() >= kLeastCorners && found.ids.size() > most) {
      most = found.ids.size();
      set_pose(view.pinhole, found, markers.board_m(), start_.layout, &result);
    }
    for (std::size_t i = 0; i < found.ids.size(); ++i) {
      const cv::Point2f at = found.corners[i];
      const auto seen = project(back ? start_.layout.back : start_.layout.front,
                                view.pinhole.direction(at.x, at.y));
      if (!seen || (!start_.two_files && belongs_to_back(start_.layout, *seen) != back)) continue;
      const double middle_px = view.pinhole.centre_px();
      const double off_px = std::hypot(at.x - middle_px, at.y - middle_px);
      const auto key = std::pair(back, found.ids[i]);
      const auto known = nearest.find(key);
      if (known != nearest.end() && known->second.first <= off_px) continue;
      const cv::Point3f on_board = markers.board_m()[static_cast<std::size_t>(found.ids[i])];
      nearest[key] = {off_px, {back, *seen, {on_board.x, -on_board.y, on_board.z}}};
    }
  }
  if (most == 0) return std::nullopt;
  for (const auto& [key, corner] : nearest) result.corners.push_back(corner.second);
  return result;
}

}  // namespace raywalk::calibrate
