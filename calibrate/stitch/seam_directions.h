// Directions that both lenses see, and how well the lenses agree on them.
#pragma once

#include <vector>

#include "calibrate/stitch/balance_fit.h"
#include "calibrate/stitch/frame_pictures.h"
#include "calibrate/stitch/lens_view.h"
#include "calibrate/stitch/light_picture.h"

namespace raywalk::calibrate {

// A direction of the overlap, in both pictures.
struct SeamDirection {
  LensImage front{};
  LensImage back{};
};

// How many pixels of the pictures are averaged for measuring light, so that what they show is about
// as large whatever their resolution.
int light_shrink(const DualFisheyeCamera& camera);

// Evenly spread over the overlap, far enough from the rims for patches of light; at most a few
// thousand.
std::vector<SeamDirection> seam_directions(const DualFisheyeCamera& camera);

struct LightPictures {
  LightPicture front;
  LightPicture back;
};
LightPictures light_pictures(const FramePictures& pictures, int shrink);

// Front against back in every direction where both can be measured.
std::vector<LightRatio> seam_ratios(const LightPictures& pictures,
                                    const std::vector<SeamDirection>& directions);

// What a frame shows of its seam under a balance.
struct SeamFigures {
  double step_levels = 0.0;  // median of front minus back, mean of the colours
  double correlation = 0.0;  // of front and back along the seam
  int directions = 0;        // that could be measured; below 3 the others are 0
};
SeamFigures seam_figures(const LightPictures& pictures,
                         const std::vector<SeamDirection>& directions, const LensBalance& balance);

}  // namespace raywalk::calibrate
