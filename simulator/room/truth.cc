#include "simulator/room/truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/csv.h"
#include "core/files/image_file.h"
#include "simulator/room/hash_random.h"
#include "simulator/room/stations.h"

namespace raywalk::simulator {
namespace {

using Eigen::Vector2d;

// A position in a cell, (x, z) from its centre in units of its side.
struct InCell {
  std::string name;
  Vector2d at;
};

// `step` is the spacing of stations in units of the cell's side.
std::vector<InCell> hard_cases(double step, HashRandom* random) {
  const double side = random->chance(0.5) ? 0.45 : -0.45;
  const double half_steps = std::floor(0.5 / step);
  // Whole steps from the corner, well inside of the line.
  const auto on_line = [&] {
    return -0.5 + step * std::floor(half_steps * (0.5 + random->uniform()));
  };
  return {{"centre", {0.0, 0.0}},
          {"quarter_pp", {0.25, 0.25}},
          {"corner", {side, random->chance(0.5) ? 0.45 : -0.45}},
          {"edge_front", {random->uniform(-0.3, 0.3), 0.45}},
          {"line_front_between", {on_line() + 0.5 * step, 0.5}},
          {"quarter_mm", {-0.25, -0.25}},
          {"edge_left", {-0.45, random->uniform(-0.3, 0.3)}},
          {"line_left_on", {-0.5, on_line()}},
          {"quarter_pm", {0.25, -0.25}},
          {"quarter_mp", {-0.25, 0.25}}};
}

// Stratified over a grid of 3 x 3 strata, visited in a fixed scattered order.
Vector2d free_place(int number, HashRandom* random) {
  constexpr int kStrata = 3;
  const int stratum = (number * 5 + 2) % (kStrata * kStrata);
  const int column = stratum % kStrata, row = stratum / kStrata;
  const Vector2d corner(column, row);
  const double in_row = random->uniform();
  const double in_column = random->uniform();
  return (corner + Vector2d(in_column, in_row)) / kStrata - Vector2d(0.5, 0.5);
}

Eigen::Vector3d in_world(const GridSettings& grid, std::int64_t cell, const Vector2d& in_cell) {
  const auto [row, column] = std::lldiv(cell, grid.cells_x);
  const Vector2d centre(static_cast<double>(column) + 0.5 - 0.5 * grid.cells_x,
                        static_cast<double>(row) + 0.5 - 0.5 * grid.cells_z);
  const Vector2d at_m = grid.cell_side_m * (centre + in_cell);
  return {at_m.x(), 0.0, at_m.y()};
}

// Along a single line there are no cells: viewpoints between its stations, every second one beside
// the line by up to a tenth of the way to the next station.
std::vector<TruthViewpoint> between_stations(const PlannedLine& line, int count,
                                             HashRandom* random) {
  const int gaps = static_cast<int>(line.along_m.size()) - 1;
  std::vector<TruthViewpoint> viewpoints;
  for (int i = 0; i < count; ++i) {
    const auto gap = static_cast<std::size_t>((static_cast<long>(i) * gaps + gaps / 2) / count);
    const double from = line.along_m[gap], step = line.along_m[gap + 1] - from;
    const double along = from + random->uniform(0.3, 0.7) * step;
    const double beside = random->uniform(-0.1, 0.1) * step;
    Eigen::Vector3d at = line.position_m(along);
    if (i % 2 == 1) (line.axis == LineAxis::kX ? at.z() : at.x()) += beside;
    viewpoints.push_back({fmt::format("{}_{:03}", i % 2 == 1 ? "beside" : "between", i), at});
  }
  return viewpoints;
}

// Cells in an order that is spread over all of them however many are taken: steps of the golden
// section of their number, which is made coprime to it so that every cell is reached.
class SpreadCells {
 public:
  SpreadCells(const GridSettings& grid, HashRandom* random)
      : count_(std::int64_t{grid.cells_x} * grid.cells_z),
        step_(std::max<std::int64_t>(std::llround(0.618034 * static_cast<double>(count_)), 1)),
        at_(random->below(static_cast<int>(count_))) {
    while (std::gcd(step_, count_) != 1) ++step_;
  }

  std::int64_t count() const { return count_; }
  std::int64_t next() {
    at_ = (at_ + step_) % count_;
    return at_;
  }

