// The blocks of the steps stitch, poses and rectify, and their merging.
#include <fmt/format.h>

#include "calibrate/chain/calibration.h"
#include "calibrate/rectify/rectify_blocks.h"

namespace raywalk::calibrate {

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
    merge_rectified(set, final_poses(), rectify_options());
    return;
  }
  merge_poses(set, poses_options());
}

}  // namespace raywalk::calibrate
