#include "core/files/lens_file.h"

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/settings.h"
#include "core/files/shipped_configs.h"

namespace raywalk {
namespace {

constexpr int kLargestSide_px = 65536;
constexpr double kLargestCoefficient = 10.0;
constexpr double kLargestPosition_mm = 1000.0;
constexpr double kDegree = kPi / 180.0;
constexpr double kMillimetre = 1e-3;

void bind_lens(SettingsSchema* schema, const std::string& name, FisheyeLens* lens,
               Eigen::Vector3d* position_m) {
  schema->number(name + ".centre_u_px", &lens->centre.u, -kLargestSide_px, kLargestSide_px)
      .number(name + ".centre_v_px", &lens->centre.v, -kLargestSide_px, kLargestSide_px)
      .number(name + ".focal_px", &lens->focal_px, 1.0, kLargestSide_px)
      .number(name + ".largest_angle_deg", &lens->largest_angle_rad, 10.0, 179.0, kDegree);
  for (std::size_t i = 0; i < lens->k.size(); ++i) {
    schema->number(fmt::format("{}.k{}", name, i + 1), &lens->k[i], -kLargestCoefficient,
                   kLargestCoefficient);
  }
  for (int axis = 0; axis < 3; ++axis) {
    schema->number(fmt::format("{}.{}_mm", name, "xyz"[axis]), &(*position_m)[axis],
                   -kLargestPosition_mm, kLargestPosition_mm, kMillimetre);
  }
}

// The radius of a lens must grow with the angle.
void require_lens(const FisheyeLens& lens, const std::string& file, const std::string& name) {
  try {
    require_monotonic_radius(lens);
  } catch (const Error& e) {
    throw UsageError(fmt::format("{}: {}: {}", file, name, e.what()));
  }
}

SettingsSchema schema_of(DualFisheyeCamera* camera) {
  DualFisheyeLayout& layout = camera->layout;
  SettingsSchema schema;
  schema.integer("picture_width_px", &camera->picture.width, 1, kLargestSide_px)
      .integer("picture_height_px", &camera->picture.height, 1, kLargestSide_px)
      .boolean("two_files", &camera->two_files)
      .number("falloff_2", &camera->falloff_2, -kLargestCoefficient, kLargestCoefficient)
      .number("falloff_4", &camera->falloff_4, -kLargestCoefficient, kLargestCoefficient)
      .number("back.yaw_deg", &layout.back_attitude.yaw_rad, -360.0, 360.0, kDegree)
      .number("back.pitch_deg", &layout.back_attitude.pitch_rad, -360.0, 360.0, kDegree)
      .number("back.roll_deg", &layout.back_attitude.roll_rad, -360.0, 360.0, kDegree);
  bind_lens(&schema, "front", &layout.front, &layout.front_position_m);
  bind_lens(&schema, "back", &layout.back, &layout.back_position_m);
  return schema;
}

// Pixel centres have whole coordinates, so the picture's corner is at -0.5.
FisheyeLens scaled(FisheyeLens lens, double factor) {
  lens.centre.u = (lens.centre.u + 0.5) * factor - 0.5;
  lens.centre.v = (lens.centre.v + 0.5) * factor - 0.5;
  lens.focal_px *= factor;
  return lens;
}

}  // namespace

double light_share(const DualFisheyeCamera& camera, double angle_rad) {
  const double square = angle_rad * angle_rad;
  return std::exp(square * (camera.falloff_2 + square * camera.falloff_4));
}

DualFisheyeCamera read_lens_file(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    throw UsageError("the lens file " + missing_config_text(file, ConfigKind::kLens));
  }
  DualFisheyeCamera camera;
  const SettingsLines given = schema_of(&camera).load(file);
  for (const char* key :
       {"picture_width_px", "picture_height_px", "front.centre_u_px", "front.centre_v_px",
        "front.focal_px", "back.centre_u_px", "back.centre_v_px", "back.focal_px"}) {
    if (given.contains(key)) continue;
    throw UsageError(
        fmt::format("{}: '{}' is missing; configs/lenses holds examples", file.string(), key));
  }
  require_lens(camera.layout.front, file.string(), "front");
  require_lens(camera.layout.back, file.string(), "back");
  return camera;
}

std::string lens_file_text(const DualFisheyeCamera& camera) {
  std::string text =
      "# A dual-fisheye camera; raywalk's configs/lenses/dual-fisheye.yaml explains the keys.\n";
  DualFisheyeCamera bound = camera;
  std::string group;
  for (const auto& [key, value] : schema_of(&bound).values()) {
    const std::size_t dot = key.find('.');
    const std::string before =
        std::exchange(group, dot == std::string::npos ? "" : key.substr(0, dot));
    if (!group.empty() && group != before) text += group + ":\n";
    text += fmt::format("{}: {}\n", group.empty() ? key : "  " + key.substr(dot + 1), value);
  }
  return text;
}

void write_lens_file(const std::filesystem::path& file, const DualFisheyeCamera& camera) {
  write_file_atomically(file, lens_file_text(camera));
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
