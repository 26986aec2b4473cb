#include "build_lf/depth/stored_maps.h"

#include <filesystem>
#include <limits>

#include "build_lf/volume_writer.h"
#include "core/base/progress.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

StationDistances stored_distances(const InverseDistanceMap& map) {
  StationDistances station;
  station.confidence = map.confidence;
  station.distance_m.reserve(map.omega.size());
  for (const float omega : map.omega) {
    station.distance_m.push_back(omega > 0.0f ? 1.0f / omega
                                              : std::numeric_limits<float>::infinity());
  }
  station.sha256 = checksum_of_distances(station.distance_m, station.confidence);
  return station;
}

// The contradicted pixels of a line's stations as DistanceMaps::left_out.
std::vector<std::int32_t> left_out_of(const Contradictions& contradictions, int line) {
  std::vector<std::int32_t> runs;
  for (const ContradictedStation& found : contradictions.stations) {
    if (found.station.line != line) continue;
    for (std::size_t i = 0; i < found.runs.size(); i += 3) {
      runs.insert(runs.end(),
                  {found.station.station, found.runs[i], found.runs[i + 1], found.runs[i + 2]});
    }
  }
  return runs;
}

}  // namespace

void write_volumes(const Room& room, DepthMethod method, const DepthPlan& plan,
                   const PartialMaps& partial, const Contradictions& contradictions) {
  const double half_pixel_per_m = 0.5 / plan.pixels_per_omega_m();
  // An interrupted run can have left the volumes it replaced there.
  for (const fs::directory_entry& entry : fs::directory_iterator(partial.volumes())) {
    fs::remove(entry.path());
  }
  Progress progress("writing", static_cast<std::int64_t>(plan.maps.size()), "maps");
  for (int l = 0; l < static_cast<int>(room.grid().lines.size()); ++l) {
    std::vector<SweepReference> of_line;
    DistanceMaps maps{{}, plan.size, "estimated by " + name_of(method), {}};
    for (const SweepReference& reference : plan.maps) {
      if (reference.station.line != l) continue;
      of_line.push_back(reference);
      maps.stations.push_back(reference.station.station);
    }
    if (of_line.empty()) continue;
    maps.read = [&](std::size_t i) {
      InverseDistanceMap map =
          partial.load_stored(kFinalStage, of_line[i].station, of_line[i].position_m, plan.size);
      show_behind(contradictions, half_pixel_per_m, &map);
      return stored_distances(map);
    };
    maps.left_out = left_out_of(contradictions, l);
    maps.compressed = room.volume(l).form().compressed();
    const Line& line = room.grid().lines[static_cast<size_t>(l)];
    write_distance_volume(partial.volumes() / (line.id + ".h5"), line, maps, &progress);
  }
}

}  // namespace raywalk::build_lf
