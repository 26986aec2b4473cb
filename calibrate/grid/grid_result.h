// The result of raywalk-calibrate grid, the reported figures of its lines, and the document of
// grid.json.
#pragma once

#include <Eigen/Core>
#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/grid/rail_model.h"

namespace raywalk::calibrate {

enum class GridMethod {
  kPoses,    // from solved poses; matches at the crossings refine and check them
  kRotation  // from matches at the crossings alone
};

// A value and its standard deviation, in the same unit.
struct Estimate {
  double value = 0.0;
  double sigma = 0.0;
};

// One estimated line. With u in [-1, 1] from its first to its last station and the Legendre
// polynomials P2(u) = (3 u^2 - 1) / 2 and P3(u) = (5 u^3 - 3 u) / 2, the predicted position of the
// station at the rail position s = middle_m + u half_length_m is
//   origin_m + (s - middle_m) direction + (bow[0] P2(u) + bow[1] P3(u)) (across, up)
// with the camera rotated from its planned attitude by the rotation vector
//   rotation + twist[0] u + twist[1] P2(u).
struct LineFit {
  int line = 0;  // index into CaptureSet::lines
  std::string id{};
  int stations = 0;
  int solved_stations = 0;             // with a solved pose that was not rejected
  std::vector<int> rejected_frames{};  // whose solved pose is an outlier from the rail
  bool connected = false;              // matches at a crossing connect it to the other lines

  double middle_m = 0.0;  // rail position of the line's middle
  double half_length_m = 0.0;
  Eigen::Vector3d origin_m{0, 0, 0};   // world, of the middle
  Eigen::Vector3d direction{1, 0, 0};  // unit, positive along the axis
  std::array<Eigen::Vector2d, 2> bow_mm{Eigen::Vector2d(0, 0), Eigen::Vector2d(0, 0)};
  Eigen::Vector3d rotation_deg{0, 0, 0};  // rotation vector, world axes
  std::array<Eigen::Vector3d, 2> twist_deg{Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0, 0, 0)};

  // Relative to the plan, as reported to the user.
  Estimate along_mm{}, across_mm{}, height_mm{};  // of the middle; across grows along +z or +x
  Estimate heading_deg{}, tilt_deg{};             // of the rail; heading turns +z towards +x
  Estimate yaw_deg{}, pitch_deg{}, roll_deg{};    // of the camera

  // Of the parameters that every line has: origin x, y, z (mm), heading, tilt (deg), rotation
  // vector (deg).
  Eigen::Matrix<double, 8, 8> covariance = Eigen::Matrix<double, 8, 8>::Zero();

  // Scatter of the stations around the rail, standard deviation per component.
  double jitter_along_mm = 0.0;
  double jitter_mm = 0.0;
  double jitter_deg = 0.0;

  std::vector<RailModelScore> position_models{}, rotation_models{};
};

// By how much two lines' panoramas disagree, measured by held-out matches. Sigmas follow from the
// matches' scatter, in the least certain direction.
struct Disagreement {
  double median_px = 0.0;    // distance of a match from its epipolar line, W = 4096
  double position_mm = 0.0;  // relative displacement that makes the matches agree
  double position_sigma_mm = 0.0;
  double rotation_deg = 0.0;  // relative rotation that does
  double rotation_sigma_deg = 0.0;
  double rotation_px = 0.0;  // the same at W = 4096
};

struct CrossingFigures {
  int along_x = 0;  // indices into CaptureSet::lines
  int along_z = 0;
  PlanPoint at{};  // nominal

  int matches = 0;           // used by the estimate
  int held_out_matches = 0;  // used to check it
  double noise_px = 0.0;     // sigma of a match, W = 4096

  Disagreement before{}, after{};  // at the start's poses and at the estimated poses

  // Change of the lines' relative pose at the crossing, from the start to the estimate.
  double correction_mm = 0.0;
  double correction_deg = 0.0;
  double correction_px = 0.0;

  // Standard deviations of the lines' relative position (per axis) and rotation here, from the
  // estimate's covariance.
  double sigma_mm = 0.0;
  double sigma_deg = 0.0;
  double sigma_px = 0.0;

  // Difference of two estimates, each from every other station, and the difference expected from
  // the stations' scatter alone. 0 where there are too few stations.
  double split_half_mm = 0.0;
  double split_half_expected_mm = 0.0;
  double split_half_deg = 0.0;
  double split_half_expected_deg = 0.0;

  bool trustworthy = false;
  std::vector<std::string> warnings{};  // why it is not trustworthy
};

struct GridResult {
  GridMethod method = GridMethod::kPoses;
  FramePoses poses{};  // every station has one, and every held-out frame that was solved
  std::vector<LineFit> lines{};
  std::vector<CrossingFigures> crossings{};
  double scale = 1.0;  // factor applied to solved positions to match the slider's lengths
  // Standard deviations per component of the error common to all solved poses of a line. The
  // estimate corrects it as far as the crossings determine it.
  double solved_line_error_mm = 0.0;
  double solved_line_error_deg = 0.0;
  std::vector<std::string> warnings{};  // each names a problem and its remedy
  std::vector<std::string> notes{};     // information, no problem
  bool trustworthy = false;
};

// The document of grid.json, keys as in docs/file-formats.md.
nlohmann::ordered_json grid_document(const CaptureSet& set, const GridResult& result);

// Fills in the members of LineFit from middle_m to covariance, from the parameters (metres,
// radians) and their covariance.
void describe_rail(const RailFrame& frame, const RailParameters& parameters,
                   const Eigen::Matrix<double, kRigidParameters, kRigidParameters>& covariance,
                   LineFit* line);

// The inverse of describe_rail: the parameters of a reported line.
RailParameters rail_parameters(const RailFrame& frame, const LineFit& line);

}  // namespace raywalk::calibrate
