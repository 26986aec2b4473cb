#include "core/evaluate/validate.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <span>
#include <utility>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/interrupt.h"
#include "core/base/median.h"
#include "core/base/number_text.h"
#include "core/evaluate/kept_results.h"
#include "core/evaluate/metrics.h"
#include "core/evaluate/truth_views.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/json.h"
#include "core/report/report.h"
#include "core/room/room.h"
#include "core/view/gpu/gpu_device.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

// Increment when views or scores change: results of another version are not found.
constexpr int kResultsVersion = 5;
constexpr std::size_t kMostShown = 3;  // truths on the page
constexpr int kPageWidth_px = 720;     // of an image on the page: sharp at half its width
// Factor that makes absolute differences visible: 32 levels become 128.
constexpr double kErrorGain = 4.0;
constexpr std::array kScoreKeys{"psnr_db", "ws_psnr_db", "ssim", "fsim"};
constexpr std::array kSilhouetteKeys{"psnr_near_silhouettes_db", "psnr_elsewhere_db",
                                     "near_silhouettes_share", "specks_per_megapixel"};

std::string method_of(const ViewMode& mode) { return method_name(mode.options.method); }

// Renders the true views of a room; has a renderer for each width and mode.
class TrueViewRenderer {
 public:
  TrueViewRenderer(const Room& room, std::span<const ViewMode> modes)
      : room_(room), modes_(modes) {}

  // Throws Error as Renderer does.
  Renderer& of(int width, std::size_t mode) {
    ViewOptions options = modes_[mode].options;
    options.width = width;
    return renderers_.try_emplace({width, mode}, room_, options).first->second;
  }

  RenderedView render(const TrueView& truth, std::size_t mode) {
    return of(truth.width, mode)
        .render(viewpoint_for(modes_[mode].options.method, truth.viewpoint, truth.height_m));
  }

 private:
  const Room& room_;
  std::span<const ViewMode> modes_;
  std::map<std::pair<int, std::size_t>, Renderer> renderers_;
};

// A row of metrics.json's "views", and those of "quarters".
ordered_json measured(const Room& room, const TrueView& truth, const ViewMode& mode,
                      const RenderedView& rendered) {
  const cv::Mat image = exposed_as(truth, rendered.image);
  const ViewReport& report = rendered.report;
  ordered_json view{{"name", truth.name},
                    {"x_m", truth.viewpoint.x_m},
                    {"z_m", truth.viewpoint.z_m},
                    {"line_distance_m", truth.line_distance_m},
                    {"method", method_of(mode)},
                    {"connection", mode.connection},
                    {"k_deg", mode.options.k_deg},
                    {"enlargement", static_cast<double>(truth.width) / room.panorama().width}};
  if (truth.height_m && mode.options.method != ViewMethod::kInitial) {
    view["y_m"] = *truth.height_m;
  }
  const FeatureSimilarity features = features_of(image, truth);
  view.update(scores_of(image, truth, features));
  if (!truth.distances.empty()) {
    const SilhouetteScores scores =
        score_silhouettes(image, truth.image, truth.distances, truth.mask);
    view.update(ordered_json{{kSilhouetteKeys[0], scores.near_psnr_db},
                             {kSilhouetteKeys[1], scores.elsewhere_psnr_db},
                             {kSilhouetteKeys[2], scores.near_share},
                             {kSilhouetteKeys[3], scores.specks_per_mpx}});
  }
  view.update(ordered_json{{"limited_corners", report.limited_corners},
                           {"filled_share", report.filled_share},
                           {"unseen_share", report.unseen_share},
                           {"empty_share", report.empty_share},
                           {"render_ms", report.render_ms}});
  ordered_json quarters = ordered_json::array();
  for (const ordered_json& scores : quarter_scores_of(room.grid(), image, truth, features)) {
    ordered_json quarter{{"name", truth.name}, {"method", method_of(mode)}};
    quarter.update(scores);
    quarters.push_back(std::move(quarter));
  }
  return {{"view", std::move(view)}, {"quarters", std::move(quarters)}};
}

// Of everything that a result of a truth and a mode depends on.
std::string key_of(const Room& room, const ListedTruth& truth, ViewMode mode) {
  const auto content = [](const fs::path& file) {
    return file.empty() ? "" : sha256_of_file(file);
  };
  mode.options.width = truth.width;
  return sha256_hex(fmt::format(
      "{} {} {} {} {} {} {} {} {} {} {} {} {}", kResultsVersion, room_fingerprint(room), truth.name,
      truth.viewpoint.x_m, truth.viewpoint.z_m, truth.height_m ? 1 : 0,
      truth.height_m.value_or(0.0), content(truth.file), content(truth.mask_file),
      content(truth.distances_file), truth.own_exposure, text_of(mode.options), device_name()));
}

