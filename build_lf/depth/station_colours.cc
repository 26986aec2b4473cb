#include "build_lf/depth/station_colours.h"

#include <opencv2/core.hpp>
#include <vector>

#include "build_lf/depth/station_image.h"

namespace raywalk::build_lf {

StationColours station_colours(const Room& room, StationIndex station, PanoramaSize size,
                               const GainField& gains) {
  // Levels that a camera may have clipped.
  constexpr double kDarkest = 4.0;
  constexpr double kBrightest = 250.0;
  const cv::Mat image = station_image(room, station, size);
  StationColours colours;
  colours.shown = image.clone();
  apply_gains(gains, &colours.shown);
  colours.least = colours.shown.clone();
  colours.most = colours.shown.clone();
  colours.least.reshape(1).setTo(0, image.reshape(1) <= kDarkest);
  colours.most.reshape(1).setTo(255, image.reshape(1) >= kBrightest);
  return colours;
}

cv::Mat ranges_of(const StationColours& colours) {
  cv::Mat ranges;
  cv::merge(std::vector<cv::Mat>{colours.least, colours.most}, ranges);
  return ranges;
}

}  // namespace raywalk::build_lf
