// The inner loops of the plane sweep (differences between a station's picture and the reference for
// an assumed inverse distance) and of the comparison of maps.
//
// Compiled for generic processors, AVX2 and AVX-512, and selected at run time. All do the same
// arithmetic, so distances do not depend on the machine.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace raywalk::build_lf {

// One sample of a station's picture: red, green, blue and detail, 8 bits each from the lowest.
// Detail is high-pass filtered luminance, normalised by local contrast, so it does not depend on
// exposure; 0 marks an invalid sample.
using MatchingSample = std::uint32_t;
inline constexpr std::uint32_t kInvalidDetail = 0;

constexpr MatchingSample matching_sample(std::uint32_t red, std::uint32_t green, std::uint32_t blue,
                                         std::uint32_t detail) {
  return red | green << 8 | blue << 16 | detail << 24;
}
constexpr int channel_of(MatchingSample sample, int channel) {
  return static_cast<int>(sample >> (8 * channel) & 255U);
}

// Red, green and blue added up: three times the luminance.
constexpr int colour_sum(MatchingSample sample) {
  return channel_of(sample, 0) + channel_of(sample, 1) + channel_of(sample, 2);
}
constexpr bool is_valid(MatchingSample sample) {
  return channel_of(sample, 3) != static_cast<int>(kInvalidDetail);
}

// The maximum difference of two samples, and the value for an invalid sample.
inline constexpr int kMaxDifference = 264;
inline constexpr int kInvalidDifference = 265;

// Neighbouring pixels of the reference: unit direction vectors in world axes, and samples.
struct ReferenceRays {
  const float* x = nullptr;
  const float* y = nullptr;
  const float* z = nullptr;
  const MatchingSample* samples = nullptr;
  int count = 0;
};

// Another station's picture, samples [theta][phi], and offset = (reference position - station
// position) * assumed inverse distance, in world axes: the station sees a point of reference
// direction u in direction u + offset, up to a positive factor.
struct ViewSamples {
  const MatchingSample* samples = nullptr;
  int width = 0;
  int height = 0;
  float offset_x = 0.0f;
  float offset_y = 0.0f;
  float offset_z = 0.0f;
};

// Points relative to a station, in world axes, at any scale.
struct RelativePoints {
  const float* x = nullptr;
  const float* y = nullptr;
  const float* z = nullptr;
  int count = 0;
};

// The directions of a tile are compared with the same stations, at most kMaxViews.
inline constexpr int kTileColumns = 16;
inline constexpr int kTileRows = 32;
inline constexpr int kTilePixels = kTileColumns * kTileRows;
inline constexpr int kMaxViews = 8;
using ViewDifferences = std::array<std::int32_t, kTilePixels>;

// The share of the mean over all views in the cost of a surface; the rest is the mean over the half
// that shows it best, as the others may not see it. Of the distances at which that half shows the
// same colour, as of a surface without texture, those at which more views do are then preferred.
inline constexpr float kShareOfAllViews = 0.25f;

struct MatchingKernels {
  const char* name;
  // Sets difference[i], for each ray, to the difference between the reference's sample and the
  // station's sample nearest to the ray's point: three times the sum of the colour differences, at
  // most 200, plus the detail difference, at most 64. Colour is sharp at edges, detail is
  // independent of exposure; the limits bound the influence of occluded points.
  void (*compare)(const ReferenceRays& reference, const ViewSamples& view,
                  std::int32_t* difference);
  // For i < count sets mean[i] to a mean of the differences of ray i in the first `views` rows of
  // `differences`: that of all by kShareOfAllViews, else that of the smaller half (rounded up). 1
  // to kMaxViews views.
  void (*average_views)(const std::array<ViewDifferences, kMaxViews>& differences, int views,
                        int count, float* mean);
  // One step of semi-global matching for `layers` layers: path[k] = cost[k] + min(previous[k],
  // previous[k +- 1] + small_step, least_previous + large_step) - least_previous; adds path to sum
  // and returns the minimum of path. previous[-1] and previous[layers] must be readable and large.
  std::uint16_t (*extend_path)(const std::uint8_t* cost, const std::uint16_t* previous,
                               std::uint16_t least_previous, std::uint16_t small_step,
                               std::uint16_t large_step, int layers, std::uint16_t* path,
                               std::uint16_t* sum);
  // Sets pixel[i], for each point, to the index (pixel_index) of the pixel that shows it in a
  // panorama of width x height, as pixel_of() does, and length[i] to the point's distance.
  void (*locate)(const RelativePoints& points, int width, int height, std::int32_t* pixel,
                 float* length);
};

// The fastest set that this processor supports.
const MatchingKernels& matching_kernels();
// "generic", "avx2" or "avx512"; null if the name is unknown or this processor does not support the
// set.
const MatchingKernels* matching_kernels_named(const char* name);

}  // namespace raywalk::build_lf
