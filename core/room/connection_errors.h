// The measured connection errors (equation (11) of the paper) that a room keeps, in
// ROOM/connect-error.json: one measurement per generation of views, each with the settings it was
// made with. raywalk-render connect-error measures and writes it.
//
//   {"format_version": 1,
//    "measurements": [{"generation", "viewpoints", "overlap_deg",
//                      "rows": [{"connection", "k_deg", "e_connect", "e_connect_common",
//                                "coverage"}]}]}
//
// An error that could not be measured is null. Measure again after distances were replaced.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace raywalk {

// Errors are in squared 8-bit levels, NaN where there was no column to compare.
struct ConnectionErrorAtK {
  double k_deg = 0.0;             // in [45, 90]
  double e_connect = 0.0;         // (11)
  double e_connect_common = 0.0;  // over the (viewpoint, corner) pairs that every k can read
  double coverage = 0.0;          // share of such pairs that this k can read
};

struct ConnectionErrorMeasurement {
  std::string generation{};  // of the views measured: initial, hlf-vd or two-sided
  int viewpoints = 0;        // per side of every cell
  double overlap_deg = 0.0;  // width of the blend, [0, 45]
  std::vector<ConnectionErrorAtK> rows{};
};

// What a measurement recommends.
struct MeasuredConnection {
  std::string generation{};
  double k_deg = 90.0;     // of the least e_connect
  double e_connect = 0.0;  // there
};

// "lfu" at k = 45, "rayspace360" at 90, "hybrid" between.
std::string connection_name(double k_deg);

std::filesystem::path connection_errors_path(const std::filesystem::path& room);

// Empty where the room has none. Throws Error naming the file where it is damaged or of a newer
// format version, and how to make it anew.
std::vector<ConnectionErrorMeasurement> read_connection_errors(const std::filesystem::path& room);

// Adds a measurement; it replaces an earlier one of its generation. A file that cannot be read is
// replaced with a warning. Throws Error where the room cannot be written.
void store_connection_errors(const std::filesystem::path& room,
                             const ConnectionErrorMeasurement& measurement);

// The row of least e_connect, of equals the one of largest k, as it connects more physically; none
// where nothing could be read at any k.
std::optional<ConnectionErrorAtK> least_error(const ConnectionErrorMeasurement& measurement);

// least_error of each generation that the room has measured and could read at some k. Throws Error
// as read_connection_errors.
std::vector<MeasuredConnection> least_errors(const std::filesystem::path& room);

}  // namespace raywalk
