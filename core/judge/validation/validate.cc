#include "core/judge/validation/validate.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/json_text.h"
#include "core/judge/validation/before_after.h"
#include "core/judge/validation/connect_error_file.h"
#include "core/judge/validation/metrics_json.h"
#include "core/judge/validation/validation_partial.h"
#include "core/judge/validation/validation_report.h"
#include "core/room/connection_errors.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxSamples = 3;
constexpr int kPageWidth_px = 720;  // of a picture on the page: sharp at half the page's width

ViewOptions options_at(const ViewMode& mode, int width) {
  ViewOptions options = mode.options;
  options.width = width;
  return options;
}

std::vector<std::unique_ptr<Renderer>> renderers_of(const Room& room,
                                                    std::span<const ViewMode> modes, int width) {
  std::vector<std::unique_ptr<Renderer>> renderers;
  for (const ViewMode& mode : modes) {
    renderers.push_back(std::make_unique<Renderer>(room, options_at(mode, width)));
  }
  return renderers;
}

// Position of a truth among the report's samples; none if it is not shown.
PictureSample* sample_of(Validation& validation, std::size_t truth) {
  const auto found = std::find_if(validation.samples.begin(), validation.samples.end(),
                                  [&](const PictureSample& s) { return s.truth == truth; });
  return found == validation.samples.end() ? nullptr : &*found;
}

void prepare_report(const fs::path& report) {
  make_directories(report);
  const AtomicFile json_probe(report / "metrics.json");
  const AtomicFile page_probe(report / "index.html");
}

bool measured_alike(const ConnectError& stored, const ConnectErrorOptions& options) {
  return stored.options.viewpoints == options.viewpoints &&
         stored.options.overlap_deg == options.overlap_deg &&
         stored.options.k_list_deg == options.k_list_deg && !std::isnan(stored.common_share);
}

// The measurement of a generation with these options stored in a directory; none if it has none.
std::optional<ConnectError> stored_error(const fs::path& directory, Generation generation,
                                         const ConnectErrorOptions& options) {
  for (const ConnectError& error : read_connect_error(directory)) {
    if (error.generation == generation && measured_alike(error, options)) return error;
  }
  return std::nullopt;
}

