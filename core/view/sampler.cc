#include "core/view/sampler.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "core/view/vector_clones.h"
#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace raywalk {
namespace {

using Int4 = std::int32_t __attribute__((vector_size(16)));
using Float4 = float __attribute__((vector_size(16)));

constexpr float kToNearest = 0.5f;                 // before truncation
constexpr int kSampleOne = kAcrossOne * kDownOne;  // a full level in what sample() returns

RAYWALK_INLINE Float4 all(float value) { return Float4{value, value, value, value}; }

// A bilinear sample times its weight, bgr in 1/kSampleOne of a level.
RAYWALK_INLINE Int4 sample(const StationSamples& s, int i) {
  const std::uint8_t *const left = s.pixels + s.at.left[i], *const right = s.pixels + s.at.right[i];
  const int part_left = s.at.across[i] & 0xff, part_right = s.at.across[i] >> 8 & 0xff;
  const int upper = s.at.down[i] & 0xffff, lower = s.at.down[i] >> 16;
  Int4 sum{};
  for (int c = 0; c < 3; ++c) {
    sum[2 - c] = (left[c] * part_left + right[c] * part_right) * upper +
                 (left[c + 3] * part_left + right[c + 3] * part_right) * lower;
  }
  return sum;
}

// Levels, bgr, and a byte that the next pixel overwrites.
RAYWALK_INLINE void store(Int4 level, std::uint8_t* bgr) {
  std::array<std::uint8_t, 4> pixel{};
  for (std::size_t c = 0; c < 3; ++c) {
    pixel[c] = static_cast<std::uint8_t>(std::clamp(level[static_cast<int>(c)], 0, 255));
  }
  std::memcpy(bgr, pixel.data(), pixel.size());
}

// The weights of the four pixels around a position `t` of the way from the second to the third.
RAYWALK_INLINE Float4 catmull_rom(float t) {
  const float t2 = t * t, t3 = t2 * t;
  return Float4{-0.5f * t3 + t2 - 0.5f * t, 1.5f * t3 - 2.5f * t2 + 1.0f,
                -1.5f * t3 + 2.0f * t2 + 0.5f * t, 0.5f * t3 - 0.5f * t2};
}
RAYWALK_INLINE Float4 linear(float t) { return Float4{0.0f, 1.0f - t, t, 0.0f}; }

RAYWALK_INLINE Float4 load_bgr(const std::uint8_t* p) {
  return Float4{static_cast<float>(p[2]), static_cast<float>(p[1]), static_cast<float>(p[0]), 0.0f};
}

// A sample in float, levels; rows end at the poles.
RAYWALK_INLINE Float4 sample_exact(const StationSamples& s, int i, bool cubic,
                                   PanoramaSize captured) {
  const int whole_u = static_cast<int>(s.u[i]), whole_v = static_cast<int>(s.v[i]);
  const float part_u = s.u[i] - static_cast<float>(whole_u);
  const float part_v = s.v[i] - static_cast<float>(whole_v);
  const Float4 across = cubic ? catmull_rom(part_u) : linear(part_u);
  const Float4 down = cubic ? catmull_rom(part_v) : linear(part_v);
  const int first = cubic ? 0 : 1, end = cubic ? 4 : 3;
  Float4 sum{};
  for (int a = first; a < end; ++a) {
    const std::uint8_t* const column =
        s.pixels +
        static_cast<std::ptrdiff_t>((whole_u - 1 + a + captured.width) % captured.width) * 3 *
            captured.height;
    Float4 of_column{};
    for (int b = first; b < end; ++b) {
      const int row = std::clamp(whole_v - 1 + b, 0, captured.height - 1);
      of_column += all(down[b]) * load_bgr(column + static_cast<std::ptrdiff_t>(3 * row));
    }
    sum += all(across[a]) * of_column;
  }
  return sum;
}

RAYWALK_INLINE Float4 load_exposure(const StationSamples& s, int row) {
  const float* const node = s.exposure + row / s.exposure_step * 4;
  const float part =
      static_cast<float>(row % s.exposure_step) / static_cast<float>(s.exposure_step);
  const Float4 here{node[2], node[1], node[0], 0.0f}, next{node[6], node[5], node[4], 0.0f};
  return here + all(part) * (next - here);
}

struct WeightedLevel {
  Float4 bgr;
  float weight;
};

RAYWALK_INLINE Float4 weighted_mean(std::span<const WeightedLevel> levels) {
  Float4 sum{};
  float total = 0.0f;
  for (const WeightedLevel& level : levels) {
    sum += all(level.weight) * level.bgr;
    total += level.weight;
  }
  return sum * all(total > 0.0f ? 1.0f / total : 0.0f);
}

// The mean of samples. Of many, those count less that contradict the others, which show something
// else: two steps of iteratively reweighted least squares with the Geman-McClure estimator's
// weights, 1 / (1 + (d / s)^2)^2, for a difference d of the colours. Noise is well below s.
RAYWALK_INLINE Float4 mean_of(std::span<WeightedLevel> levels) {
  constexpr std::size_t kMany = 6;
  constexpr float kScale = 40.0f;  // levels
  const Float4 first = weighted_mean(levels);
  if (levels.size() < kMany) return first;
  std::array<float, kMostSamples> weight;
  for (std::size_t k = 0; k < levels.size(); ++k) weight[k] = levels[k].weight;
  Float4 mean = first;
  for (int step = 0; step < 2; ++step) {
    for (std::size_t k = 0; k < levels.size(); ++k) {
      const Float4 d = (levels[k].bgr - mean) * all(1.0f / kScale);
      const float far = 1.0f + d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
      levels[k].weight = weight[k] / (far * far);
    }
    mean = weighted_mean(levels);
  }
  return mean;
}

}  // namespace

