#include "calibrate/stitch/fisheye_source.h"

#include <fmt/format.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "calibrate/base/frame_masks.h"
#include "calibrate/stitch/stitch_record.h"
#include "core/base/error.h"
#include "core/files/image_file.h"

namespace raywalk::calibrate {
namespace {

std::string lens_text(const FisheyeLens& lens, const Eigen::Vector3d& position_m) {
  std::string text;
  for (const double value :
       {lens.centre.u, lens.centre.v, lens.focal_px, lens.k[0], lens.k[1], lens.k[2], lens.k[3],
        lens.largest_angle_rad, position_m.x(), position_m.y(), position_m.z()}) {
    text += fmt::format("{} ", value);
  }
  return text;
}

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

std::string camera_text(const DualFisheyeCamera& camera) {
  const DualFisheyeLayout& layout = camera.layout;
  return lens_text(layout.front, layout.front_position_m) +
         lens_text(layout.back, layout.back_position_m) +
         fmt::format("{} {} {} ", layout.back_attitude.yaw_rad, layout.back_attitude.pitch_rad,
                     layout.back_attitude.roll_rad);
}

std::string source_text(const FisheyeSource& source) {
  const StitcherOptions& options = source.options;
  const LensBalance& balance = source.balance;
  return camera_text(source.camera) + fmt::format("{} {} {} {} {} {} {} {} {}\n", source.width,
                                                  name_of(options.blend), options.blend_deg,
                                                  options.seam_distance_m, balance.back_gain[0],
                                                  balance.back_gain[1], balance.back_gain[2],
                                                  balance.falloff_2, balance.falloff_4);
}

FisheyeSource read_fisheye_source(const CaptureSet& captured,
                                  const std::optional<DualFisheyeCamera>& camera,
                                  const std::filesystem::path& out) {
  const std::filesystem::path file = out / "stitch.json";
  const auto record = read_stitch_record(file);
  if (!record || !record->complete || record->panorama.width == 0) {
    throw Error(file.string() +
                ": missing, damaged or of an unfinished run; run raywalk-calibrate stitch");
  }
  return {.captured = captured,
          .camera = fitting_camera(captured, camera),
          .width = record->panorama.width,
          .options = record->options,
          .balance = record->balance.fit.balance};
}

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
