// The inner loop of stitching: reads a fisheye picture between its pixels, with Catmull-Rom cubics
// in floating point, and corrects what exposure and vignetting did.
//
// cv::remap's cubics have weights for every 32nd of a pixel, so that what it reads lies up to a
// 64th of a pixel beside where it should. That costs 0.03 dB only against a ray-traced panorama
// 4096 wide (44.21 dB, this 44.24), but positions are what a calibration measures, to a 25th of a
// pixel.
//
// Compiled for any processor and for AVX2, and picked at run time; both do the same arithmetic, so
// panoramas do not depend on the machine.
#pragma once

#include <cstdint>

namespace raywalk::calibrate {

// Pixels around the picture, repeated from its edge, that cubics read.
inline constexpr int kFisheyeBorder = 2;
// Results are levels times this, so that what follows need not round to whole levels.
inline constexpr int kLevelParts = 16;

// Four bytes a pixel: blue, green, red and any. `pixels` is the top left one, with at least
// kFisheyeBorder pixels around the picture.
struct FisheyePixels {
  const std::uint8_t* pixels = nullptr;
  std::int64_t row_bytes = 0;
};

// Where a pixel of the panorama is read, within half a pixel of the picture; and by what the
// correction multiplies shifted levels there (see core/panorama/srgb.h).
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

// Those this processor runs best, and those every processor runs.
const FisheyeKernels& fisheye_kernels();
const FisheyeKernels& portable_fisheye_kernels();

}  // namespace raywalk::calibrate