RAYWALK_VECTOR_CLONES void place_samples(const float* from_column, float* v, int rows, float column,
                                         PanoramaSize captured, float* u, const SamplePlaces& at) {
  const int bytes = 3 * captured.height;
  std::int32_t *const to_left = at.left, *const to_right = at.right, *const to_across = at.across;
  RAYWALK_INDEPENDENT
  for (int i = 0; i < rows; ++i) {
    float x = from_column[i] + column;
    x += x < 0.0f ? static_cast<float>(captured.width) : 0.0f;
    const int whole = static_cast<int>(x);
    int left = whole;
    left -= left >= captured.width ? captured.width : 0;
    left -= left >= captured.width ? captured.width : 0;
    const int right = left + 1 == captured.width ? 0 : left + 1;
    float y = v[i] < 0.0f ? 0.0f : v[i];
    y = y > static_cast<float>(captured.height - 1) ? static_cast<float>(captured.height - 1) : y;
    int row = static_cast<int>(y);
    row = row > captured.height - 2 ? captured.height - 2 : row;
    const float part = x - static_cast<float>(whole);
    const int part_right = static_cast<int>(part * kAcrossOne + kToNearest);
    u[i] = static_cast<float>(left) + part;
    v[i] = y;
    to_left[i] = left * bytes + 3 * row;
    to_right[i] = right * bytes + 3 * row;
    to_across[i] = (part_right * 0x0100 + kAcrossOne - part_right) * 0x00010001;
  }
}

RAYWALK_VECTOR_CLONES void weigh_samples(const float* v, const float* weight, int rows,
                                         PanoramaSize captured, std::int32_t* down) {
  RAYWALK_INDEPENDENT
  for (int i = 0; i < rows; ++i) {
    int row = static_cast<int>(v[i]);
    row = row > captured.height - 2 ? captured.height - 2 : row;
    const float part = v[i] - static_cast<float>(row), one = weight[i] * kDownOne;
    const int upper = static_cast<int>((1.0f - part) * one + kToNearest);
    const int lower = static_cast<int>(part * one + kToNearest);
    down[i] = upper | lower << 16;
  }
}

