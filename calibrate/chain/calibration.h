// The steps of a calibration in its directory: what each is made from, running one, and what
// earlier ones left for later ones.
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
#include "calibrate/grid/estimate_grid.h"
#include "calibrate/lens/calibrate_lens.h"
#include "calibrate/mask/nadir_mask.h"
#include "calibrate/poses/solve_poses.h"
#include "calibrate/rectify/rectify_set.h"
#include "calibrate/stitch/stitch_set.h"
#include "core/files/file_lock.h"

namespace raywalk::calibrate {

enum class CalibrationStep { kLens, kStitch, kMask, kPoses, kGrid, kRectify };

inline constexpr std::array kCalibrationSteps{CalibrationStep::kLens, CalibrationStep::kStitch,
                                              CalibrationStep::kMask, CalibrationStep::kPoses,
                                              CalibrationStep::kGrid, CalibrationStep::kRectify};
// "lens", "stitch", ...; also the name of the step's page, NAME.html.
std::string step_name(CalibrationStep step);

// What the user chose. What one step takes from another (masks, lenses, poses, OUT) is filled in
// when it runs.
struct CalibrationOptions {
  CaptureInput input{};
  std::filesystem::path out{};  // empty: INPUT/calibration
  LensOptions lens{};
  std::optional<std::filesystem::path> lens_file{};  // takes the place of the fit
  StitchOptions stitch{};
  MaskOptions mask{};
  PosesOptions poses{};
  GridMethod method = GridMethod::kPoses;
  RectifyOptions rectify{};
  // Poses from elsewhere (read_pose_table) take the place of the grid's.
  std::optional<std::filesystem::path> pose_table{};
};

class Calibration {
 public:
  // Reads the capture, makes OUT and locks it. Throws Error as read_capture_set does, for a
  // directory that cannot be written, and for one that another program calibrates into.
  explicit Calibration(CalibrationOptions options);

  const CalibrationOptions& options() const { return options_; }
  const std::filesystem::path& out() const { return options_.out; }
  const CaptureSet& captured() const { return captured_; }

  // Whether the capture and the method have this step: panoramas need neither lens nor stitch,
  // GridMethod::kRotation no poses.
  bool has(CalibrationStep step) const;
  // Whether the step is done, of these very inputs and options.
  bool is_done(CalibrationStep step) const;
  // Does the step, whether or not it was done, and notes it. Throws Error where an earlier step's
  // result is missing (naming that step) and as the step itself does.
  void run(CalibrationStep step);
  // Seconds that the step took when it was last done.
  double seconds(CalibrationStep step) const;
  void forget(CalibrationStep step) { records_.forget(step_name(step)); }
  StepRecords& records() { return records_; }

  // What steps have left. Throw Error naming the step to run where it is not there, or is damaged.
  std::optional<DualFisheyeCamera> camera() const;  // none for panoramas
  CaptureSet panoramas() const;
  std::optional<cv::Mat> mask() const;  // none where none was made
  FramePoses solved_poses() const;
  GridResult grid() const;
  FramePoses final_poses() const;  // the grid's, or the table's
  RectifyResult rectified() const;

  PosesOptions poses_options() const;
  GridOptions grid_options() const;
  // Of all that the poses depend on, but for the spacing of keyframes.
  std::string fingerprint_without_keyframes() const;

 private:
  // The name of a file in OUT as messages have it.
  std::filesystem::path in_out(const std::string& file) const { return options_.out / file; }
  void require_file(const std::string& file, CalibrationStep made_by) const;
  std::optional<DualFisheyeLayout> lenses() const;

  std::string frames_fingerprint() const;
  std::string panoramas_fingerprint() const;
  std::string inputs_of(CalibrationStep step) const;
  std::string fingerprint(CalibrationStep step) const;
  std::vector<std::filesystem::path> outputs_of(CalibrationStep step) const;

  void run_lens();
  void run_mask();
  void run_poses();
  void run_grid();
  void run_rectify();
  void do_step(CalibrationStep step);

  CalibrationOptions options_;
  CaptureSet captured_{};
  std::unique_ptr<FileLock> lock_;
  StepRecords records_;
};

}  // namespace raywalk::calibrate
