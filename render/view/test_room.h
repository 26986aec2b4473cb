// For tests: a room in closed form, written and opened.
#pragma once

#include <opencv2/core.hpp>

#include "core/files/test_directory.h"
#include "core/room/room.h"
#include "render/metrics/psnr.h"
#include "render/view/renderer.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {

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

// Largest difference of any channel of any pixel.
inline double largest_difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_INF);
}
// Mean of the absolute differences over all channels, grey levels.
inline double mean_difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total() * 3);
}

}  // namespace raywalk
