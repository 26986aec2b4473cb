#include "calibrate/chain/calibration.h"

#include <fmt/format.h>

#include <utility>

#include "core/base/error.h"
#include "core/base/timing.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/lens_file.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

CalibrationOptions with_directories(CalibrationOptions options) {
  if (options.out.empty()) options.out = options.input.directory / "calibration";
  options.lens.out = options.out;
  options.stitch.out = options.out;
  options.mask.out = options.out;
  options.poses.out = options.out;
  options.rectify.out = options.out;
  return options;
}

void require_lens(const CalibrationOptions& options) {
  if (options.lens_file || !options.lens.start.empty()) return;
  throw UsageError(fmt::format(
      "{}: its frames are dual-fisheye; give starting values of the lenses with --lens-start "
      "(examples in configs/lenses), or a calibrated lens file with --lens",
      options.input.directory.string()));
}

// Creates the directory and locks it against other processes.
std::unique_ptr<FileLock> locked(const fs::path& directory) {
  make_directories(directory);
  return std::make_unique<FileLock>(
      directory / "calibration.lock",
      "another raywalk-calibrate is running in this directory; wait for it to end");
}

}  // namespace

std::string step_name(CalibrationStep step) {
  constexpr std::array kNames{"lens", "stitch", "mask", "poses", "rectify"};
  return kNames[static_cast<std::size_t>(step)];
}

Calibration::Calibration(CalibrationOptions options)
    : options_(with_directories(std::move(options))),
      captured_(read_capture_set(options_.input)),
      lock_(locked(options_.out)),
      records_(options_.out) {}

bool Calibration::has(CalibrationStep step) const {
  const bool fisheye = captured_.layout == FrameLayout::kDualFisheye;
  switch (step) {
    case CalibrationStep::kLens:
    case CalibrationStep::kStitch:
      return fisheye;
    default:
      return true;
  }
}

bool Calibration::is_done(CalibrationStep step) const {
  return records_.done(step_name(step), fingerprint(step)).has_value();
}

double Calibration::seconds(CalibrationStep step) const {
  const auto record = records_.last(step_name(step));
  return record ? record->seconds : 0.0;
}

void Calibration::run(CalibrationStep step) {
  const std::string inputs = fingerprint(step);
  records_.forget(step_name(step));
  const double seconds = times_of([&] { do_step(step); }).wall_s;
  records_.note(step_name(step), inputs, seconds, outputs_of(step));
}

void Calibration::do_step(CalibrationStep step) {
  switch (step) {
    case CalibrationStep::kLens:
      return run_lens();
    case CalibrationStep::kStitch:
      stitch_set(captured_, camera(), options_.stitch);
      return;
    case CalibrationStep::kMask:
      return run_mask();
    case CalibrationStep::kPoses:
      return run_poses();
    case CalibrationStep::kRectify:
      return run_rectify();
  }
}

void Calibration::run_lens() {
  require_lens(options_);
  if (!options_.lens_file) {
    LensOptions lens = options_.lens;
    if (lens.ignore_below_deg == 0.0) lens.ignore_below_deg = options_.mask.cone_deg;
    calibrate_lens(captured_, lens);
    return;
  }
  write_lens_file(in_out("lens.yaml"),
                  scaled_to(read_lens_file(*options_.lens_file), captured_.frame));
  // The report of an earlier fit would describe other lenses.
  fs::remove(in_out("lens.json"));
}

void Calibration::run_mask() { write_mask(panoramas(), options_.mask); }

void Calibration::run_poses() {
  const PosesOptions poses = poses_options();
  fs::remove(in_out("poses.json"));  // it would describe other poses if this run fails
  solve_poses(panoramas(), poses);
}

RectifyOptions Calibration::rectify_options() const {
  RectifyOptions rectify = options_.rectify;
  rectify.mask = mask();
  rectify.tolerance = options_.input.tolerance;
  if (has(CalibrationStep::kStitch)) {
    rectify.fisheye = read_fisheye_source(captured_, camera(), options_.out);
  }
  return rectify;
}

void Calibration::run_rectify() { rectify_set(panoramas(), final_poses(), rectify_options()); }

