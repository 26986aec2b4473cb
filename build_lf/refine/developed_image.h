// The picture of a station, developed from all photographs that show what it sees.
//
// Every pixel of the finer picture is a point: the station's position plus its distance along the
// ray. It is looked up (bicubic) in the photographs of the stations around, where these see it, and
// the samples are averaged (directional_mean.h) with weights 1 / (a + e), a being the angle between
// the two rays. Photographs sample the scene at different places, so that their mean has detail
// that none of them has alone, and noise, aliasing and what compression did average out.
#pragma once

#include <memory>
#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

#include "build_lf/refine/source_views.h"
#include "core/geometry/grid.h"
#include "core/room/distance_maps.h"
#include "core/room/room.h"
#include "core/view/exposure.h"

namespace raywalk::build_lf {

// Developed levels are stored in 1/kLevel, so that later steps do not round.
inline constexpr int kLevel = 128;

// Pictures are transposed, [theta][phi], as rays are stored; colours in the order r, g, b.
struct DevelopedImage {
  cv::Mat colour;      // CV_16UC3
  cv::Mat others;      // the same without the station's own photograph; 0 where few others see it
  cv::Mat1b is_known;  // 255 where any photograph shows the pixel
};

// `distances` are the station's, of the developed size; negative where unknown: there its own
// photograph is all that shows the pixel. `exposure` may be null.
DevelopedImage develop_image(const Room& room, const Exposure* exposure, StationIndex station,
                             const InverseMap& distances,
                             std::span<const std::shared_ptr<const SourceView>> sources);

}  // namespace raywalk::build_lf
