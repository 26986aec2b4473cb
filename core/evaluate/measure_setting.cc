#include "core/evaluate/measure_setting.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "core/base/interrupt.h"
#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/evaluate/scores.h"
#include "core/panorama/pitch_remap.h"
#include "core/view/renderer.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;

// One cv::remap of the views' size, run beside every view.
class Yardstick {
 public:
  Yardstick(int width_px, const TimeSource& time) : remap_(width_px), time_(time) {
    // As often as it takes to last a while: waking the threads would make the time of a single
    // remap of a small image uneven.
    constexpr double kLeast_s = 2e-3;
    constexpr int kMostRuns = 100;
    remap_.run();
    runs_ = std::clamp(static_cast<int>(std::ceil(kLeast_s / run_s())), 1, kMostRuns);
  }

  void run() { remap_.run(); }
  // The mean time of some runs.
  double run_s() {
    return time_([&] {
             for (int run = 0; run < runs_; ++run) remap_.run();
           }) /
           runs_;
  }

 private:
  PitchRemap remap_;
  const TimeSource& time_;
  int runs_ = 1;
};

// Sets the number of threads in use during its lifetime.
class ThreadsInUse {
 public:
  explicit ThreadsInUse(int threads) : before_(thread_count()) { set_thread_count(threads); }
  ~ThreadsInUse() { set_thread_count(before_); }
  ThreadsInUse(const ThreadsInUse&) = delete;
  ThreadsInUse& operator=(const ThreadsInUse&) = delete;

 private:
  int before_;
};

Viewpoint viewpoint_of(const TrueView& view, const TradeSetting& setting) {
  return viewpoint_for(setting.options.generation, view.viewpoint, view.height_m);
}

// {"ms", "ratio" to a remap, "remap_ms"}: medians over all runs of all views; and "remap_spread".
ordered_json times_of_views(const TradeSetting& setting, const SettingMeasurement& by,
                            Renderer* renderer) {
  RenderedView shown;
  const auto time_of = [&](const TrueView& view) {
    const ThreadsInUse threads(setting.threads);
    const Viewpoint at = viewpoint_of(view, setting);
    return by.time_source([&] { shown = renderer->render(at, std::move(shown)); });
  };
  for (const TrueView& view : by.views) time_of(view);
  Yardstick yardstick(by.views.front().image.cols, by.time_source);
  std::vector<double> view_s, remap_s, ratios;
  for (int i = 0; i < by.repetitions; ++i) {
    for (const TrueView& view : by.views) {
      throw_if_interrupted();
      if (setting.threads != thread_count()) yardstick.run();  // wakes the other threads again
      remap_s.push_back(yardstick.run_s());
      view_s.push_back(time_of(view));
      ratios.push_back(view_s.back() / remap_s.back());
    }
  }
  std::ranges::sort(remap_s);
  return {{"ms", 1e3 * median(view_s)},
          {"ratio", median(ratios)},
          {"remap_ms", 1e3 * median(remap_s)},
          {"remap_spread", remap_s[remap_s.size() * 3 / 4] / remap_s.front() - 1.0}};
}

}  // namespace

nlohmann::ordered_json measured(const TradeSetting& setting, const SettingMeasurement& by) {
  Renderer renderer(by.room, setting.options);
  ordered_json result = times_of_views(setting, by, &renderer);
  std::vector<cv::Mat> images(by.views.size());
  for (std::size_t i = 0; i < images.size(); ++i) {
    throw_if_interrupted();
    const cv::Mat image = renderer.render(viewpoint_of(by.views[i], setting)).image;
    cv::resize(image, images[i], by.views[i].image.size(), 0, 0, cv::INTER_LINEAR);
  }
  std::vector<ordered_json> scores(images.size());
  parallel_for(0, static_cast<int>(images.size()), 1, [&](int begin, int /*end*/) {
    const auto i = static_cast<std::size_t>(begin);
    scores[i] = scores_of(images[i], by.views[i].image, by.views[i].mask);
  });
  for (const auto& [key, value] : scores.front().items()) result[key] = mean_of(scores, key);
  return result;
}

}  // namespace raywalk
