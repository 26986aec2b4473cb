#include "core/judge/trade/measure_setting.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "core/base/interrupt.h"
#include "core/base/parallel.h"
#include "core/base/resident_memory.h"

namespace raywalk {
namespace {

// The yardstick is run as often as it takes to last this long: waking the threads would make the
// time of a single remap of a small picture uneven.
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

// One renderer for each room of the views.
class Renderers {
 public:
  explicit Renderers(const TradeSetting& setting) : options_(setting.mode.options) {}

  Renderer& of(const TradeView& view) {
    std::unique_ptr<Renderer>& renderer = renderers_[view.room];
    if (!renderer) renderer = std::make_unique<Renderer>(*view.room, options_);
    return *renderer;
  }

 private:
  ViewOptions options_;
  std::map<const Room*, std::unique_ptr<Renderer>> renderers_;
};

void measure_memory(const TradeSetting& setting, const TradeView& view,
                    TradeMeasurement* measured) {
  // A newly opened room has no pages mapped.
  const Room room = Room::open(view.room->directory());
  Renderer renderer(room, setting.mode.options);
  release_free_memory();
  reset_peak_resident();
  const double before = resident_bytes();
  const double mapped_before = mapped_resident_bytes();
  renderer.render(viewpoint_of(view, setting.mode.options));
  measured->peak_mb = 1e-6 * (peak_resident_bytes() - before);
  measured->mapped_mb = 1e-6 * (mapped_resident_bytes() - mapped_before);
}

int yardstick_runs(const ViewTimer& timer) {
  const double once_s = timer.source.times([&] { timer.yardstick->run(); }).wall_s;
  return std::clamp(static_cast<int>(std::ceil(kLeastYardstick_s / once_s)), 1, kMostYardstickRuns);
}

// The mean of `runs` runs.
Times time_of_yardstick(const ViewTimer& timer, int runs) {
  const Times all = timer.source.times([&] {
    for (int run = 0; run < runs; ++run) timer.yardstick->run();
  });
  return {all.wall_s / runs, all.cpu_s / runs};
}

// Rendered for scoring: at the size of its truth.
cv::Mat picture(Renderer* renderer, const TradeView& view, const ViewOptions& options) {
  const RenderedView rendered = renderer->render(viewpoint_of(view, options));
  if (rendered.image.size() == view.truth.size()) return rendered.image;
  cv::Mat enlarged;
  cv::resize(rendered.image, enlarged, view.truth.size(), 0, 0, cv::INTER_LINEAR);
  return enlarged;
}

}  // namespace

TradeMeasurement measure_setting(const TradeSetting& setting, std::span<const TradeView> views,
                                 const ViewTimer& timer) {
  TradeMeasurement measured;
  measure_memory(setting, views.front(), &measured);
  measured.time = measure_time(setting, views, timer);
  measured.scores = score_setting(setting, views);
  return measured;
}

ViewTime measure_time(const TradeSetting& setting, std::span<const TradeView> views,
                      const ViewTimer& timer) {
  Renderers renderers(setting);
  RenderedView shown;
  const bool switches = setting.threads != thread_count();
  const auto time_of_view = [&](const TradeView& view) {
    const ThreadsInUse threads(setting.threads);
    const Viewpoint at = viewpoint_of(view, setting.mode.options);
    return timer.source.times([&] { shown = renderers.of(view).render(at, std::move(shown)); });
  };
  for (const TradeView& view : views) time_of_view(view);
  timer.yardstick->run();
  const int runs = yardstick_runs(timer);
  const ProcessorUse before = timer.source.processor_use();
  std::vector<TimedPair> pairs;
  for (int i = 0; i < timer.repetitions; ++i) {
    for (const TradeView& view : views) {
      throw_if_interrupted();
      if (switches) timer.yardstick->run();  // wakes the other threads again
      const Times remap = time_of_yardstick(timer, runs);
      pairs.push_back({remap, time_of_view(view)});
    }
  }
  return view_time_of(pairs, share_of_others(before, timer.source.processor_use()));
}

ViewScores score_setting(const TradeSetting& setting, std::span<const TradeView> views) {
  Renderers renderers(setting);
  std::vector<cv::Mat> pictures;
  for (const TradeView& view : views) {
    throw_if_interrupted();
    pictures.push_back(picture(&renderers.of(view), view, setting.mode.options));
  }
  std::vector<ViewScores> scores(views.size());
  parallel_for(0, static_cast<int>(views.size()), 1, [&](int begin, int /*end*/) {
    const auto i = static_cast<std::size_t>(begin);
    scores[i] = score_view(pictures[i], views[i].truth, views[i].mask);
  });
  return mean_of(scores);
}

cv::Mat picture_of(const TradeSetting& setting, const TradeView& view) {
  Renderer renderer(*view.room, setting.mode.options);
  return picture(&renderer, view, setting.mode.options);
}

}  // namespace raywalk
