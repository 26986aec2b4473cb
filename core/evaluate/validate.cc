#include "core/evaluate/validate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <span>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/interrupt.h"
#include "core/base/median.h"
#include "core/base/number_text.h"
#include "core/base/progress.h"
#include "core/evaluate/kept_results.h"
#include "core/evaluate/scores.h"
#include "core/evaluate/silhouettes.h"
#include "core/evaluate/truth_views.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/json.h"
#include "core/report/report.h"
#include "core/room/room.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

// Increment when views or scores change: results of another version are not found.
constexpr int kResultsVersion = 3;
constexpr std::size_t kMostShown = 3;  // truths on the page
constexpr int kPageWidth_px = 720;     // of an image on the page: sharp at half its width
// Factor that makes absolute differences visible: 32 levels become 128.
constexpr double kErrorGain = 4.0;
constexpr std::array kScoreKeys{"psnr_db", "ws_psnr_db", "ssim", "fsim"};
constexpr std::array kSilhouetteKeys{"psnr_near_silhouettes_db", "psnr_elsewhere_db",
                                     "near_silhouettes_share", "specks_per_megapixel"};

std::string method_of(const ViewMode& mode) { return generation_name(mode.options.generation); }

// Not measured without distances.
ordered_json silhouettes_of(const cv::Mat& view, const TrueView& truth) {
  if (truth.distances.empty()) return ordered_json::object();
  const SilhouetteScores scores = score_silhouettes(view, truth.image, truth.distances, truth.mask);
  return {{"psnr_near_silhouettes_db", scores.near_psnr_db},
          {"psnr_elsewhere_db", scores.elsewhere_psnr_db},
          {"near_silhouettes_share", scores.near_share},
          {"specks_per_megapixel", scores.specks_per_mpx}};
}

ordered_json json_of(const ViewReport& report) {
  return {{"limited_corners", report.limited_corners},
          {"filled_share", report.filled_share},
          {"unseen_share", report.unseen_share},
          {"empty_share", report.empty_share},
          {"render_ms", report.render_ms}};
}

// Renders the true views of a room.
class TrueViewRenderer {
 public:
  TrueViewRenderer(const Room& room, std::span<const ViewMode> modes)
      : room_(room), modes_(modes) {}

  // Makes the renderers of this width. Throws Error as Renderer does.
  void prepare(int width) {
    if (width == width_) return;
    renderers_.clear();
    for (const ViewMode& mode : modes_) {
      ViewOptions options = mode.options;
      options.width = width;
      renderers_.push_back(std::make_unique<Renderer>(room_, options));
    }
    width_ = width;
  }

  RenderedView render(const TrueView& truth, std::size_t mode) {
    prepare(truth.image.cols);
    return renderers_[mode]->render(
        viewpoint_for(modes_[mode].options.generation, truth.viewpoint, truth.height_m));
  }

 private:
  const Room& room_;
  std::span<const ViewMode> modes_;
  int width_ = 0;
  std::vector<std::unique_ptr<Renderer>> renderers_;
};

// All truths in all modes.
class Validation {
 public:
  // Throws Error where anything is wrong with the input.
  Validation(const Room& room, const ValidateOptions& options)
      : room_(room),
        modes_(options.modes),
        truths_(read_truth(options.truth, room)),
        renderer_(room, options.modes) {
    renderer_.prepare(truths_.front().width);
    for (const ListedTruth& truth : truths_) widest_px_ = std::max(widest_px_, truth.width);
    has_silhouettes_ = std::ranges::any_of(
        truths_, [](const ListedTruth& truth) { return !truth.distances.empty(); });
  }

