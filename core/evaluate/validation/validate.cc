#include "core/evaluate/validation/validate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/number_text.h"
#include "core/evaluate/validation/connect_error_file.h"
#include "core/evaluate/validation/measured_views.h"
#include "core/evaluate/validation/metrics_json.h"
#include "core/evaluate/validation/validation_partial.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/json_text.h"
#include "core/report/report.h"
#include "core/room/connection_errors.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

// What is to be measured of a room.
struct RoomTask {
  const Room& room;
  std::vector<ViewMode> modes{};
  std::vector<TruthView> truths{};
  const ValidationPartial* partial = nullptr;  // none until the report is locked
};

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

std::string silhouettes_text(const Validation& validation) {
  if (!measures_silhouettes(validation)) return "";
  std::string text;
  for (std::size_t mode = 0; mode < validation.modes.size(); ++mode) {
    const SilhouetteScores mean = mean_silhouettes(validation, mode);
    text += fmt::format(
        "{:<10} PSNR near silhouettes ({:.1f} % of the view) {} dB, elsewhere {} dB  {:.0f} specks "
        "per megapixel\n",
        generation_name(validation.modes[mode].options.generation), 100.0 * mean.near_share,
        number_or_dash(mean.near_psnr_db, 2), number_or_dash(mean.elsewhere_psnr_db, 2),
        mean.specks_per_mpx);
  }
  return text;
}

// The gain of each mode over the same in the room before, and E_connect of both at the largest k.
std::string gains_text(const Validation& before, const Validation& after) {
  std::string text = "gain over " + escaped(before.volume) + ":\n";
  for (std::size_t mode = 0; mode < after.modes.size(); ++mode) {
    const Generation generation = after.modes[mode].options.generation;
    const auto same = std::ranges::find_if(before.modes, [&](const ViewMode& other) {
      return other.options.generation == generation;
    });
    if (same == before.modes.end()) continue;
    const std::string name = generation_name(generation);
    const std::size_t mode_before = static_cast<std::size_t>(same - before.modes.begin());
    if (!after.views.empty()) {
      const ViewScores now = mean_scores(after, mode), then = mean_scores(before, mode_before);
      text +=
          fmt::format("{:<10} PSNR {:+.2f} dB  WS-PSNR {:+.2f} dB  SSIM {:+.4f}  FSIM {:+.4f}\n",
                      name, now.psnr_db - then.psnr_db, now.ws_psnr_db - then.ws_psnr_db,
                      now.ssim - then.ssim, now.fsim - then.fsim);
    }
    if (before.connection_error.empty() || after.connection_error.empty()) continue;
    const ConnectErrorRow& row = after.connection_error[mode].rows.back();
    text +=
        fmt::format("{:<10} E_connect at k = {:g}: {} before, {} after\n", name, row.k_deg,
                    number_or_dash(before.connection_error[mode_before].rows.back().e_connect, 1),
                    number_or_dash(row.e_connect, 1));
  }
  return text;
}

