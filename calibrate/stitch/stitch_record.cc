#include "calibrate/stitch/stitch_record.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <vector>

#include "calibrate/stitch/fisheye_frames.h"
#include "core/base/error.h"
#include "core/files/json.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

constexpr int kStitchVersion = 1;

StitchRecord record_from(const CheckedJson& json, const fs::path& out) {
  StitchRecord record{.fingerprint = json.at("fingerprint").text(),
                      .complete = json.at("complete").boolean(),
                      .width = json.at("width_px").integer(1)};
  record.options.blend = blend_method_named(json.at("blend").text());
  record.options.blend_deg = json.at("blend_deg").number();
  const CheckedJson distance = json.at("seam_distance_m");
  if (!distance.is_null()) record.options.seam_distance_m = distance.number();
  const std::vector<CheckedJson> gains = json.at("balance").at("back_gain").items(3);
  for (std::size_t colour = 0; colour < 3; ++colour) {
    record.back_gain[colour] = gains[2 - colour].number();
  }
  if (!record.complete) return record;
  record.has_figures = true;
  for (const CheckedJson& figure : json.at("figures").items()) {
    record.has_figures = record.has_figures && fs::exists(out / figure.at("file").text());
  }
  return record;
}

}  // namespace

nlohmann::ordered_json stitch_document(const StitchRecord& record, const LensGain& gain,
                                       std::size_t frames) {
  const double distance_m = record.options.seam_distance_m;
  nlohmann::ordered_json document{
      {"format_version", kStitchVersion},
      {"fingerprint", record.fingerprint},
      {"complete", record.complete},
      {"width_px", record.width},
      {"height_px", record.width / 2},
      {"frames", frames},
      {"blend", name_of(record.options.blend)},
      {"blend_deg", record.options.blend_deg},
      {"seam_distance_m", nullptr},
      {"balance",
       {{"back_gain", {gain.back_gain[2], gain.back_gain[1], gain.back_gain[0]}},
        {"frames", gain.frames},
        {"points", gain.points}}},
      {"seam",
       {{"step_before_levels", gain.step_before_levels},
        {"step_after_levels", gain.step_after_levels},
        {"correlation", gain.correlation}}},
      {"warnings", gain.warnings}};
  if (std::isfinite(distance_m)) document["seam_distance_m"] = distance_m;
  return document;
}

std::optional<StitchRecord> read_stitch_record(const fs::path& file) {
  if (!fs::exists(file)) return std::nullopt;
  try {
    const CheckedJson json = CheckedJson::read(file);
    if (json.at("format_version").integer() != kStitchVersion) return std::nullopt;
    return record_from(json, file.parent_path());
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::string name_of(BlendMethod method) {
  return method == BlendMethod::kMultiBand ? "multi-band" : "feather";
}

BlendMethod blend_method_named(const std::string& name) {
  for (const BlendMethod method : {BlendMethod::kMultiBand, BlendMethod::kFeather}) {
    if (name == name_of(method)) return method;
  }
  throw UsageError("unknown blend " + excerpt(name) + "; use multi-band or feather");
}

std::string settings_text(const DualFisheyeCamera& camera, int width,
                          const StitcherOptions& options) {
  return lens_file_text(camera) + fmt::format("{} {} {} {}\n", width, name_of(options.blend),
                                              options.blend_deg, options.seam_distance_m);
}

FisheyeSource read_fisheye_source(const CaptureSet& captured,
                                  const std::optional<DualFisheyeCamera>& camera,
                                  const fs::path& out) {
  const fs::path file = out / "stitch.json";
  const auto record = read_stitch_record(file);
  if (!record || !record->complete) {
    throw Error(file.string() +
                ": missing, damaged or of an unfinished run; run raywalk-calibrate stitch");
  }
  return {.captured = captured,
          .camera = fitting_camera(captured, camera),
          .width = record->width,
          .options = record->options,
          .back_gain = record->back_gain};
}

}  // namespace raywalk::calibrate
