// Pass 4, inner loops: samples of stations, and their mixing.
//
// Samples are bilinear in 16-bit fixed point, the positions in 1/128 of a pixel, or bicubic
// (Catmull-Rom: R. Keys, "Cubic convolution interpolation for digital image processing", IEEE
// Transactions on Acoustics, Speech, and Signal Processing 29 (6), 1981) in float.
#pragma once

#include <cstdint>
#include <span>

#include "core/geometry/sphere.h"

namespace raywalk {

// Where rows of a column are read in a station: byte offsets of the upper pixels in the two
// captured columns around, and the parts of the way between them in 1/128, each twice in 16 bits:
// part_u and part_u; 128 - part_v and part_v.
struct SamplePlaces {
  std::int32_t* left;
  std::int32_t* right;
  std::int32_t* part_u;
  std::int32_t* part_v;
};

// The samples of one station in a run of rows. The station's first byte may be preceded, and its
// last one followed, by 16 readable ones.
struct StationSamples {
  const std::uint8_t* pixels = nullptr;  // rgb, [theta][phi]
  SamplePlaces at{};
  const float* u = nullptr;  // the same places as pixel positions, u below the width
  const float* v = nullptr;
  const std::int16_t* weight = nullptr;  // of each row, in 1/kWeightOne; of all stations 1
  // The station's exposure correction at every exposure_step-th row, rgb and a fourth value that is
  // not used, linear between; null: 1.
  const float* exposure = nullptr;
  int exposure_step = 1;
};
inline constexpr int kExposureStep = 8;
inline constexpr int kWeightOne = 1 << 14;
inline constexpr std::size_t kMostSamples = 72;  // of a pixel
inline constexpr std::size_t kMostRows = 128;    // at once

// Fills `at` and `u` from positions `from_column` to the right of `column`, which is in [0, 2 W),
// and rows `v`, which are clamped.
void place_samples(const float* from_column, float* v, int rows, float column,
                   PanoramaSize captured, float* u, const SamplePlaces& at);

// Asks the processor to load what the columns after these ones will read.
void prefetch_samples(const StationSamples& samples, int rows, int column_bytes);

// Mixes bilinear samples of up to kMostRows rows into bgr pixels that are `stride` bytes apart; the
// byte after each is written too. Of a single station the weights are not looked at.
void mix_linear(std::span<const StationSamples> samples, int rows, std::uint8_t* bgr, int stride);

// Mixes captured columns as they are; weights in 1/kWeightOne, together 1.
struct WeightedColumn {
  const std::uint8_t* rgb;
  int next;  // bytes to the column after it, which is asked for
  std::int16_t weight;
};
void mix_columns(std::span<const WeightedColumn> columns, int bytes, std::uint8_t* rgb);
// Stores a column as bgr pixels that are `stride` bytes apart; the byte after each is written too.
void store_column(const std::uint8_t* rgb, int rows, std::uint8_t* bgr, int stride);

// The same of up to kMostSamples stations, bicubic or with exposure corrections. Of many samples,
// those that contradict the others count less.
void mix_exact(std::span<const StationSamples> samples, bool cubic, PanoramaSize captured, int rows,
               std::uint8_t* bgr, int stride);

}  // namespace raywalk
