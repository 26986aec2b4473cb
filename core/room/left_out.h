// Pixels of a line's stations that views leave out where another station sees the place: people and
// cars that moved while the room was captured.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/geometry/sphere.h"
#include "core/room/line_volume.h"

namespace raywalk {

// Rows of a column of a station.
struct LeftOutRun : RowRun {
  int station = 0;
  int theta = 0;
};

class LeftOutPixels {
 public:
  LeftOutPixels() = default;  // none

  // From runs of pixels of panoramas of `size`: [run][4] = station, theta, first row, one past the
  // last row, in any order. Throws Error naming `source` for a run outside the line's `stations` or
  // the panorama.
  LeftOutPixels(std::span<const std::int32_t> runs, PanoramaSize size, int stations,
                const std::string& source);

  // The pixels of a subset of the stations (increasing indices), renumbered from 0.
  LeftOutPixels subset(std::span<const int> stations) const;

  // All runs, as they are stored for panoramas of `size`; pixels that are partly left out are.
  std::vector<std::int32_t> stored_runs(PanoramaSize size) const;

  PanoramaSize size() const { return size_; }
  // Whether any pixel of the station is left out.
  bool any(int station) const { return !runs_of(station).empty(); }
  // The runs of rows left out in column theta of a station, from the top.
  std::span<const LeftOutRun> rows(int station, int theta) const;

 private:
  std::span<const LeftOutRun> runs_of(int station) const;

  PanoramaSize size_;
  std::vector<LeftOutRun> runs_;  // by station, theta and row
};

}  // namespace raywalk
