// For tests: a folder of small pictures, as a frame list or as a session.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/image_file.h"
#include "core/files/sqlite_connection.h"
#include "core/files/test_support.h"
#include "core/session/session_schema.h"

namespace raywalk::calibrate {

class TestCaptureFolder {
 public:
  std::filesystem::path path() const { return directory_.path(); }
  std::filesystem::path operator/(const std::string& name) const { return directory_ / name; }

  void add_picture(const std::string& file, cv::Size size = {16, 8}) const {
    std::filesystem::create_directories((path() / file).parent_path());
    write_image(path() / file, cv::Mat(size, CV_8UC3, cv::Scalar(10, 20, 30)));
  }
  void write_list(const std::string& rows, const std::string& columns = "file,x,y,z") const {
    write_file_atomically(path() / "poses.csv", columns + "\n" + rows);
  }
  CaptureSet read() const { return read_capture_set({.directory = path()}); }
  std::string read_error() const {
    return error_of([&] { read(); });
  }

  // One line along x at z = 0 and one along z at x = 0, three stations each 0.1 m apart.
  void write_cross() const {
    for (const char* file : {"a0.png", "a1.png", "a2.png", "b0.png", "b1.png", "b2.png"}) {
      add_picture(file);
    }
    write_list(
        "a0.png,-0.1,0,0\na1.png,0,0,0\na2.png,0.1,0,0\n"
        "b0.png,0,0,-0.1\nb1.png,0,0,0\nb2.png,0,0,0.1\n");
  }

 private:
  TestDirectory directory_;
};

// A session's database, as raywalk-capture writes it. Lines and stations are added first, then
// plan(), then frames.
class TestSession {
 public:
  explicit TestSession(const TestCaptureFolder* folder)
      : folder_(folder), database_(*folder / "session.db", SqliteAccess::kReadWrite) {
    database_.execute("PRAGMA synchronous = OFF");
    database_.execute(kSessionSchema);
    execute(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}",
                        kSessionApplicationId, kSessionFormatVersion));
  }
  void execute(const std::string& sql) { database_.execute(sql); }

  void add_line(const std::string& name, const std::string& axis, double across_m,
                bool validation = false) {
    execute(fmt::format(
        "INSERT INTO line (name, axis, across_m, validation) VALUES ('{}', '{}', {}, {})", name,
        axis, across_m, validation ? 1 : 0));
    lines_.push_back({.along_x = axis == "x", .across_m = across_m});
  }
  // On the last line, at `along_m` on its axis, which is also its position on the rail, less
  // `rail_begins_m`.
  void add_station(const std::string& name, double along_m, double rail_begins_m = 0.0) {
    const double rail_mm = 1000.0 * (along_m - rail_begins_m);
    Line& line = lines_.back();
    const PlanPoint at =
        line.along_x ? PlanPoint{along_m, line.across_m} : PlanPoint{line.across_m, along_m};
    execute(
        fmt::format("INSERT INTO station (line_id, number, name, x_m, z_m, planned_mm) VALUES "
                    "({}, {}, '{}', {}, {}, {})",
                    lines_.size(), line.stations++, name, at.x_m, at.z_m, rail_mm));
  }
  // Describes the session.
  void plan(const std::string& frames, int exposures = 1) {
    execute(fmt::format(
        "DELETE FROM session; INSERT INTO session (id, created_utc_us, mode, camera, frames, "
        "bracket_ev, config_text) VALUES (1, 0, 'stations', 'osc', '{}', '[{}]', '')",
        frames, fmt::join(std::vector<double>(static_cast<std::size_t>(exposures), 0.0), ",")));
  }
  // With its picture; the slider's feedback was `measured_mm`.
  void add_frame(const std::string& station, double measured_mm, const std::string& lens = "both",
                 int exposure = 0) {
    const std::string file = fmt::format("frames/{}_{}_{}.png", station, lens, exposure);
    folder_->add_picture(file);
    execute(fmt::format(
        "INSERT OR IGNORE INTO attempt (station_id, number, outcome, begun_utc_us, commanded_mm, "
        "measured_mm) SELECT id, 1, 'captured', 0, planned_mm, {} FROM station WHERE name = '{}'",
        measured_mm, station));
    execute(fmt::format(
        "INSERT INTO frame (attempt_id, exposure, lens, file, bytes, sha256, width_px, height_px, "
        "camera_name, settings) SELECT attempt.id, {}, '{}', '{}', {}, '{}', 16, 8, '', '' FROM "
        "attempt JOIN station ON station.id = station_id WHERE name = '{}'",
        exposure, lens, file, std::filesystem::file_size(*folder_ / file), sum_of(lens), station));
  }
  // What add_frame records as the checksum of a picture of that lens.
  static std::string sum_of(const std::string& lens) { return sha256_hex(lens); }

 private:
  const TestCaptureFolder* folder_;
  SqliteConnection database_;
  struct Line {
    bool along_x = true;
    double across_m = 0.0;
    int stations = 0;
  };
  std::vector<Line> lines_{};
};

}  // namespace raywalk::calibrate
