// The plan of a capture session and what was captured of it, checked while it is read.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/files/sqlite_connection.h"
#include "core/geometry/grid.h"

namespace raywalk {

// The half of the surroundings that a file shows: cameras that write a front and a back file per
// shot produce two frames per exposure.
enum class FrameLens { kBoth, kFront, kBack };
inline constexpr std::array kFrameLenses{FrameLens::kBoth, FrameLens::kFront, FrameLens::kBack};

// The word of the database.
constexpr std::string_view name_of(FrameLens lens) {
  constexpr std::array<std::string_view, 3> kWords = {"both", "front", "back"};
  return kWords[static_cast<std::size_t>(lens)];
}

// The most pictures of a station that a session may hold.
inline constexpr int kMostExposures = 1000;
// The largest position on a rail that a session may hold, also negative.
inline constexpr double kFarthest_mm = 1e8;

struct SessionLine {
  std::string id{};
  LineAxis axis = LineAxis::kX;
  double across_m = 0.0;    // z of a line along x, x of a line along z
  bool validation = false;  // kept out of the volumes
};

// The attempt that took a station's pictures.
struct SessionShot {
  std::int64_t attempt = 0;  // row of the table attempt
  int number = 0;            // of the attempts at this station, from 1
  bool on_card = false;      // the pictures are still on the camera's card
  double measured_mm = 0.0;  // on the rail, by the slider's feedback
  std::optional<std::int64_t> triggered_utc_us{};
  std::optional<std::int64_t> exposed_utc_us{};
};

struct SessionStation {
  std::string name{};
  int line = 0;  // index into SessionContents::lines
  PlanPoint planned_m{};
  double planned_mm = 0.0;            // on the rail
  std::optional<SessionShot> shot{};  // none: not captured yet
};

// A picture of a captured station. World frame of core/geometry/sphere.h, y = 0.
struct SessionFrame {
  std::string file{};      // relative to the session's directory and within it
  int station = 0;         // index into SessionContents::stations
  std::int64_t bytes = 0;  // of the file
  std::string sha256{};    // of the file
  int exposure = 0;        // index in the bracket
  FrameLens lens = FrameLens::kBoth;
  PlanPoint position_m{};  // along the line by the feedback, across it as planned
};

struct SessionContents {
  std::filesystem::path directory{};
  std::string frame_kind{};  // "panorama", "dual-fisheye"
  int exposures = 1;         // pictures per station
  std::vector<SessionLine> lines{};
  std::vector<SessionStation> stations{};  // line by line, along the axis
  std::vector<SessionFrame> frames{};      // by station and exposure

  const SessionStation& station_of(const SessionFrame& frame) const {
    return stations[static_cast<std::size_t>(frame.station)];
  }
  const SessionLine& line_of(const SessionStation& station) const {
    return lines[static_cast<std::size_t>(station.line)];
  }
};

// Reads one state of a session, also while another program writes to it. Throws Error, as
// throw_damaged_session does, for a value that is missing or out of range, a position by the
// feedback that is not at its station, and a frame outside the directory. Whether frames are
// missing says frame_faults().
SessionContents read_session_contents(SqliteConnection* database,
                                      const std::filesystem::path& directory);

// Something wrong with the frames of a captured station.
struct FrameFault {
  std::string station{};  // its name
  std::string text{};     // "frames/x0_007.jpg (station x0_007): No such file or directory"
};

// What is wrong with the file of a frame by its type and size; empty where nothing is. Does not
// read it.
std::string file_fault(const SessionContents& contents, const SessionFrame& frame);

// The captured stations that lack an exposure or the picture of a lens, in their order.
std::vector<FrameFault> incomplete_stations(const SessionContents& contents);

// These, and the frames whose file is missing or of another size. Does not read the files.
std::vector<FrameFault> frame_faults(const SessionContents& contents);

// Throws Error, naming the session, the first fault and what to do, if there are faults.
void require_no_faults(const std::vector<FrameFault>& faults,
                       const std::filesystem::path& directory);

}  // namespace raywalk
