#include "calibrate/stitch/fisheye_frames.h"

#include <fmt/format.h>

#include <cmath>
#include <initializer_list>
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

// Detects panoramas of the size of a dual-fisheye frame: they have no dark border around circles.
void require_dark_border(const cv::Mat& picture, std::initializer_list<FisheyeLens> lenses,
                         const std::filesystem::path& file) {
  cv::Mat border(picture.size(), CV_8UC1, cv::Scalar(255));
  for (const FisheyeLens& lens : lenses) {
    const cv::Point centre(static_cast<int>(std::lround(lens.centre.u)),
                           static_cast<int>(std::lround(lens.centre.v)));
    const double rim_px = lens.focal_px * fisheye_radius(lens.k, lens.largest_angle_rad);
    cv::circle(border, centre, static_cast<int>(std::ceil(kBorder * rim_px)), cv::Scalar(0),
               cv::FILLED);
  }
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

}  // namespace

DualFisheyeCamera fitting_camera(const CaptureSet& set,
                                 const std::optional<DualFisheyeCamera>& camera) {
  if (!camera) {
    throw UsageError(
        "dual-fisheye frames need a lens file to be stitched; run raywalk-calibrate "
        "lens, or give --lens FILE");
  }
  for (const CaptureFrame& frame : set.frames) {
    if (camera->two_files == frame.back.has_value()) continue;
    throw Error(fmt::format(
        "station {}: {}, but the lens file is for a camera with {}; capture the station "
        "again, or give this camera's lens file",
        frame.name, frame.back ? "front and back in a file each" : "one picture, no back half",
        camera->two_files ? "two files" : "one file"));
  }
  return scaled_to(*camera, set.frame);
}

FramePictures read_frame_pictures(const CaptureFrame& frame, const DualFisheyeCamera& camera) {
  const FisheyeLens &front = camera.layout.front, &back = camera.layout.back;
  FramePictures pictures;
  pictures.front = read_checked(frame.file, camera.picture);
  pictures.mask = own_mask(frame, camera.picture);
  if (!frame.back) {
    require_dark_border(pictures.front, {front, back}, frame.file);
    pictures.back = pictures.front;
    return pictures;
  }
  require_dark_border(pictures.front, {front}, frame.file);
  pictures.back = read_checked(*frame.back, camera.picture);
  require_dark_border(pictures.back, {back}, *frame.back);
  return pictures;
}

}  // namespace raywalk::calibrate
