#include "calibrate/poses/settled_poses.h"

#include <utility>
#include <vector>

#include "calibrate/poses/frame_links.h"
#include "calibrate/poses/pose_covariance.h"
#include "calibrate/poses/poses_figures.h"

namespace raywalk::calibrate {
namespace {

void keep_posed_observations(RefinedPoses* refined) {
  SeenPoints kept;
  kept.points_m = refined->points.points_m;
  std::vector<double> errors_px;
  for (std::size_t i = 0; i < refined->points.observations.size(); ++i) {
    const PointObservation& observation = refined->points.observations[i];
    if (!refined->poses[static_cast<std::size_t>(observation.frame)]) continue;
    if (refined->errors_px[i] > refined->inlier_px) continue;
    kept.observations.push_back(observation);
    errors_px.push_back(refined->errors_px[i]);
  }
  refined->points = std::move(kept);
  refined->errors_px = std::move(errors_px);
}

}  // namespace

void settle(RefinedPoses* refined, const PoseAnchor& anchor) {
  const SeenPoints inliers = widely_seen(inliers_of(*refined), 2);
  const std::vector<int> groups =
      linked_groups(static_cast<int>(refined->poses.size()), inliers, kLeastSharedPoints);
  const int main = largest_group(groups);
  for (std::size_t i = 0; i < groups.size(); ++i) {
    std::optional<FramePose>& pose = refined->poses[i];
    if (pose && (main < 0 || groups[i] != main || pose->observations < kLeastObservations)) {
      pose.reset();
    }
  }
  keep_posed_observations(refined);
  if (!refined->points.observations.empty()) set_sigmas(refined, anchor);
}

}  // namespace raywalk::calibrate