// The results of truth by truth and within it mode by mode; those that are not kept are made.
std::vector<ordered_json> measured_results(const Room& room, std::span<const ListedTruth> truths,
                                           std::span<const ViewMode> modes,
                                           TrueViewRenderer* renderer, KeptResults* kept) {
  std::vector<std::string> keys;
  for (const ListedTruth& truth : truths) {
    for (const ViewMode& mode : modes) keys.push_back(key_of(room, truth, mode));
  }
  TrueView truth;
  return kept->get_all(keys, "validating", "views", [&](std::size_t i) {
    const ListedTruth& listed = truths[i / modes.size()];
    const std::size_t mode = i % modes.size();
    if (truth.name != listed.name) truth = read_view(listed);
    return measured(room, truth, modes[mode], renderer->render(truth, mode));
  });
}

// Means over the views of a mode.
ordered_json mode_json(const ViewMode& mode, std::span<const ordered_json> views) {
  ordered_json json{{"method", method_of(mode)},
                    {"connection", mode.connection},
                    {"k_deg", mode.options.k_deg},
                    {"k_source", mode.k_source},
                    {"overlap_deg", mode.options.overlap_deg}};
  for (const char* key : kScoreKeys) json[key] = mean_of(views, key);
  for (const char* key : kSilhouetteKeys) {
    if (views.front().contains(key)) json[key] = mean_of(views, key);
  }
  std::vector<double> times_ms;
  times_ms.reserve(views.size());
  for (const ordered_json& view : views) times_ms.push_back(view["render_ms"].get<double>());
  json["median_render_ms"] = median(std::move(times_ms));
  return json;
}

// Of metrics.json, but for the connection errors.
ordered_json document_of(const Room& room, std::span<const ListedTruth> truths,
                         std::span<const ViewMode> modes, std::span<const ordered_json> results) {
  const bool silhouettes = std::ranges::any_of(
      truths, [](const ListedTruth& truth) { return !truth.distances_file.empty(); });
  std::vector<ordered_json> views, quarters, means;
  for (const ordered_json& result : results) {
    views.push_back(result["view"]);
    for (const char* key : kSilhouetteKeys) {
      if (silhouettes) views.back().emplace(key, nullptr);  // unless it has one
    }
    quarters.insert(quarters.end(), result["quarters"].begin(), result["quarters"].end());
  }
  for (std::size_t mode = 0; mode < modes.size(); ++mode) {
    std::vector<ordered_json> of_mode;
    for (std::size_t i = mode; i < views.size(); i += modes.size()) of_mode.push_back(views[i]);
    means.push_back(mode_json(modes[mode], of_mode));
  }
  return {{"volume", room.directory().string()},
          {"distances", room.distances_origin()},
          {"captured_width_px", room.panorama().width},
          {"truths", truths.size()},
          {"exposure_matched", truths.front().own_exposure},
          {"widest_truth_px", std::ranges::max(truths, {}, &ListedTruth::width).width},
          {"modes", means},
          {"views", views},
          {"quarters", quarters},
          {"connection", nullptr},
          {"connection_error", ordered_json::array()}};
}

// Measures how lines connect in views of each mode, unless it is kept.
void add_connect_errors(const Room& room, const ValidateOptions& options, KeptResults* kept,
                        ordered_json* metrics) {
  if (room.grid().cells.empty()) return;
  for (const ViewMode& mode : options.modes) {
    const std::string key = sha256_hex(fmt::format(
        "{} connect-error {} {} {} {}", room_fingerprint(room), method_of(mode),
        options.connect.viewpoints, options.connect.overlap_deg, options.connect.k_list_deg));
    const ordered_json errors = kept->get(
        key, [&] { return measure_connect_error(room, mode.options.method, options.connect); });
    ordered_json& rows = (*metrics)["connection_error"];
    rows.insert(rows.end(), errors["rows"].begin(), errors["rows"].end());
    // The same of every method.
    if ((*metrics)["connection"].is_null()) (*metrics)["connection"] = errors["connection"];
  }
}

// For the page; averaged down, never enlarged.
cv::Mat shrunk(const cv::Mat& panorama) {
  if (panorama.cols <= kPageWidth_px) return panorama;
  cv::Mat shrunk;
  cv::resize(panorama, shrunk, {kPageWidth_px, kPageWidth_px / 2}, 0, 0, cv::INTER_AREA);
  return shrunk;
}

