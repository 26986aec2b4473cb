// The same things seen in different places of a lens's picture as the camera moves: what tells how
// much light a lens loses towards its rim.
#pragma once

#include <utility>
#include <vector>

#include "calibrate/stitch/balance_fit.h"
#include "calibrate/stitch/seam_directions.h"
#include "core/files/lens_file.h"

namespace raywalk::calibrate {

// Follows points from picture to picture along a line (Lucas and Kanade, forwards and back) and
// compares their light where they begin and where they end. What stands still, as a dolly does, is
// left out. Surfaces that shine differently into different directions are left to the fit's robust
// weights.
class LightTracks {
 public:
  // `first` and what follows are the pictures of stations one after the other.
  LightTracks(const DualFisheyeCamera& camera, LightPictures first);

  void follow(const LightPictures& next);

  // Ratios between the first and the last picture; `frames` is their number in LightRatio.
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
