// The colours that a station shows, for the comparison of stations.
#pragma once

#include <algorithm>
#include <cstddef>
#include <opencv2/core/mat.hpp>

#include "core/panorama/gain_field.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// A range of colours, 8-bit levels.
struct ColourRange {
  cv::Vec3b least;
  cv::Vec3b most;
};

// Largest distance, over the channels, of two ranges from each other; 0 where they overlap.
inline int gap_between(const ColourRange& a, const ColourRange& b) {
  int gap = 0;
  for (int c = 0; c < 3; ++c) {
    gap = std::max({gap, a.least[c] - b.most[c], b.least[c] - a.most[c]});
  }
  return gap;
}

// Pictures of one size, CV_8UC3, [theta][phi], without gaps between the columns. The colour of the
// scene is within a range, as a dark or clipped channel may be darker or brighter than it shows.
struct StationColours {
  cv::Mat shown;  // after the gains
  cv::Mat least;  // as shown, or 0 where dark
  cv::Mat most;   // as shown, or 255 where clipped
};

// A ColourRange per pixel, CV_8UC(6): side by side, so that looking one up takes one line of cache.
cv::Mat ranges_of(const StationColours& colours);
// Of a pixel by its index (pixel_index).
inline const ColourRange& range_at(const cv::Mat& ranges, std::size_t pixel) {
  static_assert(sizeof(ColourRange) == 6);
  return ranges.ptr<ColourRange>()[pixel];
}

// The colours of a station's panorama. `size` is that of the panoramas or smaller.
StationColours station_colours(const Room& room, StationIndex station, PanoramaSize size,
                               const GainField& gains);

}  // namespace raywalk::build_lf