// For some truths, spread over the distance from the line, and each mode a row: the truth, the view
// and its error, |view - truth| times kErrorGain per channel, saturating; black where they agree.
std::vector<ReportImage> images_of(std::span<const ListedTruth> truths,
                                   std::span<const ViewMode> modes, const ordered_json& views,
                                   TrueViewRenderer* renderer) {
  std::vector<ReportImage> images;
  for (const std::size_t i : spread_over_distance(truths, kMostShown)) {
    const TrueView truth = read_view(truths[i]);
    for (std::size_t mode = 0; mode < modes.size(); ++mode) {
      throw_if_interrupted();
      const cv::Mat view = exposed_as(truth, renderer->render(truth, mode).image);
      cv::Mat error;
      cv::absdiff(view, truth_completed_by(view, truth), error);
      error.convertTo(error, -1, kErrorGain);
      const ordered_json& scores = views[i * modes.size() + mode];
      const std::string row =
          fmt::format("{} at ({:.3g}, {:.3g}) m, {:.0f} cm from the nearest line, {}", truth.name,
                      truth.viewpoint.x_m, truth.viewpoint.z_m, 100.0 * truth.line_distance_m,
                      method_of(modes[mode]));
      images.push_back(report_image("views", row, "true view", shrunk(truth.image)));
      images.push_back(
          report_image("views", row,
                       fmt::format("rendered: PSNR {:.2f} dB, SSIM {:.3f}",
                                   scores["psnr_db"].get<double>(), scores["ssim"].get<double>()),
                       shrunk(view)));
      images.push_back(
          report_image("views", row, fmt::format("error, times {:g}", kErrorGain), shrunk(error)));
    }
  }
  return images;
}

std::string validation_summary(const ordered_json& metrics, const fs::path& report) {
  std::string text, silhouettes;
  for (const ordered_json& mode : metrics["modes"]) {
    const auto value = [&](const char* key) {
      return mode[key].is_number() ? mode[key].get<double>() : std::nan("");
    };
    const std::string name = mode["method"].get<std::string>();
    text += fmt::format("{:<10} PSNR {:6.2f} dB  WS-PSNR {:6.2f} dB  SSIM {:.4f}  FSIM {:.4f}\n",
                        name, value("psnr_db"), value("ws_psnr_db"), value("ssim"), value("fsim"));
    if (!mode.contains(kSilhouetteKeys[0])) continue;
    silhouettes += fmt::format(
        "{:<10} PSNR near silhouettes ({:.1f} % of the view) {} dB, elsewhere {} dB  {:.0f} specks "
        "per megapixel\n",
        name, 100.0 * value("near_silhouettes_share"),
        number_or_dash(value("psnr_near_silhouettes_db"), 2),
        number_or_dash(value("psnr_elsewhere_db"), 2), value("specks_per_megapixel"));
  }
  text += silhouettes;
  const int widest_px = metrics["widest_truth_px"], captured_px = metrics["captured_width_px"];
  if (widest_px > captured_px) {
    text +=
        fmt::format("views up to {} pixels wide are enlarged {:.1f} times from panoramas of {}\n",
                    widest_px, static_cast<double>(widest_px) / captured_px, captured_px);
  }
  return text + "distances in use: " + metrics["distances"].get<std::string>() + "\n" +
         escaped((report / "index.html").string());
}

}  // namespace

std::string validate(const Room& room, const ValidateOptions& options) {
  std::vector<ListedTruth> truths = read_truth(options.truth, room);
  for (ListedTruth& truth : truths) truth.own_exposure = options.match_exposure;
  TrueViewRenderer renderer(room, options.modes);
  for (std::size_t mode = 0; mode < options.modes.size(); ++mode) {
    renderer.of(truths.front().width, mode);  // checks what they need before any work
  }
  if (!room.grid().cells.empty()) require_connect_error_options(options.connect);
  make_directories(options.report);
  for (const char* name : {"metrics.json", "index.html"}) {
    const AtomicFile probe(options.report / name);
  }
  KeptResults kept(options.report / "validation.partial");
  try {
    const std::vector<ordered_json> results =
        measured_results(room, truths, options.modes, &renderer, &kept);
    ordered_json metrics = document_of(room, truths, options.modes, results);
    add_connect_errors(room, options, &kept, &metrics);
    const std::vector<ReportImage> images =
        images_of(truths, options.modes, metrics["views"], &renderer);
    const std::string page = report_page("validation", metrics, images);
    write_file_atomically(options.report / "metrics.json", json_text(metrics));
    write_file_atomically(options.report / "index.html", page);
    kept.remove();
    return validation_summary(metrics, options.report);
  } catch (const Interrupted&) {
    throw Interrupted("interrupted; the same command resumes with the remaining views");
  }
}

}  // namespace raywalk
