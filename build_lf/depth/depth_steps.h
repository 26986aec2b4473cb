// The steps of a depth run, which can be divided into blocks.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "build_lf/depth/contradictions.h"
#include "build_lf/depth/depth_summary.h"
#include "build_lf/depth/station_links.h"
#include "core/room/gain_fields.h"

namespace raywalk::build_lf {

// In this order: each needs all blocks of those before it, kChoose and kFuse only those around
// their maps.
enum class DepthStep {
  kLinks,     // compare neighbouring frames
  kReach,     // how near surfaces are, in a room without cells
  kSurfaces,  // coarse maps
  kColours,   // compare the colours of what they show
  kSweep,     // a map from the pictures of every station; with optical flow the finished map
  kChoose,    // each pixel's surface among those around it
  kFuse,      // the finished maps: neighbours vote
  kMoved,     // what single stations show and the others contradict
  kVolumes,   // the room's distance volumes
  kGains,     // compare the colours of what they show, for the room's gains
};

inline constexpr std::array kDepthSteps{
    DepthStep::kLinks,   DepthStep::kReach,  DepthStep::kSurfaces, DepthStep::kColours,
    DepthStep::kSweep,   DepthStep::kChoose, DepthStep::kFuse,     DepthStep::kMoved,
    DepthStep::kVolumes, DepthStep::kGains};

// "links", "reach", ...
std::string name_of(DepthStep step);
// All names in order, with commas between.
std::string depth_step_names();
// Throws UsageError naming all.
DepthStep depth_step_from_name(const std::string& name);

// What the blocks of a depth run leave besides maps, as bytes. The functions that read throw Error
// for other bytes.

std::string bytes_of(const std::vector<StationLink>& links);
std::vector<StationLink> links_of(std::string_view bytes);

std::string bytes_of(const std::vector<MapSummary>& maps);
std::vector<MapSummary> map_summaries_of(std::string_view bytes);

std::string bytes_of(const std::vector<ContradictedStation>& stations);
std::vector<ContradictedStation> contradicted_stations_of(std::string_view bytes);

std::string bytes_of(const GainFields& fields);
GainFields gain_fields_of(std::string_view bytes);

}  // namespace raywalk::build_lf