std::string summary_of(const Validation& validation, const std::optional<Validation>& before,
                       const fs::path& report) {
  std::string text;
  for (std::size_t mode = 0; mode < validation.modes.size(); ++mode) {
    if (validation.views.empty()) break;
    const ViewScores mean = mean_scores(validation, mode);
    text += fmt::format("{:<10} PSNR {:6.2f} dB  WS-PSNR {:6.2f} dB  SSIM {:.4f}  FSIM {:.4f}\n",
                        generation_name(validation.modes[mode].options.generation), mean.psnr_db,
                        mean.ws_psnr_db, mean.ssim, mean.fsim);
  }
  text += silhouettes_text(validation);
  const int widest_px = widest_truth_px(validation);
  if (widest_px > validation.captured_width_px) {
    text +=
        fmt::format("views up to {} pixels wide are enlarged {:.1f} times from panoramas of {}\n",
                    widest_px, enlargement_at(validation, widest_px), validation.captured_width_px);
  }
  if (before) text += gains_text(*before, validation);
  return text + "distances in use: " + validation.distances + "\n" +
         escaped((report / "index.html").string());
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

// Throws where it cannot be measured.
RoomTask checked_task(const Room& room, std::vector<ViewMode> modes,
                      const ValidateOptions& options) {
  RoomTask task{.room = room, .modes = std::move(modes)};
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

// Renders and measures all that is not kept from earlier runs.
Validation measured_validation(const RoomTask& task, const ConnectErrorOptions& options) {
  Validation validation = validate_views(task.room, task.truths, task.modes, *task.partial);
  validation.connection_error =
      connection_errors(task.room, task.modes, options, task.partial->connection_errors());
  return validation;
}

// For each sample and mode a row: the truth, the view and its error.
std::vector<ReportImage> report_images(const Validation& validation) {
  std::vector<ReportImage> images;
  for (const PictureSample& sample : validation.samples) {
    const TruthView& truth = validation.truths[sample.truth];
    for (std::size_t mode = 0; mode < validation.modes.size(); ++mode) {
      const ViewScores& scores =
          validation.views[sample.truth * validation.modes.size() + mode].scores;
      const std::string row =
          fmt::format("{} at ({:.3g}, {:.3g}) m, {:.0f} cm from the nearest line, {}", truth.name,
                      truth.viewpoint.x_m, truth.viewpoint.z_m, 100.0 * truth.line_distance_m,
                      generation_name(validation.modes[mode].options.generation));
      images.push_back(report_image("views", row, "true view", sample.truth_picture));
      images.push_back(report_image(
          "views", row,
          fmt::format("rendered: PSNR {:.2f} dB, SSIM {:.3f}", scores.psnr_db, scores.ssim),
          sample.by_mode[mode].view));
      images.push_back(report_image("views", row, fmt::format("error, times {:g}", kErrorGain),
                                    sample.by_mode[mode].error));
    }
  }
  return images;
}

// Of one room, or of it and that before.
std::string written_report(std::span<const RoomTask> tasks, const ValidateOptions& options) {
  const Validation validation = measured_validation(tasks.front(), options.connect);
  nlohmann::ordered_json document = metrics_document(validation);
  std::optional<Validation> before;
  if (tasks.size() > 1) {
    before = measured_validation(tasks[1], options.connect);
    document["before"] = metrics_document(*before);
  }
  write_file_atomically(options.report / "metrics.json", json_text(document));
  write_file_atomically(options.report / "index.html",
                        report_page("validation", document, report_images(validation)));
  return summary_of(validation, before, options.report);
}

}  // namespace

Validation validate_views(const Room& room, std::vector<TruthView> truths,
                          std::vector<ViewMode> modes, const ValidationPartial& partial) {
  Validation validation;
  validation.volume = room.directory().string();
  validation.captured_width_px = room.panorama().width;
  validation.distances = room.distances_origin();
  for (const std::size_t truth : shown_truths(truths)) {
    const cv::Mat picture = read_panorama(truths[truth].file);
    validation.samples.push_back(
        {.truth = truth, .truth_picture = shrunk_to(picture, kPageWidth_px)});
  }
  std::vector<MeasuredView> views = measured_views(room, truths, modes, partial);
  for (std::size_t i = 0; i < views.size(); ++i) {
    MeasuredView& view = views[i];
    const std::size_t truth = i / modes.size();
    validation.views.push_back({truth, i % modes.size(), view.report, view.scores, view.silhouettes,
                                std::move(view.quarters)});
    PictureSample* sample = sample_of(validation, truth);
    if (sample != nullptr) sample->by_mode.push_back(std::move(view.pictures).value());
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

SilhouetteScores mean_silhouettes(const Validation& validation, std::size_t mode) {
  std::vector<SilhouetteScores> scores;
  for (const ValidatedView& view : validation.views) {
    if (view.mode == mode) scores.push_back(view.silhouettes);
  }
  return mean_of(scores);
}

bool measures_silhouettes(const Validation& validation) {
  return std::ranges::any_of(validation.truths,
                             [](const TruthView& truth) { return !truth.distances.empty(); });
}

std::string validate(const Room& room, const ValidateOptions& options) {
  if (options.truth.empty() && options.before.empty()) {
    throw UsageError("give true views with --truth, or another room with --before");
  }
  std::vector<RoomTask> tasks{checked_task(room, options.modes, options)};
  std::optional<Room> room_before;
  if (!options.before.empty()) {
    room_before = Room::open(options.before);
    tasks.push_back(checked_task(*room_before, modes_for(*room_before, options.modes), options));
  }
  prepare_report(options.report);
  ValidationPartial partial(options.report, room);
  std::optional<ValidationPartial> partial_before;
  tasks.front().partial = &partial;
  if (room_before) tasks[1].partial = &partial_before.emplace(partial, *room_before);
  try {
    std::string summary = written_report(tasks, options);
    partial.complete();
    return summary;
  } catch (const Interrupted&) {
    throw Interrupted("interrupted; the same command resumes with the remaining views");
  }
}

}  // namespace raywalk
