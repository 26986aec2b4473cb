// Everything that decides where features appear in the frames of a capture: the camera's lenses,
// how each line of the rail lies, where every station is, and where the features are. All of it is
// estimated in one least-squares problem (a bundle adjustment, Triggs et al. 2000), of which the
// lenses are what is wanted.
//
// The rail makes this well posed without a target: its positions are known to a millimetre or so,
// so a feature at the direction b(s) from the position s on a straight line has to move such that
// cot(angle to the rail) grows linearly with s. A lens model that is wrong in any part of the
// picture bends these tracks. Features seen by both lenses tie them together.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calibrate/lens/camera_model.h"
#include "calibrate/lens/lens_uncertainty.h"

namespace raywalk::calibrate {

struct BundleStation {
  int line = 0;
  Eigen::Vector3d nominal_m{0, 0, 0};  // world frame
  Eigen::Matrix3d nominal_world_from_camera = Eigen::Matrix3d::Identity();
};

struct BundleObservation {
  int station = 0;
  bool back = false;  // by which lens
  PixelPosition seen{};
};

// One feature of the scene wherever it was seen.
using BundleTrack = std::vector<BundleObservation>;

struct BundleInput {
  DualFisheyeLayout start{};
  int lines = 0;
  std::vector<BundleStation> stations{};
  std::vector<BundleTrack> tracks{};
};

// What is estimated, but for the features. The camera of station s has the world position
//   middle + R(line)(nominal - middle) + shift(line) + shift(s), middle: of the line's stations,
// and its directions are R(s) nominal_camera_from_world (world direction).
struct BundleState {
  CameraParameters camera{};
  std::vector<PoseParameters> lines{};
  std::vector<PoseParameters> stations{};
};

struct StationPoseNow {
  Eigen::Vector3d position_m{0, 0, 0};
  Eigen::Matrix3d world_from_camera = Eigen::Matrix3d::Identity();
};

BundleState start_of(const BundleInput& input);
// Of every station, by the state.
std::vector<StationPoseNow> poses_of(const BundleInput& input, const BundleState& state);

// An observation that the fit rests on.
struct BundleResidual {
  int track = 0;
  int observation = 0;
  double right_px = 0.0;  // seen minus fitted
  double down_px = 0.0;
};

struct BundleResult {
  BundleState state{};
  std::vector<BundleResidual> residuals{};  // of the observations kept
  int tracks_kept = 0;
  int observations_dropped = 0;
  double sigma_px = 0.0;  // robust standard deviation of a residual, per axis
  std::optional<CameraCovariance> covariance{};  // none: not wanted, or singular
};

struct BundleOptions {
  double tolerance_px = 4.0;    // a typical error of the start
  int least_tracks = 100;       // that have to agree
  bool want_covariance = true;  // costs about as much as the fit
};

// Fits, from `from`, in rounds that tighten what counts as an outlier from the tolerance down to
// the noise of the features. Throws Interrupted, and Error where too few tracks agree.
BundleResult adjust_bundle(const BundleInput& input, const BundleState& from,
                           const BundleOptions& options);

}  // namespace raywalk::calibrate
