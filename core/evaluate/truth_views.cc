#include "core/evaluate/truth_views.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <opencv2/core.hpp>
#include <set>

#include "core/base/error.h"
#include "core/files/csv.h"
#include "core/files/frame_list.h"
#include "core/files/image_file.h"
#include "core/panorama/panorama_rotation.h"
#include "core/view/view_plan.h"

namespace raywalk {
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
                              const std::filesystem::path& list) {
  if (!table.has_column(column) || table.text(row, column).empty()) return {};
  return list.parent_path() / table.text(row, column);
}

// Empty without; throws Error where its size is another than the image's.
cv::Mat read_true_distances(const ListedTruth& truth) {
  if (truth.distances.empty()) return {};
  cv::Mat distances = read_distance_map(truth.distances);
  if (distances.cols != truth.width || distances.rows != truth.width / 2) {
    throw Error(fmt::format("{}: the distance map is {}x{}, but {}x{} is needed",
                            truth.distances.string(), distances.cols, distances.rows, truth.width,
                            truth.width / 2));
  }
  return distances;
}

// Empty without.
cv::Mat read_truth_mask(const ListedTruth& truth) {
  if (truth.mask.empty()) return {};
  return read_mask(truth.mask, {truth.width, truth.width / 2});
}

ListedTruth truth_at(const CsvTable& table, std::size_t row, const std::filesystem::path& list,
                     const Room& room, TurnedPictures* turned) {
  ListedTruth truth;
  truth.file = list.parent_path() / table.text(row, "file");
  truth.name = truth.file.stem().string();
  truth.viewpoint = {table.number(row, "x"), table.number(row, "z")};
  // Which lines serve a viewpoint does not depend on how they are connected.
  const ViewPlan plan(room.grid(), truth.viewpoint, {kHalfPi, 0.0});
  truth.line_distance_m = nearest_line_m(room.grid(), plan);
  const ImageHeader header = panorama_header_of(truth.file);
  truth.width = header.size.width;
  turned->add(truth.file, header.orientation);
  if (truth.width % 4 != 0 || truth.width < kMinWidth_px) {
    throw Error(
        fmt::format("{} is {} pixels wide; a truth's width must be a multiple of 4, at "
                    "least {}",
                    truth.file.string(), truth.width, kMinWidth_px));
  }
  truth.mask = file_in(table, row, "mask", list);
  if (!truth.mask.empty() && cv::countNonZero(read_truth_mask(truth)) == 0) {
    throw Error(truth.mask.string() + " masks every pixel; remove this view from the list");
  }
  truth.world_from_camera = world_from_camera(read_attitude(table, row));
  truth.distances = file_in(table, row, "distance", list);
  read_true_distances(truth);
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
  for (std::size_t row = 0; row < table.rows(); ++row) {
    try {
      truths.push_back(truth_at(table, row, list, room, &turned));
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
  TrueView view{.name = truth.name,
                .viewpoint = truth.viewpoint,
                .height_m = truth.height_m,
                .image = read_panorama(truth.file),
                .mask = read_truth_mask(truth),
                .distances = read_true_distances(truth)};
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

}  // namespace raywalk
