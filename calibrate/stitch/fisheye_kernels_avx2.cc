// The stitching kernel for processors with AVX2 (this file alone is compiled with -mavx2). Two
// neighbouring pixels fill a register of eight floats, so a row of four takes two.
#include <immintrin.h>

#include "calibrate/stitch/fisheye_arithmetic.h"
#include "calibrate/stitch/fisheye_kernels.h"

namespace raywalk::calibrate {
namespace {

__m256 two_pixels(const std::uint8_t* pixels) {
  const __m128i bytes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(pixels));
  return _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(bytes));
}

__m128 cubic_weights(float position) {
  const __m128 t = _mm_set1_ps(position);
  __m128 weights = _mm_load_ps(kCubic[3]);
  for (int power = 2; power >= 0; --power) {
    weights = _mm_add_ps(_mm_mul_ps(weights, t), _mm_load_ps(kCubic[power]));
  }
  return weights;
}

// Weights I and I + 1, one for each of the two pixels.
template <int I>
__m256 two_weights(__m128 weights) {
  return _mm256_set_m128(_mm_permute_ps(weights, (I + 1) * 0x55),
                         _mm_permute_ps(weights, I * 0x55));
}

template <int J>
__m256 row_sum(const std::uint8_t* row, std::int64_t row_bytes, __m256 left, __m256 right,
               __m128 down) {
  row += J * row_bytes;
  const __m256 along = _mm256_add_ps(_mm256_mul_ps(left, two_pixels(row)),
                                     _mm256_mul_ps(right, two_pixels(row + 8)));
  const __m128 weight = _mm_permute_ps(down, J * 0x55);
  return _mm256_mul_ps(_mm256_set_m128(weight, weight), along);
}

// Even columns in the lower half, odd ones in the upper.
__m128 cubic(const std::uint8_t* row, std::int64_t row_bytes, __m128 across, __m128 down) {
  const __m256 left = two_weights<0>(across), right = two_weights<2>(across);
  __m256 sum = row_sum<0>(row, row_bytes, left, right, down);
  sum = _mm256_add_ps(sum, row_sum<1>(row, row_bytes, left, right, down));
  sum = _mm256_add_ps(sum, row_sum<2>(row, row_bytes, left, right, down));
  sum = _mm256_add_ps(sum, row_sum<3>(row, row_bytes, left, right, down));
  return _mm_add_ps(_mm256_castps256_ps128(sum), _mm256_extractf128_ps(sum, 1));
}

__m128 clamp_level(__m128 level) {
  return _mm_min_ps(_mm_max_ps(level, _mm_setzero_ps()), _mm_set1_ps(255.0F));
}

__m128 corrected(__m128 level, __m128 root) {
  const __m128 one = _mm_set1_ps(1.0F);
  const __m128 toe = _mm_min_ps(_mm_mul_ps(level, _mm_set1_ps(1.0F / kToe)), one);
  const __m128 shift = _mm_mul_ps(_mm_set1_ps(kShift), _mm_sub_ps(root, one));
  return clamp_level(_mm_add_ps(_mm_mul_ps(root, level), _mm_mul_ps(shift, toe)));
}

void sample_with_avx2(const FisheyePixels& picture, const FisheyeSample* samples, int count,
                      const ColourRoots& colours, std::int16_t* levels) {
  const __m128 colour_roots = _mm_setr_ps(colours.bgr[0], colours.bgr[1], colours.bgr[2], 1.0F);
  for (int i = 0; i < count; ++i, levels += 3) {
    const FisheyeSample& sample = samples[i];
    const float u = __builtin_floorf(sample.u), v = __builtin_floorf(sample.v);
    const std::uint8_t* row = picture.pixels +
                              (static_cast<std::int64_t>(v) - 1) * picture.row_bytes +
                              4 * (static_cast<std::int64_t>(u) - 1);
    const __m128 level = clamp_level(
        cubic(row, picture.row_bytes, cubic_weights(sample.u - u), cubic_weights(sample.v - v)));
    const __m128 root = _mm_mul_ps(_mm_set1_ps(sample.root), colour_roots);
    const __m128 parts =
        _mm_add_ps(_mm_mul_ps(corrected(level, root), _mm_set1_ps(kLevelParts)), _mm_set1_ps(0.5F));
    const __m128i whole = _mm_cvttps_epi32(parts);
    const __m128i words = _mm_packs_epi32(whole, whole);
    levels[0] = static_cast<std::int16_t>(_mm_extract_epi16(words, 0));
    levels[1] = static_cast<std::int16_t>(_mm_extract_epi16(words, 1));
    levels[2] = static_cast<std::int16_t>(_mm_extract_epi16(words, 2));
  }
}

}  // namespace

extern const FisheyeKernels kAvx2Fisheye;
const FisheyeKernels kAvx2Fisheye{"avx2", &sample_with_avx2};

}  // namespace raywalk::calibrate
