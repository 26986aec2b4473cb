// The ratios measured between the stations of a room.
#pragma once

#include <array>
#include <filesystem>
#include <memory_resource>
#include <utility>
#include <vector>

#include "build_lf/depth/file_memory.h"
#include "build_lf/exposure/gain_graph.h"
#include "build_lf/exposure/patch_ratios.h"
#include "build_lf/exposure/surface_maps.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Two whole pictures differ by the median of their patches' ratios.
struct WholeRatio {
  int from = 0;  // stations by their place in all_stations()
  int to = 0;
  std::array<GainEquation, 3> channels{};
  bool known = false;  // whether any patch was compared
};

struct StationRatios {
  explicit StationRatios(std::filesystem::path directory) : files(std::move(directory)) {}

  std::vector<WholeRatio> whole;  // by increasing `to`
  FileMemory files;
  // Those of kRatioGroup stations `to` each, in their order.
  std::vector<std::pmr::vector<PatchRatio>> patches;
};
inline constexpr int kRatioGroup = 8;

// Compares all stations each with the nearest stations that have a map, on its own line, where the
// views are most alike, and on others, which tie the lines together. Fills `ratios`, whose patches,
// some 200 kB per station, lie in files. The result does not depend on the number of threads.
// Throws Error if the disk is full; Interrupted.
void measure_ratios(const Room& room, const SurfaceMaps& maps, StationRatios* ratios);

}  // namespace raywalk::build_lf
