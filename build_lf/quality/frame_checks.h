// Detects capture faults from the frames: a camera that did not move, a frame unlike its
// neighbours, an exposure step, a line too short for estimating distances.
//
// Outliers are judged per line, by its median and median absolute deviation.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "build_lf/quality/station_links.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

enum class FrameFault {
  // The file is a copy of an earlier station's. Measure: metres between the two stations.
  kSameFile,
  // Only noise changes since the previous station. Measure: the change relative to that of nearby
  // stations over the same distance; at most 1/2.
  kNotMoved,
  // Differs from its neighbours on the line far more than they do from each other: something moved,
  // or the frame is misplaced. Measure: the ratio; at least sqrt 2.
  kUnlikeNeighbours,
  // The exposure jumps. Measure: factor of the levels relative to the previous station.
  kExposureStep,
};

// "same_file", "not_moved", "unlike_neighbours", "exposure_step".
std::string_view name_of(FrameFault fault);

struct FrameFinding {
  StationIndex station;
  std::string file;  // as named in the frame list
  FrameFault fault = FrameFault::kSameFile;
  StationIndex other;  // compared with: the earlier station, or a neighbour
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
  double needed_m = 0.0;  // minimum (too short) or maximum (too sparse)
};

struct FrameChecks {
  std::vector<FrameFinding> frames;  // by line, fault, station
  std::vector<LineFinding> lines;
  // Factor of the levels from one station to the next on its line, of comparable frames.
  double largest_exposure_step = 1.0;
};

// `links` must contain those of pairs_to_compare(); `reach_m` is the longest baseline used for
// matching. Throws Error if a volume's checksums cannot be read; volumes without checksums skip the
// kSameFile check.
FrameChecks check_frames(const Room& room, std::span<const StationLink> links, double reach_m);

// One sentence per finding: the fault, the files, and how the run handles it.
std::vector<std::string> warnings_of(const Room& room, const FrameChecks& checks);

}  // namespace raywalk::build_lf
