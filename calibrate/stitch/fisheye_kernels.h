// The inner loop of stitching: samples a fisheye picture with Catmull-Rom cubics in floating point,
// and corrects exposure and vignetting.
//
// cv::remap quantises positions to 1/32 pixel, an error of up to 1/64 pixel. Against a ray-traced
// panorama 4096 wide that costs only 0.03 dB (44.21 dB instead of 44.24), but a calibration
// measures positions to 1/25 pixel.
//
// There are a portable and an AVX2 version, selected at run time. Both do the same arithmetic, so
// panoramas do not depend on the machine.
#pragma once

#include <cstdint>

namespace raywalk::calibrate {

// Replicated border pixels around the picture that the cubics read.
inline constexpr int kFisheyeBorder = 2;
// Results are levels times this, which keeps fractions of a level.
inline constexpr int kLevelParts = 16;

// Four bytes a pixel: blue, green, red and unused. `pixels` is the top left pixel of the picture,
// which has a border of at least kFisheyeBorder pixels.
struct FisheyePixels {
  const std::uint8_t* pixels = nullptr;
  std::int64_t row_bytes = 0;
};

// The source position of a panorama's pixel, at most half a pixel outside of the picture, and the
// factor that corrects shifted levels there (see core/panorama/srgb.h).
struct FisheyeSample {
  float u = 0.0F;
  float v = 0.0F;
  float root = 1.0F;
};

// A colour's part of that factor.
struct ColourRoots {
  float bgr[3] = {1.0F, 1.0F, 1.0F};
};

struct FisheyeKernels {
  const char* name;
  // Writes blue, green and red of `count` samples, clamped to 0..255 times kLevelParts.
  void (*sample)(const FisheyePixels& picture, const FisheyeSample* samples, int count,
                 const ColourRoots& colours, std::int16_t* levels);
};

// The fastest kernels for this processor, and the portable ones.
const FisheyeKernels& fisheye_kernels();
const FisheyeKernels& portable_fisheye_kernels();

}  // namespace raywalk::calibrate
