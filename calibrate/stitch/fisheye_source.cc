#include "calibrate/stitch/fisheye_source.h"

#include <fmt/format.h>

#include "calibrate/stitch/stitch_record.h"
#include "core/base/error.h"

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

}  // namespace raywalk::calibrate
