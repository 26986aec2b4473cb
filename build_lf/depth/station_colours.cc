#include "build_lf/depth/station_colours.h"

#include <algorithm>
#include <opencv2/core.hpp>
#include <vector>

#include "build_lf/depth/station_image.h"

namespace raywalk::build_lf {

int gap_between(const ColourRange& a, const ColourRange& b) {
  int gap = 0;
  for (int c = 0; c < 3; ++c) {
    gap = std::max({gap, a.least[c] - b.most[c], b.least[c] - a.most[c]});
  }
  return gap;
}

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
