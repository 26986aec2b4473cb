#include "core/evaluate/trade/measure_setting.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/interrupt.h"
#include "core/base/parallel.h"
#include "core/view/renderer.h"

namespace raywalk {
namespace {

// The yardstick is run as often as it takes to last this long: waking the threads would make the
// time of a single remap of a small image uneven.
constexpr double kLeastYardstick_s = 2e-3;
constexpr int kMostYardstickRuns = 100;

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

Viewpoint viewpoint_of(const TradeView& view, const ViewOptions& options) {
  return viewpoint_for(options.generation, view.viewpoint, view.height_m);
}

// The mean of `runs` runs.
double yardstick_s(const ViewTimer& timer, int runs) {
  const double all_s = timer.source([&] {
    for (int run = 0; run < runs; ++run) timer.yardstick->run();
  });
  return all_s / runs;
}

int yardstick_runs(const ViewTimer& timer) {
  return std::clamp(static_cast<int>(std::ceil(kLeastYardstick_s / yardstick_s(timer, 1))), 1,
                    kMostYardstickRuns);
}

ViewTime time_of_views(const TradeSetting& setting, std::span<const TradeView> views,
                       const ViewTimer& timer, Renderer* renderer) {
  RenderedView shown;
  const bool switches = setting.threads != thread_count();
  const auto time_of_view = [&](const TradeView& view) {
    const ThreadsInUse threads(setting.threads);
    const Viewpoint at = viewpoint_of(view, setting.mode.options);
    return timer.source([&] { shown = renderer->render(at, std::move(shown)); });
  };
  for (const TradeView& view : views) time_of_view(view);
  timer.yardstick->run();
  const int runs = yardstick_runs(timer);
  std::vector<TimedPair> pairs;
  for (int i = 0; i < timer.repetitions; ++i) {
    for (const TradeView& view : views) {
      throw_if_interrupted();
      if (switches) timer.yardstick->run();  // wakes the other threads again
      const double remap_s = yardstick_s(timer, runs);
      pairs.push_back({remap_s, time_of_view(view)});
    }
  }
  return view_time_of(pairs);
}

// At the size of its truth.
cv::Mat image(Renderer* renderer, const TradeView& view, const ViewOptions& options) {
  const RenderedView rendered = renderer->render(viewpoint_of(view, options));
  if (rendered.image.size() == view.truth.size()) return rendered.image;
  cv::Mat enlarged;
  cv::resize(rendered.image, enlarged, view.truth.size(), 0, 0, cv::INTER_LINEAR);
  return enlarged;
}

}  // namespace

TradeMeasurement measure_setting(const TradeSetting& setting, std::span<const TradeView> views,
                                 const ViewTimer& timer) {
  Renderer renderer(*views.front().room, setting.mode.options);
  TradeMeasurement measured{.time = time_of_views(setting, views, timer, &renderer)};
  std::vector<cv::Mat> images;
  for (const TradeView& view : views) {
    throw_if_interrupted();
    images.push_back(image(&renderer, view, setting.mode.options));
  }
  std::vector<ViewScores> scores(views.size());
  parallel_for(0, static_cast<int>(views.size()), 1, [&](int begin, int /*end*/) {
    const auto i = static_cast<std::size_t>(begin);
    scores[i] = score_view(images[i], views[i].truth, views[i].mask);
  });
  measured.scores = mean_of(scores);
  return measured;
}

cv::Mat image_of(const TradeSetting& setting, const TradeView& view) {
  Renderer renderer(*view.room, setting.mode.options);
  return image(&renderer, view, setting.mode.options);
}

}  // namespace raywalk
