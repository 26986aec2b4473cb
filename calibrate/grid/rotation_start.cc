#include "calibrate/grid/rotation_start.h"

#include <Eigen/QR>

namespace raywalk::calibrate {

std::vector<LineMotion> motions_of_start(const CaptureSet& set, const FramePoses& start) {
  std::vector<LineMotion> motions(set.lines.size());
  for (size_t line = 0; line < set.lines.size(); ++line) {
    for (const int index : set.lines[line].frames) {
      const CaptureFrame& frame = set.frames[static_cast<size_t>(index)];
      const FramePose& pose = *start[static_cast<size_t>(index)];
      motions[line].rotation_rad +=
          vector_of(pose.world_from_camera * planned_attitude(frame).transpose());
      motions[line].offset_m += pose.position_m - frame.nominal_m;
    }
    const auto count = static_cast<double>(set.lines[line].frames.size());
    motions[line].rotation_rad /= count;
    motions[line].offset_m /= count;
  }
  return motions;
}

void align_at_crossings(std::span<const FittedCrossing> crossings,
                        const std::vector<bool>& may_move, std::vector<LineMotion>* lines) {
  const auto count = static_cast<Eigen::Index>(crossings.size());
  if (count == 0) return;
  Eigen::MatrixXd differences =
      Eigen::MatrixXd::Zero(count, static_cast<Eigen::Index>(lines->size()));
  Eigen::MatrixXd offsets(count, 6);
  for (Eigen::Index i = 0; i < count; ++i) {
    const FittedCrossing& crossing = crossings[static_cast<size_t>(i)];
    const int x = crossing.crossing.along_x;
    const int z = crossing.crossing.along_z;
    // A fixed line has a zero column, so its minimum-norm motion is zero.
    differences(i, x) = may_move[static_cast<size_t>(x)] ? 1.0 : 0.0;
    differences(i, z) = may_move[static_cast<size_t>(z)] ? -1.0 : 0.0;
    offsets.row(i) << crossing.fit.rotation_rad.transpose(), crossing.fit.motion_m.transpose();
  }
  const Eigen::MatrixXd motions = differences.completeOrthogonalDecomposition().solve(offsets);
  for (size_t line = 0; line < lines->size(); ++line) {
    const Eigen::RowVectorXd motion = motions.row(static_cast<Eigen::Index>(line));
    (*lines)[line].rotation_rad =
        vector_of(matrix_of(motion.head<3>()) * matrix_of((*lines)[line].rotation_rad));
    (*lines)[line].offset_m += motion.tail<3>();
  }
}

}  // namespace raywalk::calibrate