 private:
  std::int64_t count_, step_, at_;
};

cv::Mat millimetres_of(const cv::Mat& distance_m) {
  cv::Mat mm(distance_m.size(), CV_16UC1);
  std::transform(distance_m.begin<float>(), distance_m.end<float>(), mm.begin<ushort>(),
                 [](float metres) {
                   if (!std::isfinite(metres)) return ushort{0};
                   return static_cast<ushort>(
                       std::clamp(std::round(static_cast<double>(metres) * 1e3), 1.0, 65535.0));
                 });
  return mm;
}

}  // namespace

std::vector<TruthViewpoint> truth_viewpoints(const VirtualRoom& room, int count) {
  constexpr double kAround = 0.1;  // free around a viewpoint, in cell sides
  const GridSettings& grid = room.settings().grid;
  HashRandom random(hash_bits(static_cast<std::uint64_t>(room.settings().seed), 0x7127));
  const std::vector<PlannedLine> lines = plan_lines(grid);
  if (lines.size() == 1) return between_stations(lines.front(), count, &random);
  const auto& along_m = lines.front().along_m;
  const std::vector<InCell> hard =
      hard_cases((along_m[1] - along_m[0]) / grid.cell_side_m, &random);
  SpreadCells cells(grid, &random);
  std::vector<TruthViewpoint> viewpoints;
  for (int i = 0; i < count; ++i) {
    const int number = i - static_cast<int>(hard.size());
    const InCell place =
        number < 0 ? hard[static_cast<std::size_t>(i)]
                   : InCell{fmt::format("free_{:03}", number), free_place(number, &random)};
    Eigen::Vector3d at = in_world(grid, cells.next(), place.at);
    for (std::int64_t tries = 1; !room.is_free(at, kAround * grid.cell_side_m); ++tries) {
      if (tries > cells.count()) {
        throw Error(
            fmt::format("no cell has a free place for the true view {}; move the grid "
                        "(scene.x_m, y_m and z_m), or name true views in a table (--views)",
                        place.name));
      }
      at = in_world(grid, cells.next(), place.at);
    }
    viewpoints.push_back({place.name, at});
  }
  return viewpoints;
}

std::vector<TruthViewpoint> read_truth_viewpoints(const std::filesystem::path& file) {
  const CsvTable table = CsvTable::read(file, {"name", "x", "z"}, {"y"});
  const std::vector<std::string> names = file_names_of_rows(table, "name");
  std::vector<TruthViewpoint> viewpoints;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double y_m = table.has_column("y") ? table.number(row, "y") : 0.0;
    viewpoints.push_back({names[row], {table.number(row, "x"), y_m, table.number(row, "z")}});
  }
  if (viewpoints.empty()) {
    throw Error(file.string() + ": no viewpoints; give at least one line name,x,z");
  }
  return viewpoints;
}

std::string position_fields(const Eigen::Vector3d& position_m) {
  // Adding zero turns -0 into 0.
  return fmt::format("{:.9f},{:.9f},{:.9f}", position_m.x() + 0.0, position_m.y() + 0.0,
                     position_m.z() + 0.0);
}

std::string pose_fields(const CameraPose& pose) {
  return fmt::format("{},{:.9f},{:.9f},{:.9f}", position_fields(pose.position_m),
                     degrees_from_radians(pose.attitude.yaw_rad),
                     degrees_from_radians(pose.attitude.pitch_rad),
                     degrees_from_radians(pose.attitude.roll_rad));
}

cv::Mat thin_structures(const cv::Mat& distance_m) {
  constexpr double kWidth_deg = 3.0;
  constexpr float kNearer = 0.1F;  // relative, in inverse distance
  // The longitude wraps around.
  const int side = std::max(static_cast<int>(std::lround(distance_m.cols * kWidth_deg / 360.0)), 3);
  cv::Mat inverse(distance_m.size(), CV_32FC1), around;
  std::transform(distance_m.begin<float>(), distance_m.end<float>(), inverse.begin<float>(),
                 [](float metres) { return std::isinf(metres) ? 0.0F : 1.0F / metres; });
  cv::copyMakeBorder(inverse, around, 0, 0, 2 * side, 2 * side, cv::BORDER_WRAP);
  // An opening of the inverse distance removes what is near and narrower than its window.
  cv::Mat opened;
  cv::morphologyEx(around, opened, cv::MORPH_OPEN,
                   cv::getStructuringElement(cv::MORPH_RECT, {side, side}));
  const cv::Mat thin = around - opened > kNearer * around;
  cv::Mat mask;
  cv::dilate(thin, mask, cv::getStructuringElement(cv::MORPH_RECT, {3, 3}));
  return mask.colRange(2 * side, 2 * side + distance_m.cols).clone();
}

void write_distance_map(const VirtualRoom& room, const CameraPose& pose, PanoramaSize size,
                        const std::filesystem::path& file) {
  write_image(file, millimetres_of(room.distance_map(pose, size)));
}

void write_truth_views(const VirtualRoom& room, std::span<const TruthViewpoint> viewpoints,
                       PanoramaSize size, const std::filesystem::path& directory, bool thin,
                       Progress* progress) {
  std::string table = "file,x,y,z,distance\n", thin_table = "file,x,y,z,mask\n";
  for (const TruthViewpoint& viewpoint : viewpoints) {
    const CameraPose pose{viewpoint.position_m, {}};
    const std::string file = "gt/" + viewpoint.name + ".png";
    write_image(directory / file, room.render(PanoramaRays(size), pose));
    const std::string distance_file = "dist/gt_" + viewpoint.name + ".png";
    write_distance_map(room, pose, size, directory / distance_file);
    const std::string row = file + "," + position_fields(viewpoint.position_m);
    table += fmt::format("{},{}\n", row, distance_file);
    if (thin) {
      const std::string mask_file = "thin/" + viewpoint.name + ".png";
      const cv::Mat mask = thin_structures(room.distance_map(pose, size));
      write_image(directory / mask_file, mask);
      if (cv::countNonZero(mask) > 0) thin_table += fmt::format("{},{}\n", row, mask_file);
    }
    progress->advance();
  }
  if (thin) write_file_atomically(directory / "gt_thin.csv", thin_table);
  write_file_atomically(directory / "gt.csv", table);
}

}  // namespace raywalk::simulator
