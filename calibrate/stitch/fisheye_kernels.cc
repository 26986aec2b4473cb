#include "calibrate/stitch/fisheye_kernels.h"

#include <algorithm>
#include <cmath>

#include "calibrate/stitch/fisheye_arithmetic.h"

namespace raywalk::calibrate {
namespace {

constexpr int kColours = 3;
constexpr float kBrightest = 255.0F;

void set_cubic_weights(float t, float* weights) {
  for (int i = 0; i < 4; ++i) {
    weights[i] = ((kCubic[3][i] * t + kCubic[2][i]) * t + kCubic[1][i]) * t + kCubic[0][i];
  }
}

// Even and odd columns are summed separately, in the same order as in the AVX2 kernel.
void sample_portably(const FisheyePixels& picture, const FisheyeSample* samples, int count,
                     const ColourRoots& colours, std::int16_t* levels) {
  for (int i = 0; i < count; ++i) {
    const FisheyeSample& sample = samples[i];
    const float u = std::floor(sample.u), v = std::floor(sample.v);
    float across[4], down[4];
    set_cubic_weights(sample.u - u, across);
    set_cubic_weights(sample.v - v, down);
    const std::uint8_t* row = picture.pixels +
                              (static_cast<std::int64_t>(v) - 1) * picture.row_bytes +
                              4 * (static_cast<std::int64_t>(u) - 1);
    float even[kColours] = {}, odd[kColours] = {};
    for (int j = 0; j < 4; ++j, row += picture.row_bytes) {
      for (int c = 0; c < kColours; ++c) {
        even[c] += down[j] * (across[0] * static_cast<float>(row[c]) +
                              across[2] * static_cast<float>(row[c + 8]));
        odd[c] += down[j] * (across[1] * static_cast<float>(row[c + 4]) +
                             across[3] * static_cast<float>(row[c + 12]));
      }
    }
    for (int c = 0; c < kColours; ++c) {
      const float level = std::clamp(even[c] + odd[c], 0.0F, kBrightest);
      const float root = sample.root * colours.bgr[c];
      const float toe = std::min(level * (1.0F / kToe), 1.0F);
      const float corrected = root * level + (kShift * (root - 1.0F)) * toe;
      // Never negative, so truncation after adding a half rounds, as in the AVX2 kernel.
      const float parts = std::min(std::max(corrected, 0.0F), kBrightest) * kLevelParts + 0.5F;
      levels[kColours * i + c] = static_cast<std::int16_t>(parts);
    }
  }
}

}  // namespace

const FisheyeKernels& portable_fisheye_kernels() {
  static constexpr FisheyeKernels kPortable{"portable", &sample_portably};
  return kPortable;
}

#ifdef RAYWALK_HAVE_X86_STITCHING
extern const FisheyeKernels kAvx2Fisheye;

const FisheyeKernels& fisheye_kernels() {
  static const FisheyeKernels& best =
      __builtin_cpu_supports("avx2") ? kAvx2Fisheye : portable_fisheye_kernels();
  return best;
}
#else
const FisheyeKernels& fisheye_kernels() { return portable_fisheye_kernels(); }
#endif

}  // namespace raywalk::calibrate
