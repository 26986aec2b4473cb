#include "calibrate/chain/calibration.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "calibrate/rectify/rectify_blocks.h"
#include "core/base/error.h"
#include "core/base/timing.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/image_file.h"
#include "core/files/lens_file.h"
#include "core/files/sha256.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

// Part of every fingerprint; incremented when a step gives other outputs for the same inputs.
constexpr int kStepsVersion = 1;

CalibrationOptions with_directories(CalibrationOptions options) {
  if (options.out.empty()) options.out = options.input.directory / "calibration";
  options.lens.out = options.out;
  options.stitch.out = options.out;
  options.mask.out = options.out;
  options.poses.out = options.out;
  options.rectify.out = options.out;
  return options;
}

fs::path panorama_file(const CaptureFrame& frame) {
  return fs::path("panoramas") / (frame.name + ".png");
}

fs::path panorama_mask_file(const CaptureFrame& frame) {
  return fs::path("panoramas") / "masks" / (frame.name + ".png");
}

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
  std::string text =
      fmt::format("{}{} {}\n", content_line(lens.start), lens.pairs, lens.ignore_below_deg);
  if (lens.board) {
    text += fmt::format("{} {} {} {} {}\n", lens.board->dictionary, lens.board->squares_x,
                        lens.board->squares_y, lens.board->square_mm, lens.board->marker_mm);
  }
  for (const fs::path& picture : lens.board_pictures) text += content_line(picture);
  return text;
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
  std::string text = fmt::format("{} {}\n", poses.keyframes_mm, poses.face_px);
  // Results of before there were parts stay valid.
  if (poses.part_stations != kPartStations) text += fmt::format("{}\n", poses.part_stations);
  return text;
}

std::string rectify_options_text(const CalibrationOptions& options) {
  const GridTolerance& tolerance = options.input.tolerance;
  return fmt::format("{} {} {}\n", options.rectify.equalise_gain,
                     tolerance.off_line_m.value_or(0.0), tolerance.same_station_m.value_or(0.0));
}

void require_lens(const CalibrationOptions& options) {
  if (options.lens_file || !options.lens.start.empty()) return;
  throw UsageError(fmt::format(
      "{}: its frames are dual-fisheye; give starting values of the lenses with --lens-start "
      "(examples in configs/lenses), or a calibrated lens file with --lens",
      options.input.directory.string()));
}

std::string with_rotation_hint(const std::string& message) {
  constexpr const char* kOther = "--method rotation";
  if (message.find(kOther) != std::string::npos) return message;
  return fmt::format("{}; raywalk-calibrate all {} aligns the lines without COLMAP", message,
                     kOther);
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
  switch (step) {
    case CalibrationStep::kLens:
      return "lens";
    case CalibrationStep::kStitch:
      return "stitch";
    case CalibrationStep::kMask:
      return "mask";
    case CalibrationStep::kPoses:
      return "poses";
    case CalibrationStep::kGrid:
      return "grid";
    case CalibrationStep::kRectify:
      return "rectify";
  }
  return {};
}

Calibration::Calibration(CalibrationOptions options, CalibrationAccess access)
    : options_(with_directories(std::move(options))),
      captured_(read_capture_set(options_.input)),
      lock_(access == CalibrationAccess::kAlone ? locked(options_.out) : nullptr),
      records_(options_.out) {}

