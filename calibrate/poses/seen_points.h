// Scene points, what panoramas see of them, and which frames they connect.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace raywalk::calibrate {

// A scene point seen in a panorama. Camera's frame.
struct PointObservation {
  std::size_t frame = 0;              // index into the poses
  std::size_t point = 0;              // index into the points
  Eigen::Vector3d bearing{0, 0, 1};   // unit vector
  Eigen::Vector3d centre_m{0, 0, 0};  // centre of projection: the lens's position
};

// Two rows: unit vectors across a bearing and each other.
Eigen::Matrix<double, 2, 3> axes_across(const Eigen::Vector3d& bearing);

struct SeenPoints {
  std::vector<Eigen::Vector3d> points_m{};  // world frame
  std::vector<PointObservation> observations{};
};

// The points of which `keep` is true, and their observations.
SeenPoints chosen_points(const SeenPoints& points, const std::vector<bool>& keep);

// Without points that fewer than `least_frames` different panoramas see, and their observations.
SeenPoints widely_seen(const SeenPoints& points, std::size_t least_frames);

// A subset of points of which every frame sees about `per_frame`, if it has so many. Points with
// the most observations come first: they constrain the most poses for their computing time.
SeenPoints strongest(const SeenPoints& points, int per_frame);

// The largest group of `frames` frames that shared points connect, as a flag for each frame: two
// frames are linked if they share at least `least_points` points. All false if none are.
std::vector<bool> largest_linked_group(std::size_t frames, const SeenPoints& points,
                                       int least_points);

}  // namespace raywalk::calibrate
