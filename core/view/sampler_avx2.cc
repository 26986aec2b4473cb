// mix_linear() for processors with AVX2: two pixels in a register.
#include "core/view/sampler.h"

#if defined(__x86_64__)
#include <immintrin.h>

#include <cstring>

#define RAYWALK_AVX2 __attribute__((target("avx2")))

namespace raywalk {
namespace {

RAYWALK_AVX2 inline __m128i load_two_rows(const std::uint8_t* pixel) {
  return _mm_loadl_epi64(reinterpret_cast<const __m128i*>(pixel));
}

RAYWALK_AVX2 inline __m256i load_four(const std::int32_t* values) {
  return _mm256_castsi128_si256(_mm_loadu_si128(reinterpret_cast<const __m128i*>(values)));
}

inline void store_pixel(std::int32_t bgr, std::uint8_t* to) { std::memcpy(to, &bgr, sizeof bgr); }

// The i-th and the next sample of a station, each in a half: blue, green and red times weight.
RAYWALK_AVX2 inline __m256i sample_two(const StationSamples& s, int i, __m256i across,
                                       __m256i down) {
  const __m256i left = _mm256_set_m128i(load_two_rows(s.pixels + s.at.left[i + 1]),
                                        load_two_rows(s.pixels + s.at.left[i]));
  const __m256i right = _mm256_set_m128i(load_two_rows(s.pixels + s.at.right[i + 1]),
                                         load_two_rows(s.pixels + s.at.right[i]));
  // Words: red, green, blue of the upper row, then of the lower one.
  const __m256i mixed = _mm256_maddubs_epi16(_mm256_unpacklo_epi8(left, right), across);
  constexpr std::int64_t kBlueGreen = 0x09'08'03'02'0b'0a'05'04;
  constexpr auto kRed = static_cast<std::int64_t>(0x80'80'80'80'07'06'01'00);
  const __m256i pairs = _mm256_set_epi64x(kRed, kBlueGreen, kRed, kBlueGreen);
  return _mm256_madd_epi16(_mm256_shuffle_epi8(mixed, pairs), down);
}

}  // namespace

bool has_mix_avx2() {
  static const bool has = __builtin_cpu_supports("avx2") != 0;
  return has;
}

RAYWALK_AVX2 void mix_linear_avx2(std::span<const StationSamples> samples,
                                  std::span<const SamplesAhead> ahead, int rows, std::uint8_t* bgr,
                                  int stride) {
  const __m256i first_two = _mm256_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1);
  const __m256i second_two = _mm256_setr_epi32(2, 2, 2, 2, 3, 3, 3, 3);
  for (int i = 0; i < rows; i += 4) {
    __m256i first = _mm256_set1_epi32(kAcrossOne * kDownOne / 2), second = first;
    for (const StationSamples& s : samples) {
      const __m256i across = load_four(s.at.across + i), down = load_four(s.at.down + i);
      first =
          _mm256_add_epi32(first, sample_two(s, i, _mm256_permutevar8x32_epi32(across, first_two),
                                             _mm256_permutevar8x32_epi32(down, first_two)));
      second = _mm256_add_epi32(
          second, sample_two(s, i + 2, _mm256_permutevar8x32_epi32(across, second_two),
                             _mm256_permutevar8x32_epi32(down, second_two)));
    }
    for (const SamplesAhead& s : ahead) {
      for (int k = 0; k < 4; ++k) {
        _mm_prefetch(reinterpret_cast<const char*>(s.pixels + s.left[i + k]), _MM_HINT_T0);
        _mm_prefetch(reinterpret_cast<const char*>(s.pixels + s.right[i + k]), _MM_HINT_T0);
      }
    }
    const __m256i words =
        _mm256_packs_epi32(_mm256_srai_epi32(first, 20), _mm256_srai_epi32(second, 20));
    const __m256i bytes = _mm256_packus_epi16(words, words);
    const __m128i even = _mm256_castsi256_si128(bytes), odd = _mm256_extracti128_si256(bytes, 1);
    store_pixel(_mm_cvtsi128_si32(even), bgr);
    store_pixel(_mm_cvtsi128_si32(odd), bgr + stride);
    store_pixel(_mm_extract_epi32(even, 1), bgr + 2 * stride);
    store_pixel(_mm_extract_epi32(odd, 1), bgr + 3 * stride);
    bgr += 4 * stride;
  }
}

}  // namespace raywalk

#else

namespace raywalk {
bool has_mix_avx2() { return false; }
void mix_linear_avx2(std::span<const StationSamples> /*samples*/,
                     std::span<const SamplesAhead> /*ahead*/, int /*rows*/, std::uint8_t* /*bgr*/,
                     int /*stride*/) {}
}  // namespace raywalk

#endif
