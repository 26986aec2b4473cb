// For tests: a synthetic room in closed form, written to disk and opened.
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "core/evaluate/metrics.h"
#include "core/files/test_directory.h"
#include "core/room/room.h"
#include "core/view/renderer.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {

inline constexpr ViewMethod kViewMethods[] = {ViewMethod::kInitial, ViewMethod::kHlfVd,
                                              ViewMethod::kTwoSided};
inline constexpr ViewMethod kCorrected[] = {ViewMethod::kHlfVd, ViewMethod::kTwoSided};

// The synthetic scene's own room with stations beyond the corners.
inline SyntheticRoomSpec box_room(int width = 192) { return {.overhang_m = 0.25, .width = width}; }

// A room with a pillar in the cell, up to above the stations: lines do not see its far side nor
// what is behind it.
inline SyntheticRoomSpec pillar_spec(int width = 128) {
  return {.scene = {.obstacle = SceneBox{{0.1, -1.2, 0.12}, {0.3, 0.4, 0.32}}},
          .overhang_m = 0.25,
          .width = width,
          .distance_width = 128};
}

// Masked: every camera's directions with a y below `y`.
inline CameraCompanion masked_below(double y) {
  return {.hides = [y](const std::string&, int, const Eigen::Vector3d& d) { return d.y() < y; }};
}

class TestRoom {
 public:
  explicit TestRoom(const SyntheticRoomSpec& spec) : spec_(spec) {
    write_synthetic_room(spec, directory_ / "room.lf");
    room_ = Room::open(directory_ / "room.lf");
  }

  const SyntheticRoomSpec& spec() const { return spec_; }
  const Room& room() const { return room_; }

  RenderedView view(const ViewOptions& options, PlanPoint at) const {
    return Renderer(room_, options).render(at);
  }
  cv::Mat image(const ViewOptions& options, PlanPoint at) const { return view(options, at).image; }
  cv::Mat truth(PlanPoint at, int width = 0) const {
    return render_truth(spec_, at, width > 0 ? width : spec_.width);
  }
  double psnr(const ViewOptions& options, PlanPoint at) const {
    return psnr_db(image(options, at), truth(at, options.width));
  }

 private:
  TestDirectory directory_;
  SyntheticRoomSpec spec_;
  Room room_;
};

// Written once per program.
inline const TestRoom& pillar_room() {
  static const TestRoom room(pillar_spec());
  return room;
}

// Largest difference of any channel of any pixel.
inline double largest_difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_INF);
}
// Mean of the absolute differences over all channels, grey levels.
inline double mean_difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total() * 3);
}

}  // namespace raywalk
