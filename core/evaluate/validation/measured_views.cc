#include "core/evaluate/validation/measured_views.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <optional>
#include <string>

#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "core/files/image_file.h"

namespace raywalk {
namespace {

constexpr std::size_t kMaxSamples = 3;

ViewOptions options_at(const ViewMode& mode, int width) {
  ViewOptions options = mode.options;
  options.width = width;
  return options;
}

bool contains(std::span<const std::size_t> indices, std::size_t index) {
  return std::ranges::find(indices, index) != indices.end();
}

// The views of an earlier run and their keys.
struct KeptViews {
  std::vector<std::string> keys{};
  std::vector<std::optional<MeasuredView>> views{};  // none where it has to be measured
};

KeptViews kept_views(std::span<const TruthView> truths, std::span<const ViewMode> modes,
                     std::span<const std::size_t> shown, const ValidationPartial& partial) {
  KeptViews kept;
  for (std::size_t truth = 0; truth < truths.size(); ++truth) {
    const std::string truth_key = partial.key_of(truths[truth], contains(shown, truth));
    for (const ViewMode& mode : modes) {
      kept.keys.push_back(
          ValidationPartial::key_of(truth_key, options_at(mode, truths[truth].width)));
      kept.views.push_back(partial.find(kept.keys.back()));
    }
  }
  return kept;
}

// Renders and scores the views of one truth after another.
class ViewRun {
 public:
  ViewRun(const Room& room, std::span<const ViewMode> modes) : room_(room), modes_(modes) {}

  MeasuredView measured(const TruthView& view, std::size_t mode, bool shown) {
    begin(view);
    if (truth_.cols != width_) renderers_ = renderers_of(room_, modes_, width_ = truth_.cols);
    const RenderedView rendered = renderers_[mode]->render(
        viewpoint_for(modes_[mode].options.generation, view.viewpoint, view.height_m));
    MeasuredView result{
        .report = rendered.report,
        .scores = score_view(rendered.image, truth_, mask_),
        .silhouettes = distances_.empty()
                           ? SilhouetteScores{}
                           : score_silhouettes(rendered.image, truth_, distances_, mask_),
        .quarters = score_quarters(room_.grid(), view.viewpoint, rendered.image, truth_, mask_)};
    if (shown) {
      result.pictures =
          compare(rendered.image, truth_completed_by(rendered.image, truth_, mask_), kPageWidth_px);
    }
    return result;
  }

 private:
  // Reads the truth's picture, unless it is that of the view before.
  void begin(const TruthView& view) {
    if (view_ == &view) return;
    view_ = &view;
    truth_ = read_panorama(view.file);
    mask_ = view.mask.empty() ? cv::Mat() : read_mask(view.mask, {truth_.cols, truth_.rows});
    distances_ = read_true_distances(view);
  }

  const Room& room_;
  std::span<const ViewMode> modes_;
  const TruthView* view_ = nullptr;
  cv::Mat truth_, mask_, distances_;
  int width_ = 0;  // that the renderers are made for
  std::vector<std::unique_ptr<Renderer>> renderers_;
};

}  // namespace

std::vector<std::size_t> shown_truths(std::span<const TruthView> truths) {
  return spread_over_distance(truths, kMaxSamples);
}

std::vector<std::unique_ptr<Renderer>> renderers_of(const Room& room,
                                                    std::span<const ViewMode> modes, int width) {
  std::vector<std::unique_ptr<Renderer>> renderers;
  for (const ViewMode& mode : modes) {
    renderers.push_back(std::make_unique<Renderer>(room, options_at(mode, width)));
  }
  return renderers;
}

std::vector<MeasuredView> measured_views(const Room& room, std::span<const TruthView> truths,
                                         std::span<const ViewMode> modes,
                                         const ValidationPartial& partial) {
  const std::vector<std::size_t> shown = shown_truths(truths);
  KeptViews kept = kept_views(truths, modes, shown, partial);
  const auto found =
      std::ranges::count_if(kept.views, [](const auto& view) { return view.has_value(); });
  const auto total = std::ssize(kept.views);
  if (found > 0) spdlog::info("{} of {} views are kept from earlier runs", found, total);
  Progress progress("validating", total - found, "views");
  ViewRun run(room, modes);
  std::vector<MeasuredView> views;
  for (std::size_t i = 0; i < kept.views.size(); ++i) {
    throw_if_interrupted();
    std::optional<MeasuredView>& view = kept.views[i];
    if (!view) {
      const std::size_t truth = i / modes.size();
      view = run.measured(truths[truth], i % modes.size(), contains(shown, truth));
      partial.keep(kept.keys[i], *view);
      progress.advance();
    }
    views.push_back(*std::move(view));
  }
  return views;
}

}  // namespace raywalk
