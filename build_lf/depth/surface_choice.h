// Which of the surfaces around a pixel it shows.
//
// Windows and smooth costs spread what is near over what is beside it. So the last word is spoken
// pixel by pixel: the planes on either side (TilePlanes) are candidates, all stations around say
// how well each explains the pixel's colour, and semi-global matching over the candidates, not over
// layers of distance, lets surfaces end where colours do.
#pragma once

#include <span>

#include "build_lf/depth/inverse_distance_map.h"
#include "build_lf/depth/station_colours.h"

namespace raywalk::build_lf {

// Another station that may see a pixel's surface.
struct ChoiceView {
  // sampled_ranges() of its station, [theta][phi], kSamplesPerPixel times as wide and high as map
  std::span<const ColourRange> ranges;
  const InverseDistanceMap* map = nullptr;  // as swept, of the size of the map chosen for
};

// The map with each known pixel's value chosen among its own and the planes around it. `colours`:
// of the map's station, of the map's size. Confidences stay. `pixel_per_m`, 1/m, is the inverse
// distance whose parallax is one pixel at the reach. With fewer than two views the map stays as it
// is.
//
// A candidate costs the mean over all views of how far the pixel's colour is from what the view
// shows of the candidate's point, within half a pixel and in units of the pictures' noise. Where
// the view's own map has something nearer, the point is hidden there, and the view says little;
// what nearly all views say is hidden costs more. Neighbours of one walk on the same plane cost
// nothing; a jump costs less the more the colours differ. Takes 80 bytes a pixel.
InverseDistanceMap choose_surfaces(const InverseDistanceMap& map, const StationColours& colours,
                                   std::span<const ChoiceView> views, double pixel_per_m);

}  // namespace raywalk::build_lf
