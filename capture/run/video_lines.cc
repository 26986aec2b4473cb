#include "capture/run/video_lines.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "core/base/interrupt.h"

namespace raywalk::capture {
namespace {

constexpr double kStep_ms = 20.0;  // between checks for an interrupt

void wait(Clock* clock, double ms) {
  const SteadyTime end = clock->now() + duration_from_ms(ms);
  while (clock->now() < end) {
    throw_if_interrupted();
    clock->sleep(std::min<Duration>(duration_from_ms(kStep_ms), end - clock->now()));
  }
}

// Stops the video on every path, so that no camera is left recording.
class Video {
 public:
  explicit Video(Camera* camera) : camera_(camera) { camera_->start_video(); }
  ~Video() {
    if (camera_ == nullptr) return;
    try {
      camera_->stop_video();
    } catch (const std::exception& error) {
      spdlog::warn("the camera may still be recording: {}", error.what());
    }
  }
  Video(const Video&) = delete;
  Video& operator=(const Video&) = delete;

  void stop() {
    Camera* camera = camera_;
    camera_ = nullptr;
    camera->stop_video();
  }

 private:
  Camera* camera_;
};

// Records the feedback of one pass while in scope.
class Journal {
 public:
  explicit Journal(Carriage* carriage) : carriage_(carriage) {
    carriage_->watch([this](WallTime time, double mm) { samples_.push_back({time, mm}); });
  }
  ~Journal() { carriage_->watch({}); }
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  const std::vector<JournalSample>& samples() const { return samples_; }

 private:
  Carriage* carriage_;
  std::vector<JournalSample> samples_;
};

void record_line(const CaptureLine& line, const CaptureParts& parts, const VideoRules& rules) {
  Carriage& carriage = *parts.carriage;
  const SoftLimits& limits = carriage.limits();
  const double first_mm = line.stations.front().rail_mm - rules.approach_mm;
  const double last_mm = line.stations.back().rail_mm + rules.approach_mm;
  const SafePosition start = limits.require(std::max(limits.low_mm(), first_mm), "start");
  const SafePosition end = limits.require(std::min(limits.high_mm(), last_mm), "end");
  carriage.move_to(start);
  Video video(parts.camera);
  wait(parts.clock, rules.still_ms);
  const Journal journal(&carriage);
  carriage.move_to(end, rules.profile);
  wait(parts.clock, rules.still_ms);
  video.stop();
  parts.session->record_journal(line.id, journal.samples());
}

std::size_t count_recorded(const CapturePlan& plan, const Session& session) {
  return static_cast<std::size_t>(
      std::count_if(plan.lines.begin(), plan.lines.end(),
                    [&](const CaptureLine& line) { return session.has_journal(line.id); }));
}

}  // namespace

void record_lines(const CapturePlan& plan, const CaptureParts& parts, const VideoRules& rules) {
  WorkState state;
  state.done = [&] {
    return fmt::format("{} of {} lines recorded", count_recorded(plan, *parts.session),
                       plan.lines.size());
  };
  const int count = static_cast<int>(plan.lines.size());
  pause_on_error(parts.session, state, [&] {
    for (int i = 0; i < count; ++i) {
      const CaptureLine& line = plan.lines[i];
      if (parts.session->has_journal(line.id)) continue;
      state.place = "line " + line.id;
      parts.place_rail(line, i + 1, count);
      parts.session->record_event("line-placed", line.id);
      record_line(line, parts, rules);
      spdlog::info("line {} is recorded", line.id);
    }
  });
  parts.session->record_event("finished", state.done());
}

}  // namespace raywalk::capture
