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

constexpr float kToNearest = 0.5f;   // before truncation
constexpr int kSampleOne = 1 << 14;  // a full level in what sample() returns

RAYWALK_INLINE Int4 all(std::int32_t value) { return Int4{value, value, value, value}; }
RAYWALK_INLINE Float4 all(float value) { return Float4{value, value, value, value}; }

// A bilinear sample, rgb in 1/2^14 of a level.
#if defined(__SSE2__)
RAYWALK_INLINE __m128i load_pixels(const std::uint8_t* p) {
  return _mm_unpacklo_epi8(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p)),
                           _mm_setzero_si128());
}
RAYWALK_INLINE Int4 sample(const StationSamples& s, int i) {
  const __m128i left = load_pixels(s.pixels + s.at.left[i]);
  const __m128i right = load_pixels(s.pixels + s.at.right[i]);
  const __m128i across =
      _mm_add_epi16(_mm_slli_epi16(left, 7),
                    _mm_mullo_epi16(_mm_sub_epi16(right, left), _mm_set1_epi32(s.at.part_u[i])));
  // The upper pixel is in words 0 to 2, the lower one in words 3 to 5.
  return reinterpret_cast<Int4>(_mm_madd_epi16(
      _mm_unpacklo_epi16(across, _mm_srli_si128(across, 6)), _mm_set1_epi32(s.at.part_v[i])));
}
#else
RAYWALK_INLINE Int4 sample(const StationSamples& s, int i) {
  const std::uint8_t* const left = s.pixels + s.at.left[i];
  const std::uint8_t* const right = s.pixels + s.at.right[i];
  const int part_u = s.at.part_u[i] & 0xffff, part_v = s.at.part_v[i] >> 16;
  Int4 sum{};
  for (int c = 0; c < 3; ++c) {
    const int upper = left[c] * 128 + (right[c] - left[c]) * part_u;
    const int lower = left[c + 3] * 128 + (right[c + 3] - left[c + 3]) * part_u;
    sum[c] = upper * (128 - part_v) + lower * part_v;
  }
  return sum;
}
#endif

// 15 bits of a sample times a weight: levels in 1/2^21.
RAYWALK_INLINE Int4 weighted(Int4 sample, std::int16_t weight) {
  const Int4 level = sample >> 7;
#if defined(__SSE2__)
  // The upper halves of the values are 0.
  return reinterpret_cast<Int4>(
      _mm_madd_epi16(reinterpret_cast<__m128i>(level), _mm_set1_epi32(weight)));
#else
  return level * all(weight);
#endif
}

// Levels, rgb, as bgr and a byte that the next pixel overwrites.
RAYWALK_INLINE void store(Int4 rgb, std::uint8_t* bgr) {
#if defined(__SSE2__)
  const __m128i value = _mm_shuffle_epi32(reinterpret_cast<__m128i>(rgb), _MM_SHUFFLE(3, 0, 1, 2));
  const __m128i words = _mm_packs_epi32(value, value);
  const std::int32_t pixel = _mm_cvtsi128_si32(_mm_packus_epi16(words, words));
  std::memcpy(bgr, &pixel, 4);
#else
  for (int c = 0; c < 3; ++c) bgr[c] = static_cast<std::uint8_t>(std::clamp(rgb[2 - c], 0, 255));
#endif
}

// The weights of the four pixels around a position `t` of the way from the second to the third.
RAYWALK_INLINE Float4 catmull_rom(float t) {
  const float t2 = t * t, t3 = t2 * t;
  return Float4{-0.5f * t3 + t2 - 0.5f * t, 1.5f * t3 - 2.5f * t2 + 1.0f,
                -1.5f * t3 + 2.0f * t2 + 0.5f * t, 0.5f * t3 - 0.5f * t2};
}

RAYWALK_INLINE Float4 load_pixel(const std::uint8_t* p) {
  return Float4{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]), 0.0f};
}

// A bicubic sample, rgb levels; rows end at the poles.
RAYWALK_INLINE Float4 sample_cubic(const StationSamples& s, int i, PanoramaSize captured) {
  const int whole_u = static_cast<int>(s.u[i]), whole_v = static_cast<int>(s.v[i]);
  const Float4 across = catmull_rom(s.u[i] - static_cast<float>(whole_u));
  const Float4 down = catmull_rom(s.v[i] - static_cast<float>(whole_v));
  Float4 sum{};
  for (int a = 0; a < 4; ++a) {
    const std::uint8_t* const column =
        s.pixels +
        static_cast<std::ptrdiff_t>((whole_u - 1 + a + captured.width) % captured.width) * 3 *
            captured.height;
    Float4 of_column{};
    for (int b = 0; b < 4; ++b) {
      const int row = std::clamp(whole_v - 1 + b, 0, captured.height - 1);
      of_column += all(down[b]) * load_pixel(column + static_cast<std::ptrdiff_t>(3 * row));
    }
    sum += all(across[a]) * of_column;
  }
  return sum;
}

RAYWALK_INLINE Float4 load_exposure(const StationSamples& s, int row) {
  const float* const node = s.exposure + row / s.exposure_step * 4;
  const float part =
      static_cast<float>(row % s.exposure_step) / static_cast<float>(s.exposure_step);
  Float4 here, next;
  std::memcpy(&here, node, sizeof here);
  std::memcpy(&next, node + 4, sizeof next);
  return here + all(part) * (next - here);
}

struct WeightedLevel {
  Float4 rgb;
  float weight;
};

