#include "core/evaluate/truth_views.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <opencv2/core.hpp>
#include <set>

#include "core/base/error.h"
#include "core/base/median.h"
#include "core/evaluate/metrics.h"
#include "core/files/csv.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"
#include "core/files/listed_files.h"
#include "core/geometry/panorama_pixels.h"
#include "core/panorama/panorama_rotation.h"
#include "core/view/view_plan.h"

namespace raywalk {

using nlohmann::ordered_json;

namespace {

constexpr double kHeightTolerance_m = 0.005;  // a pixel at 1.6 m in a panorama 2048 pixels wide
constexpr int kMinWidth_px = 32;              // the metrics need 8 columns in a quarter

double nearest_line_m(const Grid& grid, const ViewPlan& plan) {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const int index : plan.lines()) {
    const Line& line = grid.lines[static_cast<std::size_t>(index)];
    const double along_m = along_line(line, plan.viewpoint());
    const double off_x_m = line.origin.x_m + along_m * line.direction.x_m - plan.viewpoint().x_m;
    const double off_z_m = line.origin.z_m + along_m * line.direction.z_m - plan.viewpoint().z_m;
    nearest_m = std::min(nearest_m, std::hypot(off_x_m, off_z_m));
  }
  return nearest_m;
}

// Empty where the row names none.
std::filesystem::path file_in(const CsvTable& table, std::size_t row, const std::string& column,
                              ListedFiles* files) {
  if (!table.has_column(column) || table.text(row, column).empty()) return {};
  return files->find(table.text(row, column));
}

// Empty without.
cv::Mat read_true_mask(const ListedTruth& truth) {
  if (truth.mask_file.empty()) return {};
  return read_mask(truth.mask_file, {truth.width, truth.width / 2});
}

ListedTruth truth_at(const CsvTable& table, std::size_t row, ListedFiles* files, const Room& room,
                     TurnedPictures* turned) {
  ListedTruth truth{.file = files->find(table.text(row, "file")),
                    .viewpoint = {table.number(row, "x"), table.number(row, "z")},
                    .mask_file = file_in(table, row, "mask", files),
                    .distances_file = file_in(table, row, "distance", files)};
  truth.name = truth.file.stem().string();
  // Which lines serve a viewpoint does not depend on how they are connected.
  const ViewPlan plan(room.grid(), truth.viewpoint, {kHalfPi, 0.0});
  truth.line_distance_m = nearest_line_m(room.grid(), plan);
  const ImageHeader header = panorama_header_of(truth.file);
  truth.width = header.size.width;
  turned->add(truth.file, header.orientation);
  if (truth.mask_file.empty() && header.has_alpha) truth.mask_file = truth.file;
  if (truth.width % 4 != 0 || truth.width < kMinWidth_px) {
    throw Error(
        fmt::format("{} is {} pixels wide; a truth's width must be a multiple of 4, at least {}",
                    truth.file.string(), truth.width, kMinWidth_px));
  }
  const cv::Mat mask = read_true_mask(truth);
  if (!mask.empty() && cv::countNonZero(mask) == 0) {
    throw Error(truth.mask_file.string() + " masks every pixel; remove this view from the list");
  }
  truth.world_from_camera = world_from_camera(read_attitude(table, row));
  if (!truth.distances_file.empty()) {
    const PanoramaSize size = distance_map_size_of(truth.distances_file);
    if (size != header.size) {
      throw Error(fmt::format("{}: the distance map is {}x{}, but {}x{} is needed",
                              truth.distances_file.string(), size.width, size.height,
                              header.size.width, header.size.height));
    }
  }
  const double height_m = table.number(row, "y");
  const double off_height_m = std::abs(height_m - plan.height_m());
  if (off_height_m > kHeightTolerance_m) {
    truth.height_m = height_m;
    spdlog::warn("{}: captured {:.3f} m off the height of the lines, which initial views are at",
                 table.where(row), off_height_m);
  }
  return truth;
}

}  // namespace

std::vector<ListedTruth> read_truth(const std::filesystem::path& list, const Room& room) {
  const CsvTable table =
      CsvTable::read(list, {"file", "x", "y", "z"}, {"yaw", "pitch", "roll", "mask", "distance"});
  std::vector<ListedTruth> truths;
  TurnedPictures turned;
  std::set<std::string> names;
  ListedFiles files(list.parent_path());
  for (std::size_t row = 0; row < table.rows(); ++row) {
    try {
      truths.push_back(truth_at(table, row, &files, room, &turned));
    } catch (const Error& e) {
      const std::string what = e.what();
      // Errors of the table already name the row.
      throw Error(what.starts_with(table.where(row)) ? what : table.where(row) + ": " + what);
    }
    if (!names.insert(truths.back().name).second) {
      throw Error(table.where(row) + ": the name " + excerpt(truths.back().name) +
                  " appears twice; file stems must be unique");
    }
  }
  turned.warn();
  if (truths.empty()) {
    throw Error(list.string() + ": no views; give at least one line file,x,y,z");
  }
  return truths;
}

