// Directions in the overlap of both lenses, and the agreement of the lenses there.
#pragma once

#include <vector>

#include "calibrate/stitch/balance_fit.h"
#include "calibrate/stitch/frame_pictures.h"
#include "calibrate/stitch/lens_view.h"
#include "calibrate/stitch/light_picture.h"

namespace raywalk::calibrate {

// A direction of the overlap, imaged in both pictures.
struct SeamDirection {
  LensImage front{};
  LensImage back{};
};

// The factor by which pictures are reduced for measuring light, chosen so that a patch covers the
// same angle at any resolution.
int light_shrink(const DualFisheyeCamera& camera);

// Directions spread evenly over the overlap, far enough from the rims for the patches of
// LightPicture; at most a few thousand.
std::vector<SeamDirection> seam_directions(const DualFisheyeCamera& camera);

struct LightPictures {
  LightPicture front;
  LightPicture back;
};
LightPictures light_pictures(const FramePictures& pictures, int shrink);

// Ratios of back to front in every direction where both can be measured.
std::vector<LightRatio> seam_ratios(const LightPictures& pictures,
                                    const std::vector<SeamDirection>& directions);

// The agreement of a frame's two halves along the seam under a balance.
struct SeamFigures {
  double step_levels = 0.0;  // median of front minus back, mean of the colours
  double correlation = 0.0;  // of front and back along the seam
  int directions = 0;        // measured; below 3 the other figures are 0
};
SeamFigures seam_figures(const LightPictures& pictures,
                         const std::vector<SeamDirection>& directions, const LensBalance& balance);

}  // namespace raywalk::calibrate
