// The measured connection errors (equation (11) of the paper) of a room, in
// ROOM/connect-error.json: one measurement per generation of views, with its settings. Written by
// raywalk-render connect-error.
//
//   {"format_version": 1,
//    "measurements": [{"generation", "viewpoints", "overlap_deg", "common_share", "distances",
//                      "rows": [{"connection", "k_deg", "e_connect", "e_connect_common",
//                                "coverage"}]}]}
//
// An error that could not be measured is null; "common_share" is null or missing where it is not
// known. "distances" says where those in use came from; files of older programs lack it. Measure
// again after replacing distances.
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace raywalk {

// Errors are in squared 8-bit levels, NaN where there was no column to compare.
struct ConnectionErrorAtK {
  double k_deg = 0.0;             // in [45, 90]
  double e_connect = 0.0;         // (11)
  double e_connect_common = 0.0;  // (11) over the (viewpoint, corner) pairs readable at every k
  double coverage = 0.0;          // share of pairs readable at this k, [0, 1]
};

struct ConnectionErrorMeasurement {
  std::string generation{};  // of the views measured: initial, hlf-vd or two-sided
  int viewpoints = 0;        // per side of every cell
  double overlap_deg = 0.0;  // width of the blend, [0, 45]
  // Share of the (viewpoint, corner) pairs that e_connect_common is over, [0, 1]; NaN: not known.
  double common_share = std::numeric_limits<double>::quiet_NaN();
  std::vector<ConnectionErrorAtK> rows{};
  std::string distances{};  // in use when measured: Room::distances_origin(); empty: unknown
};

// The recommendation of a measurement.
struct MeasuredConnection {
  std::string generation{};
  double k_deg = 90.0;     // with the least e_connect_common
  double e_connect = 0.0;  // e_connect_common at k_deg
};

// "lfu" at k = 45, "rayspace360" at 90, "hybrid" between.
std::string connection_name(double k_deg);

std::filesystem::path connection_errors_path(const std::filesystem::path& room);

// Empty if the room has none. Throws Error naming the file and how to measure it again if it is
// damaged or of a newer format version.
std::vector<ConnectionErrorMeasurement> read_connection_errors(const std::filesystem::path& room);

// Adds a measurement, replacing an earlier one of its generation. An unreadable file is replaced
// with a warning. Throws Error if the room cannot be written.
void store_connection_errors(const std::filesystem::path& room,
                             const ConnectionErrorMeasurement& measurement);

// The least share of pairs readable at every k whose errors speak for the room: with less, most of
// its corners are not compared at all.
inline constexpr double kLeastCommonShare = 0.5;

// The row with the least e_connect_common; of equal ones the largest k, which connects physically
// more often. e_connect is not compared: where the overhang is short, a small k is measured on
// fewer and other corners than a large one. None where common_share is below kLeastCommonShare or
// not known, and where only one k was measured.
std::optional<ConnectionErrorAtK> least_error(const ConnectionErrorMeasurement& measurement);

// least_error of each measured generation that has one. Throws Error as read_connection_errors.
std::vector<MeasuredConnection> least_errors(const std::filesystem::path& room);

}  // namespace raywalk
