#include "build_lf/pack/pack_plan.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/core.hpp>
#include <set>
#include <span>
#include <system_error>

#include "build_lf/pack/station_data.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"
#include "core/geometry/line_gaps.h"
#include "core/panorama/panorama_rotation.h"
#include "core/room/hdf5_file.h"
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

// Cameras with an inertial sensor state how they were held. Without a rotation in the list the
// pictures are taken as upright.
void warn_of_stated_attitudes(const std::vector<Frame>& frames,
                              const std::vector<ImageHeader>& headers) {
  constexpr double kUpright_deg = 1.0;
  std::vector<std::size_t> tilted;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto stated = headers[i].attitude;
    if (frames[i].attitude || !stated) continue;
    if (std::max(std::abs(stated->pitch_deg), std::abs(stated->roll_deg)) > kUpright_deg) {
      tilted.push_back(i);
    }
  }
  if (tilted.empty()) return;
  const StatedAttitude& first = *headers[tilted.front()].attitude;
  spdlog::warn(
      "{}: states a pitch of {:.1f} and a roll of {:.1f} degrees (GPano), which are not used, as "
      "in {} of {} frames: the list has no rotations. Let raywalk-calibrate find them unless the "
      "pictures are upright",
      frames[tilted.front()].path.string(), first.pitch_deg, first.roll_deg, tilted.size(),
      frames.size());
}

// The common size of all panoramas, from their headers. A panorama without a mask is masked where
// it is transparent.
PanoramaSize check_panoramas(std::vector<Frame>* frames) {
  const std::vector<ImageHeader> headers = headers_of(*frames);
  TurnedPictures turned;
  for (std::size_t i = 0; i < frames->size(); ++i) {
    Frame& frame = (*frames)[i];
    turned.add(frame.path, headers[i].orientation);
    if (!frame.mask && headers[i].has_alpha) frame.mask = frame.path;
  }
  turned.warn();
  warn_of_stated_attitudes(*frames, headers);
  return headers.front().size;
}

// Shares of the sphere: what a mask hides, and what a room hides that keeps one run of rows of each
// column.
struct HiddenShares {
  double by_mask = 0.0;
  double in_room = 0.0;
};

HiddenShares hidden_shares(const Frame& frame, PanoramaSize panorama) {
  try {
    if (*frame.mask != frame.path) require_mask(*frame.mask, panorama);
    cv::Mat mask = read_mask(*frame.mask, panorama);
    HiddenShares shares{.by_mask = masked_share(mask)};
    const std::vector<std::int32_t> rows = valid_rows_of(mask);
    for (int u = 0; u < mask.cols; ++u) {
      const auto run = 2 * static_cast<std::size_t>(u);
      mask.col(u).rowRange(0, rows[run]).setTo(0);
      mask.col(u).rowRange(rows[run + 1], mask.rows).setTo(0);
    }
    shares.in_room = masked_share(mask);
    return shares;
  } catch (const Error& unusable) {
    throw Error(fmt::format("{}: {}", frame.where, unusable.what()));
  }
}

