#include "build_lf/pack/pack_room.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "build_lf/pack/free_space.h"
#include "build_lf/pack/listed_motion.h"
#include "build_lf/pack/partial_room.h"
#include "build_lf/pack/reused_lines.h"
#include "build_lf/pack/station_data.h"
#include "build_lf/pack/volume_writer.h"
#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/output_folder.h"
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

// The volumes of lines that no earlier run finished.
std::vector<Job> open_jobs(const PackPlan& plan, IndexRange lines, const fs::path& room) {
  std::vector<Job> jobs;
  for (std::size_t i = lines.begin; i < lines.end; ++i) {
    const std::string& id = plan.grid.lines[i].id;
    if (!fs::exists(line_volume_path(room, id))) {
      jobs.push_back({i, false, static_cast<std::int64_t>(plan.sources[i].size())});
    }
    if (plan.has_maps() && !fs::exists(distance_volume_path(room, id))) {
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

// Takes unchanged volumes from the room that is being replaced, and says what of it is lost.
void reuse_earlier(const fs::path& earlier, const PackPlan& plan, IndexRange lines,
                   const fs::path& room) {
  const ReusedVolumes reused = reuse_volumes(earlier, plan, lines, room);
  if (reused.lines + reused.distances > 0) {
    const std::string distances =
        reused.distances > 0 ? " and the given distances of " + counted(reused.distances, "line")
                             : "";
    spdlog::info("unchanged and taken from {}: {} of {}{}", earlier.string(), reused.lines,
                 counted(lines.size(), "line"), distances);
  }
  const std::string lost = measurements_of(earlier);
  if (!lost.empty()) {
    spdlog::warn(
        "{}: what was measured on it is not kept, as it was measured on all lines together: {}; "
        "run raywalk-build-lf depth, and what else is needed, on the new room",
        earlier.string(), lost);
  }
}

// Packs those of the lines that are not packed; returns the number of volumes written.
std::size_t pack_lines(const PackOptions& options, const PackPlan& plan, IndexRange lines,
                       PartialRoom* partial) {
  const fs::path& room = partial->directory();
  if (options.replace) reuse_earlier(without_trailing_slash(options.out), plan, lines, room);
  const std::vector<Job> jobs = open_jobs(plan, lines, room);
  const std::uint64_t needed = bytes_of(jobs, plan);
  std::uint64_t all = 0;
  for (std::size_t i = lines.begin; i < lines.end; ++i) {
    all += plan.bytes_of_rays(i) + plan.bytes_of_maps(i);
  }
  require_space(room, {.needed = needed, .there = all - needed},
                options.free_bytes ? options.free_bytes(room) : free_bytes(room));
  std::int64_t stations = 0;
  for (const Job& job : jobs) stations += job.stations;
  try {
    Progress progress("packing", stations, "images");
    for (const Job& job : jobs) run_job(job, plan, room, &progress);
  } catch (const InputError&) {
    partial->discard();
    throw;
  }
  return jobs.size();
}

// Makes the room of its volumes.
void complete_room(const PackPlan& plan, PartialRoom* partial) {
  const fs::path& room = partial->directory();
  write_line_inputs(room, plan);
  write_file_atomically(manifest_path(room),
                        manifest_to_json(manifest_of_volumes(room, plan.panorama, plan.grid)));
  Room::open(room);  // checks that the result can be opened
  partial->complete();
}

}  // namespace

RoomManifest manifest_of_volumes(const fs::path& room, PanoramaSize panorama, const Grid& grid) {
  RoomManifest manifest{panorama, grid, {}};
  for (const Line& line : grid.lines) {
    manifest.rays_sha256.push_back(checksum_of_line(line_volume_path(room, line.id)));
  }
  std::error_code error;
  for (const DistanceKind kind : {DistanceKind::kEstimated, DistanceKind::kGiven}) {
    const fs::path folder = distances_directory(room, kind);
    if (fs::exists(folder, error) && !fs::is_empty(folder)) manifest.distances = kind;
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
  require_listed_motion(plan, input_name(options.frames));
  PartialRoom partial(options.out, plan.fingerprint, options.replace);
  pack_lines(options, plan, {0, plan.grid.lines.size()}, &partial);
  complete_room(plan, &partial);
}

std::string pack_part(const PackOptions& options, WorkPart part) {
  require_free(without_trailing_slash(options.out), options.replace);
  const PackPlan plan = plan_pack(options);
  const IndexRange lines = part.share_of(plan.grid.lines.size());
  const std::string name =
      fmt::format("{}: part {}/{}", options.out.string(), part.index, part.count);
  if (lines.size() == 0) {
    return fmt::format("{} is empty: the room has {}", name,
                       counted(plan.grid.lines.size(), "line"));
  }
  // The last part is never empty.
  if (part.index == part.count) require_listed_motion(plan, input_name(options.frames));
  PartialRoom partial(options.out, plan.fingerprint, options.replace, FileLock::Use::kShared);
  const std::size_t packed = pack_lines(options, plan, lines, &partial);
  return fmt::format("{}: {}, {}", name, counted(lines.size(), "line"),
                     packed == 0 ? "all packed before" : "packed");
}

}  // namespace raywalk::build_lf
