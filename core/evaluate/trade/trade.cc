#include "core/evaluate/trade/trade.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/interrupt.h"
#include "core/base/parallel.h"
#include "core/evaluate/trade/held_out_views.h"
#include "core/evaluate/trade/trade_json.h"
#include "core/evaluate/validation/comparison_pictures.h"
#include "core/files/atomic_output.h"
#include "core/files/json_text.h"
#include "core/report/report.h"
#include "core/room/requirements.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kViews = 6;
constexpr int kImageWidth_px = 560;  // sharp at half the page's width

fs::path partial_file(const fs::path& report) { return report / "trade.partial.json"; }

void prepare_report(const fs::path& report, const fs::path& room) {
  make_directories(report);
  const AtomicFile room_probe(measured_settings_path(room));
  for (const char* name : {"trade.json", "trade.csv", "index.html", "trade.partial.json"}) {
    const AtomicFile probe(report / name);
  }
}

std::string row_of(const MeasuredSetting& setting, const std::string& name) {
  const TradeMeasurement& measured = setting.measured;
  return fmt::format("{:8.2f}  {:7.2f}  {:8.2f}  {:6.4f}  {}\n", measured.time.ms,
                     measured.time.ratio, measured.scores.psnr_db, measured.scores.ssim, name);
}

std::string summary_of(const TradeInput& input, std::vector<MeasuredSetting> settings,
                       const nlohmann::ordered_json& document, const fs::path& report) {
  std::string text = fmt::format("{:>8}  {:>7}  {:>8}  {:>6}  {}\n", "ms", "x remap", "PSNR dB",
                                 "SSIM", "settings on the Pareto front");
  std::string presets;
  for (const auto& preset : document["presets"]) {
    presets += row_of(settings[preset["number"].get<std::size_t>() - 1],
                      "preset " + preset["name"].get<std::string>());
  }
  std::ranges::sort(settings, {},
                    [](const MeasuredSetting& setting) { return setting.measured.time.ratio; });
  for (const MeasuredSetting& setting : settings) {
    if (setting.on_front) text += row_of(setting, setting.setting.name);
  }
  text += presets;
  if (document["busy"].get<bool>()) {
    text += "other programs were busy meanwhile, so that times are less certain\n";
  }
  const std::string room = escaped(input.room->directory().string());
  text += input.room->has_distances()
              ? fmt::format("{}: distances in use: {}\n", room, input.room->distances_origin())
              : room +
                    ": no distances, so only initial views were measured; estimate distances "
                    "with raywalk-build-lf depth\n";
  return text + escaped((report / "index.html").string());
}

// The truth of the pictured view beside the error of every setting there.
std::vector<ReportImage> images_of(const TradeInput& input) {
  const TradeView& view = input.views[pictured_view(input.views.size())];
  const cv::Mat truth = shrunk_to(view.truth, kImageWidth_px);
  std::vector<ReportImage> images;
  for (std::size_t i = 0; i < input.settings.size(); ++i) {
    throw_if_interrupted();
    const cv::Mat image = image_of(input.settings[i], view);
    const cv::Mat error = error_of(image, truth_completed_by(image, view.truth, view.mask));
    const std::string row = fmt::format("setting {}: {}", i + 1, input.settings[i].name);
    images.push_back(report_image("settings", row, "true view " + view.name, truth));
    images.push_back(report_image("settings", row, fmt::format("error, times {:g}", kErrorGain),
                                  shrunk_to(error, kImageWidth_px)));
  }
  return images;
}

// What settings are chosen by: those on all threads.
MeasuredSettings measured_settings(const TradeInput& input,
                                   const std::vector<MeasuredSetting>& settings) {
  static_assert(kMostPsnr_db == kMaxPsnrDb, "written scores have to be readable");
  MeasuredSettings measured{.distances_sha256 = distances_sha256(*input.room),
                            .width_px = input.views.front().truth.cols};
  for (const MeasuredSetting& setting : settings) {
    if (setting.setting.threads != thread_count()) continue;
    measured.choices.push_back({.name = setting.setting.name,
                                .options = setting.setting.mode.options,
                                .ratio = setting.measured.time.ratio,
                                .psnr_db = setting.measured.scores.psnr_db});
  }
  return measured;
}

// Presets use all threads and the truths' width; those that are not in the sweep are added to it.
void add_presets(const std::vector<NamedMode>& presets, int width_px, TradeInput* input) {
  input->presets = presets;
  for (const NamedMode& preset : presets) {
    TradeSetting setting{
        .name = "preset " + preset.name, .mode = preset.mode, .threads = thread_count()};
    setting.mode.options.width = width_px;
    const bool known = std::ranges::any_of(input->settings, [&](const TradeSetting& other) {
      return parameters_of(other) == parameters_of(setting);
    });
    if (!known) input->settings.push_back(setting);
  }
}

}  // namespace

std::string write_trade(const TradeInput& input, const fs::path& report) {
  prepare_report(report, input.room->directory());
  try {
    const std::vector<MeasuredSetting> settings = measure_trade(input, partial_file(report));
    const std::vector<ReportImage> images = images_of(input);
    const nlohmann::ordered_json document = trade_document(input, settings);
    write_file_atomically(report / "trade.json", json_text(document));
    write_measured_settings(input.room->directory(), measured_settings(input, settings));
    write_file_atomically(report / "trade.csv", trade_csv(document));
    write_file_atomically(report / "index.html", report_page("trade", document, images));
    fs::remove(partial_file(report));
    return summary_of(input, settings, document, report);
  } catch (const Interrupted&) {
    throw Interrupted("interrupted; the same command resumes with the remaining settings");
  }
}

std::string trade(const Room& room, const TradeOptions& options) {
  if (options.truth.empty() == (options.held_out == 0)) {
    throw UsageError(
        "give true views with --truth, or use stations as true views with --held-out (one of "
        "both)");
  }
  TradeInput input{.room = &room, .repetitions = options.repetitions};
  HeldOutViews held_out;
  if (options.held_out > 0) {
    prepare_report(options.report, room.directory());  // before minutes of estimating
    held_out = held_out_views(room, options.held_out, kViews);
    input.truth = fmt::format("one of {} stations, held out", options.held_out);
    input.views = held_out.views;
  } else {
    input.truth = options.truth.string();
    input.views = captured_views(room, read_truth(options.truth, room), kViews);
  }
  const int width_px = input.views.front().truth.cols;
  input.settings = trade_sweep({.centres = options.centres,
                                .stored_width_px = room.panorama().width,
                                .width_px = width_px,
                                .threads = thread_count()});
  add_presets(options.presets, width_px, &input);
  return write_trade(input, options.report);
}

}  // namespace raywalk
