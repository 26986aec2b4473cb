// For tests: a synthetic room in closed form, written to disk and opened.
#pragma once

#include <functional>
#include <limits>
#include <map>
#include <opencv2/core.hpp>
#include <string>

#include "core/files/test_directory.h"
#include "core/judge/metrics/psnr.h"
#include "core/room/room.h"
#include "core/view/renderer.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {

// A cell with the given station spacing, in a room scaled in proportion.
inline SyntheticRoomSpec room_of_spacing(double spacing_m) {
  const double scale = spacing_m / 0.125;
  SyntheticRoomSpec spec;
  spec.side_m = scale;
  spec.spacing_m = spacing_m;
  spec.overhang_m = 0.25 * scale;
  spec.scene.walls.min_m *= scale;
  spec.scene.walls.max_m *= scale;
  spec.scene.texture_wavelength_m *= scale;
  return spec;
}

// The synthetic scene's own room with stations beyond the corners.
inline SyntheticRoomSpec box_room(int width = 192) {
  SyntheticRoomSpec spec;
  spec.overhang_m = 0.25;
  spec.width = width;
  return spec;
}

// Extreme contents of distance maps, by name.
inline std::map<std::string, std::function<float(int, int, double)>> extreme_distances() {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const auto always = [](float metres) { return [metres](int, int, double) { return metres; }; };
  const auto checkerboard = [](float a, float b) {
    return [a, b](int u, int v, double) { return (u / 2 + v / 2) % 2 == 0 ? a : b; };
  };
  return {{"1 um", always(1e-6f)},
          {"100000 km", always(1e8f)},
          {"none", always(0.0f)},
          {"infinite", always(kInfinity)},
          {"less than a float can invert", always(1e-42f)},
          {"the largest float", always(std::numeric_limits<float>::max())},
          {"1 m", always(1.0f)},
          {"half a metre, where stations are", always(0.5f)},
          {"near beside far", checkerboard(1e-6f, 1e8f)},
          {"known beside unknown", checkerboard(2.0f, 0.0f)},
          {"infinite beside zero", checkerboard(kInfinity, 0.0f)}};
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

// Largest difference of any channel of any pixel.
inline double largest_difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_INF);
}
// Mean of the absolute differences over all channels, grey levels.
inline double mean_difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total() * 3);
}

}  // namespace raywalk
