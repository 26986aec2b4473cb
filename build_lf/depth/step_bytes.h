// What the blocks of a depth run leave besides maps, as bytes.
//
// The functions that read throw Error for other bytes.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "build_lf/depth/contradictions.h"
#include "build_lf/depth/depth_summary.h"
#include "build_lf/depth/station_links.h"
#include "core/room/gain_fields.h"

namespace raywalk::build_lf {

std::string bytes_of(const std::vector<StationLink>& links);
std::vector<StationLink> links_of(std::string_view bytes);

std::string bytes_of(const std::vector<MapSummary>& maps);
std::vector<MapSummary> map_summaries_of(std::string_view bytes);

std::string bytes_of(const std::vector<ContradictedStation>& stations);
std::vector<ContradictedStation> contradicted_stations_of(std::string_view bytes);

std::string bytes_of(const GainFields& fields);
GainFields gain_fields_of(std::string_view bytes);

}  // namespace raywalk::build_lf
