// A developed station, kept in the working directory until its line is written.
#pragma once

#include <filesystem>
#include <string>

#include "build_lf/pack/station_data.h"
#include "build_lf/refine/source_views.h"
#include "core/room/distance_maps.h"
#include "core/room/room.h"
#include "core/view/exposure.h"

namespace raywalk::build_lf {

struct DevelopedStation {
  StationRays rays;
  StationDistances distances;
  double sharpening = 0.0;
};

// Makes one, `width` pixels wide (refine_plan.h). `exposure` may be null.
DevelopedStation develop_station(const Room& room, const Exposure* exposure, StationIndex station,
                                 int width, SourceViews* views);

// Stores it, atomically, with the inputs that inputs_of() reads. Throws Error if it cannot be
// written.
void store_developed(const std::filesystem::path& file, const DevelopedStation& station,
                     const std::string& inputs);

// What is stored of one. Throw Error naming the file if it is damaged.
StationRays developed_rays(const std::filesystem::path& file);
StationDistances developed_distances(const std::filesystem::path& file);
double developed_sharpening(const std::filesystem::path& file);

// The map at another, larger width: inverse distances are interpolated between neighbours on one
// surface (resized), and steps, which would be stairs of the map's pixels, are smoothed by medians
// that leave what is a pixel of the map wide.
InverseMap enlarged(const InverseMap& map, int width);

}  // namespace raywalk::build_lf
