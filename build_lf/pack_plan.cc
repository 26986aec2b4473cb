#include "build_lf/pack_plan.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <set>
#include <span>
#include <system_error>

#include "build_lf/reused_lines.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"
#include "core/geometry/line_gaps.h"
#include "core/room/room.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

// Bytes of one distance and its confidence.
constexpr std::uint64_t kBytesPerDistance = sizeof(float) + 1;
// Bytes of the first valid row of a column and the row after its last.
constexpr std::uint64_t kBytesPerRowRun = 2 * sizeof(std::int32_t);

std::uint64_t pixels(PanoramaSize size) {
  return static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height);
}

// Calls check(item) for each of `items`, in parallel, and shows progress. Opening many small files
// mostly waits for the disk.
template <typename Item, typename Check>
void check_each(const std::vector<Item>& items, Progress* progress, const Check& check) {
  check_in_parallel(static_cast<int>(items.size()), [&](int i) {
    check(items[static_cast<std::size_t>(i)]);
    progress->advance();
  });
}

// Without opening them, which takes longer.
void require_frames_and_masks(const std::vector<Frame>& frames) {
  Progress progress("looking for", static_cast<std::int64_t>(frames.size()), "frames",
                    Progress::Shown::kIfLong);
  check_each(frames, &progress, [](const Frame& frame) {
    std::error_code error;
    if (!fs::exists(frame.path, error)) {
      throw Error(fmt::format("{}: {}: no such file", frame.where, frame.path.string()));
    }
    if (frame.mask && !fs::exists(*frame.mask, error)) {
      throw Error(fmt::format("{}: the mask {} does not exist; make it or leave the column empty",
                              frame.where, frame.mask->string()));
    }
  });
}

// What each frame's header says.
std::vector<ImageHeader> headers_of(const std::vector<Frame>& frames) {
  std::vector<ImageHeader> headers(frames.size());
  const ImageHeader first = panorama_header_of(frames.front().path);
  Progress progress("checking", static_cast<std::int64_t>(frames.size()), "frames");
  check_each(frames, &progress, [&](const Frame& frame) {
    ImageHeader& header = headers[static_cast<std::size_t>(&frame - frames.data())];
    header = panorama_header_of(frame.path);
    if (header.size == first.size) return;
    throw Error(fmt::format("{} is {} x {} but {} is {} x {}; all frames must have one size",
                            frame.path.string(), header.size.width, header.size.height,
                            frames.front().path.string(), first.size.width, first.size.height));
  });
  return headers;
}

// The common size of all panoramas, from their headers.
PanoramaSize common_panorama_size(const std::vector<Frame>& frames) {
  const std::vector<ImageHeader> headers = headers_of(frames);
  TurnedPictures turned;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    turned.add(frames[i].path, headers[i].orientation);
  }
  turned.warn();
  return headers.front().size;
}

void check_masks(const std::vector<Frame>& frames, PanoramaSize panorama) {
  std::set<fs::path> known;  // many frames may share a mask
  std::vector<const Frame*> with_mask;
  for (const Frame& frame : frames) {
    if (frame.mask && known.insert(*frame.mask).second) with_mask.push_back(&frame);
  }
  Progress progress("checking", static_cast<std::int64_t>(with_mask.size()), "masks",
                    Progress::Shown::kIfLong);
  check_each(with_mask, &progress, [&](const Frame* frame) {
    try {
      require_mask(*frame->mask, panorama);
    } catch (const Error& unusable) {
      throw Error(fmt::format("{}: {}", frame->where, unusable.what()));
    }
  });
}

// The map of each frame that has one; frames and maps share their stem.
std::map<std::string, fs::path> find_distance_maps(const std::vector<Frame>& frames,
                                                   const fs::path& directory) {
  std::error_code error;
  if (!fs::is_directory(directory, error)) {
    throw Error(directory.string() + ": no such directory of distance maps");
  }
  std::map<std::string, fs::path> maps;           // frame -> map
  std::map<std::string, std::string> stem_owner;  // stem -> frame
  for (const Frame& frame : frames) {
    const std::string stem = frame.path.stem().string();
    const fs::path map = directory / (stem + ".png");
    if (!fs::exists(map, error)) continue;
    const auto [owner, is_new] = stem_owner.emplace(stem, frame.file);
    if (!is_new) {
      throw Error(fmt::format("{} could belong to {} or to {}; give the frames different names",
                              map.string(), owner->second, frame.file));
    }
    maps[frame.file] = map;
  }
  if (maps.empty()) {
    throw Error(fmt::format("{}: no map is named after a frame; for {} it would be {}.png",
                            directory.string(), frames.front().file,
                            frames.front().path.stem().string()));
  }
  return maps;
}

