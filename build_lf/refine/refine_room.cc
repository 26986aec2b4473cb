#include "build_lf/refine/refine_room.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <memory>
#include <numeric>
#include <span>
#include <vector>

#include "build_lf/pack/free_space.h"
#include "build_lf/pack/pack_room.h"
#include "build_lf/pack/room_folder.h"
#include "build_lf/pack/volume_writer.h"
#include "build_lf/refine/developed_station.h"
#include "build_lf/refine/refine_plan.h"
#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/interrupt.h"
#include "core/base/number_text.h"
#include "core/base/progress.h"
#include "core/evaluate/held_out.h"
#include "core/files/fingerprint.h"
#include "core/files/output_folder.h"
#include "core/room/refined_record.h"
#include "core/room/requirements.h"
#include "core/room/room.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRefinedOrigin = "refined";

// A run: the captured room without what is held out, and what is made of it.
class Refinement {
 public:
  explicit Refinement(const RefineOptions& options, FileLock::Use use = FileLock::Use::kAlone)
      : options_(options),
        captured_(opened(options)),
        room_(options.hold_out == 0 ? captured_
                                    : room_without_held_out(captured_, options.hold_out)),
        kept_(stations_to_develop(room_, options.stations)),
        refined_(room_.subset(kept_)),
        width_(developed_width(room_.panorama(), options.width)),
        inputs_(fingerprint()),
        stations_(stations_of(kept_)),
        folder_(options.out, volumes(), options.replace, use) {}

  // Develops those of the part that are not. Returns how many stations the part has.
  std::size_t develop(WorkPart part) {
    const IndexRange share = part.share_of(stations_.size());
    const std::span<const StationIndex> of_part(stations_.data() + share.begin, share.size());
    require_space();
    const std::unique_ptr<const Exposure> exposure =
        room_.gains().empty() ? nullptr : std::make_unique<const Exposure>(room_);
    SourceViews views(room_);
    Progress progress("developing", std::ssize(of_part), "stations");
    for (const StationIndex station : of_part) {
      throw_if_interrupted();
      if (!fs::exists(file_of(station))) {
        store_developed(file_of(station),
                        develop_station(room_, exposure.get(), station, width_, &views), inputs_);
      }
      progress.advance();
    }
    return share.size();
  }

  // Makes the room of what is developed.
  void complete() {
    std::array<double, 2> sharpening{2.0, 0.0};
    Progress progress("storing", 2 * static_cast<std::int64_t>(stations_.size()), "images");
    for (int line = 0; line < static_cast<int>(kept_.size()); ++line) {
      write_line(line, &sharpening, &progress);
    }
    const PanoramaSize size{width_, width_ / 2};
    const fs::path source =
        fs::absolute(options_.room)
            .lexically_relative(fs::absolute(without_trailing_slash(options_.out)));
    RoomManifest manifest = manifest_of_volumes(folder_.directory(), size, refined_.grid());
    manifest.refined = {.source = source,
                        .source_fingerprint = room_fingerprint(captured_),
                        .source_stations = static_cast<int>(all_stations(room_.grid()).size()),
                        .hold_out = options_.hold_out,
                        .sharpening = sharpening};
    folder_.complete(manifest);
  }

 private:
  static Room opened(const RefineOptions& options) {
    require_free(without_trailing_slash(options.out), options.replace);
    if (options.hold_out < 0 || options.hold_out == 1) {
      throw UsageError("--hold-out: must be at least 2: every n-th station is left out; 0 = none");
    }
    Room room = Room::open(options.room);
    if (room.manifest().refined) {
      throw Error(fmt::format("{}: is a refined room already; refine the captured one",
                              options.room.string()));
    }
    if (!room.has_distances()) {
      throw Error(fmt::format("{}: has no distances; run raywalk-build-lf depth {} first",
                              options.room.string(), shell_word(options.room.string())));
    }
    return room;
  }

  // Over everything that determines the result.
  std::string fingerprint() const {
    return sha256_hex(fmt::format("refine 1 {} {} {}\n{}{}{}", width_, options_.hold_out,
                                  name_of(options_.form), room_fingerprint(captured_),
                                  manifest_to_json(refined_.manifest()), distances_sha256(room_)));
  }

