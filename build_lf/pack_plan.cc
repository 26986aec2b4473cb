#include "build_lf/pack_plan.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <set>
#include <span>
#include <system_error>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"
#include "core/files/image_header.h"
#include "core/files/sha256.h"
#include "core/files/turned_pictures.h"
#include "core/geometry/line_gaps.h"
#include "core/room/room.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

// More than signature and header chunk.
constexpr std::size_t kPngHeaderBytes = 64;

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
std::vector<PictureHeader> headers_of(const std::vector<Frame>& frames) {
  std::vector<PictureHeader> headers(frames.size());
  const PictureHeader first = panorama_header_of(frames.front().path);
  Progress progress("checking", static_cast<std::int64_t>(frames.size()), "frames");
  check_each(frames, &progress, [&](const Frame& frame) {
    PictureHeader& header = headers[static_cast<std::size_t>(&frame - frames.data())];
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
  const std::vector<PictureHeader> headers = headers_of(frames);
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

// Size of a distance map from its header, without decoding it. A PNG's header is its first chunk.
PanoramaSize distance_map_size_of(const fs::path& file) {
  const std::string start = read_file_prefix(file, kPngHeaderBytes);
  const std::optional<ImageHeader> header =
      parse_image_header(std::as_bytes(std::span(start)), file.string());
  if (!header || header->format != ImageFormat::kPng || header->bits_per_channel != 16 ||
      !header->is_grey) {
    throw Error(file.string() +
                ": not a distance map, a 16-bit grey PNG in millimetres along the ray");
  }
  if (header->width != 2 * header->height) {
    throw Error(fmt::format("{}: {} x {} is not 2:1, as distance maps must be", file.string(),
                            header->width, header->height));
  }
  return {static_cast<int>(header->width), static_cast<int>(header->height)};
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

std::string stamp_lines(const fs::path& file) {
  return file.string() + "\n" + stamp_of(file).text() + "\n";
}

std::string fingerprint_of(const PackOptions& options, const std::string& list,
                           const PackPlan& plan) {
  std::string text = fmt::format("room format {}\n", kRoomFormatVersion);
  const GridTolerance& tolerance = options.tolerance;
  if (tolerance.off_line_m) text += fmt::format("tolerance {}\n", *tolerance.off_line_m);
  if (tolerance.same_station_m) text += fmt::format("same station {}\n", *tolerance.same_station_m);
  if (options.form.compressed()) text += fmt::format("compress {}\n", name_of(options.form));
  text += list;
  std::vector<const StationSource*> sources;
  for (const std::vector<StationSource>& line : plan.sources) {
    for (const StationSource& source : line) sources.push_back(&source);
  }
  std::vector<std::string> stamps(sources.size());
  Progress progress("comparing the times of", static_cast<std::int64_t>(sources.size()), "frames",
                    Progress::Shown::kIfLong);
  check_in_parallel(static_cast<int>(sources.size()), [&](int i) {
    const StationSource& source = *sources[static_cast<std::size_t>(i)];
    std::string& stamp = stamps[static_cast<std::size_t>(i)];
    stamp = stamp_lines(source.panorama);
    if (source.distance_map) stamp += stamp_lines(*source.distance_map);
    if (source.mask) stamp += stamp_lines(*source.mask);
    progress.advance();
  });
  for (const std::string& stamp : stamps) text += stamp;
  return sha256_hex(text);
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

bool PackPlan::has_maps(std::size_t line) const {
  return std::any_of(sources[line].begin(), sources[line].end(),
                     [](const StationSource& source) { return source.distance_map.has_value(); });
}

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
  const std::string list = read_file_or_stdin(options.frames);
  const std::vector<Frame> frames = parse_frame_list(list, options.frames);
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
  plan.fingerprint = fingerprint_of(options, list, plan);
  return plan;
}

}  // namespace raywalk::build_lf
