// The work of `raywalk-render trade`: measures many settings of the rendering parameters against
// ground truth and finds the Pareto front of time and accuracy.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/evaluate/measured_settings.h"
#include "core/room/room.h"
#include "core/view/gpu/gpu_device.h"
#include "core/view/view_options.h"

namespace raywalk {

// A preset for the room.
struct NamedOptions {
  std::string name{};
  std::string reason{};  // explanation for the user
  ViewOptions options{};
};

struct TradeOptions {
  std::filesystem::path truth{};   // gt.csv, views of one width
  bool match_exposure = false;     // of views to these truths (exposed_as)
  int held_out = 0;                // instead of it: every n-th station is held out as a true view
  std::filesystem::path report{};  // directory, created if it is missing
  int repetitions = 3;             // of every view
  // The central setting of every method that the room can be rendered in: the sweep varies it.
  std::vector<ViewOptions> centres{};
  std::vector<NamedOptions> presets{};  // measured beside the sweep, at the width of the truths
  // Where it finds a graphics card, the settings are measured on it too.
  Device device = Device::kCpu;
  double gpu_mb = kUsualGpu_mb;
  TimeSource time_source = wall_time_s;
};

// Reads the truths, checks that the report can be written, and measures every setting: the time of
// every view after a warm-up, each beside one of cv::remap; then, so that scoring does not disturb
// the times, the scores. An image smaller than its truth is enlarged before it is scored; its time
// does not include that. The number of threads in use (core/base/parallel.h) is changed while views
// are timed.
//
// Writes `report`/trade.json (docs/file-formats.md lists its keys), trade.csv and index.html, each
// atomically, and the room's measured settings, by which views are chosen. A stopped run leaves
// what it measured in `report`/trade.partial, and the same call resumes it. Returns a summary for
// the user. Throws Error before any rendering where the input is wrong or the report cannot be
// written; Interrupted.
std::string trade(const Room& room, const TradeOptions& options);

}  // namespace raywalk
