// The steps of a calibration in its directory: their inputs, running them, and reading their
// results.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/chain/step_records.h"
#include "calibrate/lens/calibrate_lens.h"
#include "calibrate/mask/nadir_mask.h"
#include "calibrate/poses/solve_poses.h"
#include "calibrate/rectify/rectify_set.h"
#include "calibrate/stitch/stitch_set.h"
#include "core/files/file_lock.h"

namespace raywalk::calibrate {

enum class CalibrationStep { kLens, kStitch, kMask, kPoses, kRectify };

inline constexpr std::array kCalibrationSteps{CalibrationStep::kLens, CalibrationStep::kStitch,
                                              CalibrationStep::kMask, CalibrationStep::kPoses,
                                              CalibrationStep::kRectify};
// "lens", "stitch", ...; also the name of its part of calibration.json.
std::string step_name(CalibrationStep step);

// The user's options. The inputs that a step takes from another (masks, lenses, poses, OUT) are
// filled in when it runs.
struct CalibrationOptions {
  CaptureInput input{};
  std::filesystem::path out{};  // empty: INPUT/calibration
  LensOptions lens{};
  std::optional<std::filesystem::path> lens_file{};  // replaces the fit
  StitchOptions stitch{};
  MaskOptions mask{};
  PosesOptions poses{};
  RectifyOptions rectify{};
  // A table of poses (read_pose_table) that replaces the solved ones.
  std::optional<std::filesystem::path> pose_table{};
};

class Calibration {
 public:
  // Reads the capture, creates OUT and locks it. Throws Error as read_capture_set does, for a
  // directory that cannot be written, and for one that another process has locked.
  explicit Calibration(CalibrationOptions options);

  const CalibrationOptions& options() const { return options_; }
  const std::filesystem::path& out() const { return options_.out; }
  const CaptureSet& captured() const { return captured_; }

  // Whether the capture needs this step: panoramas need neither lens nor stitch.
  bool has(CalibrationStep step) const;
  // Whether the step was run with the current inputs and options and its outputs are unchanged.
  bool is_done(CalibrationStep step) const;
  // Runs the step, even if it is done, and records it. Throws Error where an earlier step's result
  // is missing (naming that step) and as the step itself does.
  void run(CalibrationStep step);
  // Duration of the step's last run, seconds.
  double seconds(CalibrationStep step) const;
  void forget(CalibrationStep step) { records_.forget(step_name(step)); }
  StepRecords& records() { return records_; }

  // Results of the steps. Throw Error naming the step to run if the result is missing or damaged.
  std::optional<DualFisheyeCamera> camera() const;  // nullopt for panoramas
  CaptureSet panoramas() const;
  std::optional<cv::Mat> mask() const;  // nullopt without a mask
  FramePoses final_poses() const;       // the solved ones, or the table's

  PosesOptions poses_options() const;
  // Hash of everything that the poses depend on, except the spacing of keyframes.
  std::string fingerprint_without_keyframes() const;

 private:
  // OUT/file.
  std::filesystem::path in_out(const std::string& file) const { return options_.out / file; }
  void require_file(const std::string& file, CalibrationStep made_by) const;
  std::optional<DualFisheyeLayout> lenses() const;

  std::string frames_fingerprint() const;
  std::string panoramas_fingerprint() const;
  std::string inputs_of(CalibrationStep step) const;
  std::string fingerprint(CalibrationStep step) const;
  std::vector<std::filesystem::path> outputs_of(CalibrationStep step) const;

  RectifyOptions rectify_options() const;

  void run_lens();
  void run_mask();
  void run_poses();
  void run_rectify();
  void do_step(CalibrationStep step);

  CalibrationOptions options_;
  CaptureSet captured_{};
  std::unique_ptr<FileLock> lock_;
  StepRecords records_;
};

}  // namespace raywalk::calibrate
