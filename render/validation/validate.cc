#include "render/validation/validate.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "render/validation/connect_error_file.h"
#include "render/validation/metrics_json.h"
#include "render/validation/validation_report.h"

namespace raywalk::render {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxSamples = 3;
constexpr int kPageWidth_px = 720;  // of a picture on the page: sharp at half the page's width

std::vector<std::unique_ptr<Renderer>> renderers_of(const Room& room,
                                                    std::span<const ViewMode> modes, int width) {
  std::vector<std::unique_ptr<Renderer>> renderers;
  for (const ViewMode& mode : modes) {
    ViewOptions options = mode.options;
    options.width = width;
    renderers.push_back(std::make_unique<Renderer>(room, options));
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

bool measured_alike(const ConnectErrorOptions& a, const ConnectErrorOptions& b) {
  return a.viewpoints == b.viewpoints && a.overlap_deg == b.overlap_deg &&
         a.k_list_deg == b.k_list_deg;
}

std::string summary_of(const Validation& validation, const fs::path& report) {
  std::string text;
  for (std::size_t mode = 0; mode < validation.modes.size(); ++mode) {
    const ViewScores mean = mean_scores(validation, mode);
    text += fmt::format("{:<10} PSNR {:6.2f} dB  WS-PSNR {:6.2f} dB  SSIM {:.4f}  FSIM {:.4f}\n",
                        generation_name(validation.modes[mode].options.generation), mean.psnr_db,
                        mean.ws_psnr_db, mean.ssim, mean.fsim);
  }
  return text + escaped((report / "index.html").string());
}

}  // namespace

Validation validate_views(const Room& room, std::vector<TruthView> truths,
                          std::vector<ViewMode> modes) {
  Validation validation;
  validation.volume = room.directory().string();
  validation.has_distances = room.has_distances();
  for (const std::size_t truth : spread_over_distance(truths, kMaxSamples)) {
    validation.samples.push_back({.truth = truth});
  }
  Progress progress("validating", static_cast<std::int64_t>(truths.size() * modes.size()), "views");
  std::vector<std::unique_ptr<Renderer>> renderers;
  int width = 0;
  for (std::size_t t = 0; t < truths.size(); ++t) {
    const cv::Mat truth = read_panorama(truths[t].file);
    const cv::Mat mask =
        truths[t].mask.empty() ? cv::Mat() : read_mask(truths[t].mask, {truth.cols, truth.rows});
    if (truth.cols != width) renderers = renderers_of(room, modes, width = truth.cols);
    PictureSample* sample = sample_of(validation, t);
    if (sample != nullptr) sample->truth_picture = shrunk_to(truth, kPageWidth_px);
    for (std::size_t m = 0; m < modes.size(); ++m) {
      throw_if_interrupted();
      const RenderedView view = renderers[m]->render(truths[t].viewpoint);
      validation.views.push_back(
          {t, m, view.report, score_view(view.image, truth, mask),
           score_quarters(room.grid(), truths[t].viewpoint, view.image, truth, mask)});
      if (sample != nullptr) {
        sample->by_mode.push_back(
            compare(view.image, truth_completed_by(view.image, truth, mask), kPageWidth_px));
      }
      progress.advance();
    }
  }
  validation.truths = std::move(truths);
  validation.modes = std::move(modes);
  return validation;
}

std::vector<ConnectError> connection_errors(const Room& room, std::span<const ViewMode> modes,
                                            const ConnectErrorOptions& options) {
  if (room.grid().cells.empty()) return {};
  const std::vector<ConnectError> stored = read_connect_error(room.directory());
  std::vector<ConnectError> errors;
  for (const ViewMode& mode : modes) {
    const auto found = std::find_if(stored.begin(), stored.end(), [&](const ConnectError& error) {
      return error.generation == mode.options.generation && measured_alike(error.options, options);
    });
    errors.push_back(found != stored.end()
                         ? *found
                         : measure_connect_error(room, mode.options.generation, options));
  }
  return errors;
}

ViewScores mean_scores(const Validation& validation, std::size_t mode) {
  std::vector<ViewScores> scores;
  for (const ValidatedView& view : validation.views) {
    if (view.mode == mode) scores.push_back(view.scores);
  }
  return mean_of(scores);
}

std::string validate(const Room& room, const ValidateOptions& options) {
  std::vector<TruthView> truths = read_truth(options.truth, room);
  renderers_of(room, options.modes,
               truths.front().width);  // throws for modes that cannot be rendered
  prepare_report(options.report);
  Validation validation = validate_views(room, std::move(truths), options.modes);
  validation.connection_error = connection_errors(room, options.modes, options.connect);
  write_file_atomically(options.report / "metrics.json", metrics_json(validation));
  write_file_atomically(options.report / "index.html", validation_report(validation));
  return summary_of(validation, options.report);
}

}  // namespace raywalk::render