// Alpha channels that hide nothing are no masks afterwards.
void check_masks(std::vector<Frame>* frames, PanoramaSize panorama) {
  constexpr double kMost = 0.5, kNoticed = 0.005;
  std::set<fs::path> known;  // many frames may share a mask
  std::vector<Frame*> with_mask;
  for (Frame& frame : *frames) {
    if (frame.mask && known.insert(*frame.mask).second) with_mask.push_back(&frame);
  }
  std::vector<HiddenShares> shares(with_mask.size());
  Progress progress("checking", static_cast<std::int64_t>(with_mask.size()), "masks",
                    Progress::Shown::kIfLong);
  check_each(with_mask, &progress, [&](Frame* const& frame) {
    shares[static_cast<std::size_t>(&frame - with_mask.data())] = hidden_shares(*frame, panorama);
  });
  const auto warn = [&](auto is_odd, auto text) {
    const auto odd = std::ranges::find_if(shares, is_odd);
    if (odd == shares.end()) return;
    const Frame& first = *with_mask[static_cast<std::size_t>(odd - shares.begin())];
    spdlog::warn("{}: the mask {}{}, as {} of {} masks do", first.where, first.mask->string(),
                 text(*odd), std::ranges::count_if(shares, is_odd), shares.size());
  };
  warn([](const HiddenShares& of) { return of.by_mask > kMost; },
       [](const HiddenShares& of) {
         return fmt::format(" hides {:.0f} % of the sphere (black is hidden)", 100.0 * of.by_mask);
       });
  warn([](const HiddenShares& of) { return of.in_room - of.by_mask > kNoticed; },
       [](const HiddenShares& of) {
         return fmt::format(
             " hides {:.1f} % of the sphere, but {:.1f} % in the room, which keeps the longest run "
             "of pixels of each column",
             100.0 * of.by_mask, 100.0 * of.in_room);
       });
  for (std::size_t i = 0; i < shares.size(); ++i) {
    Frame& frame = *with_mask[i];
    if (shares[i].by_mask == 0.0 && frame.mask == frame.path) frame.mask.reset();
  }
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

// Without the folder, so that a folder that was moved or linked elsewhere is the same input.
std::string file_text(const fs::path& file) {
  return fmt::format("{}\n{}\n", file.filename().string(), stamp_of(file).text());
}

std::string attitude_text(const StationSource& source) {
  if (!source.attitude) return "";
  return fmt::format("attitude {} {} {}\n", source.attitude->yaw_rad, source.attitude->pitch_rad,
                     source.attitude->roll_rad);
}

std::string inputs_of_rays(const Line& line, const std::vector<StationSource>& sources,
                           const PackPlan& plan) {
  std::string text =
      fmt::format("rays {} {} {} {} {} {}\n", kRoomFormatVersion, kVolumeFormatVersion, line.id,
                  plan.panorama.width, plan.panorama.height, name_of(plan.form));
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const StationSource& source = sources[i];
    const auto& position_m = line.stations[i].position_m;
    text += fmt::format("{} {} {} {}\n", line.stations[i].file, position_m[0], position_m[1],
                        position_m[2]);
    text += attitude_text(source) + file_text(source.panorama);
    if (source.mask) text += "mask " + file_text(*source.mask);
  }
  return text;
}

std::string inputs_of_distances(const Line& line, const std::vector<StationSource>& sources,
                                const PackPlan& plan) {
  const PanoramaSize map = plan.distance_map;
  std::string text = fmt::format("distances {} {} {} {} {}\n", kRoomFormatVersion, sha256_of(line),
                                 map.width, map.height, plan.form.compressed());
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const StationSource& source = sources[i];
    if (!source.distance_map) continue;
    // Maps are turned as their panoramas are.
    text += fmt::format("{}\n", i) + file_text(*source.distance_map) + attitude_text(source);
  }
  return text;
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

fs::path default_room_name(const fs::path& frames) {
  fs::path folder = fs::absolute(frames).lexically_normal().parent_path();
  if (folder.filename() == "calibration") folder = folder.parent_path();
  const std::string name = folder.filename().string();
  return (name.empty() ? "room" : name) + ".lf";
}

PackPlan plan_pack(const PackOptions& options) {
  std::vector<Frame> frames = read_frame_list(options.frames);
  require_frames_and_masks(frames);
  std::map<std::string, fs::path> maps;
  if (options.distances) maps = find_distance_maps(frames, *options.distances);
  PackPlan plan;
  plan.grid = grid_of(frames, options);
  plan.panorama = check_panoramas(&frames);
  check_masks(&frames, plan.panorama);
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
  for (std::size_t i = 0; i < plan.grid.lines.size(); ++i) {
    throw_if_interrupted();
    const Line& line = plan.grid.lines[i];
    LineInputs& inputs = plan.inputs.emplace_back();
    inputs.rays = sha256_hex(inputs_of_rays(line, plan.sources[i], plan));
    if (!plan.has_maps()) continue;
    inputs.distances = sha256_hex(inputs_of_distances(line, plan.sources[i], plan));
  }
  return plan;
}

}  // namespace raywalk::build_lf
