#include "capture/run/place_rail.h"

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

void request_placement(const RunConfig& config, const CaptureLine& line) {
  const HttpUrl url = split_url(config.place_url);
  httplib::Client client(url.server);
  const auto timeout =
      std::chrono::milliseconds(static_cast<std::int64_t>(config.place_timeout_ms));
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
                    config.place_url, httplib::to_string(reply.error())));
  }
  if (reply->status != 200) {
    throw Error(fmt::format("{}: the rig refused to place the rail at line {}: HTTP {} {}",
                            config.place_url, line.id, reply->status, excerpt(reply->body)));
  }
}

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

void place_rail(const RunConfig& config, bool yes, const CaptureLine& line, int number, int count) {
  const std::string text = placement_text(line, number, count);
  if (config.place_url.empty() && !yes) {
    // A question belongs to the terminal, also where --quiet silences standard output.
    fmt::print(stderr, "{}\nThen press Enter (Ctrl-C stops here; the same command resumes later). ",
               text);
    std::fflush(stderr);
    wait_for_enter();
    return;
  }
  spdlog::info("{}", text);
  if (!config.place_url.empty()) request_placement(config, line);
}

}  // namespace raywalk::capture
