// The picture that a virtual room's camera, or its ring of cameras, takes at a station.
#pragma once

#include <opencv2/core/mat.hpp>

#include "simulator/room/room_stations.h"
#include "simulator/room/virtual_room.h"

namespace raywalk::capture {

// The panorama (CV_8UC3) from the station's true pose, with people, the cameras' exposures,
// stitching and noise. `moment` is the number of the station among all. Throws as
// VirtualRoom::panorama does.
cv::Mat station_picture(const VirtualRoom& room, const RoomStation& station, int moment,
                        PanoramaSize size);

}  // namespace raywalk::capture
