#include "capture/run/run_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "capture/base/units.h"
#include "capture/plan/line_selection.h"
#include "capture/run/capture_sequence.h"
#include "capture/run/check_devices.h"
#include "capture/run/video_lines.h"
#include "capture/session/session_status.h"
#include "capture/slider/modbus_slider.h"
#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/interrupt.h"
#include "core/base/number_text.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/session/session_contents.h"

namespace raywalk::capture {
namespace {

std::string dry_run(const CapturePlan& plan, const CaptureConfig& config, const PlaceRail& place) {
  SystemClock clock;
  const auto slider = open_slider(config.slider, &clock);
  Carriage carriage(slider.get(), &clock, limits_of(config.slider), config.slider.motion);
  carriage.home();
  Progress progress("dry run", static_cast<std::int64_t>(plan.stations()), "stations");
  const std::vector<CaptureLine> placements = placements_of(plan);
  const int count = static_cast<int>(placements.size());
  for (int i = 0; i < count; ++i) {
    place(placements[i], i + 1, count);
    for (const CaptureStation& station : placements[i].stations) {
      carriage.move_to(carriage.limits().require(station.rail_mm, "station " + station.name));
      progress.advance();
    }
  }
  return fmt::format("dry run: the slider settled at all {} stations; no picture was taken",
                     plan.stations());
}

// A session is not complete, whatever its database says, while a frame is not on the disk.
void require_frames(Session* session) {
  require_no_faults(frame_faults(session->contents()), session->directory());
}

void capture(const CapturePlan& plan, const CaptureConfig& config, const CaptureParts& parts) {
  if (config.run.mode == CaptureMode::kVideo) {
    record_lines(
        plan, parts,
        {.profile = {config.run.video_speed_mm_s, config.slider.motion.profile.acceleration_mm_s2},
         .approach_mm = config.run.approach_mm});
    return;
  }
  CaptureSequence(parts, {.shots = config.run.shots,
                          .exposures = static_cast<int>(config.camera.exposure.bracket_ev.size()),
                          .frames = config.camera.frames,
                          .approach_mm = config.run.approach_mm,
                          .least_free_bytes = config.run.least_free_mb * kBytesPerMegabyte})
      .run(plan);
}

// The summary of a completed run and the next step.
std::string outcome_text(const CapturePlan& plan, const CaptureConfig& config,
                         const std::filesystem::path& session) {
  SessionReader reader(session);
  const nlohmann::json status = session_status(&reader);
  const std::string lines = counted(plan.lines.size(), "line");
  const std::string done =
      config.run.mode == CaptureMode::kVideo
          ? fmt::format("all {} are recorded", lines)
          : fmt::format("all {} stations of {} are {}", plan.stations(), lines,
                        status["exposed"] > 0 ? "on the camera's card" : "captured");
  return fmt::format("{}: {}; next: {}", escaped(session.string()), done,
                     status["next_step"].get<std::string>());
}

}  // namespace

std::string run_session(const CaptureConfig& config, const RunOptions& options) {
  const DeferStopSignals protection;
  const CapturePlan plan = select_lines(plan_capture(config), config.camera, options.lines);
  const PlaceRail place = [&](const CaptureLine& line, int number, int count) {
    place_rail(config.run, options.yes, line, number, count);
  };
  if (options.dry_run) return dry_run(plan, config, place);

  SystemClock clock;
  const auto session =
      Session::open_or_create(options.session, plan, config, read_file(config.file), &clock);
  require_frames(session.get());
  const std::size_t pictures =
      count_missing(plan, *session) * config.camera.exposure.bracket_ev.size();
  // Stations of a video have their pictures only once it is imported.
  const auto is_recorded = [&](const CaptureLine& line) { return session->has_journal(line.id); };
  const bool is_complete = config.run.mode == CaptureMode::kVideo
                               ? std::ranges::all_of(plan.lines, is_recorded)
                               : pictures == 0;
  if (is_complete) return outcome_text(plan, config, options.session);

  const auto camera = open_camera(config.camera, &clock);
  const auto slider = open_slider(config.slider, &clock);
  session->record_event("run-started", slider->description() + ", " + camera->description());
  require_room_on_card(camera->report(), pictures);
  if (!camera->keeps_pictures()) {
    require_room_on_disk(session->directory(), pictures, config);
  }
  Carriage carriage(slider.get(), &clock, limits_of(config.slider), config.slider.motion);
  carriage.home();
  session->set_exposure(camera->prepare(config.camera.exposure, session->exposure()));
  capture(plan, config, {&carriage, camera.get(), session.get(), place, &clock});
  require_frames(session.get());
  return outcome_text(plan, config, options.session);
}

}  // namespace raywalk::capture
