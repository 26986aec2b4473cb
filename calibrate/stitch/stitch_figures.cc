#include "calibrate/stitch/stitch_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "calibrate/base/figures.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

constexpr int kSmallestCrop_px = 320;  // enlarged to this
constexpr double kCropSpan_deg = 40.0;

// Where the seam crosses the horizon.
struct SeamPlace {
  double theta_deg;
  const char* captured;  // names of its figures
  const char* balanced;
};
constexpr std::array kPlaces{SeamPlace{-90.0, "stitch_left_captured", "stitch_left"},
                             SeamPlace{90.0, "stitch_right_captured", "stitch_right"}};
constexpr const char* kPanorama = "stitch_panorama";

cv::Mat seam_crop(const cv::Mat& panorama, double theta_deg) {
  const int side = static_cast<int>(panorama.cols * kCropSpan_deg / 360.0);
  const int centre = static_cast<int>(panorama.cols * (0.5 + theta_deg / 360.0));
  cv::Mat shown = panorama(cv::Rect(centre - side / 2, panorama.rows / 2 - side / 2, side, side));
  if (side >= kSmallestCrop_px) return shown;
  cv::Mat enlarged;
  cv::resize(shown, enlarged, {kSmallestCrop_px, kSmallestCrop_px}, 0.0, 0.0, cv::INTER_CUBIC);
  return enlarged;
}

}  // namespace

nlohmann::ordered_json write_stitch_figures(const StitchSample& sample, const fs::path& out) {
  constexpr const char* kBalanced = "balanced and blended";
  auto figures = nlohmann::ordered_json::array();
  figures.push_back(
      write_figure(out, kPanorama, "Station " + sample.station, kBalanced, sample.panorama));
  for (const SeamPlace& place : kPlaces) {
    const std::string row = fmt::format("Seam at {:g} degrees", place.theta_deg);
    figures.push_back(write_figure(out, place.captured, row, "as captured",
                                   seam_crop(sample.unbalanced, place.theta_deg)));
    figures.push_back(write_figure(out, place.balanced, row, kBalanced,
                                   seam_crop(sample.panorama, place.theta_deg)));
  }
  return figures;
}

bool has_stitch_figures(const fs::path& out) {
  const auto exists = [&](const char* name) {
    return fs::exists(out / "figures" / (std::string(name) + ".png"));
  };
  return exists(kPanorama) && std::ranges::all_of(kPlaces, [&](const SeamPlace& place) {
           return exists(place.captured) && exists(place.balanced);
         });
}

}  // namespace raywalk::calibrate
