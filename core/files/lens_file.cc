#include "core/files/lens_file.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <string>
#include <system_error>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/settings.h"
#include "core/files/shipped_configs.h"

namespace raywalk {
namespace {

constexpr int kLargestSide_px = 65536;
constexpr double kLargestCoefficient = 10.0;
constexpr double kLargestPosition_mm = 1000.0;
constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

// A lens in the units of the file, degrees and millimetres.
struct LensEntry {
  FisheyeLens lens{};
  double largest_angle_deg = degrees_from_radians(FisheyeLens{}.largest_angle_rad);
  Eigen::Vector3d position_mm{0, 0, 0};
};

void bind_lens(SettingsSchema* schema, const std::string& name, LensEntry* entry) {
  FisheyeLens* lens = &entry->lens;
  lens->centre = {kMissing, kMissing};
  lens->focal_px = kMissing;
  schema->number(name + ".centre_u_px", &lens->centre.u, -kLargestSide_px, kLargestSide_px)
      .number(name + ".centre_v_px", &lens->centre.v, -kLargestSide_px, kLargestSide_px)
      .number(name + ".focal_px", &lens->focal_px, 1.0, kLargestSide_px)
      .number(name + ".largest_angle_deg", &entry->largest_angle_deg, 10.0, 179.0)
      .number(name + ".x_mm", &entry->position_mm.x(), -kLargestPosition_mm, kLargestPosition_mm)
      .number(name + ".y_mm", &entry->position_mm.y(), -kLargestPosition_mm, kLargestPosition_mm)
      .number(name + ".z_mm", &entry->position_mm.z(), -kLargestPosition_mm, kLargestPosition_mm);
  for (std::size_t i = 0; i < lens->k.size(); ++i) {
    schema->number(fmt::format("{}.k{}", name, i + 1), &lens->k[i], -kLargestCoefficient,
                   kLargestCoefficient);
  }
}

// For keys without a sensible default.
void require_given(bool given, const std::string& file, const std::string& key) {
  if (!given) {
    throw UsageError(fmt::format("{}: '{}' is missing; configs/lenses holds examples", file, key));
  }
}

FisheyeLens lens_of(const LensEntry& entry, const std::string& file, const std::string& name) {
  FisheyeLens lens = entry.lens;
  require_given(!std::isnan(lens.centre.u), file, name + ".centre_u_px");
  require_given(!std::isnan(lens.centre.v), file, name + ".centre_v_px");
  require_given(!std::isnan(lens.focal_px), file, name + ".focal_px");
  lens.largest_angle_rad = radians_from_degrees(entry.largest_angle_deg);
  try {
    require_monotonic_radius(lens);
  } catch (const Error& e) {
    throw UsageError(fmt::format("{}: {}: {}", file, name, e.what()));
  }
  return lens;
}

std::string lens_text(const std::string& name, const FisheyeLens& lens,
                      const Eigen::Vector3d& position_m) {
  std::string text = fmt::format("{}:\n  centre_u_px: {}\n  centre_v_px: {}\n  focal_px: {}\n",
                                 name, lens.centre.u, lens.centre.v, lens.focal_px);
  for (std::size_t i = 0; i < lens.k.size(); ++i) {
    text += fmt::format("  k{}: {}\n", i + 1, lens.k[i]);
  }
  const Eigen::Vector3d position_mm = 1e3 * position_m;
  return text + fmt::format("  largest_angle_deg: {}\n  x_mm: {}\n  y_mm: {}\n  z_mm: {}\n",
                            degrees_from_radians(lens.largest_angle_rad), position_mm.x(),
                            position_mm.y(), position_mm.z());
}

// Pixel centres have whole coordinates, so the picture's corner is at -0.5.
FisheyeLens scaled(FisheyeLens lens, double factor) {
  lens.centre.u = (lens.centre.u + 0.5) * factor - 0.5;
  lens.centre.v = (lens.centre.v + 0.5) * factor - 0.5;
  lens.focal_px *= factor;
  return lens;
}

}  // namespace

DualFisheyeCamera read_lens_file(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    throw UsageError("the lens file " + missing_config_text(file, ConfigKind::kLens));
  }
  DualFisheyeCamera camera;
  LensEntry front, back;
  double yaw_deg = 180.0, pitch_deg = 0.0, roll_deg = 0.0;  // of the back lens
  SettingsSchema schema;
  schema.integer("picture_width_px", &camera.picture.width, 1, kLargestSide_px)
      .integer("picture_height_px", &camera.picture.height, 1, kLargestSide_px)
      .boolean("two_files", &camera.two_files)
      .number("back.yaw_deg", &yaw_deg, -360.0, 360.0)
      .number("back.pitch_deg", &pitch_deg, -360.0, 360.0)
      .number("back.roll_deg", &roll_deg, -360.0, 360.0);
  bind_lens(&schema, "front", &front);
  bind_lens(&schema, "back", &back);
  schema.load(file);
  const std::string source = file.string();
  require_given(camera.picture.width > 0, source, "picture_width_px");
  require_given(camera.picture.height > 0, source, "picture_height_px");
  camera.layout.front = lens_of(front, source, "front");
  camera.layout.back = lens_of(back, source, "back");
  camera.layout.front_position_m = 1e-3 * front.position_mm;
  camera.layout.back_position_m = 1e-3 * back.position_mm;
  camera.layout.back_attitude = {radians_from_degrees(yaw_deg), radians_from_degrees(pitch_deg),
                                 radians_from_degrees(roll_deg)};
  return camera;
}

void write_lens_file(const std::filesystem::path& file, const DualFisheyeCamera& camera) {
  const DualFisheyeLayout& layout = camera.layout;
  const Attitude& attitude = layout.back_attitude;
  write_file_atomically(
      file,
      "# A dual-fisheye camera; raywalk's configs/lenses/dual-fisheye.yaml explains the keys.\n" +
          fmt::format("picture_width_px: {}\npicture_height_px: {}\ntwo_files: {}\n",
                      camera.picture.width, camera.picture.height, camera.two_files) +
          lens_text("front", layout.front, layout.front_position_m) +
          lens_text("back", layout.back, layout.back_position_m) +
          fmt::format("  yaw_deg: {}\n  pitch_deg: {}\n  roll_deg: {}\n",
                      degrees_from_radians(attitude.yaw_rad),
                      degrees_from_radians(attitude.pitch_rad),
                      degrees_from_radians(attitude.roll_rad)));
}

DualFisheyeCamera scaled_to(const DualFisheyeCamera& camera, PanoramaSize picture) {
  const double factor = static_cast<double>(picture.width) / camera.picture.width;
  // The scaled height may be off by rounding to whole pixels.
  if (!(std::abs(camera.picture.height * factor - picture.height) <= 0.5)) {
    throw Error(fmt::format(
        "the lens file is for pictures of {} x {} pixels; {} x {} has another aspect ratio; use "
        "the lens file of this camera and its picture format",
        camera.picture.width, camera.picture.height, picture.width, picture.height));
  }
  DualFisheyeCamera out = camera;
  out.picture = picture;
  out.layout.front = scaled(camera.layout.front, factor);
  out.layout.back = scaled(camera.layout.back, factor);
  return out;
}

}  // namespace raywalk
