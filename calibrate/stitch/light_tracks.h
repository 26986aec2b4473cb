// Tracks points through a lens's picture as the camera moves, to measure the lens's vignetting.
#pragma once

#include <utility>
#include <vector>

#include "calibrate/stitch/balance_fit.h"
#include "calibrate/stitch/seam_directions.h"
#include "core/files/lens_file.h"

namespace raywalk::calibrate {

// Tracks points from picture to picture along a line (Lucas and Kanade, with a forward-backward
// check) and compares their light at the first and the last picture. Static points, as on a dolly,
// are dropped. Surfaces that are not Lambertian are left to the fit's robust weights.
class LightTracks {
 public:
  // `first` and those passed to follow() are the pictures of consecutive stations.
  LightTracks(const DualFisheyeCamera& camera, LightPictures first);

  void follow(const LightPictures& next);

  // Ratios between the first and the last picture; `frames` is stored in LightRatio::frames.
  std::vector<LightRatio> ratios(int frames) const;

 private:
  struct Lens {
    FisheyeLens model{};
    bool back = false;
    std::vector<cv::Point2f> first{};  // of tracks still followed, in the small picture
    std::vector<cv::Point2f> last{};
  };

  const LightPicture& picture_of(const LightPictures& pictures, const Lens& lens) const {
    return lens.back ? pictures.back : pictures.front;
  }
  void place_points(Lens* lens) const;
  void follow(const LightPicture& from, const LightPicture& to, Lens* lens) const;

  LightPictures first_;
  LightPictures last_;
  std::array<Lens, 2> lenses_;
};

}  // namespace raywalk::calibrate
