// Re-creates stations that are left out from the two stations kept around each, with the renderer,
// and compares them with what was captured: what leaving them out loses.
#pragma once

#include "core/room/room.h"
#include "core/view/distance_view.h"
#include "core/view/view_plan.h"

namespace raywalk {

// A station by its indices in a room.
struct HeldOutStation {
  int line = 0;
  int station = 0;
};

struct RecreationScore {
  double psnr_with_distances_db = 0.0;  // over RGB, at most kMaxPsnrDb
  double psnr_without_depth_db = 0.0;
  double psnr_of_tolerance_db = 0.0;  // captured view against itself, displaced by the tolerance
  double hidden_share = 0.0;          // of the solid angle: seen by neither neighbour
};

// Re-creates stations of a room, one after the other, each with all threads. Memory does not grow
// with their number.
class StationRecreation {
 public:
  // `captured` holds the stations, and views take their distances from the maps of `distances`;
  // both must outlive this. `tolerance_px` is for psnr_of_tolerance_db.
  StationRecreation(const Room& captured, const Room& distances, double tolerance_px)
      : captured_(captured),
        distances_(distances),
        tolerance_px_(tolerance_px),
        distance_view_(distances) {}

  // Renders the view at the station's position from its two neighbours on the line of `kept`, the
  // same lines without it, and compares it with the captured one on a grid of pixels about 512
  // wide.
  // - With distances: the corrected view (hlf-vd), from each neighbour where it sees a point. What
  //   one does not see, or masks, is read from the other; what neither sees, from both. The view's
  //   distances are gathered from the two maps nearest to the station, but its own; without any,
  //   everything is taken to be infinitely far. What a neighbour sees is found in the same way,
  //   from the two maps of its line nearest to it; without any on the line it is taken to see all.
  // - Without depth: the vertical cut through both (an initial view).
  // Pixels masked in the station are not compared, nor those that neither neighbour can show
  // (masked in both): a view would show them from another line. Gains are not applied. The PSNR of
  // the tolerance is that of the captured view against itself, displaced by the tolerance once
  // along rows and once along columns; it depends on the scene's texture. Throws Interrupted.
  RecreationScore score(const HeldOutStation& station, const Room& kept);

 private:
  // `kept` with distance maps of the two stations around a source, gathered as those of a view.
  Room with_maps_of_neighbours(const Room& kept, const RaySource& between,
                               const Eigen::Vector3d& left_out_m);

  const Room& captured_;
  const Room& distances_;
  double tolerance_px_;
  DistanceView distance_view_;
};

}  // namespace raywalk