RAYWALK_INLINE Float4 weighted_mean(std::span<const WeightedLevel> levels) {
  Float4 sum{};
  float total = 0.0f;
  for (const WeightedLevel& level : levels) {
    sum += all(level.weight) * level.rgb;
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
      const Float4 d = (levels[k].rgb - mean) * all(1.0f / kScale);
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
  std::int32_t *const to_left = at.left, *const to_right = at.right;
  std::int32_t *const to_u = at.part_u, *const to_v = at.part_v;
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
    const int part_u = static_cast<int>((x - static_cast<float>(whole)) * 128.0f + kToNearest);
    const int part_v = static_cast<int>((y - static_cast<float>(row)) * 128.0f + kToNearest);
    u[i] = static_cast<float>(left) + (x - static_cast<float>(whole));
    v[i] = y;
    to_left[i] = left * bytes + 3 * row;
    to_right[i] = right * bytes + 3 * row;
    to_u[i] = part_u | part_u << 16;
    to_v[i] = (128 - part_v) | part_v << 16;
  }
}

void prefetch_samples(const StationSamples& samples, int rows, int column_bytes) {
  constexpr int kRowsPerLine = 8;  // nearly: 64 bytes hold 21
  for (int i = 0; i < rows; i += kRowsPerLine) {
    const std::uint8_t* const next = samples.pixels + samples.at.right[i] + column_bytes;
    __builtin_prefetch(next);
    __builtin_prefetch(next + column_bytes);
  }
}

namespace {

// One station after the other, so that a loop has few pointers; sums in 1/2^21 of a level.
RAYWALK_VECTOR_CLONES void begin_sum(StationSamples samples, int rows, Int4* sum) {
  for (int i = 0; i < rows; ++i) {
    sum[i] = weighted(sample(samples, i), samples.weight[i]) + all(1 << 20);
  }
}
RAYWALK_VECTOR_CLONES void add_sum(StationSamples samples, int rows, Int4* sum) {
  for (int i = 0; i < rows; ++i) sum[i] += weighted(sample(samples, i), samples.weight[i]);
}
RAYWALK_VECTOR_CLONES void store_sum(StationSamples samples, int rows, const Int4* sum,
                                     std::uint8_t* bgr, int stride) {
  for (int i = 0; i < rows; ++i, bgr += stride) {
    store((sum[i] + weighted(sample(samples, i), samples.weight[i])) >> 21, bgr);
  }
}
RAYWALK_VECTOR_CLONES void store_only(StationSamples samples, int rows, std::uint8_t* bgr,
                                      int stride) {
  for (int i = 0; i < rows; ++i, bgr += stride) {
    store((sample(samples, i) + all(kSampleOne / 2)) >> 14, bgr);
  }
}

}  // namespace

void mix_linear(std::span<const StationSamples> samples, int rows, std::uint8_t* bgr, int stride) {
  if (samples.size() == 1) {
    store_only(samples[0], rows, bgr, stride);
    return;
  }
  std::array<Int4, kMostRows> sum;
  if (samples.empty()) {
    for (int i = 0; i < rows; ++i) store(all(0), bgr + i * stride);
    return;
  }
  begin_sum(samples.front(), rows, sum.data());
  for (const StationSamples& of : samples.subspan(1, samples.size() - 2)) {
    add_sum(of, rows, sum.data());
  }
  store_sum(samples.back(), rows, sum.data(), bgr, stride);
}

RAYWALK_VECTOR_CLONES void mix_columns(std::span<const WeightedColumn> columns, int bytes,
                                       std::uint8_t* rgb) {
  constexpr int kAtOnce = 64;  // so that sums stay in registers
  std::array<std::int32_t, kAtOnce> sum;
  for (int first = 0; first < bytes; first += kAtOnce) {
    sum.fill(kWeightOne / 2);
    const int count = bytes - first < kAtOnce ? bytes - first : kAtOnce;
    for (const WeightedColumn& column : columns) {
      const std::uint8_t* const from = column.rgb + first;
      __builtin_prefetch(from + column.next);
      if (count == kAtOnce) {
        for (std::size_t i = 0; i < kAtOnce; ++i) sum[i] += from[i] * column.weight;
      } else {
        for (int i = 0; i < count; ++i) sum[static_cast<std::size_t>(i)] += from[i] * column.weight;
      }
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      rgb[static_cast<std::size_t>(first) + i] = static_cast<std::uint8_t>(sum[i] >> 14);
    }
  }
}

void store_column(const std::uint8_t* rgb, int rows, std::uint8_t* bgr, int stride) {
  for (int i = 0; i < rows; ++i, rgb += 3, bgr += stride) {
    const std::array<std::uint8_t, 4> pixel{rgb[2], rgb[1], rgb[0], 0};
    std::memcpy(bgr, pixel.data(), pixel.size());
  }
}

RAYWALK_VECTOR_CLONES void mix_exact(std::span<const StationSamples> samples, bool cubic,
                                     PanoramaSize captured, int rows, std::uint8_t* bgr,
                                     int stride) {
  std::array<WeightedLevel, kMostSamples> levels;
  for (int i = 0; i < rows; ++i, bgr += stride) {
    std::size_t count = 0;
    for (const StationSamples& s : samples) {
      if (s.weight[i] == 0) continue;
      WeightedLevel& level = levels[count++];
      level.weight = static_cast<float>(s.weight[i]);
      level.rgb = cubic ? sample_cubic(s, i, captured)
                        : __builtin_convertvector(sample(s, i), Float4) * all(1.0f / kSampleOne);
      if (s.exposure != nullptr) level.rgb *= load_exposure(s, i);
    }
    Float4 rgb = mean_of({levels.data(), count}) + all(0.5f);
    for (int c = 0; c < 3; ++c) rgb[c] = std::clamp(rgb[c], 0.0f, 255.0f);
    store(__builtin_convertvector(rgb, Int4), bgr);
  }
}

}  // namespace raywalk