// What an interrupted run left; none if it is missing or damaged.
std::optional<ConnectError> kept_error(const fs::path& directory, Generation generation,
                                       const ConnectErrorOptions& options) {
  try {
    return stored_error(directory, generation, options);
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::string summary_of(const Validation& validation, const std::optional<BeforeAfter>& compared,
                       const fs::path& report) {
  std::string text;
  for (std::size_t mode = 0; mode < validation.modes.size(); ++mode) {
    if (validation.views.empty()) break;
    const ViewScores mean = mean_scores(validation, mode);
    text += fmt::format("{:<10} PSNR {:6.2f} dB  WS-PSNR {:6.2f} dB  SSIM {:.4f}  FSIM {:.4f}\n",
                        generation_name(validation.modes[mode].options.generation), mean.psnr_db,
                        mean.ws_psnr_db, mean.ssim, mean.fsim);
  }
  const int widest_px = widest_truth_px(validation);
  if (widest_px > validation.captured_width_px) {
    text +=
        fmt::format("views up to {} pixels wide are enlarged {:.1f} times from panoramas of {}\n",
                    widest_px, enlargement_at(validation, widest_px), validation.captured_width_px);
  }
  if (compared) text += before_after_text(*compared);
  return text + "distances in use: " + validation.distances + "\n" +
         escaped((report / "index.html").string());
}

// The views of an earlier run, truth by truth, within it mode by mode, and their keys.
struct KeptViews {
  std::vector<std::string> keys{};
  std::vector<std::optional<MeasuredView>> views{};  // none where it has to be measured
};

KeptViews kept_views(Validation& validation, std::span<const TruthView> truths,
                     std::span<const ViewMode> modes, const ValidationPartial& partial) {
  KeptViews kept;
  for (std::size_t t = 0; t < truths.size(); ++t) {
    const bool shown = sample_of(validation, t) != nullptr;
    const std::string truth_key = partial.key_of(truths[t], shown);
    for (const ViewMode& mode : modes) {
      kept.keys.push_back(ValidationPartial::key_of(truth_key, options_at(mode, truths[t].width)));
      kept.views.push_back(partial.find(kept.keys.back()));
    }
  }
  const auto found =
      std::ranges::count_if(kept.views, [](const auto& view) { return view.has_value(); });
  if (found > 0) {
    spdlog::info("{} of {} views are kept from an interrupted run", found, kept.views.size());
  }
  return kept;
}

// Renders and scores the views of one truth after another.
class ViewRun {
 public:
  ViewRun(const Room& room, std::span<const ViewMode> modes) : room_(room), modes_(modes) {}

  void begin(const TruthView& view) {
    view_ = &view;
    truth_.release();
    mask_.release();
  }

  // The truth's picture, read when it is first needed.
  const cv::Mat& truth() {
    if (truth_.empty()) {
      truth_ = read_panorama(view_->file);
      if (!view_->mask.empty()) mask_ = read_mask(view_->mask, {truth_.cols, truth_.rows});
    }
    return truth_;
  }

  MeasuredView measured(std::size_t mode, bool shown) {
    if (truth().cols != width_) renderers_ = renderers_of(room_, modes_, width_ = truth_.cols);
    const RenderedView view = renderers_[mode]->render(
        viewpoint_for(modes_[mode].options.generation, view_->viewpoint, view_->height_m));
    MeasuredView result{
        .report = view.report,
        .scores = score_view(view.image, truth_, mask_),
        .quarters = score_quarters(room_.grid(), view_->viewpoint, view.image, truth_, mask_)};
    if (shown) {
      result.pictures =
          compare(view.image, truth_completed_by(view.image, truth_, mask_), kPageWidth_px);
    }
    return result;
  }

 private:
  const Room& room_;
  std::span<const ViewMode> modes_;
  const TruthView* view_ = nullptr;
  cv::Mat truth_, mask_;
  int width_ = 0;  // that the renderers are made for
  std::vector<std::unique_ptr<Renderer>> renderers_;
};

// What is to be measured of a room.
struct RoomTask {
  const Room& room;
  std::vector<ViewMode> modes{};
  std::vector<TruthView> truths{};
};

// Throws where it cannot be measured.
RoomTask checked_task(const Room& room, std::vector<ViewMode> modes,
                      const ValidateOptions& options) {
  RoomTask task{room, std::move(modes)};
  if (!options.truth.empty()) task.truths = read_truth(options.truth, room);
  renderers_of(room, task.modes,
               task.truths.empty() ? room.panorama().width : task.truths.front().width);
  if (!room.grid().cells.empty()) {
    require_connect_error_options(options.connect);
  } else if (task.truths.empty()) {
    throw Error(room.directory().string() +
                ": has no cell, so that no lines connect; give true views with --truth");
  }
  return task;
}

// Of these, the modes that a room can be rendered in.
std::vector<ViewMode> modes_for(const Room& room, std::vector<ViewMode> modes) {
  if (room.has_distances()) return modes;
  std::erase_if(
      modes, [](const ViewMode& mode) { return mode.options.generation != Generation::kInitial; });
  if (!modes.empty()) return modes;
  throw Error(room.directory().string() +
              ": has no distances, so that only initial views can be compared; ask for them with "
              "--generation initial, or run raywalk-build-lf depth on it");
}

// Renders and measures all that is not kept from an earlier run.
Validation measured_validation(const RoomTask& task, const ConnectErrorOptions& options,
                               const ValidationPartial& partial) {
  try {
    Validation validation = validate_views(task.room, task.truths, task.modes, partial);
    validation.connection_error =
        connection_errors(task.room, task.modes, options, partial.connection_errors());
    return validation;
  } catch (const Interrupted&) {
    throw Interrupted("interrupted; the same command resumes with the remaining views");
  }
}

}  // namespace

Validation validate_views(const Room& room, std::vector<TruthView> truths,
                          std::vector<ViewMode> modes, const ValidationPartial& partial) {
  Validation validation;
  validation.volume = room.directory().string();
  validation.captured_width_px = room.panorama().width;
  validation.distances = room.distances_origin();
  for (const std::size_t truth : spread_over_distance(truths, kMaxSamples)) {
    validation.samples.push_back({.truth = truth});
  }
  KeptViews kept = kept_views(validation, truths, modes, partial);
  Progress progress(
      "validating",
      std::ranges::count_if(kept.views, [](const auto& view) { return !view.has_value(); }),
      "views");
  ViewRun run(room, modes);
  for (std::size_t t = 0; t < truths.size(); ++t) {
    PictureSample* sample = sample_of(validation, t);
    run.begin(truths[t]);
    if (sample != nullptr) sample->truth_picture = shrunk_to(run.truth(), kPageWidth_px);
    for (std::size_t m = 0; m < modes.size(); ++m) {
      throw_if_interrupted();
      const std::size_t index = t * modes.size() + m;
      std::optional<MeasuredView>& view = kept.views[index];
      if (!view) {
        view = run.measured(m, sample != nullptr);
        partial.keep(kept.keys[index], *view);
        progress.advance();
      }
      validation.views.push_back({t, m, view->report, view->scores, view->quarters});
      if (sample != nullptr) sample->by_mode.push_back(view->pictures.value());
    }
  }
  validation.truths = std::move(truths);
  validation.modes = std::move(modes);
  return validation;
}

std::vector<ConnectError> connection_errors(const Room& room, std::span<const ViewMode> modes,
                                            const ConnectErrorOptions& options,
                                            const std::optional<fs::path>& kept_in) {
  if (room.grid().cells.empty()) return {};
  std::vector<ConnectError> errors;
  for (const ViewMode& mode : modes) {
    const Generation generation = mode.options.generation;
    auto found = stored_error(room.directory(), generation, options);
    if (!found && kept_in) found = kept_error(*kept_in, generation, options);
    if (!found) {
      found = measure_connect_error(room, generation, options);
      if (kept_in) store_connect_error(*kept_in, *found);
    }
    errors.push_back(*std::move(found));
  }
  return errors;
}

int widest_truth_px(const Validation& validation) {
  int widest_px = 0;
  for (const TruthView& truth : validation.truths) widest_px = std::max(widest_px, truth.width);
  return widest_px;
}

double enlargement_at(const Validation& validation, int width_px) {
  return static_cast<double>(width_px) / validation.captured_width_px;
}

ViewScores mean_scores(const Validation& validation, std::size_t mode) {
  std::vector<ViewScores> scores;
  for (const ValidatedView& view : validation.views) {
    if (view.mode == mode) scores.push_back(view.scores);
  }
  return mean_of(scores);
}

std::string validate(const Room& room, const ValidateOptions& options) {
  if (options.truth.empty() && options.before.empty()) {
    throw UsageError("give true views with --truth, or another room with --before");
  }
  const RoomTask task = checked_task(room, options.modes, options);
  std::optional<Room> room_before;
  std::optional<RoomTask> task_before;
  if (!options.before.empty()) {
    room_before = Room::open(options.before);
    task_before.emplace(
        checked_task(*room_before, modes_for(*room_before, options.modes), options));
  }
  prepare_report(options.report);
  ValidationPartial partial(options.report, room);
  const Validation validation = measured_validation(task, options.connect, partial);
  std::optional<BeforeAfter> compared;
  if (task_before) {
    const ValidationPartial partial_before(partial, *room_before);
    compared = compare_rooms(measured_validation(*task_before, options.connect, partial_before),
                             validation);
  }
  const nlohmann::ordered_json document = metrics_document(validation, compared);
  write_file_atomically(options.report / "metrics.json", json_text(document));
  write_file_atomically(options.report / "index.html",
                        validation_report(document, validation.samples));
  partial.complete();
  return summary_of(validation, compared, options.report);
}

}  // namespace raywalk