  // Renders and scores what is not kept, truth by truth and within it mode by mode.
  void measure(KeptResults* kept) {
    std::vector<std::string> keys;
    for (const ListedTruth& truth : truths_) {
      const std::string of_truth = key_of(truth);
      for (ViewMode mode : modes_) {
        mode.options.width = truth.width;
        keys.push_back(sha256_hex(of_truth + text_of(mode.options)));
      }
    }
    const auto left =
        std::ranges::count_if(keys, [&](const auto& key) { return kept->find(key) == nullptr; });
    Progress progress("validating", left, "views");
    std::optional<std::size_t> loaded;
    TrueView truth;
    for (std::size_t i = 0; i < keys.size(); ++i) {
      throw_if_interrupted();
      if (kept->find(keys[i]) == nullptr) {
        if (loaded != i / modes_.size()) truth = read_view(truths_[i / modes_.size()]);
        loaded = i / modes_.size();
        kept->keep(keys[i], measured(truth, i % modes_.size()));
        progress.advance();
      }
      add_view(i / modes_.size(), i % modes_.size(), *kept->find(keys[i]));
    }
  }

  // Of metrics.json, but for the connection errors.
  ordered_json document() const {
    ordered_json modes = ordered_json::array();
    for (std::size_t mode = 0; mode < modes_.size(); ++mode) modes.push_back(mode_json(mode));
    return {{"volume", room_.directory().string()},
            {"distances", room_.distances_origin()},
            {"captured_width_px", room_.panorama().width},
            {"truths", truths_.size()},
            {"widest_truth_px", widest_px_},
            {"modes", modes},
            {"views", views_},
            {"quarters", quarters_},
            {"connection", nullptr},
            {"connection_error", ordered_json::array()}};
  }

  // For some truths, spread over the distance from the line, and each mode a row: the truth, the
  // view and its error.
  std::vector<ReportImage> images() {
    std::vector<ReportImage> images;
    for (const std::size_t i : spread_over_distance(truths_, kMostShown)) {
      const ListedTruth& listed = truths_[i];
      const TrueView truth = read_view(listed);
      for (std::size_t mode = 0; mode < modes_.size(); ++mode) {
        throw_if_interrupted();
        const cv::Mat view = renderer_.render(truth, mode).image;
        const ordered_json& scores = views_[i * modes_.size() + mode];
        const std::string row =
            fmt::format("{} at ({:.3g}, {:.3g}) m, {:.0f} cm from the nearest line, {}",
                        listed.name, listed.viewpoint.x_m, listed.viewpoint.z_m,
                        100.0 * listed.line_distance_m, method_of(modes_[mode]));
        const auto add = [&](const std::string& caption, const cv::Mat& image) {
          images.push_back(report_image("views", row, caption, image));
        };
        add("true view", shrunk(truth.image));
        add(fmt::format("rendered: PSNR {:.2f} dB, SSIM {:.3f}", scores["psnr_db"].get<double>(),
                        scores["ssim"].get<double>()),
            shrunk(view));
        add(fmt::format("error, times {:g}", kErrorGain),
            shrunk(error_of(view, truth_completed_by(view, truth.image, truth.mask))));
      }
    }
    return images;
  }

 private:
  std::string key_of(const ListedTruth& truth) const {
    const auto content = [](const fs::path& file) {
      return file.empty() ? "" : sha256_of_file(file);
    };
    return fmt::format("{} {} {} {} {} {} {} {} ", kResultsVersion, room_fingerprint(room_),
                       truth.viewpoint.x_m, truth.viewpoint.z_m,
                       truth.height_m ? fmt::format("{}", *truth.height_m) : "",
                       content(truth.file), content(truth.mask), content(truth.distances));
  }

  ordered_json measured(const TrueView& truth, std::size_t mode) {
    const RenderedView view = renderer_.render(truth, mode);
    return {{"scores", scores_of(view.image, truth.image, truth.mask)},
            {"silhouettes", silhouettes_of(view.image, truth)},
            {"report", json_of(view.report)},
            {"quarters", quarter_scores_of(room_.grid(), truth.viewpoint, view.image, truth.image,
                                           truth.mask)}};
  }

