// The colours that a station shows, for the comparison of stations.
#pragma once

#include <algorithm>
#include <cstddef>
#include <opencv2/core/mat.hpp>

#include "build_lf/depth/inverse_distance_map.h"
#include "core/room/gain_fields.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// A range of colours, 8-bit levels.
struct ColourRange {
  cv::Vec3b least;
  cv::Vec3b most;
};

// Distance of two ranges from each other in one channel; 0 where they overlap.
inline int channel_gap(const ColourRange& a, const ColourRange& b, int channel) {
  return std::max({0, a.least[channel] - b.most[channel], b.least[channel] - a.most[channel]});
}
// The largest over the channels.
inline int gap_between(const ColourRange& a, const ColourRange& b) {
  return std::max({channel_gap(a, b, 0), channel_gap(a, b, 1), channel_gap(a, b, 2)});
}
// The sum over the channels.
inline int gaps_between(const ColourRange& a, const ColourRange& b) {
  return channel_gap(a, b, 0) + channel_gap(a, b, 1) + channel_gap(a, b, 2);
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
// Whether a sampled range is masked: then it is no range.
inline bool is_masked(const ColourRange& range) { return range.least[0] > range.most[0]; }

// The colours of a station's panorama. `size` is that of the panoramas or smaller.
StationColours station_colours(const Room& room, StationIndex station, PanoramaSize size,
                               const GainField& gains);

}  // namespace raywalk::build_lf