PanoramaSize common_map_size(const std::map<std::string, fs::path>& maps, PanoramaSize panorama) {
  std::vector<fs::path> files;
  files.reserve(maps.size());
  for (const auto& [frame, map] : maps) files.push_back(map);
  const fs::path& first = files.front();
  const PanoramaSize common = distance_map_size_of(first);
  Progress progress("checking", static_cast<std::int64_t>(files.size()), "distance maps",
                    Progress::Shown::kIfLong);
  check_each(files, &progress, [&](const fs::path& map) {
    const PanoramaSize size = distance_map_size_of(map);
    if (size == common) return;
    throw Error(fmt::format("{} is {} x {} but {} is {} x {}; all distance maps must have one size",
                            map.string(), size.width, size.height, first.string(), common.width,
                            common.height));
  });
  if (common.width > panorama.width) {
    throw Error(fmt::format("{} is {} x {}, larger than the frames' {} x {}", first.string(),
                            common.width, common.height, panorama.width, panorama.height));
  }
  return common;
}

Grid grid_of(const std::vector<Frame>& frames, const PackOptions& options) {
  std::vector<StationPose> poses;
  poses.reserve(frames.size());
  for (const Frame& frame : frames) {
    poses.push_back({frame.file, frame.position_m, frame.where, frame.line});
  }
  Grid grid = find_grid(poses, options.tolerance);
  if (const auto doubt = doubt_of_unit(grid)) {
    spdlog::warn("{}: {}", input_name(options.frames), *doubt);
  }
  for (const std::string& note : line_notes(grid)) {
    spdlog::warn("{}: {}", input_name(options.frames), note);
  }
  return grid;
}

}  // namespace

std::uint64_t PackPlan::bytes_of_rays(std::size_t line) const {
  const bool masked =
      std::any_of(sources[line].begin(), sources[line].end(),
                  [](const StationSource& source) { return source.mask.has_value(); });
  const std::uint64_t rows =
      masked ? kBytesPerRowRun * static_cast<std::uint64_t>(panorama.width) : 0;
  return sources[line].size() * (estimated_bytes(form, 3 * pixels(panorama)) + rows);
}

std::uint64_t PackPlan::bytes_of_maps(std::size_t line) const {
  const auto maps =
      std::count_if(sources[line].begin(), sources[line].end(),
                    [](const StationSource& source) { return source.distance_map.has_value(); });
  return static_cast<std::uint64_t>(maps) * kBytesPerDistance * pixels(distance_map);
}

std::uint64_t PackPlan::bytes() const {
  std::uint64_t sum = 0;
  for (std::size_t line = 0; line < sources.size(); ++line) {
    sum += bytes_of_rays(line) + bytes_of_maps(line);
  }
  return sum;
}

fs::path default_room_name(const fs::path& frames) {
  fs::path folder = fs::absolute(frames).lexically_normal().parent_path();
  if (folder.filename() == "calibration") folder = folder.parent_path();
  const std::string name = folder.filename().string();
  return (name.empty() ? "room" : name) + ".lf";
}

PackPlan plan_pack(const PackOptions& options) {
  const std::vector<Frame> frames = read_frame_list(options.frames);
  require_frames_and_masks(frames);
  std::map<std::string, fs::path> maps;
  if (options.distances) maps = find_distance_maps(frames, *options.distances);
  PackPlan plan;
  plan.grid = grid_of(frames, options);
  plan.panorama = common_panorama_size(frames);
  check_masks(frames, plan.panorama);
  if (options.distances) plan.distance_map = common_map_size(maps, plan.panorama);
  std::map<std::string, const Frame*> frame_of;
  for (const Frame& frame : frames) frame_of[frame.file] = &frame;
  for (const Line& line : plan.grid.lines) {
    std::vector<StationSource>& sources = plan.sources.emplace_back();
    for (const Station& station : line.stations) {
      const Frame& frame = *frame_of.at(station.file);
      StationSource source{frame.path, frame.attitude, std::nullopt, frame.mask, frame.where};
      if (const auto map = maps.find(frame.file); map != maps.end())
        source.distance_map = map->second;
      sources.push_back(std::move(source));
    }
  }
  plan.form = options.form;
  std::string text;
  for (std::size_t i = 0; i < plan.grid.lines.size(); ++i) {
    const LineInputs& inputs = plan.inputs.emplace_back(line_inputs(plan, i));
    text += inputs.rays + inputs.distances + "\n";
  }
  plan.fingerprint = sha256_hex(text);
  return plan;
}

}  // namespace raywalk::build_lf
