#include "calibrate/stitch/frame_pictures.h"

#include <fmt/format.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "calibrate/base/frame_masks.h"
#include "core/base/error.h"
#include "core/files/image_file.h"

namespace raywalk::calibrate {
namespace {

// The border may be lit a little by flare; a panorama is as bright there as elsewhere.
constexpr double kBrightBorder_levels = 64.0;
constexpr double kBorder = 1.04;  // start of the border, relative to the image circle's radius
constexpr int kLeastBorder_px = 64;

double circle_radius_px(const FisheyeLens& lens) {
  const double angle = lens.largest_angle_rad;
  const auto rim = project(lens, {std::sin(angle - 1e-6), 0.0, std::cos(angle - 1e-6)});
  return rim ? rim->u - lens.centre.u : 0.0;
}

void clear_circle(const FisheyeLens& lens, cv::Mat* border) {
  cv::circle(
      *border,
      {static_cast<int>(std::lround(lens.centre.u)), static_cast<int>(std::lround(lens.centre.v))},
      static_cast<int>(std::ceil(kBorder * circle_radius_px(lens))), cv::Scalar(0), cv::FILLED);
}

// Detects panoramas of the size of a dual-fisheye frame: they have no dark border around circles.
void require_dark_border(const cv::Mat& picture, const cv::Mat& border,
                         const std::filesystem::path& file) {
  if (cv::countNonZero(border) < kLeastBorder_px) return;
  const cv::Scalar mean = cv::mean(picture, border);
  if ((mean[0] + mean[1] + mean[2]) / 3.0 < kBrightBorder_levels) return;
  throw Error(file.string() +
              ": bright around the image circles of the lens file; it is a panorama, or the lens "
              "file is of another camera");
}

cv::Mat read_checked(const std::filesystem::path& file, PanoramaSize size) {
  cv::Mat picture = read_picture(file);
  if (picture.cols != size.width || picture.rows != size.height) {
    throw Error(
        fmt::format("{}: {}x{}, but the other frames are {}x{}; remove it, or capture the "
                    "station again",
                    file.string(), picture.cols, picture.rows, size.width, size.height));
  }
  return picture;
}

cv::Mat border_of(PanoramaSize size) { return {size.height, size.width, CV_8UC1, cv::Scalar(255)}; }

}  // namespace

FramePictures read_frame_pictures(const CaptureFrame& frame, const DualFisheyeCamera& camera) {
  FramePictures pictures;
  cv::Mat border = border_of(camera.picture);
  pictures.front = read_checked(frame.file, camera.picture);
  pictures.mask = own_mask(frame, camera.picture);
  clear_circle(camera.layout.front, &border);
  if (!frame.back) {
    clear_circle(camera.layout.back, &border);
    require_dark_border(pictures.front, border, frame.file);
    pictures.back = pictures.front;
    return pictures;
  }
  require_dark_border(pictures.front, border, frame.file);
  pictures.back = read_checked(*frame.back, camera.picture);
  border = border_of(camera.picture);
  clear_circle(camera.layout.back, &border);
  require_dark_border(pictures.back, border, *frame.back);
  return pictures;
}

}  // namespace raywalk::calibrate