  // A row of "views", and those of "quarters".
  void add_view(std::size_t truth_index, std::size_t mode_index, const ordered_json& result) {
    const ListedTruth& truth = truths_[truth_index];
    const ViewMode& mode = modes_[mode_index];
    ordered_json view{{"name", truth.name},
                      {"x_m", truth.viewpoint.x_m},
                      {"z_m", truth.viewpoint.z_m},
                      {"line_distance_m", truth.line_distance_m},
                      {"generation", method_of(mode)},
                      {"connection", mode.connection},
                      {"k_deg", mode.options.k_deg},
                      {"enlargement", static_cast<double>(truth.width) / room_.panorama().width}};
    if (truth.height_m && mode.options.generation != Generation::kInitial) {
      view["y_m"] = *truth.height_m;
    }
    view.update(result["scores"]);
    for (const char* key : kSilhouetteKeys) {
      if (has_silhouettes_) view[key] = result["silhouettes"].value(key, ordered_json());
    }
    view.update(result["report"]);
    views_.push_back(view);
    for (const ordered_json& quarter : result["quarters"]) {
      quarters_.push_back({{"name", truth.name}, {"generation", method_of(mode)}});
      quarters_.back().update(quarter);
    }
  }

  // Means over the views of a mode.
  ordered_json mode_json(std::size_t index) const {
    const ViewMode& mode = modes_[index];
    std::vector<ordered_json> views;
    std::vector<double> times_ms;
    for (std::size_t i = index; i < views_.size(); i += modes_.size()) {
      views.push_back(views_[i]);
      times_ms.push_back(views_[i]["render_ms"].get<double>());
    }
    ordered_json json{{"generation", method_of(mode)},
                      {"connection", mode.connection},
                      {"k_deg", mode.options.k_deg},
                      {"k_source", mode.k_source},
                      {"overlap_deg", mode.options.overlap_deg}};
    for (const char* key : kScoreKeys) json[key] = mean_of(views, key);
    for (const char* key : kSilhouetteKeys) {
      if (has_silhouettes_) json[key] = mean_of(views, key);
    }
    json["median_render_ms"] = median(times_ms);
    return json;
  }

  // |view - truth| times kErrorGain per channel, saturating; black where they agree.
  static cv::Mat error_of(const cv::Mat& view, const cv::Mat& truth) {
    cv::Mat error;
    cv::absdiff(view, truth, error);
    error.convertTo(error, -1, kErrorGain);
    return error;
  }

  // For the page; averaged down, never enlarged.
  static cv::Mat shrunk(const cv::Mat& panorama) {
    if (panorama.cols <= kPageWidth_px) return panorama;
    cv::Mat shrunk;
    cv::resize(panorama, shrunk, {kPageWidth_px, kPageWidth_px / 2}, 0, 0, cv::INTER_AREA);
    return shrunk;
  }

  const Room& room_;
  std::span<const ViewMode> modes_;
  std::vector<ListedTruth> truths_;
  TrueViewRenderer renderer_;
  int widest_px_ = 0;             // of the truths
  bool has_silhouettes_ = false;  // whether a truth has distances
  std::vector<ordered_json> views_, quarters_;
};

std::string validation_summary(const ordered_json& metrics, const fs::path& report) {
  std::string text, silhouettes;
  for (const ordered_json& mode : metrics["modes"]) {
    const auto value = [&](const char* key) {
      return mode[key].is_number() ? mode[key].get<double>() : std::nan("");
    };
    const std::string name = mode["generation"].get<std::string>();
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
  Validation validation(room, options);
  std::vector<Generation> connected;  // whose lines connect
  if (!room.grid().cells.empty()) {
    require_connect_error_options(options.connect);
    for (const ViewMode& mode : options.modes) connected.push_back(mode.options.generation);
  }
  make_directories(options.report);
  for (const char* name : {"metrics.json", "index.html"}) {
    const AtomicFile probe(options.report / name);
  }
  KeptResults kept(options.report / "validation.partial");
  try {
    validation.measure(&kept);
    ordered_json metrics = validation.document();
    add_connect_errors(room, connected, options.connect, &kept, &metrics);
    const std::string page = report_page("validation", metrics, validation.images());
    write_file_atomically(options.report / "metrics.json", json_text(metrics));
    write_file_atomically(options.report / "index.html", page);
    kept.remove();
    return validation_summary(metrics, options.report);
  } catch (const Interrupted&) {
    throw Interrupted("interrupted; the same command resumes with the remaining views");
  }
}

}  // namespace raywalk
