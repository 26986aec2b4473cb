// Blends the two lenses' halves of a panorama along their seam.
#pragma once

#include <opencv2/core/mat.hpp>

#include "calibrate/stitch/stitch_tables.h"

namespace raywalk::calibrate {

// Levels are blended times this, which keeps fractions of a level.
inline constexpr int kLevelParts = 16;

// `front` and `back` are CV_16SC3, levels times kLevelParts, of the tables' size, each valid where
// StitchTables::region includes its lens. Writes the panorama to `front`. Multi-band blending works
// only on tiles near the seam, about a fifth of the panorama. Thread-safe.
void blend_seam(const StitchTables& tables, const StitcherOptions& options, const cv::Mat& back,
                cv::Mat* front);

}  // namespace raywalk::calibrate
