#include "build_lf/pack_room.h"

#include <fmt/format.h>

#include <algorithm>

#include "build_lf/free_space.h"
#include "build_lf/partial_room.h"
#include "build_lf/station_data.h"
#include "build_lf/volume_writer.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/output_path.h"
#include "core/files/sha256.h"
#include "core/room/hdf5_file.h"
#include "core/room/room.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

// One volume still to be written.
struct Job {
  std::size_t line;
  bool distances;
  std::int64_t stations;
};

// The volumes not finished by an earlier run.
std::vector<Job> open_jobs(const PackPlan& plan, const fs::path& room) {
  std::vector<Job> jobs;
  for (std::size_t i = 0; i < plan.grid.lines.size(); ++i) {
    const std::string& id = plan.grid.lines[i].id;
    if (!fs::exists(line_volume_path(room, id))) {
      jobs.push_back({i, false, static_cast<std::int64_t>(plan.sources[i].size())});
    }
    if (plan.has_maps(i) && !fs::exists(distance_volume_path(room, id))) {
      const auto maps =
          std::count_if(plan.sources[i].begin(), plan.sources[i].end(),
                        [](const StationSource& s) { return s.distance_map.has_value(); });
      jobs.push_back({i, true, maps});
    }
  }
  return jobs;
}

std::uint64_t bytes_of(const std::vector<Job>& jobs, const PackPlan& plan) {
  std::uint64_t sum = 0;
  for (const Job& job : jobs) {
    sum += job.distances ? plan.bytes_of_maps(job.line) : plan.bytes_of_rays(job.line);
  }
  return sum;
}

DistanceMaps given_maps(const std::vector<StationSource>& sources, PanoramaSize size) {
  DistanceMaps maps{{}, size, kGivenOrigin, {}};
  for (std::size_t i = 0; i < sources.size(); ++i) {
    if (sources[i].distance_map) maps.stations.push_back(static_cast<std::int32_t>(i));
  }
  maps.read = [&sources, size, stations = maps.stations](std::size_t map) {
    return read_station_distances(sources[static_cast<std::size_t>(stations[map])], size);
  };
  return maps;
}

void run_job(const Job& job, const PackPlan& plan, const fs::path& room, Progress* progress) {
  const Line& line = plan.grid.lines[job.line];
  const std::vector<StationSource>& sources = plan.sources[job.line];
  if (job.distances) {
    DistanceMaps maps = given_maps(sources, plan.distance_map);
    maps.compressed = plan.form.compressed();
    write_distance_volume(distance_volume_path(room, line.id), line, maps, progress);
  } else {
    write_line_volume(line_volume_path(room, line.id), line, sources, plan.panorama, plan.form,
                      progress);
  }
}

}  // namespace

RoomManifest manifest_of_volumes(const fs::path& room, PanoramaSize panorama, const Grid& grid) {
  RoomManifest manifest{panorama, grid, {}, std::vector<DistanceSet>()};
  for (const Line& line : grid.lines) {
    manifest.rays_sha256.push_back(checksum_of_line(line_volume_path(room, line.id)));
  }
  const fs::path directory = distances_directory(room);
  if (auto distances = set_of(open_distance_volumes(directory, grid), grid)) {
    add_file_checksums(directory, &*distances);
    manifest.distances->push_back(std::move(*distances));
  }
  return manifest;
}

std::string checksum_of_line(const fs::path& volume) {
  std::string all;
  for (const std::string& sha256 : Hdf5File::open(volume).read_strings("sha256")) all += sha256;
  return sha256_hex(all);
}

void pack_room(const PackOptions& options) {
  require_free(without_trailing_slash(options.out), options.replace);
  const PackPlan plan = plan_pack(options);
  PartialRoom partial(options.out, plan.fingerprint, options.replace);
  const fs::path& room = partial.directory();
  const std::vector<Job> jobs = open_jobs(plan, room);
  const std::uint64_t needed = bytes_of(jobs, plan);
  require_space(room, {.needed = needed, .there = plan.bytes() - needed},
                options.free_bytes ? options.free_bytes(room) : free_bytes(room));
  std::int64_t stations = 0;
  for (const Job& job : jobs) stations += job.stations;
  try {
    Progress progress("packing", stations, "images");
    for (const Job& job : jobs) run_job(job, plan, room, &progress);
  } catch (const InputError&) {
    partial.discard();
    throw;
  }
  write_file_atomically(manifest_path(room),
                        manifest_to_json(manifest_of_volumes(room, plan.panorama, plan.grid)));
  Room::open(room);  // checks that the result can be opened
  partial.complete();
}

}  // namespace raywalk::build_lf