TrueView read_view(const ListedTruth& truth) {
  TrueView view{truth, read_panorama(truth.file), read_true_mask(truth), {}};
  if (!truth.distances_file.empty()) view.distances = read_distance_map(truth.distances_file);
  const Eigen::Matrix3d& turn = truth.world_from_camera;
  if (turn.isIdentity(0.0)) return view;
  view.image = rotate_panorama(view.image, turn);
  if (!view.mask.empty()) view.mask = rotate_mask(view.mask, turn);
  if (!view.distances.empty()) view.distances = rotate_distance_map(view.distances, turn);
  return view;
}

std::vector<std::size_t> spread_over_distance(std::span<const ListedTruth> truths,
                                              std::size_t most) {
  std::vector<std::size_t> order(truths.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return truths[a].line_distance_m < truths[b].line_distance_m;
  });
  const std::size_t count = std::min(most, order.size());
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < count; ++i) {
    chosen.push_back(order[count == 1 ? 0 : i * (order.size() - 1) / (count - 1)]);
  }
  return chosen;
}

cv::Mat exposed_as(const TrueView& truth, const cv::Mat& view) {
  if (!truth.own_exposure) return view;
  constexpr int kDark = 16, kClipped = 240;
  cv::Scalar factors = cv::Scalar::all(1.0);
  for (int colour = 0; colour < 3; ++colour) {
    std::vector<double> ratios;
    ratios.reserve(view.total());
    for (int v = 0; v < view.rows; ++v) {
      for (int u = 0; u < view.cols; ++u) {
        if (!truth.mask.empty() && truth.mask.at<uchar>(v, u) == 0) continue;
        const int shown = view.at<cv::Vec3b>(v, u)[colour];
        const int level = truth.image.at<cv::Vec3b>(v, u)[colour];
        if (std::min(shown, level) < kDark || std::max(shown, level) > kClipped) continue;
        ratios.push_back(static_cast<double>(level) / shown);
      }
    }
    if (!ratios.empty()) factors[colour] = median(std::move(ratios));
  }
  cv::Mat exposed;
  cv::multiply(view, factors, exposed);
  return exposed;
}

FeatureSimilarity features_of(const cv::Mat& view, const TrueView& truth) {
  return feature_similarity(view, truth_completed_by(view, truth));
}

ordered_json scores_of(const cv::Mat& view, const TrueView& truth,
                       const FeatureSimilarity& features) {
  return {{"psnr_db", std::min(kMaxPsnrDb, psnr_db(view, truth.image, truth.mask))},
          {"ws_psnr_db", std::min(kMaxPsnrDb, ws_psnr_db(view, truth.image, truth.mask))},
          {"ssim", ssim(view, truth_completed_by(view, truth))},
          {"fsim", fsim(features)}};
}

cv::Mat truth_completed_by(const cv::Mat& view, const TrueView& truth) {
  if (truth.mask.empty()) return truth.image;
  cv::Mat completed = view.clone();
  truth.image.copyTo(completed, truth.mask);
  return completed;
}

ordered_json quarter_scores_of(const Grid& grid, const cv::Mat& view, const TrueView& truth,
                               const FeatureSimilarity& features) {
  // Ray-space360's plan without a blend: straight ahead every side is read from its own line.
  const ViewPlan plan(grid, truth.viewpoint, {kHalfPi, 0.0});
  const cv::Mat completed = truth_completed_by(view, truth);
  ordered_json quarters = ordered_json::array();
  for (const Side side : {Side::kFront, Side::kRight, Side::kBack, Side::kLeft}) {
    const double theta_rad = side_normal_rad(side);
    const ColumnPlan ahead = plan.column(theta_rad);
    if (ahead.front_count == 0) continue;
    const auto quarter = [&](const cv::Mat& image) { return quarter_of(image, theta_rad); };
    cv::Mat mask;
    if (!truth.mask.empty()) mask = quarter(truth.mask);
    if (!mask.empty() && cv::countNonZero(mask) == 0) continue;
    const double psnr = psnr_db(quarter(view), quarter(truth.image), mask);
    quarters.push_back({{"line_distance_m", ahead.front[0].d_p_m},
                        {"psnr_db", std::min(kMaxPsnrDb, psnr)},
                        {"ssim", ssim(quarter(view), quarter(completed))},
                        {"fsim", fsim({quarter(features.weighted), quarter(features.weight)})}});
  }
  return quarters;
}

cv::Mat quarter_of(const cv::Mat& panorama, double theta_rad) {
  const int quarter = panorama.cols / 4;
  cv::Mat around;
  cv::copyMakeBorder(panorama, around, 0, 0, quarter, quarter, cv::BORDER_WRAP);
  const double centre = (theta_rad / kTwoPi + 0.5) * panorama.cols;  // the pixel edge at theta
  const int first = static_cast<int>(std::lround(centre - 0.5 * quarter));
  const int begin = quarter + wrapped_column(first, panorama.cols);
  return around.colRange(begin, begin + quarter);
}

ordered_json mean_of(std::span<const ordered_json> rows, const std::string& key) {
  double sum = 0.0;
  int known = 0;
  for (const ordered_json& row : rows) {
    const auto value = row.find(key);
    if (value == row.end() || value->is_null()) continue;
    sum += value->get<double>();
    ++known;
  }
  return known == 0 ? ordered_json(nullptr) : ordered_json(sum / known);
}

}  // namespace raywalk
