// Writes the HDF5 volumes of one line. Stations are read and converted in parallel, one per thread
// at a time, so memory does not grow with their number. Files appear only when complete.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "build_lf/pack_plan.h"
#include "core/base/progress.h"

namespace raywalk {

// lines/<id>.h5 as core/room/line_volume.h describes it, with `position_m` float64 [station][xyz]
// and `sha256` [station] beside the rays. `progress` advances by one per station. Throws InputError
// (an image is unusable), Error (cannot write) and Interrupted.
void write_line_volume(const std::filesystem::path& file, const Line& line,
                       const std::vector<StationSource>& sources, PanoramaSize panorama,
                       Progress* progress);

// distances/<id>.h5 as core/room/distance_volume.h describes it, with `sha256` [map]; one map for
// every source that has one, of which there must be at least one. Throws as write_line_volume does.
void write_distance_volume(const std::filesystem::path& file, const Line& line,
                           const std::vector<StationSource>& sources, PanoramaSize size,
                           Progress* progress);

}  // namespace raywalk
