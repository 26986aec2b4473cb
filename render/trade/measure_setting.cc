#include "render/trade/measure_setting.h"

#include <algorithm>
#include <map>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "core/base/interrupt.h"
#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/resident_memory.h"
#include "core/base/timing.h"

namespace raywalk::render {
namespace {

constexpr double kClockStep_s = 1.0 / CLOCKS_PER_SEC;  // resolution of std::clock

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
  renderer.render(view.viewpoint);
  measured->peak_mb = 1e-6 * (peak_resident_bytes() - before);
  measured->mapped_mb = 1e-6 * (mapped_resident_bytes() - mapped_before);
  renderer.count_bytes(true);
  const RenderedView counted = renderer.render(view.viewpoint);
  measured->touched_mb = 1e-6 * static_cast<double>(counted.report.bytes_touched);
}

void measure_times(const TradeSetting& setting, std::span<const TradeView> views, int repetitions,
                   PitchRemap* yardstick, TradeMeasurement* measured) {
  Renderers renderers(setting);
  RenderedView rendered;
  const bool switches = setting.threads != thread_count();
  const auto render = [&](const TradeView& view) {
    const ThreadsInUse threads(setting.threads);
    return times_of([&] { renderers.of(view).render(view.viewpoint, rendered); });
  };
  for (const TradeView& view : views) render(view);
  yardstick->run();
  std::vector<double> view_s, remap_s, ratios, cpu_ratios;
  for (int i = 0; i < repetitions; ++i) {
    for (const TradeView& view : views) {
      throw_if_interrupted();
      if (switches) yardstick->run();  // wakes the other threads again
      const Times remap = times_of([&] { yardstick->run(); });
      const Times rendering = render(view);
      view_s.push_back(rendering.wall_s);
      remap_s.push_back(remap.wall_s);
      ratios.push_back(rendering.wall_s / remap.wall_s);
      cpu_ratios.push_back(rendering.cpu_s / std::max(remap.cpu_s, kClockStep_s));
    }
  }
  measured->ms = 1e3 * median(view_s);
  measured->remap_ms = 1e3 * median(remap_s);
  measured->ratio = median(ratios);
  measured->cpu_ratio = median(cpu_ratios);
}

// Rendered for scoring: at the size of its truth.
cv::Mat picture(Renderer* renderer, const TradeView& view) {
  const RenderedView rendered = renderer->render(view.viewpoint);
  if (rendered.image.size() == view.truth.size()) return rendered.image;
  cv::Mat enlarged;
  cv::resize(rendered.image, enlarged, view.truth.size(), 0, 0, cv::INTER_LINEAR);
  return enlarged;
}

}  // namespace

TradeMeasurement measure_setting(const TradeSetting& setting, std::span<const TradeView> views,
                                 int repetitions, PitchRemap* yardstick) {
  TradeMeasurement measured;
  measure_memory(setting, views.front(), &measured);
  measure_times(setting, views, repetitions, yardstick, &measured);
  measured.scores = score_setting(setting, views);
  return measured;
}

ViewScores score_setting(const TradeSetting& setting, std::span<const TradeView> views) {
  Renderers renderers(setting);
  std::vector<cv::Mat> pictures;
  for (const TradeView& view : views) {
    throw_if_interrupted();
    pictures.push_back(picture(&renderers.of(view), view));
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
  return picture(&renderer, view);
}

}  // namespace raywalk::render