  static std::vector<StationIndex> stations_of(const KeptStations& kept) {
    std::vector<StationIndex> stations;
    for (int line = 0; line < static_cast<int>(kept.size()); ++line) {
      for (const int station : kept[static_cast<std::size_t>(line)]) {
        stations.push_back({line, station});
      }
    }
    return stations;
  }

  // Of a developed station, relative to the room.
  static fs::path name_of_file(StationIndex station) {
    return fs::path(kDevelopedDirectory) / fmt::format("{}-{}.h5", station.line, station.station);
  }

  fs::path file_of(StationIndex station) const {
    return folder_.directory() / name_of_file(station);
  }

  std::vector<PlannedVolume> volumes() const {
    std::vector<PlannedVolume> volumes;
    for (const StationIndex station : stations_) {
      volumes.push_back({name_of_file(station), inputs_});
    }
    for (const Line& line : refined_.grid().lines) {
      volumes.push_back({line_volume_path("", line.id), inputs_});
      volumes.push_back({distance_volume_path("", line.id, DistanceKind::kEstimated), inputs_});
    }
    return volumes;
  }

  void require_space() const {
    const std::uint64_t pixels = static_cast<std::uint64_t>(width_) * (width_ / 2);
    constexpr std::uint64_t kDevelopedBytes = 8, kStoredBytes = 8;  // of a pixel
    const auto there = static_cast<std::uint64_t>(
        std::ranges::count_if(stations_, [&](StationIndex at) { return fs::exists(file_of(at)); }));
    const std::uint64_t all = stations_.size() * pixels * (kDevelopedBytes + kStoredBytes);
    const std::uint64_t developed = there * pixels * kDevelopedBytes;
    build_lf::require_space(folder_.directory(), {.needed = all - developed, .there = developed},
                            free_bytes(folder_.directory()));
  }

  void write_line(int index, std::array<double, 2>* sharpening, Progress* progress) {
    const Line& line = refined_.grid().lines[static_cast<std::size_t>(index)];
    const std::vector<int>& kept = kept_[static_cast<std::size_t>(index)];
    const PanoramaSize size{width_, width_ / 2};
    const auto file = [&](std::size_t i) { return file_of({index, kept[i]}); };
    for (std::size_t i = 0; i < kept.size(); ++i) {
      const double amount = developed_sharpening(file(i));
      (*sharpening)[0] = std::min((*sharpening)[0], amount);
      (*sharpening)[1] = std::max((*sharpening)[1], amount);
    }
    const fs::path rays = line_volume_path(folder_.directory(), line.id);
    if (!fs::exists(rays)) {
      write_line_volume(rays, line,
                        {.panorama = size,
                         .masked = room_.masked(),
                         .read = [&](std::size_t i) { return developed_rays(file(i)); },
                         .form = options_.form,
                         .inputs = inputs_},
                        progress);
    }
    const fs::path distances =
        distance_volume_path(folder_.directory(), line.id, DistanceKind::kEstimated);
    if (fs::exists(distances)) return;
    std::vector<std::int32_t> all(kept.size());
    std::iota(all.begin(), all.end(), 0);
    write_distance_volume(distances, line,
                          {.stations = std::move(all),
                           .size = size,
                           .origin = kRefinedOrigin,
                           .read = [&](std::size_t i) { return developed_distances(file(i)); },
                           .compressed = options_.form.compressed(),
                           .inputs = inputs_},
                          progress);
  }

  const RefineOptions& options_;
  Room captured_;
  Room room_;
  KeptStations kept_;
  Room refined_;  // what the refined room has of the room: lines, cells and stations
  int width_;
  std::string inputs_;                  // of every volume
  std::vector<StationIndex> stations_;  // that are developed
  RoomFolder folder_;
};

}  // namespace

void refine_room(const RefineOptions& options) {
  Refinement refinement(options);
  refinement.develop({});
  refinement.complete();
}

std::string refine_part(const RefineOptions& options, WorkPart part) {
  const std::size_t stations = Refinement(options, FileLock::Use::kShared).develop(part);
  return fmt::format("{}: part {}/{}: {} developed", options.out.string(), part.index, part.count,
                     counted(stations, "station"));
}

}  // namespace raywalk::build_lf
