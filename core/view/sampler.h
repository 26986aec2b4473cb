// Pass 4, inner loops: samples of stations, and their mixing.
//
// Samples are bilinear in 16-bit fixed point, the positions in 1/64 of a pixel, or bicubic
// (Catmull-Rom: R. Keys, "Cubic convolution interpolation for digital image processing", IEEE
// Transactions on Acoustics, Speech, and Signal Processing 29 (6), 1981) in float.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/geometry/sphere.h"

namespace raywalk {

// Where rows of a column are read in a station: byte offsets of the upper pixels in the two
// captured columns around; the parts of the left and the right one in 1/kAcrossOne, four bytes:
// left, right and the same again; the parts of the upper and the lower row, times the station's
// weight, in 1/kDownOne, two words.
struct SamplePlaces {
  std::int32_t* left;
  std::int32_t* right;
  std::int32_t* across;
  std::int32_t* down;
};
inline constexpr int kAcrossOne = 1 << 6;
inline constexpr int kDownOne = 1 << 14;

// The samples of one station in a run of rows. The station's first byte may be preceded, and its
// last one followed, by 16 readable ones.
struct StationSamples {
  const std::uint8_t* pixels = nullptr;  // rgb, [theta][phi]
  SamplePlaces at{};
  const float* u = nullptr;  // the same places as pixel positions, u below the width
  const float* v = nullptr;
  const float* weight = nullptr;  // of each row; of all stations 1
  // The station's exposure correction at every exposure_step-th row, rgb and a fourth value that is
  // not used, linear between; null: 1.
  const float* exposure = nullptr;
  int exposure_step = 1;
};
// Where the samples mixed next are read, as in StationSamples: so that they are loaded in time.
// Near the poles every one is in another column of the station.
struct SamplesAhead {
  const std::uint8_t* pixels = nullptr;
  const std::int32_t *left = nullptr, *right = nullptr;
};
inline constexpr int kExposureStep = 8;
inline constexpr std::size_t kMostSamples = 72;  // of a pixel
inline constexpr std::size_t kMostRows = 128;    // at once

// Fills `left`, `right`, `across` and `u` from positions `from_column` to the right of `column`,
// which is in [0, 2 W), and rows `v`, which are clamped.
void place_samples(const float* from_column, float* v, int rows, float column,
                   PanoramaSize captured, float* u, const SamplePlaces& at);
// Fills `down` from rows and weights.
void weigh_samples(const float* v, const float* weight, int rows, PanoramaSize captured,
                   std::int32_t* down);

// Mixes bilinear samples of up to kMostRows rows into bgr pixels that are `stride` bytes apart; the
// byte after each is written too.
void mix_linear(std::span<const StationSamples> samples, std::span<const SamplesAhead> ahead,
                int rows, std::uint8_t* bgr, int stride);
// The same for a multiple of 4 rows, with AVX2 (sampler_avx2.cc), to the same bits.
bool has_mix_avx2();
void mix_linear_avx2(std::span<const StationSamples> samples, std::span<const SamplesAhead> ahead,
                     int rows, std::uint8_t* bgr, int stride);

// The same of up to kMostSamples stations, bicubic or with exposure corrections. Of many samples,
// those that contradict the others count less.
void mix_exact(std::span<const StationSamples> samples, bool cubic, PanoramaSize captured, int rows,
               std::uint8_t* bgr, int stride);

// Mixes captured columns as they are; weights in 1/kColumnsOne, together 1.
inline constexpr int kColumnsOne = 1 << 8;
struct WeightedColumn {
  const std::uint8_t* rgb;
  int next;  // bytes to the column after it, which is asked for
  std::uint16_t weight;
};
void mix_columns(std::span<const WeightedColumn> columns, int bytes, std::uint8_t* rgb);
// Copies a tile of a picture into it, past the processor's caches: nothing is read of it again.
struct TileRows {
  const std::uint8_t* from;
  std::size_t stride, bytes;  // of a row
  int rows;
};
void store_tile(const TileRows& tile, std::uint8_t* to, std::size_t to_stride);
// Stores a column, after which a byte may be read, as bgr pixels that are `stride` bytes apart; the
// byte after each is written too.
void store_column(const std::uint8_t* rgb, int rows, std::uint8_t* bgr, int stride);

}  // namespace raywalk
