// How far apart stations are, the gaps between them, and what users are warned of.
// Lengths are metres.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/geometry/grid.h"

namespace raywalk {

// How far apart stations typically are, metres: the median distance to the second nearest station
// at another position, as the nearest may belong to another pass of the same line; to the nearest
// where the second is in the same direction, as at the end of a line. 0 if all stations are at one
// position. Of many stations a thousand are measured.
double typical_spacing(std::span<const StationPose> stations);

// A part of a line without stations.
struct LineGap {
  int after = 0;      // index of the station before it
  double from_m = 0;  // along_m
  double to_m = 0;
};

// The spacing of stations with these gaps between neighbours (at least one, none negative): that of
// evenly spaced ones; else the larger of the median gap and the gap such that half of the line lies
// in gaps at least as large, the largest left out. So neither the short gaps of two passes of a
// line nor one missing section decide alone.
double covering_spacing(std::vector<double> gaps_m);
double covering_spacing(const Line& line);

// Median distance between neighbouring stations of a line.
double median_spacing_m(const Line& line);

// The gaps of a line that exceed four times its covering spacing: a few lost frames do not open a
// cell, a missing section does.
std::vector<LineGap> missing_sections(const Line& line);

// Sentences for users: of every missing section, of lines side by side, closer than their stations'
// spacing, which may be passes of one line, and of the side that is missing where no cell is
// closed.
std::vector<std::string> line_notes(const Grid& grid);

// Why the positions look like millimetres or centimetres, and what to do; none if they do not.
// Stations of rooms are millimetres to decimetres apart and cells a few metres wide. Doubtful: more
// than 2 m between neighbours of the most widely spaced line, or a cell wider than 50 m.
std::optional<std::string> doubt_of_unit(const Grid& grid);

}  // namespace raywalk