bool Calibration::has(CalibrationStep step) const {
  const bool fisheye = captured_.layout == FrameLayout::kDualFisheye;
  switch (step) {
    case CalibrationStep::kLens:
    case CalibrationStep::kStitch:
      return fisheye;
    case CalibrationStep::kPoses:
      return options_.method == GridMethod::kPoses;
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

template <typename Work>
void Calibration::record(CalibrationStep step, const Work& work) {
  const std::string inputs = fingerprint(step);
  records_.forget(step_name(step));
  const double seconds = times_of(work).wall_s;
  records_.note(step_name(step), inputs, seconds, outputs_of(step));
}

void Calibration::run(CalibrationStep step) {
  record(step, [&] { do_step(step); });
}

void Calibration::merge(CalibrationStep step) {
  record(step, [&] { merge_step(step); });
}

std::string Calibration::run_block(CalibrationStep step, Block block) const {
  if (step == CalibrationStep::kStitch) {
    const std::size_t made = stitch_block(captured_, camera(), options_.stitch, block);
    return fmt::format("stitch: block {} is done, {} panoramas made now", block.text(), made);
  }
  const CaptureSet set = panoramas();
  if (step == CalibrationStep::kRectify) {
    const std::size_t frames =
        calibrate::rectify_block(set, final_poses(), rectify_options(), block);
    return fmt::format("rectify: block {} is done, {} frames", block.text(), frames);
  }
  const PoseBlock done = solve_pose_block(set, poses_options(), block);
  if (done.share.size() == 0) {
    return fmt::format("poses: nothing to do for block {}, as the grid has {} part{}", block.text(),
                       done.parts, done.parts == 1 ? "" : "s");
  }
  return fmt::format("poses: block {} is done, {} of its {} parts of {} solved now", block.text(),
                     done.made, done.share.size(), done.parts);
}

std::string Calibration::run_light_block(Block block) const {
  const std::size_t pairs =
      compare_light_block(panoramas(), final_poses(), rectify_options(), block);
  return fmt::format("rectify: block {} of the light is done, {} pairs of frames", block.text(),
                     pairs);
}

void Calibration::merge_light() const {
  calibrate::merge_light(panoramas(), final_poses(), rectify_options());
}

void Calibration::merge_step(CalibrationStep step) {
  if (step == CalibrationStep::kStitch) {
    merge_stitched(captured_, camera(), options_.stitch);
    return;
  }
  const CaptureSet set = panoramas();
  if (step == CalibrationStep::kRectify) {
    const std::optional<GridResult> estimated = grid_of_poses();
    merge_rectified(set, final_poses(), estimated ? &*estimated : nullptr, rectify_options());
    return;
  }
  merge_poses(set, poses_options());
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
    case CalibrationStep::kGrid:
      return run_grid();
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
  // Reports of an earlier fit would describe other lenses.
  for (const char* file : {"lens.json", "lens.html"}) fs::remove(in_out(file));
}

void Calibration::run_mask() { write_mask(panoramas(), options_.mask); }

void Calibration::run_poses() {
  const CaptureSet set = panoramas();
  const PosesOptions poses = poses_options();
  try {
    solve_poses(set, poses);
  } catch (const UsageError&) {
    throw;
  } catch (const Error& e) {
    throw Error(with_rotation_hint(e.what()));
  }
}

void Calibration::run_grid() {
  const CaptureSet set = panoramas();
  const FramePoses solved =
      options_.method == GridMethod::kPoses ? solved_poses() : FramePoses(set.frames.size());
  estimate_grid(set, solved, grid_options());
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

std::optional<GridResult> Calibration::grid_of_poses() const {
  return options_.pose_table ? std::nullopt : std::optional(grid());
}

void Calibration::run_rectify() {
  const std::optional<GridResult> estimated = grid_of_poses();
  rectify_set(panoramas(), final_poses(), estimated ? &*estimated : nullptr, rectify_options());
}

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
  stitched.frame = panorama_size_of(stitched.frames.front().file);
  return stitched;
}

std::optional<cv::Mat> Calibration::mask() const {
  if (!fs::exists(in_out("mask.png"))) return std::nullopt;
  return read_mask(in_out("mask.png"), panoramas().frame);
}

FramePoses Calibration::solved_poses() const {
  require_file("poses.json", CalibrationStep::kPoses);
  return read_frame_poses(in_out("poses.json"), captured_);
}

GridResult Calibration::grid() const {
  require_file("grid.json", CalibrationStep::kGrid);
  return read_grid_result(in_out("grid.json"), captured_);
}

FramePoses Calibration::final_poses() const {
  return options_.pose_table ? read_pose_table(*options_.pose_table, captured_) : grid().poses;
}

RectifyResult Calibration::rectified() const {
  require_file("rectify.json", CalibrationStep::kRectify);
  return read_rectify_result(in_out("rectify.json"), captured_);
}

PosesOptions Calibration::poses_options() const {
  PosesOptions poses = options_.poses;
  poses.mask = mask();
  poses.lenses = lenses();
  poses.start = nominal_poses(captured_);
  return poses;
}

GridOptions Calibration::grid_options() const {
  return {.method = options_.method,
          .start = nominal_poses(captured_),
          .mask = mask(),
          .lenses = lenses(),
          .out = options_.out};
}

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
    case CalibrationStep::kGrid:
      return shared + fmt::format("{}\n", static_cast<int>(options_.method)) +
             (has(CalibrationStep::kPoses) ? content_line(in_out("poses.json")) : "");
    case CalibrationStep::kRectify:
      return shared + rectify_options_text(options_) +
             content_line(options_.pose_table.value_or(in_out("grid.json")));
  }
  return {};
}

std::string Calibration::fingerprint(CalibrationStep step) const {
  return sha256_hex(fmt::format("{} {}\n{}", step_name(step), kStepsVersion, inputs_of(step)));
}

std::vector<fs::path> Calibration::outputs_of(CalibrationStep step) const {
  std::vector<fs::path> outputs;
  const auto add_if_there = [&](const fs::path& file) {
    if (fs::exists(options_.out / file)) outputs.push_back(file);
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
      outputs = {"poses.json"};
      add_if_there("poses-report.json");
      break;
    case CalibrationStep::kGrid:
      break;
    case CalibrationStep::kRectify:
      outputs = {"poses.csv"};
      add_if_there("gt.csv");
      add_if_there("before.csv");
      for (const auto& entry : fs::recursive_directory_iterator(options_.out / "rectified")) {
        if (entry.is_regular_file()) {
          outputs.push_back(fs::relative(entry.path(), options_.out));
        }
      }
      break;
  }
  add_if_there(name + ".json");
  add_if_there(name + ".html");
  return outputs;
}

}  // namespace raywalk::calibrate
