// Faults of a capture that show in its frames: a camera that did not move, a frame unlike its
// neighbours, an exposure that jumps, a line too short to tell distances from.
//
// What is usual is taken from each line itself: its median and its median absolute deviation.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "build_lf/depth/station_gains.h"
#include "build_lf/depth/station_links.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

enum class FrameFault {
  // The file is a copy of an earlier station's. Measure: metres between the two stations.
  kSameFile,
  // Nothing but noise changes since the station before. Measure: the change, as a share of what
  // stations around change over such a way; at most 1/2.
  kNotMoved,
  // Differs from its neighbours on the line far more than these do from one another: something
  // moved, or the frame belongs elsewhere. Measure: how many times more; at least sqrt 2.
  kUnlikeNeighbours,
  // The exposure jumps. Measure: factor of the levels against the station before.
  kExposureStep,
};

// "same_file", "not_moved", "unlike_neighbours", "exposure_step".
std::string_view name_of(FrameFault fault);

struct FrameFinding {
  StationIndex station;
  std::string file;  // as named in the frame list
  FrameFault fault = FrameFault::kSameFile;
  StationIndex other;  // the station it is compared with: the earlier one, or a neighbour
  double measure = 0.0;
};

enum class LineFault {
  // No two stations are a quarter of the reach apart. Measure: the line's length, metres.
  kTooShort,
  // Neighbours are farther apart than the reach. Measure: the widest gap, metres.
  kTooSparse,
};

struct LineFinding {
  int line = 0;
  LineFault fault = LineFault::kTooShort;
  double measure_m = 0.0;
  double needed_m = 0.0;  // at least (too short) or at most (too sparse)
};

struct FrameChecks {
  std::vector<FrameFinding> frames;  // by line, fault, station
  std::vector<LineFinding> lines;
};

// `links` must hold those of pairs_to_compare(); `reach_m` is the longest baseline at which
// stations are compared. Throws Error if a volume's checksums cannot be read; volumes without
// checksums are judged by what they show.
FrameChecks check_frames(const Room& room, std::span<const StationLink> links,
                         const StationGains& gains, double reach_m);

}  // namespace raywalk::build_lf
