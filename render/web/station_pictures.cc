#include "render/web/station_pictures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "core/room/gain_fields.h"
#include "core/room/station_image.h"
#include "core/view/view_plan.h"

namespace raywalk::render {
namespace {

const Station& station_of(const Room& room, int line, int station) {
  return room.grid()
      .lines[static_cast<std::size_t>(line)]
      .stations[static_cast<std::size_t>(station)];
}

cv::Mat at_width(const cv::Mat& picture, int width) {
  if (picture.cols == width) return picture;
  cv::Mat scaled;
  cv::resize(picture, scaled, {width, width / 2}, 0.0, 0.0, cv::INTER_AREA);
  return scaled;
}

// Marks runs of rows of a column of a transposed picture.
void mark(RowRun rows, int theta, cv::Mat* columns) {
  if (!rows.empty()) columns->row(theta).colRange(rows.begin, rows.end).setTo(255);
}

cv::Mat left_out_pixels(const LeftOutPixels& left_out, int station) {
  cv::Mat columns(left_out.size().width, left_out.size().height, CV_8UC1, cv::Scalar(0));
  for (int theta = 0; theta < columns.rows; ++theta) {
    for (const RowRun& rows : left_out.rows(station, theta)) mark(rows, theta, &columns);
  }
  return columns.t();
}

// The place nearest to a station that views can be rendered at.
PlanPoint nearest_viewpoint(const Grid& grid, const Eigen::Vector3d& position_m) {
  PlanPoint nearest{position_m.x(), position_m.z()};
  double least_m = std::numeric_limits<double>::infinity();
  for (const Cell& cell : grid.cells) {
    const PlanPoint inside{std::clamp(position_m.x(), cell.x_min_m, cell.x_max_m),
                           std::clamp(position_m.z(), cell.z_min_m, cell.z_max_m)};
    const double off_m = std::hypot(inside.x_m - position_m.x(), inside.z_m - position_m.z());
    if (off_m >= least_m) continue;
    least_m = off_m;
    nearest = inside;
  }
  return nearest;
}

// `view`, rendered `offset_m` away (the station from the viewpoint), as the station sees it; only
// the marked pixels.
cv::Mat seen_from_station(const cv::Mat& view, const Eigen::Vector3d& offset_m,
                          const InverseMap& distances, const cv::Mat& marked) {
  const PanoramaSize size{view.cols, view.rows};
  const double scale = static_cast<double>(distances.size().width) / size.width;
  cv::Mat places(view.size(), CV_32FC2, cv::Scalar(0.0, 0.0));
  for (int v = 0; v < view.rows; ++v) {
    for (int u = 0; u < view.cols; ++u) {
      if (marked.at<std::uint8_t>(v, u) == 0) continue;
      const Eigen::Vector3d direction =
          direction_from_angles(angles_from_pixel({double(u), double(v)}, size));
      const double inverse =
          distances.at(static_cast<int>((u + 0.5) * scale), static_cast<int>((v + 0.5) * scale));
      const PixelPosition place =
          pixel_from_angles(angles_from_direction(direction + inverse * offset_m), size);
      places.at<cv::Vec2f>(v, u) = {
          static_cast<float>(place.u),
          std::clamp(static_cast<float>(place.v), 0.0F, static_cast<float>(size.height - 1))};
    }
  }
  cv::Mat seen;
  cv::remap(view, seen, places, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_WRAP);
  return seen;
}

}  // namespace

cv::Mat captured_picture_at(const Room& room, int line, int station, int width) {
  cv::Mat columns = captured_columns(room.volume(line), station);
  if (!room.gains().empty()) {
    apply_gains(room.gains()[static_cast<std::size_t>(line)][static_cast<std::size_t>(station)],
                &columns);
  }
  cv::Mat picture;
  cv::cvtColor(columns.t(), picture, cv::COLOR_RGB2BGR);
  return at_width(picture, width);
}

cv::Mat hidden_in_views(const Room& room, int line, int station, int width) {
  cv::Mat hidden;
  if (room.volume(line).masked()) {
    hidden = at_width(captured_validity(room.volume(line), station).t() == 0, width);
  }
  const LeftOutPixels& left_out = room.distances(line).left_out();
  if (left_out.any(station)) {
    const cv::Mat more = at_width(left_out_pixels(left_out, station), width);
    hidden = hidden.empty() ? more : cv::Mat(cv::max(hidden, more));
  }
  if (hidden.empty() || cv::countNonZero(hidden) == 0) return {};
  return hidden > 0;  // also what is partly hidden
}

cv::Mat StationPictures::picture_of(int line, int station, const InverseMap& distances) {
  cv::Mat picture = captured_picture_at(room_, line, station, options_.width);
  const cv::Mat hidden = hidden_in_views(room_, line, station, options_.width);
  if (hidden.empty()) return picture;
  if (!renderer_) renderer_ = std::make_unique<Renderer>(room_, options_);
  const Eigen::Vector3d& position_m = station_of(room_, line, station).position_m;
  const PlanPoint viewpoint = nearest_viewpoint(room_.grid(), position_m);
  const cv::Mat view = renderer_->render(viewpoint).image;
  const ViewPlan plan(room_.grid(), viewpoint, {kHalfPi, 0.0});  // any connection: for the height
  const Eigen::Vector3d viewpoint_m(viewpoint.x_m, plan.height_m(), viewpoint.z_m);
  seen_from_station(view, position_m - viewpoint_m, distances, hidden).copyTo(picture, hidden);
  return picture;
}

}  // namespace raywalk::render
