// For tests: small plans, and sessions captured without devices.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "capture/base/manual_clock.h"
#include "capture/config/capture_config.h"
#include "capture/plan/capture_plan.h"
#include "capture/session/session.h"
#include "capture/session/session_database.h"
#include "capture/session/session_frames.h"  // IWYU pragma: export
#include "capture/session/session_status.h"
#include "core/files/test_support.h"  // IWYU pragma: export

namespace raywalk::capture {

inline constexpr double kTestFirst_mm = 50.0;  // of every line, on the rail

inline CaptureLine test_line(const std::string& id, LineAxis axis, double across_m, double first_m,
                             double spacing_m, int stations) {
  CaptureLine line{.id = id,
                   .axis = axis,
                   .across_m = across_m,
                   .validation = id.starts_with('v'),
                   .stations = {}};
  for (int i = 0; i < stations; ++i) {
    const double along_m = first_m + i * spacing_m;
    line.stations.push_back(
        {fmt::format("{}_{:03}", id, i),
         axis == LineAxis::kX ? PlanPoint{along_m, across_m} : PlanPoint{across_m, along_m},
         kTestFirst_mm + 1e3 * i * spacing_m});
  }
  return line;
}

// A cell of side 1 m around the origin, a quarter of a metre of overhang: 4 lines of 3 stations,
// and with `validation` one of 3 through the middle.
inline CapturePlan test_plan(bool validation = false) {
  CapturePlan plan;
  for (const LineAxis axis : {LineAxis::kX, LineAxis::kZ}) {
    for (const int number : {0, 1}) {
      plan.lines.push_back(test_line(fmt::format("{}{}", name_of(axis), number), axis, number - 0.5,
                                     -0.75, 0.75, 3));
    }
  }
  if (validation) plan.lines.push_back(test_line("v0", LineAxis::kX, 0.0, -0.25, 0.25, 3));
  return plan;
}

// One line of three stations.
inline CapturePlan short_plan() {
  return {.lines = {test_line("x0", LineAxis::kX, 0.5, -0.25, 0.25, 3)}};
}

// A picture with different bytes for every text.
inline Picture test_picture(const std::string& text) {
  return {.bytes = "picture of " + text + std::string(1000, '.'),
          .extension = "jpg",
          .camera_name = "",
          .size = {64, 32},
          .exposure = R"({"iso": 100})"};
}

inline SettledPosition settled_at(double commanded_mm, double measured_mm) {
  return {.commanded_mm = commanded_mm,
          .measured_mm = measured_mm,
          .moving_ms = 1200.0,
          .settling_ms = 300.0,
          .settled_at = {}};
}

// A session in a directory, captured like by a run.
struct TestCapture {
  std::filesystem::path directory;
  CapturePlan plan = test_plan();
  CaptureConfig config{};
  ManualClock clock{};
  double off_mm = 0.0;  // difference of the feedback from the planned position
  double own_ms = 6.5;  // of the program at each station

  std::unique_ptr<Session> open() {
    return Session::open_or_create(directory, plan, config, "camera:\n  kind: osc\n", &clock);
  }

  Shot shoot(const std::string& station) {
    Shot shot{.pictures = {},
              .triggered_at = clock.wall_now(),
              .exposed_at = clock.wall_now(),
              .exposing_ms = 800.0,
              .transfer_ms = 150.0};
    for (std::size_t i = 0; i < config.camera.exposure.bracket_ev.size(); ++i) {
      if (config.camera.kind == CameraKind::kGpio) break;
      shot.pictures.push_back(test_picture(fmt::format("{} {}", station, i)));
    }
    return shot;
  }

  nlohmann::json status() const {
    SessionReader reader(directory);
    return session_status(&reader);
  }
  SessionVerification verify() const {
    SessionReader reader(directory);
    return verify_session(&reader);
  }

  void capture(Session* session, const CaptureStation& station) {
    const AttemptId attempt = session->begin_attempt(station.name, station.rail_mm);
    clock.sleep(duration_from_ms(2500.0));
    const Shot shot = shoot(station.name);
    std::vector<StoredFrame> frames;
    for (const Picture& picture : shot.pictures) {
      frames.push_back(session->store_frame(attempt, static_cast<int>(frames.size()), picture));
    }
    session->complete_attempt(attempt, settled_at(station.rail_mm, station.rail_mm + off_mm), shot,
                              frames, own_ms);
  }

  // Captures the missing stations, at most `at_most`.
  void capture_missing(Session* session, int at_most = 1000000) {
    for (const CaptureLine& line : plan.lines) {
      for (const CaptureStation& station : line.stations) {
        if (session->is_captured(station.name)) continue;
        if (at_most-- <= 0) return;
        capture(session, station);
      }
    }
  }
};

// A session of its own for every case, not captured yet.
class SessionCase : public testing::Test {
 protected:
  explicit SessionCase(CapturePlan plan = short_plan()) { capture_.plan = std::move(plan); }

  std::filesystem::path database() const { return session_database_path(capture_.directory); }
  std::int64_t count(const std::string& what) const {
    return open_session_to_read(capture_.directory).integer("SELECT count(*) FROM " + what);
  }
  SessionContents contents() const { return SessionReader(capture_.directory).contents(); }
  std::string error_of_opening() {
    return error_of([this] { capture_.open(); });
  }
  // Changes the database behind the program's back, without syncing, which takes most of the time.
  void change(const std::string& sql) const {
    SqliteConnection(database(), SqliteAccess::kReadWrite)
        .execute("PRAGMA synchronous = OFF;" + sql);
  }

  TestDirectory directory_;
  TestCapture capture_{.directory = directory_ / "session"};
};

}  // namespace raywalk::capture
