#include "simulator/room/truth_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/files/atomic_output.h"
#include "core/files/image_file.h"

namespace raywalk::capture {
namespace {

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

}  // namespace raywalk::capture
