#include "calibrate/chain/calibration_numbers.h"

#include <fmt/format.h>

#include <optional>

#include "core/files/checked_json.h"

namespace raywalk::calibrate {
namespace {

CheckedJson report_of(const Calibration& calibration, const char* file, CalibrationStep step) {
  return CheckedJson::read(calibration.out() / file,
                           "run raywalk-calibrate " + step_name(step) + " again");
}

// What not every document has: null, or without its key in those of earlier versions.
std::optional<CheckedJson> part_of(const CheckedJson& document, const std::string& key) {
  if (!document.has(key) || document.at(key).is_null()) return std::nullopt;
  return document.at(key);
}

std::string lens_numbers(const Calibration& calibration) {
  if (calibration.options().lens_file) return "the lenses of the given file";
  const CheckedJson fit = report_of(calibration, "lens.json", CalibrationStep::kLens);
  return fmt::format("residual {:.2f} px over {} points in {} pictures",
                     fit.at("residual_px").number_or(0.0), fit.at("points").integer(0),
                     fit.at("pictures").integer(0));
}

std::string stitch_numbers(const Calibration& calibration) {
  const CheckedJson record = report_of(calibration, "stitch.json", CalibrationStep::kStitch);
  const CheckedJson seam = record.at("seam");
  return fmt::format(
      "{} panoramas of {} x {}, step at the seam {:.1f} levels before balancing, {:.1f} after",
      record.at("frames").integer(0), record.at("width_px").integer(0),
      record.at("height_px").integer(0), seam.at("step_before_levels").number_or(0.0),
      seam.at("step_after_levels").number_or(0.0));
}

std::string mask_numbers(const Calibration& calibration) {
  if (!std::filesystem::exists(calibration.out() / "mask.json")) return "nothing is masked";
  const CheckedJson mask = report_of(calibration, "mask.json", CalibrationStep::kMask);
  const double share = mask.at("masked_share").number();
  std::string text = fmt::format("{:.2f} % of the sphere is masked", 100.0 * share);
  const std::optional<CheckedJson> own = part_of(mask, "frame_masks");
  if (!own) return text;
  const std::string with_own =
      fmt::format("{:.2f} % in the {} of {} frames with a mask of their own",
                  100.0 * own->at("masked_share").number(), own->at("frames").integer(),
                  own->at("of_frames").integer());
  return share > 0.0 ? fmt::format("{} in all frames, {}", text, with_own)
                     : fmt::format("masked of the sphere: {}", with_own);
}

std::string poses_numbers(const Calibration& calibration) {
  const CheckedJson poses = report_of(calibration, "poses-report.json", CalibrationStep::kPoses);
  const int keyframes = poses.at("keyframes").integer(0),
            stations = poses.at("stations").integer(0);
  std::string held_out;
  if (const auto frames = part_of(poses, "held_out")) {
    held_out = fmt::format(", {} of {} held-out frames", frames->at("posed").integer(),
                           frames->at("frames").integer());
  }
  return fmt::format(
      "{} of {} stations posed{}{}, residual {:.2f} px (W = 4096), positions to {:.2f} "
      "mm, attitudes to {:.3f} deg",
      poses.at("posed").integer(0), keyframes,
      keyframes < stations ? fmt::format(" ({} in all)", stations) : "", held_out,
      poses.at("residual_px").number_or(0.0), poses.at("position_sigma_mm").number_or(0.0),
      poses.at("rotation_sigma_deg").number_or(0.0));
}

std::string grid_numbers(const Calibration& calibration) {
  const GridResult grid = calibration.grid();
  const std::string set =
      fmt::format("{} stations on {} lines", calibration.captured().stations(), grid.lines.size());
  if (grid.crossings.empty()) return set + ", no crossings";
  const LargestDisagreement before = largest_disagreement(grid.crossings, &CrossingFigures::before);
  const LargestDisagreement after = largest_disagreement(grid.crossings, &CrossingFigures::after);
  return fmt::format(
      "{}, largest error at the {} crossings {:.2f} mm and {:.2f} px (W = 4096), before {:.2f} mm "
      "and {:.2f} px",
      set, grid.crossings.size(), after.position_mm, after.rotation_px, before.position_mm,
      before.rotation_px);
}

std::string rectify_numbers(const Calibration& calibration) {
  const RectifyResult result = calibration.rectified();
  std::string text = fmt::format("{} frames", result.frames);
  if (result.validation_frames > 0) {
    text += fmt::format(", {} for validation", result.validation_frames);
  }
  if (!result.left_out.empty()) text += fmt::format(", {} left out", result.left_out.size());
  if (result.masks.frames > 0) {
    text += fmt::format(", {} with a mask of their own", result.masks.frames);
  }
  return text;
}

}  // namespace

std::string step_numbers(const Calibration& calibration, CalibrationStep step) {
  switch (step) {
    case CalibrationStep::kLens:
      return lens_numbers(calibration);
    case CalibrationStep::kStitch:
      return stitch_numbers(calibration);
    case CalibrationStep::kMask:
      return mask_numbers(calibration);
    case CalibrationStep::kPoses:
      return poses_numbers(calibration);
    case CalibrationStep::kGrid:
      return grid_numbers(calibration);
    case CalibrationStep::kRectify:
      return rectify_numbers(calibration);
  }
  return {};
}

}  // namespace raywalk::calibrate
