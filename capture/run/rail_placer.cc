#include "capture/run/rail_placer.h"

#include <fmt/format.h>
#include <httplib.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "capture/base/http_url.h"
#include "core/base/error.h"
#include "core/base/interrupt.h"

namespace raywalk::capture {
namespace {

constexpr int kPollStdin_ms = 100;

std::string point_text(const PlanPoint& point) {
  return fmt::format("x = {:+.3f} m, z = {:+.3f} m", point.x_m, point.z_m);
}

// Waits for the end of a line on standard input. Reads without the C library's buffer, because poll
// sees only what has not been read from the descriptor.
void wait_for_enter() {
  for (;;) {
    pollfd descriptor = {STDIN_FILENO, POLLIN, 0};
    const int ready = poll(&descriptor, 1, kPollStdin_ms);
    throw_if_interrupted();
    if (ready <= 0) continue;
    char typed = 0;
    if (read(STDIN_FILENO, &typed, 1) != 1) {
      throw Error(
          "cannot ask for the rail to be placed (end of standard input); start from a terminal, or "
          "use --yes for a rig that places its own rail");
    }
    if (typed == '\n') return;
  }
}

class OperatorPlacer final : public RailPlacer {
 public:
  void place(const CaptureLine& line, int number, int count) override {
    // A question belongs to the terminal, also where --quiet silences standard output.
    fmt::print(stderr, "{}\nThen press Enter (Ctrl-C stops here; the same command resumes later). ",
               placement_text(line, number, count));
    std::fflush(stderr);
    wait_for_enter();
  }
};

class PlacedAlready final : public RailPlacer {
 public:
  void place(const CaptureLine& line, int number, int count) override {
    spdlog::info("{}", placement_text(line, number, count));
  }
};

class UrlPlacer final : public RailPlacer {
 public:
  UrlPlacer(std::string url, double timeout_ms) : url_(std::move(url)), timeout_ms_(timeout_ms) {}

  void place(const CaptureLine& line, int number, int count) override {
    spdlog::info("{}", placement_text(line, number, count));
    const HttpUrl url = split_url(url_);
    httplib::Client client(url.server);
    const auto timeout = std::chrono::milliseconds(static_cast<std::int64_t>(timeout_ms_));
    client.set_connection_timeout(timeout);
    client.set_read_timeout(timeout);
    const PlanPoint start = line.stations.front().position_m;
    const PlanPoint end = line.stations.back().position_m;
    const nlohmann::json request = {{"line", line.id},
                                    {"placement", line.placement},
                                    {"start_m", {start.x_m, start.z_m}},
                                    {"end_m", {end.x_m, end.z_m}}};
    const httplib::Result reply = client.Post(url.path, request.dump(), "application/json");
    if (!reply) {
      throw Error(
          fmt::format("{}: no answer to the request to place the rail ({}); check that "
                      "the rig is on, or raise run.place_timeout_ms",
                      url_, httplib::to_string(reply.error())));
    }
    if (reply->status != 200) {
      throw Error(fmt::format("{}: the rig refused to place the rail at line {}: HTTP {} {}", url_,
                              line.id, reply->status, excerpt(reply->body)));
    }
  }

 private:
  std::string url_;
  double timeout_ms_;
};

}  // namespace

std::string placement_text(const CaptureLine& line, int number, int count) {
  const CaptureStation& first = line.stations.front();
  const CaptureStation& last = line.stations.back();
  return fmt::format(
      "Line {} ({} of {}), stations {} to {}: place the rail along {}. Its position {:.1f} mm "
      "belongs at {}; it runs "
      "towards +{} to {} at {:.1f} mm.",
      line.id, number, count, first.name, last.name, name_of(line.axis), first.rail_mm,
      point_text(first.position_m), name_of(line.axis), point_text(last.position_m), last.rail_mm);
}

std::unique_ptr<RailPlacer> make_rail_placer(const RunConfig& config, bool yes) {
  if (!config.place_url.empty()) {
    return std::make_unique<UrlPlacer>(config.place_url, config.place_timeout_ms);
  }
  if (yes) return std::make_unique<PlacedAlready>();
  return std::make_unique<OperatorPlacer>();
}

}  // namespace raywalk::capture
