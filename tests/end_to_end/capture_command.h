// For tests: raywalk-capture with the simulated rig, each in a process of its own.
#pragma once

#include <gtest/gtest.h>
#include <httplib.h>
#include <sqlite3.h>

#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/files/csv.h"
#include "core/files/fingerprint.h"
#include "core/files/test_directory.h"
#include "tests/end_to_end/run_command.h"
#include "tests/end_to_end/simulated_rig_process.h"

namespace raywalk {

// The default plan: 4 lines of 3 stations, 500 mm apart.
inline constexpr std::size_t kStations = 12;

class CaptureCommandTest : public ::testing::Test {
 protected:
  CaptureCommandTest() { files_.directory = directory_.path(); }

  void start_rig() {
    files_.write();
    rig_.emplace(files_);
    url_ = nlohmann::json::parse(read_file(rig_->directory() / "rig.json"))["camera_url"]
               .get<std::string>();
  }
  std::string session() const { return (directory_ / "session").string(); }
  std::string with_rig() const {
    return files_.capture().string() + " --rig " + rig_->directory().string();
  }
  CommandResult capture(const std::string& arguments) const {
    return run_command(std::string(RAYWALK_CAPTURE) + " " + arguments);
  }
  CommandResult run() const { return capture("run " + with_rig() + " --session " + session()); }
  std::unique_ptr<BackgroundProcess> run_in_background() const {
    return std::make_unique<BackgroundProcess>(
        std::vector<std::string>{RAYWALK_CAPTURE, "run", files_.capture().string(), "--rig",
                                 rig_->directory().string(), "--session", session()},
        directory_ / "run.log");
  }
  std::string run_log() const { return read_file(directory_ / "run.log"); }
  nlohmann::json rig_state() const {
    return nlohmann::json::parse(httplib::Client(url_).Get("/rig/state")->body);
  }
  void rig_fault(const nlohmann::json& fault) const {
    const auto reply = httplib::Client(url_).Post("/rig/fault", fault.dump(), "application/json");
    ASSERT_EQ(reply->status, 200) << reply->body;
  }
  bool is_rig_reachable() const {
    return std::filesystem::exists(rig_->directory() / "slider") &&
           httplib::Client(url_).Get("/rig/state");
  }
  void mend_rig() const { httplib::Client(url_).Post("/rig/mend", "", "application/json"); }
  nlohmann::json status() const {
    return nlohmann::json::parse(capture("status --json " + session()).output);
  }

  // All invariants of a finished session.
  void expect_finished_session() const {
    const CommandResult verified = capture("verify " + session());
    EXPECT_EQ(verified.exit_code, 0) << verified.output << verified.errors;
    const CommandResult exported = capture("export " + session());
    ASSERT_EQ(exported.exit_code, 0) << exported.errors;
    const CsvTable poses = CsvTable::read(std::filesystem::path(session()) / "poses.csv",
                                          {"file", "x", "y", "z", "line"}, {});
    std::set<std::string> frames;
    for (std::size_t row = 0; row < poses.rows(); ++row) frames.insert(poses.text(row, "file"));
    EXPECT_EQ(poses.rows(), kStations);
    EXPECT_EQ(frames.size(), kStations);
    EXPECT_EQ(integrity(), "ok");
  }
  std::string integrity() const {
    sqlite3* database = nullptr;
    std::string answer;
    sqlite3_open((session() + "/session.db").c_str(), &database);
    sqlite3_exec(
        database, "PRAGMA integrity_check",
        [](void* out, int, char** values, char**) {
          *static_cast<std::string*>(out) = values[0];
          return 0;
        },
        &answer, nullptr);
    sqlite3_close(database);
    return answer;
  }
  // Checksum of every frame file stored so far.
  std::map<std::string, std::string> frame_sums() const {
    std::map<std::string, std::string> sums;
    const std::filesystem::path frames = std::filesystem::path(session()) / "frames";
    if (!std::filesystem::exists(frames)) return sums;
    for (const auto& entry : std::filesystem::directory_iterator(frames)) {
      if (entry.path().extension() != ".jpg" || entry.path().filename().string()[0] == '.')
        continue;
      const std::string bytes = read_file(entry.path());
      sums[entry.path().filename()] = sha256_hex(std::as_bytes(std::span(bytes)));
    }
    return sums;
  }

  TestDirectory directory_;
  RehearsalFiles files_;
  std::optional<SimulatedRigProcess> rig_;
  std::string url_;
};

}  // namespace raywalk
