// The inner loop of the plane sweep: how unlike a station's picture is to the reference, if what
// the reference sees lies at a given inverse distance.
//
// Compiled for any processor, for AVX2 and for AVX-512, and picked at run time; all do the same
// arithmetic, so distances do not depend on the machine.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace raywalk::build_lf {

// One sample of a station's picture: red, green, blue and detail, 8 bits each from the lowest.
// Detail is a high-pass of the luminance, normalised by the contrast around it, so it does not
// depend on exposure; 0 marks a sample that is not to be used.
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

// The most that one pair of samples can differ by, and what is set where the sample is invalid.
inline constexpr int kMaxDifference = 264;
inline constexpr int kInvalidDifference = 265;

// A few neighbouring pixels of the reference: the unit vectors they are seen in, in world axes, and
// their samples.
struct ReferenceRays {
  const float* x = nullptr;
  const float* y = nullptr;
  const float* z = nullptr;
  const MatchingSample* samples = nullptr;
  int count = 0;
};

// Another station's picture, samples [theta][phi], and where the reference lies from it times the
// inverse distance assumed, in world axes: the direction in which the station sees a point of
// direction u is u + offset, up to a positive factor.
struct ViewSamples {
  const MatchingSample* samples = nullptr;
  int width = 0;
  int height = 0;
  float offset_x = 0.0f;
  float offset_y = 0.0f;
  float offset_z = 0.0f;
};

// Directions this close together are compared with the same stations, at most so many.
inline constexpr int kTileColumns = 16;
inline constexpr int kTileRows = 32;
inline constexpr int kTilePixels = kTileColumns * kTileRows;
inline constexpr int kMaxViews = 8;
using ViewDifferences = std::array<std::int32_t, kTilePixels>;

struct MatchingKernels {
  const char* name;
  // Sets difference[i], for each ray, to how much the sample nearest to where the station sees the
  // ray's point differs from the reference's: three times the sum of the colour differences, at
  // most 200, plus that of the detail, at most 64: colour is sharp at edges, detail does not mind
  // exposure. The limits keep what the station cannot see from outweighing the rest.
  void (*compare)(const ReferenceRays& reference, const ViewSamples& view,
                  std::int32_t* difference);
  // mean[i], for i < count, becomes the mean of the least half, rounded up, of what the first
  // `views` rows of `differences` hold for ray i. 1 to kMaxViews views.
  void (*average_better_half)(const std::array<ViewDifferences, kMaxViews>& differences, int views,
                              int count, float* mean);
  // One step of semi-global matching for `layers` layers: path[k] = cost[k] + min(previous[k],
  // previous[k +- 1] + small_step, least_previous + large_step) - least_previous; adds path to sum
  // and returns the least of it. previous[-1] and previous[layers] must be readable and large.
  std::uint16_t (*extend_path)(const std::uint8_t* cost, const std::uint16_t* previous,
                               std::uint16_t least_previous, std::uint16_t small_step,
                               std::uint16_t large_step, int layers, std::uint16_t* path,
                               std::uint16_t* sum);
};

// The fastest set that this processor runs.
const MatchingKernels& matching_kernels();
// "generic", "avx2" or "avx512"; null if the set is unknown or this processor cannot run it.
const MatchingKernels* matching_kernels_named(const char* name);

}  // namespace raywalk::build_lf
