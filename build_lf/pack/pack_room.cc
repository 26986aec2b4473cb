#include "build_lf/pack/pack_room.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <system_error>
#include <utility>
#include <vector>

#include "build_lf/pack/free_space.h"
#include "build_lf/pack/listed_motion.h"
#include "build_lf/pack/room_folder.h"
#include "build_lf/pack/station_data.h"
#include "build_lf/pack/volume_writer.h"
#include "core/base/number_text.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/output_folder.h"
#include "core/room/hdf5_file.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

// The stations of a line that have a distance map.
std::vector<std::int32_t> mapped_stations_of(const std::vector<StationSource>& sources) {
  std::vector<std::int32_t> stations;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    if (sources[i].distance_map) stations.push_back(static_cast<std::int32_t>(i));
  }
  return stations;
}

// A volume to be packed.
struct PackJob {
  std::size_t line;
  bool distances;
  PlannedVolume volume;
  std::int64_t images;
  std::uint64_t bytes;
};

std::vector<PackJob> jobs_of(const PackPlan& plan) {
  std::vector<PackJob> jobs;
  for (std::size_t i = 0; i < plan.grid.lines.size(); ++i) {
    const std::string& id = plan.grid.lines[i].id;
    const std::vector<StationSource>& sources = plan.sources[i];
    jobs.push_back({i,
                    false,
                    {line_volume_path("", id), plan.inputs[i].rays},
                    std::ssize(sources),
                    plan.bytes_of_rays(i)});
    if (!plan.has_maps()) continue;
    jobs.push_back({i,
                    true,
                    {distance_volume_path("", id), plan.inputs[i].distances},
                    std::ssize(mapped_stations_of(sources)),
                    plan.bytes_of_maps(i)});
  }
  return jobs;
}

std::vector<PlannedVolume> volumes_of(const std::vector<PackJob>& jobs) {
  std::vector<PlannedVolume> volumes;
  volumes.reserve(jobs.size());
  for (const PackJob& job : jobs) volumes.push_back(job.volume);
  return volumes;
}

void run_job(const PackJob& job, const PackPlan& plan, const fs::path& room, Progress* progress) {
  const Line& line = plan.grid.lines[job.line];
  const std::vector<StationSource>& sources = plan.sources[job.line];
  const fs::path file = room / job.volume.file;
  if (!job.distances) {
    const auto has_mask = [](const StationSource& source) { return source.mask.has_value(); };
    const auto read = [&](std::size_t i) { return read_station_rays(sources[i], plan.panorama); };
    write_line_volume(file, line,
                      {.panorama = plan.panorama,
                       .masked = std::ranges::any_of(sources, has_mask),
                       .read = read,
                       .form = plan.form,
                       .inputs = job.volume.inputs},
                      progress);
    return;
  }
  const std::vector<std::int32_t> stations = mapped_stations_of(sources);
  const auto read = [&](std::size_t map) {
    return read_station_distances(sources[static_cast<std::size_t>(stations[map])],
                                  plan.distance_map);
  };
  write_distance_volume(file, line,
                        {.stations = stations,
                         .size = plan.distance_map,
                         .origin = kGivenOrigin,
                         .read = read,
                         .compressed = plan.form.compressed(),
                         .inputs = job.volume.inputs},
                        progress);
}

// What was measured on a room and is lost when it is replaced, for messages: "the estimated
// distances, the gains". Empty: nothing.
std::string measurements_of(const fs::path& room) {
  constexpr std::array<std::pair<const char*, const char*>, 5> kMeasurements{
      {{"depth.json", "estimated distances"},
       {"gains.h5", "gains"},
       {"held-out", "held-out stations"},
       {"require.json", "requirements"},
       {"measured.json", "measured settings"}}};
  std::vector<std::string> found;
  std::error_code error;
  for (const auto& [file, what] : kMeasurements) {
    if (fs::exists(room / file, error)) found.emplace_back(what);
  }
  return fmt::format("{}", fmt::join(found, ", "));
}

// Takes unchanged volumes from the room that is replaced, and says what of it is lost.
void reuse_earlier(const fs::path& earlier, std::size_t lines, const RoomFolder& folder,
                   std::vector<PackJob>* jobs) {
  std::size_t rays = 0, distances = 0;
  std::erase_if(*jobs, [&](const PackJob& job) {
    const bool taken = folder.take_over(job.volume);
    if (taken) ++(job.distances ? distances : rays);
    return taken;
  });
  if (rays + distances > 0) {
    const std::string given =
        distances > 0 ? " and the given distances of " + counted(distances, "line") : "";
    spdlog::info("unchanged and taken from {}: {} of {}{}", earlier.string(), rays,
                 counted(lines, "line"), given);
  }
  const std::string lost = measurements_of(earlier);
  if (!lost.empty()) {
    spdlog::warn(
        "{}: what was measured on it is not kept, as it was measured on all lines together: {}; "
        "run raywalk-build-lf depth, and what else is needed, on the new room",
        earlier.string(), lost);
  }
}

std::uint64_t bytes_of_jobs(const std::vector<PackJob>& jobs) {
  std::uint64_t sum = 0;
  for (const PackJob& job : jobs) sum += job.bytes;
  return sum;
}

// Packs those of the lines that are not packed; returns the number of volumes written.
std::size_t pack_lines(const PackOptions& options, const PackPlan& plan, IndexRange lines,
                       std::vector<PackJob> jobs, const RoomFolder& folder) {
  const fs::path& room = folder.directory();
  std::erase_if(
      jobs, [&](const PackJob& job) { return job.line < lines.begin || job.line >= lines.end; });
  const std::uint64_t all = bytes_of_jobs(jobs);
  std::erase_if(jobs, [&](const PackJob& job) { return folder.has(job.volume.file); });
  if (options.replace) {
    reuse_earlier(without_trailing_slash(options.out), lines.size(), folder, &jobs);
  }
  const std::uint64_t needed = bytes_of_jobs(jobs);
  require_space(room, {.needed = needed, .there = all - needed},
                options.free_bytes ? options.free_bytes(room) : free_bytes(room));
  std::int64_t images = 0;
  for (const PackJob& job : jobs) images += job.images;
  Progress progress("packing", images, "images");
  for (const PackJob& job : jobs) run_job(job, plan, room, &progress);
  return jobs.size();
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

bool is_packed_from(const fs::path& room, const PackPlan& plan) {
  std::error_code error;
  return fs::exists(manifest_path(room), error) &&
         read_manifest(room).grid.lines.size() == plan.grid.lines.size() &&
         std::ranges::all_of(jobs_of(plan), [&](const PackJob& job) {
           return inputs_of(room / job.volume.file) == job.volume.inputs;
         });
}

void pack_room(const PackOptions& options) {
  require_free(without_trailing_slash(options.out), options.replace);
  const PackPlan plan = plan_pack(options);
  require_listed_motion(plan, input_name(options.frames));
  const std::vector<PackJob> jobs = jobs_of(plan);
  RoomFolder folder(options.out, volumes_of(jobs), options.replace);
  pack_lines(options, plan, {0, plan.grid.lines.size()}, jobs, folder);
  folder.complete(manifest_of_volumes(folder.directory(), plan.panorama, plan.grid));
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
  const std::vector<PackJob> jobs = jobs_of(plan);
  const RoomFolder folder(options.out, volumes_of(jobs), options.replace, FileLock::Use::kShared);
  const std::size_t packed = pack_lines(options, plan, lines, jobs, folder);
  return fmt::format("{}: {}, {}", name, counted(lines.size(), "line"),
                     packed == 0 ? "all packed before" : "packed");
}

}  // namespace raywalk::build_lf
