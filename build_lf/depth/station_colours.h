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

// The same, summed over the channels.
inline int gaps_between(const ColourRange& a, const ColourRange& b) {
  int gaps = 0;
  for (int c = 0; c < 3; ++c) gaps += std::max({0, a.least[c] - b.most[c], b.least[c] - a.most[c]});
  return gaps;
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

// The ranges of what lies within half a pixel, at kSamplesPerPixel samples a pixel in each
// direction, so that what is sampled beside an edge differs from neither side. Where `valid`, empty
// or CV_8UC1 of the picture's size, is 0, they are masked.
cv::Mat sampled_ranges(const StationColours& colours, const cv::Mat& valid);
// Whether a sampled range is masked.
inline bool is_masked(const ColourRange& range) { return range.least[0] > range.most[0]; }

// The colours of a station's panorama. `size` is that of the panoramas or smaller.
StationColours station_colours(const Room& room, StationIndex station, PanoramaSize size,
                               const GainField& gains);

}  // namespace raywalk::build_lf
