#include "core/evaluate/validation/validation_partial.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/checked_json.h"
#include "core/files/fingerprint.h"
#include "core/files/image_file.h"
#include "core/files/sha256.h"
#include "core/room/room_fingerprint.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

// Increment when views or scores change: results of another version are not found.
constexpr int kResultsVersion = 2;
constexpr const char* kLockFile = "lock";
constexpr std::array kPictures{std::pair{"view", &ViewComparison::view},
                               std::pair{"error", &ViewComparison::error}};

fs::path made_directory(const fs::path& directory) {
  make_directories(directory);
  return directory;
}

// The keys of a view's report, for both writing and reading: visit(key, member).
template <typename Report, typename Visit>
void visit_members(Report& report, Visit&& visit) {
  visit("limited_corners", report.limited_corners);
  visit("filled_share", report.filled_share);
  visit("unseen_share", report.unseen_share);
  visit("empty_share", report.empty_share);
  visit("render_ms", report.render_ms);
}

void read(const CheckedJson& json, int* value) { *value = json.integer(0); }
void read(const CheckedJson& json, double* value) { *value = json.number(); }

std::string text_of(const MeasuredView& view) {
  ordered_json report;
  visit_members(view.report, [&](const char* key, const auto& value) { report[key] = value; });
  ordered_json quarters = ordered_json::array();
  for (const QuarterScore& quarter : view.quarters) {
    quarters.push_back({quarter.line_distance_m, quarter.psnr_db, quarter.ssim, quarter.fsim});
  }
  const ViewScores& scores = view.scores;
  const SilhouetteScores& edges = view.silhouettes;
  const ordered_json json{
      {"report", report},
      {"scores", {scores.psnr_db, scores.ws_psnr_db, scores.ssim, scores.fsim}},
      {"silhouettes",
       {edges.near_psnr_db, edges.elsewhere_psnr_db, edges.near_share, edges.specks_per_mpx}},
      {"quarters", quarters},
      {"shown", view.pictures.has_value()}};
  return json.dump();
}

MeasuredView view_from(const CheckedJson& json) {
  MeasuredView view;
  const CheckedJson report = json.at("report");
  visit_members(view.report, [&](const char* key, auto& value) { read(report.at(key), &value); });
  const auto number = [](const CheckedJson& value) { return value.number_or(std::nan("")); };
  const std::vector<CheckedJson> scores = json.at("scores").items(4);
  view.scores = {number(scores[0]), number(scores[1]), number(scores[2]), number(scores[3])};
  const std::vector<CheckedJson> edges = json.at("silhouettes").items(4);
  view.silhouettes = {number(edges[0]), number(edges[1]), number(edges[2]), number(edges[3])};
  for (const CheckedJson& quarter : json.at("quarters").items()) {
    const std::vector<CheckedJson> values = quarter.items(4);
    view.quarters.push_back(
        {number(values[0]), number(values[1]), number(values[2]), number(values[3])});
  }
  if (json.at("shown").boolean()) view.pictures.emplace();
  return view;
}

std::string fingerprint_of(const Room& room) {
  return sha256_hex(fmt::format("{} {}", kResultsVersion, room_fingerprint(room)));
}

}  // namespace

ValidationPartial::ValidationPartial(const fs::path& report, const Room& room)
    : directory_(made_directory(report / "validation.partial")),
      lock_(std::make_shared<FileLock>(
          directory_ / kLockFile,
          "another raywalk-render validate is writing this report; wait for it to finish")),
      room_fingerprint_(fingerprint_of(room)),
      connection_errors_(made_directory(directory_ / ("connections-" + room_fingerprint_))) {}

ValidationPartial::ValidationPartial(const ValidationPartial& partial, const Room& room)
    : directory_(partial.directory_),
      lock_(partial.lock_),
      room_fingerprint_(fingerprint_of(room)),
      connection_errors_(made_directory(directory_ / ("connections-" + room_fingerprint_))) {}

ValidationPartial::~ValidationPartial() {
  std::error_code ignored;
  if (is_empty()) fs::remove_all(directory_, ignored);
}

std::string ValidationPartial::key_of(const TruthView& truth, bool shown) const {
  const std::string height = truth.height_m ? fmt::format("{} ", *truth.height_m) : "";
  return sha256_hex(fmt::format(
      "{} {} {}{} {} {} {} {}", room_fingerprint_, truth.viewpoint.x_m, height, truth.viewpoint.z_m,
      sha256_of_file(truth.file), truth.mask.empty() ? "" : sha256_of_file(truth.mask),
      truth.distances.empty() ? "" : sha256_of_file(truth.distances), shown));
}

std::string ValidationPartial::key_of(const std::string& truth_key, const ViewOptions& options) {
  return sha256_hex(truth_key + " " + text_of(options));
}

fs::path ValidationPartial::file_of(const std::string& key) const {
  return directory_ / ("view-" + key);
}

// The file holds the checksum of the rest of it on its first line.
std::optional<MeasuredView> ValidationPartial::find(const std::string& key) const {
  const fs::path file = file_of(key);
  std::error_code error;
  if (!fs::exists(file, error)) return std::nullopt;
  try {
    const std::string text = read_file(file);
    const std::size_t line_end = text.find('\n');
    if (line_end == std::string::npos) return std::nullopt;
    const std::string json = text.substr(line_end + 1);
    if (text.substr(0, line_end) != sha256_hex(json)) return std::nullopt;
    MeasuredView view = view_from(CheckedJson::parse(json, file.string()));
    if (!view.pictures) return view;
    for (const auto& [name, picture] : kPictures) {
      (*view.pictures).*picture = read_picture(file.string() + "-" + name + ".png");
    }
    return view;
  } catch (const Error&) {
    return std::nullopt;
  }
}

void ValidationPartial::keep(const std::string& key, const MeasuredView& view) const {
  const fs::path file = file_of(key);
  if (view.pictures) {
    for (const auto& [name, picture] : kPictures) {
      write_image(file.string() + "-" + name + ".png", (*view.pictures).*picture);
    }
  }
  // Last, as it says that the pictures are there.
  const std::string json = text_of(view);
  write_file_atomically(file, sha256_hex(json) + "\n" + json);
}

void ValidationPartial::complete() {
  std::error_code error;
  fs::remove_all(directory_, error);
  if (error) {
    throw Error(
        fmt::format("cannot remove {}: {}; remove it", directory_.string(), error.message()));
  }
}

bool ValidationPartial::is_empty() const {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory_, error)) {
    const bool kept = entry.is_directory(error) ? !fs::is_empty(entry.path(), error)
                                                : entry.path().filename() != kLockFile;
    if (kept) return false;
  }
  return !error;
}

}  // namespace raywalk