void mix_linear(std::span<const StationSamples> samples, std::span<const SamplesAhead> ahead,
                int rows, std::uint8_t* bgr, int stride) {
  int row = 0;
  if (has_mix_avx2()) {
    row = rows / 4 * 4;
    mix_linear_avx2(samples, ahead, row, bgr, stride);
  }
  for (; row < rows; ++row) {
    Int4 sum{};
    for (const StationSamples& s : samples) sum += sample(s, row);
    store((sum + kSampleOne / 2) / kSampleOne, bgr + static_cast<std::ptrdiff_t>(row) * stride);
  }
}

RAYWALK_VECTOR_CLONES void mix_columns(std::span<const WeightedColumn> columns, int bytes,
                                       std::uint8_t* rgb) {
  constexpr int kAtOnce = 64;  // so that sums stay in registers
  std::array<std::uint16_t, kAtOnce> sum;
  for (int first = 0; first < bytes; first += kAtOnce) {
    sum.fill(kColumnsOne / 2);
    const int count = bytes - first < kAtOnce ? bytes - first : kAtOnce;
    for (const WeightedColumn& column : columns) {
      const std::uint8_t* const from = column.rgb + first;
      __builtin_prefetch(from + column.next);
      const std::uint16_t weight = column.weight;
      if (count == kAtOnce) {
        for (std::size_t i = 0; i < kAtOnce; ++i) {
          sum[i] = static_cast<std::uint16_t>(sum[i] + from[i] * weight);
        }
      } else {
        for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
          sum[i] = static_cast<std::uint16_t>(sum[i] + from[i] * weight);
        }
      }
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      rgb[static_cast<std::size_t>(first) + i] = static_cast<std::uint8_t>(sum[i] / kColumnsOne);
    }
  }
}

void store_tile(const TileRows& tile, std::uint8_t* to, std::size_t to_stride) {
  const std::uint8_t* from = tile.from;
  for (int row = 0; row < tile.rows; ++row, from += tile.stride, to += to_stride) {
    std::size_t done = 0;
#if defined(__SSE2__)
    if (reinterpret_cast<std::uintptr_t>(to) % sizeof(__m128i) == 0) {
      for (; done + sizeof(__m128i) <= tile.bytes; done += sizeof(__m128i)) {
        _mm_stream_si128(reinterpret_cast<__m128i*>(to + done),
                         _mm_loadu_si128(reinterpret_cast<const __m128i*>(from + done)));
      }
    }
#endif
    std::memcpy(to + done, from + done, tile.bytes - done);
  }
#if defined(__SSE2__)
  _mm_sfence();
#endif
}

void store_column(const std::uint8_t* rgb, int rows, std::uint8_t* bgr, int stride) {
  for (int i = 0; i < rows; ++i, rgb += 3, bgr += stride) {
    std::uint32_t pixel;
    std::memcpy(&pixel, rgb, sizeof pixel);
    pixel = __builtin_bswap32(pixel) >> 8;
    std::memcpy(bgr, &pixel, sizeof pixel);
  }
}

RAYWALK_VECTOR_CLONES void mix_exact(std::span<const StationSamples> samples, bool cubic,
                                     PanoramaSize captured, int rows, std::uint8_t* bgr,
                                     int stride) {
  std::array<WeightedLevel, kMostSamples> levels;
  for (int i = 0; i < rows; ++i, bgr += stride) {
    std::size_t count = 0;
    for (const StationSamples& s : samples) {
      if (s.weight[i] == 0.0f) continue;
      WeightedLevel& level = levels[count++];
      level.weight = s.weight[i];
      level.bgr = sample_exact(s, i, cubic, captured);
      if (s.exposure != nullptr) level.bgr *= load_exposure(s, i);
    }
    const Float4 mean = mean_of({levels.data(), count}) + all(kToNearest);
    store(__builtin_convertvector(mean, Int4), bgr);
  }
}

}  // namespace raywalk
