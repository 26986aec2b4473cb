// Which station shows a point that the lines in use do not see.
//
// Some 50 operations per station searched, once per pixel of the distances that needs one.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/view/view_inputs.h"

namespace raywalk {

class FillStations {
 public:
  static constexpr int kNone = -1;

  // For a view with distances, which must outlive the object.
  explicit FillStations(const ViewInputs& view) : view_(view) {}

  // The station that shows what the viewpoint sees in a pixel of the distances, as an index into
  // ViewInputs::fill_maps, or kNone. Remembered for the last column.
  int of(int depth_theta, int depth_row);

  // Whether one of the pixels of a station around a pixel of the distances is left out.
  bool is_left_out(const MapStation& map, int depth_theta, int depth_row) const;

 private:
  static constexpr int kUnknown = -2;

  // What the view shows in a pixel of the distances.
  struct Seen {
    Eigen::Vector3d eye_m{0, 0, 0};  // of the pixel's column
    Eigen::Vector3f direction{0, 0, 1};
    float omega = 0.0f;  // inverse distance from the eye, 1/m
  };
  Seen seen_in(int depth_theta, int depth_row) const;
  // The direction from a station, of any length.
  static Eigen::Vector3d direction_from(const MapStation& map, const Seen& seen);
  int find(int depth_theta, int depth_row) const;
  // The same where the distances cannot be relied on.
  int find_unmasked(const Seen& seen) const;
  // Whether the pixels of a station that a pixel of the distances covers are unmasked.
  bool is_unmasked(const MapStation& map, const Seen& seen) const;
  bool is_left_out(const MapStation& map, const Seen& seen) const;

  const ViewInputs& view_;
  int theta_ = -1;
  std::vector<int> of_row_;  // of column theta_; index into fill_maps, kUnknown or kNone
};

}  // namespace raywalk