void Calibration::require_file(const std::string& file, CalibrationStep made_by) const {
  if (fs::is_regular_file(in_out(file))) return;
  throw Error(fmt::format("{} does not exist; run raywalk-calibrate {} first (or all)",
                          in_out(file).string(), step_name(made_by)));
}

std::optional<DualFisheyeCamera> Calibration::camera() const {
  if (captured_.layout == FrameLayout::kPanorama) return std::nullopt;
  require_file("lens.yaml", CalibrationStep::kLens);
  return read_lens_file(in_out("lens.yaml"));
}

std::optional<DualFisheyeLayout> Calibration::lenses() const {
  const auto calibrated = camera();
  return calibrated ? std::optional(calibrated->layout) : std::nullopt;
}

CaptureSet Calibration::panoramas() const {
  if (captured_.layout == FrameLayout::kPanorama) return captured_;
  CaptureSet stitched = captured_;
  stitched.layout = FrameLayout::kPanorama;
  for (CaptureFrame& frame : stitched.frames) {
    require_file(panorama_file(frame).generic_string(), CalibrationStep::kStitch);
    frame.file = options_.out / panorama_file(frame);
    frame.back.reset();
    frame.sha256.clear();
    if (!frame.mask) continue;
    require_file(panorama_mask_file(frame).generic_string(), CalibrationStep::kStitch);
    frame.mask = options_.out / panorama_mask_file(frame);
  }
  stitched.frame = panorama_header_of(stitched.frames.front().file).size;
  return stitched;
}

std::optional<cv::Mat> Calibration::mask() const {
  if (!fs::exists(in_out("mask.png"))) return std::nullopt;
  return read_mask(in_out("mask.png"), panoramas().frame);
}

FramePoses Calibration::final_poses() const {
  if (options_.pose_table) return read_pose_table(*options_.pose_table, captured_);
  require_file("poses.json", CalibrationStep::kPoses);
  constexpr const char* kAgain = "run raywalk-calibrate poses again";
  FramePoses poses = read_frame_poses(in_out("poses.json"), captured_, kAgain);
  for (std::size_t i = 0; i < captured_.stations(); ++i) {
    if (poses[i]) continue;
    throw Error(fmt::format("{}: frame {} has no pose; {}", in_out("poses.json").string(),
                            excerpt(captured_.frames[i].name), kAgain));
  }
  return poses;
}

PosesOptions Calibration::poses_options() const {
  PosesOptions poses = options_.poses;
  poses.mask = mask();
  poses.lenses = lenses();
  poses.start = nominal_poses(captured_);
  return poses;
}

std::vector<fs::path> Calibration::outputs_of(CalibrationStep step) const {
  std::vector<fs::path> outputs;
  const auto add_if_there = [&](const fs::path& file) {
    if (fs::exists(options_.out / file)) outputs.push_back(file);
  };
  const auto add_folder = [&](const fs::path& folder, const std::string& prefix = "") {
    if (!fs::exists(options_.out / folder)) return;
    for (const auto& entry : fs::recursive_directory_iterator(options_.out / folder)) {
      if (!entry.is_regular_file()) continue;
      if (!entry.path().filename().string().starts_with(prefix)) continue;
      outputs.push_back(fs::relative(entry.path(), options_.out));
    }
  };
  const std::string name = step_name(step);
  switch (step) {
    case CalibrationStep::kLens:
      outputs = {"lens.yaml"};
      break;
    case CalibrationStep::kStitch:
      for (const CaptureFrame& frame : captured_.frames) {
        outputs.push_back(panorama_file(frame));
        if (frame.mask) outputs.push_back(panorama_mask_file(frame));
      }
      break;
    case CalibrationStep::kMask:
      add_if_there("mask.png");
      break;
    case CalibrationStep::kPoses:
      break;
    case CalibrationStep::kRectify:
      outputs = {"poses.csv"};
      add_if_there("gt.csv");
      add_if_there("before.csv");
      add_folder("joined_masks");
      add_folder("rectified");
      add_folder("intersections");
      break;
  }
  add_if_there(name + ".json");
  add_folder("figures", name);
  return outputs;
}

}  // namespace raywalk::calibrate
