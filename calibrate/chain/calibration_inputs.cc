// The hashes of what the steps depend on: the capture, the options and results of earlier steps.
#include <fmt/format.h>

#include "calibrate/chain/calibration.h"
#include "core/files/fingerprint.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

// Part of every fingerprint; incremented when a step gives other outputs for the same inputs.
constexpr int kStepsVersion = 5;

std::string file_line(const fs::path& file) {
  return fs::absolute(file).string() + " " + stamp_of(file).text() + "\n";
}

// The hash of a file's content, or a text for a missing file.
std::string content_line(const fs::path& file) {
  return fs::exists(file) ? sha256_of_file(file) + "\n" : "none\n";
}

std::string lens_options_text(const CalibrationOptions& options) {
  const LensOptions& lens = options.lens;
  if (options.lens_file) return "given " + content_line(*options.lens_file);
  return fmt::format("{}{} {}\n", content_line(lens.start), lens.pairs, lens.ignore_below_deg);
}

std::string stitch_options_text(const StitchOptions& stitch) {
  return fmt::format("{} {} {} {} {}\n", stitch.width, static_cast<int>(stitch.blend),
                     stitch.blend_deg, stitch.seam_distance_m, stitch.balance);
}

std::string mask_options_text(const MaskOptions& mask) {
  return fmt::format("{} {}\n", mask.cone_deg, mask.automatic) +
         (mask.picture ? content_line(*mask.picture) : "");
}

std::string poses_options_text(const PosesOptions& poses) {
  return fmt::format("{} {}\n", poses.keyframes_mm, poses.face_px);
}

std::string rectify_options_text(const CalibrationOptions& options) {
  const GridTolerance& tolerance = options.input.tolerance;
  return fmt::format("{} {}\n", tolerance.off_line_m.value_or(0.0),
                     tolerance.same_station_m.value_or(0.0));
}

}  // namespace

// The hash that the session recorded of a frame, else its size and time.
std::string Calibration::frames_fingerprint() const {
  std::string text = fmt::format("{}x{} {}\n", captured_.frame.width, captured_.frame.height,
                                 static_cast<int>(captured_.layout));
  for (const CaptureFrame& frame : captured_.frames) {
    const Attitude attitude = frame.nominal_attitude.value_or(Attitude{});
    text += fmt::format("{} {} {:.12g} {:.12g} {:.12g} {:.12g} {:.12g} {:.12g} ", frame.name,
                        frame.held_out() ? "held out" : captured_.line_id(frame.line),
                        frame.nominal_m.x(), frame.nominal_m.y(), frame.nominal_m.z(),
                        attitude.yaw_rad, attitude.pitch_rad, attitude.roll_rad);
    if (frame.mask) text += "mask " + file_line(*frame.mask);
    if (!frame.sha256.empty()) {
      text += frame.sha256 + "\n";
      continue;
    }
    text += file_line(frame.file);
    if (frame.back) text += file_line(*frame.back);
  }
  return sha256_hex(text);
}

std::string Calibration::panoramas_fingerprint() const {
  std::string frames = frames_fingerprint();
  if (captured_.layout == FrameLayout::kPanorama) return frames;
  const auto stitched = records_.last(step_name(CalibrationStep::kStitch));
  return frames + (stitched ? stitched->fingerprint : "unknown");
}

std::string Calibration::fingerprint_without_keyframes() const {
  return fmt::format("{} {} {} {} {}", kStepsVersion, panoramas_fingerprint(),
                     content_line(in_out("mask.png")), content_line(in_out("lens.yaml")),
                     options_.poses.face_px);
}

std::string Calibration::inputs_of(CalibrationStep step) const {
  const std::string shared = panoramas_fingerprint() + content_line(in_out("mask.png")) +
                             content_line(in_out("lens.yaml"));
  switch (step) {
    case CalibrationStep::kLens:
      return frames_fingerprint() + lens_options_text(options_) +
             fmt::format("{}", options_.mask.cone_deg);
    case CalibrationStep::kStitch:
      return frames_fingerprint() + content_line(in_out("lens.yaml")) +
             stitch_options_text(options_.stitch);
    case CalibrationStep::kMask:
      return panoramas_fingerprint() + mask_options_text(options_.mask);
    case CalibrationStep::kPoses:
      return shared + poses_options_text(options_.poses);
    case CalibrationStep::kRectify:
      return shared + rectify_options_text(options_) +
             content_line(options_.pose_table.value_or(in_out("poses.json")));
  }
  return {};
}

std::string Calibration::fingerprint(CalibrationStep step) const {
  return sha256_hex(fmt::format("{} {}\n{}", step_name(step), kStepsVersion, inputs_of(step)));
}

}  // namespace raywalk::calibrate
