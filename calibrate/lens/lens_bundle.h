// Bundle adjustment (Triggs et al. 2000) of the frames of a capture for the lenses: the camera's
// lenses, the pose of each line of the rail, the pose of every station and the positions of the
// features are estimated in one least-squares problem.
//
// The rail makes this well posed without a target: its positions are known to about a millimetre,
// so a feature at the direction b(s) from the position s on a straight line has to move such that
// cot(angle to the rail) grows linearly with s. An error of the lens model in any part of the
// picture bends these tracks. Features seen by both lenses constrain their relative pose.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "calibrate/lens/calibrate_lens.h"
#include "calibrate/lens/camera_model.h"

namespace raywalk::calibrate {

struct BundleStation {
  std::size_t line = 0;
  Eigen::Vector3d nominal_m{0, 0, 0};  // world frame
  Eigen::Matrix3d nominal_world_from_camera = Eigen::Matrix3d::Identity();
};

struct BundleObservation {
  std::size_t station = 0;
  bool back = false;  // by which lens
  PixelPosition seen{};
};

// All observations of one scene feature.
using BundleTrack = std::vector<BundleObservation>;

// Whether both lenses see it.
bool spans_both_lenses(const BundleTrack& track);

struct BundleInput {
  DualFisheyeLayout start{};
  std::size_t lines = 0;
  std::vector<BundleStation> stations{};
  std::vector<BundleTrack> tracks{};
};

// The unknowns except for the features. The camera of station s has the world position
//   middle + R(line)(nominal - middle) + shift(line) + shift(s), middle: of the line's stations,
// and its directions are R(s) nominal_camera_from_world (world direction).
struct BundleState {
  CameraParameters camera{};
  std::vector<PoseParameters> lines{};
  std::vector<PoseParameters> stations{};
};

struct BundlePose {
  Eigen::Vector3d position_m{0, 0, 0};
  Eigen::Matrix3d world_from_camera = Eigen::Matrix3d::Identity();
};

BundleState start_of(const BundleInput& input);
// The pose of every station.
std::vector<BundlePose> poses_of(const BundleInput& input, const BundleState& state);

// World frame; unit direction.
struct ViewRay {
  Eigen::Vector3d origin_m{0, 0, 0};
  Eigen::Vector3d direction{0, 0, 1};
};

// Converts observations to rays by a state.
class Viewing {
 public:
  Viewing(const BundleInput& input, const BundleState& state);
  // nullopt outside of the lens's field of view.
  std::optional<ViewRay> ray_of(const BundleObservation& seen) const;
  const std::vector<BundlePose>& poses() const { return poses_; }

 private:
  DualFisheyeLayout layout_;
  Eigen::Matrix3d camera_from_back_;
  std::vector<BundlePose> poses_;
};

struct BundleResult {
  BundleState state{};
  std::vector<LensResidual> residuals{};  // of the observations kept
  int tracks_kept = 0;
  int overlap_tracks = 0;  // of these, kept in both lenses
  int observations_dropped = 0;
  double sigma_px = 0.0;  // robust standard deviation of a residual, per axis
  std::optional<CameraCovariance> covariance{};  // nullopt: not requested, or singular
};

struct BundleOptions {
  double tolerance_px = 4.0;       // a typical error of the start
  std::size_t least_tracks = 100;  // inlier tracks required
  bool want_covariance = true;     // costs about as much as the fit
};

// Fits from the initial state `from`, in rounds that tighten the outlier threshold from the
// tolerance down to the noise of the features. Throws Interrupted, and Error if too few tracks
// agree or the fit does not converge.
BundleResult adjust_bundle(const BundleInput& input, const BundleState& from,
                           const BundleOptions& options);

}  // namespace raywalk::calibrate
