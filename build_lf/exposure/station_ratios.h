// The ratios measured between the stations of a room, and where they are kept.
#pragma once

#include <array>
#include <filesystem>
#include <mutex>
#include <span>
#include <vector>

#include "build_lf/exposure/gain_graph.h"
#include "build_lf/exposure/patch_ratios.h"
#include "build_lf/exposure/surface_maps.h"
#include "core/files/atomic_output.h"
#include "core/room/gain_fields.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// How much brighter station `to` is than `from`, by patches.
struct StationRatios {
  int from = 0;  // index in the list of stations
  int to = 0;
  std::vector<PatchRatio> patches;
};

// The ratios of all stations, some 200 kB each, in a NamelessFile. Can be used by several
// threads at once.
class RatioFile {
 public:
  // In this directory, for so many stations. Throws Error if it cannot be written.
  RatioFile(const std::filesystem::path& directory, std::size_t stations);

  // Keeps the ratios of one station `to`. Throws Error if the disk is full.
  void put(int to, std::span<const StationRatios> ratios);
  // Those of a station; none if nothing was put. Throws Error if they cannot be read.
  std::vector<StationRatios> get(int to) const;

 private:
  // Of one pair of stations in the file.
  struct Place {
    int from = 0;
    std::size_t patches = 0;
  };
  struct Station {
    std::vector<Place> pairs;
    std::size_t offset = 0;  // bytes
  };

  std::filesystem::path directory_;
  NamelessFile file_;
  std::mutex mutex_;
  std::size_t size_ = 0;  // bytes given away
  std::vector<Station> stations_;
};

// Two whole pictures differ by the median of their patches' ratios.
struct WholeRatio {
  int from = 0;
  int to = 0;
  std::array<GainEquation, 3> channels{};
  bool known = false;  // whether any patch was compared
};

// Compares `stations` (increasing) each with the nearest stations that have a map, on its own line,
// where the views are most alike, and on others, which tie the lines together. Puts the ratios into
// `file`; returns those of whole pictures, by increasing `to`. The result does not depend on the
// number of threads. Throws Error as RatioFile does; Interrupted.
std::vector<WholeRatio> measure_ratios(const Room& room, std::span<const StationIndex> stations,
                                       const SurfaceMaps& maps, RatioFile* file);

}  // namespace raywalk::build_lf
