#include "build_lf/depth/stored_maps.h"

#include <filesystem>
#include <iterator>
#include <limits>
#include <set>

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
std::vector<std::int32_t> left_out_of(const Contradictions& of_line) {
  std::vector<std::int32_t> runs;
  for (const ContradictedStation& found : of_line.stations) {
    for (std::size_t i = 0; i < found.runs.size(); i += 3) {
      runs.insert(runs.end(),
                  {found.station.station, found.runs[i], found.runs[i + 1], found.runs[i + 2]});
    }
  }
  return runs;
}

std::vector<SweepReference> maps_of_line(const DepthPlan& plan, std::size_t line) {
  std::vector<SweepReference> of_line;
  for (const SweepReference& reference : plan.maps) {
    if (reference.station.line == static_cast<int>(line)) of_line.push_back(reference);
  }
  return of_line;
}

}  // namespace

void write_volumes(const Room& room, DepthMethod method, const DepthPlan& plan,
                   const PartialMaps& partial, const std::vector<std::size_t>& lines,
                   const std::function<Contradictions(int line)>& contradictions_of) {
  const double half_pixel_per_m = 0.5 / plan.pixels_per_omega_m();
  std::int64_t count = 0;
  for (const std::size_t l : lines) count += std::ssize(maps_of_line(plan, l));
  Progress progress("writing", count, "maps");
  for (const std::size_t l : lines) {
    const std::vector<SweepReference> of_line = maps_of_line(plan, l);
    if (of_line.empty()) continue;
    DistanceMaps maps{{}, plan.size, "estimated by " + name_of(method), {}};
    for (const SweepReference& reference : of_line) {
      maps.stations.push_back(reference.station.station);
    }
    const Contradictions contradictions = contradictions_of(static_cast<int>(l));
    maps.read = [&](std::size_t i) {
      InverseDistanceMap map =
          partial.load_stored(kFinalStage, of_line[i].station, of_line[i].position_m, plan.size);
      show_behind(contradictions, half_pixel_per_m, &map);
      return stored_distances(map);
    };
    maps.left_out = left_out_of(contradictions);
    maps.compressed = room.volume(static_cast<int>(l)).form().compressed();
    const Line& line = room.grid().lines[l];
    write_distance_volume(partial.volumes() / (line.id + ".h5"), line, maps, &progress);
  }
}

void remove_other_volumes(const Room& room, const DepthPlan& plan, const PartialMaps& partial) {
  std::set<fs::path> names;
  for (const SweepReference& reference : plan.maps) {
    names.insert(room.grid().lines[static_cast<std::size_t>(reference.station.line)].id + ".h5");
  }
  for (const fs::directory_entry& entry : fs::directory_iterator(partial.volumes())) {
    if (!names.contains(entry.path().filename())) fs::remove_all(entry.path());
  }
}

}  // namespace raywalk::build_lf
