// For tests: a folder of small pictures, as a frame list or as a session.
#pragma once

#include <fmt/format.h>

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/sqlite_connection.h"
#include "core/files/test_directory.h"

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

  // One line along x at z = 0 and one along z at x = 0, three stations each 0.1 m apart.
  void write_cross() const {
    std::string rows;
    for (int i = -1; i <= 1; ++i) {
      for (const char* line : {"a", "b"}) add_picture(fmt::format("{}{}.png", line, i + 1));
    }
    for (int i = -1; i <= 1; ++i) rows += fmt::format("a{}.png,{},0,0\n", i + 1, 0.1 * i);
    for (int i = -1; i <= 1; ++i) rows += fmt::format("b{}.png,0,0,{}\n", i + 1, 0.1 * i);
    write_list(rows);
  }

 private:
  TestDirectory directory_;
};

// A session's database with the tables and columns of docs/session.md that are read here. The view
// captured_frame is a table in it.
class TestSession {
 public:
  explicit TestSession(const TestCaptureFolder* folder)
      : folder_(folder), database_(*folder / "session.db", SqliteAccess::kReadWrite) {
    database_.execute(
        "PRAGMA application_id = 0x52574c4b; PRAGMA user_version = 1;"
        "CREATE TABLE session (frames TEXT, exposures INTEGER);"
        "CREATE TABLE line (id INTEGER PRIMARY KEY, name TEXT, axis TEXT, across_m REAL,"
        " validation INTEGER);"
        "CREATE TABLE station (name TEXT, x_m REAL, z_m REAL);"
        "CREATE TABLE captured_frame (file TEXT, sha256 TEXT, exposure INTEGER, lens TEXT,"
        " line TEXT, station TEXT, x_m REAL, z_m REAL)");
  }
  void execute(const std::string& sql) { database_.execute(sql); }
  void describe(const std::string& frames, int exposures = 1) {
    execute(fmt::format("INSERT INTO session VALUES ('{}', {})", frames, exposures));
  }
  void add_line(const std::string& name, const std::string& axis, double across_m,
                bool validation = false) {
    execute(fmt::format(
        "INSERT INTO line (name, axis, across_m, validation) VALUES ('{}', '{}', {}, {})", name,
        axis, across_m, validation ? 1 : 0));
  }
  // Its first frame gives it its planned place.
  void add_station(const std::string& name) {
    execute(fmt::format("INSERT INTO station (name) VALUES ('{}')", name));
  }
  // With its picture.
  void add_frame(const std::string& station, const std::string& line, PlanPoint at,
                 const std::string& lens = "both", int exposure = 0) {
    const std::string file = fmt::format("frames/{}_{}_{}.png", station, lens, exposure);
    folder_->add_picture(file);
    add_row(file, station, line, at, lens, exposure);
  }
  void add_row(const std::string& file, const std::string& station, const std::string& line,
               PlanPoint at, const std::string& lens = "both", int exposure = 0) {
    execute(
        fmt::format("INSERT INTO captured_frame VALUES ('{}', 'sha-{}', {}, '{}', '{}', '{}', "
                    "{}, {})",
                    file, lens, exposure, lens, line, station, at.x_m, at.z_m));
    execute(fmt::format("UPDATE station SET x_m = {}, z_m = {} WHERE name = '{}' AND x_m IS NULL",
                        at.x_m, at.z_m, station));
  }

 private:
  const TestCaptureFolder* folder_;
  SqliteConnection database_;
};

}  // namespace raywalk::calibrate
