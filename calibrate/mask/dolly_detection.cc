#include "calibrate/mask/dolly_detection.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "calibrate/base/frame_masks.h"
#include "core/base/error.h"
#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/image_file.h"
#include "core/panorama/panorama_sampler.h"

namespace raywalk::calibrate {
namespace {

// The downward view in which stations are compared: equidistant, the nadir in its middle.
constexpr double kReach_deg = 60.0;
constexpr double kPixel_deg = 0.5;
constexpr int kRadius_px = static_cast<int>(kReach_deg / kPixel_deg);
constexpr int kSide_px = 2 * kRadius_px + 1;

constexpr std::size_t kFewestStations = 8;
constexpr std::size_t kMostStations = 24;  // of a line
// Half angle about the nadir that the camera's mount covers, if there is one.
constexpr double kMount_deg = 4.0;
constexpr double kNoiseFactor = 4.0;  // deviations up to this multiple of the mount's are noise
constexpr double kLeastNoise_levels = 0.5;  // rounding and compression
constexpr double kStillShare = 0.5;         // largest ratio of the mount's deviation to the room's
constexpr double kMargin_deg = 2.0;
constexpr int kClosing_px = 2;

// Where the pixels of the downward view are in a panorama of a size, CV_32FC2.
cv::Mat positions_in(PanoramaSize panorama) {
  cv::Mat positions(kSide_px, kSide_px, CV_32FC2);
  for (int v = 0; v < kSide_px; ++v) {
    for (int u = 0; u < kSide_px; ++u) {
      const double right = u - kRadius_px, forward = kRadius_px - v;
      const double phi = -kHalfPi + radians_from_degrees(kPixel_deg * std::hypot(right, forward));
      const PixelPosition at = pixel_from_angles({std::atan2(right, forward), phi}, panorama);
      positions.at<cv::Vec2f>(v, u) = {static_cast<float>(at.u), static_cast<float>(at.v)};
    }
  }
  return positions;
}

// A station's view down.
struct StationView {
  cv::Mat levels{};  // CV_32FC3
  cv::Mat valid{};   // CV_8UC1, 255, or 0 where a masked pixel was read
};

// Averaged to about the resolution of the view.
cv::Mat reduced(const cv::Mat& panorama) {
  constexpr int kWidth_px = static_cast<int>(360.0 / kPixel_deg);
  if (panorama.cols <= kWidth_px) return panorama;
  cv::Mat small;
  cv::resize(panorama, small, {kWidth_px, kWidth_px / 2}, 0.0, 0.0, cv::INTER_AREA);
  return small;
}

StationView read_view(const CaptureSet& set, int station) {
  constexpr int kReach_px = 2;  // of cubic interpolation
  const CaptureFrame& frame = set.frames[static_cast<std::size_t>(station)];
  const cv::Mat panorama = reduced(read_panorama(frame.file));
  const cv::Mat positions =
      positions_in({panorama.cols, panorama.rows}) + cv::Scalar::all(kReach_px);
  cv::Mat bordered;
  with_wrapped_border(panorama, kReach_px).convertTo(bordered, CV_32F);
  StationView view{.valid = cv::Mat(kSide_px, kSide_px, CV_8UC1, cv::Scalar(255))};
  cv::remap(bordered, view.levels, positions, cv::noArray(), cv::INTER_CUBIC);
  if (!frame.mask) return view;
  const cv::Mat whole = reduced(own_mask(frame, set.frame)) == 255;
  const int side = 2 * kReach_px + 1;
  cv::Mat least;
  cv::erode(with_wrapped_border(whole, kReach_px), least, cv::Mat::ones(side, side, CV_8UC1));
  cv::remap(least, view.valid, positions, cv::noArray(), cv::INTER_NEAREST);
  return view;
}

std::vector<int> spread_stations(const CaptureLine& line) {
  const std::size_t count = std::min(line.frames.size(), kMostStations);
  std::vector<int> spread;
  for (std::size_t i = 0; i < count; ++i) {
    spread.push_back(line.frames[i * (line.frames.size() - 1) / (count - 1)]);
  }
  return spread;
}

std::vector<StationView> read_views(const CaptureSet& set, const std::vector<int>& stations,
                                    Progress* progress) {
  std::vector<StationView> views(stations.size());
  parallel_for(0, static_cast<int>(stations.size()), 1, [&](int begin, int end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      views[i] = read_view(set, stations[i]);
      progress->advance();
    }
  });
  return views;
}

cv::Mat within(double angle_deg) {
  cv::Mat mask(kSide_px, kSide_px, CV_8UC1, cv::Scalar(0));
  cv::circle(mask, {kRadius_px, kRadius_px}, static_cast<int>(angle_deg / kPixel_deg),
             cv::Scalar(255), cv::FILLED);
  return mask;
}

double median_of(const cv::Mat& values, const cv::Mat& where) {
  std::vector<double> chosen;
  for (int v = 0; v < values.rows; ++v) {
    for (int u = 0; u < values.cols; ++u) {
      if (where.at<unsigned char>(v, u) != 0) chosen.push_back(values.at<float>(v, u));
    }
  }
  return median(std::move(chosen));
}

// Exposure may drift from station to station; the mount, if there is one, measures it.
void equalise(std::vector<StationView>* views, const cv::Mat& mount) {
  const auto brightness = [&](const cv::Mat& view) {
    const cv::Scalar mean = cv::mean(view, mount);
    return mean[0] + mean[1] + mean[2] + 1.0;
  };
  const double first = brightness(views->front().levels);
  for (StationView& view : *views) view.levels *= first / brightness(view.levels);
}

// 255 where every station is valid.
cv::Mat valid_everywhere(const std::vector<StationView>& views) {
  cv::Mat valid = views.front().valid.clone();
  for (const StationView& view : views) valid &= view.valid;
  return valid;
}

// Number of stations that are valid, CV_32FC1.
cv::Mat valid_count(const std::vector<StationView>& views) {
  cv::Mat count(kSide_px, kSide_px, CV_32FC1, cv::Scalar(0));
  for (const StationView& view : views) cv::add(count, cv::Scalar(1.0), count, view.valid);
  return count;
}

// Standard deviation over the stations that are valid at a pixel, maximum over the colours,
// CV_32FC1.
cv::Mat deviation_of(const std::vector<StationView>& views, const cv::Mat& count) {
  cv::Mat sum(kSide_px, kSide_px, CV_32FC3, cv::Scalar::all(0)), squares = sum.clone(), counts;
  cv::merge(std::vector<cv::Mat>(3, cv::max(count, 1.0)), counts);
  for (const StationView& view : views) cv::add(sum, view.levels, sum, view.valid);
  const cv::Mat mean = sum / counts;
  for (const StationView& view : views) {
    const cv::Mat off = view.levels - mean;
    cv::add(squares, off.mul(off), squares, view.valid);
  }
  cv::Mat deviation = squares / counts;
  cv::sqrt(deviation, deviation);
  std::vector<cv::Mat> colours;
  cv::split(deviation, colours);
  return cv::max(cv::max(colours[0], colours[1]), colours[2]);
}

// The region connected to the middle of the view, with its holes filled.
cv::Mat connected_with_nadir(const cv::Mat& still) {
  cv::Mat closed, labels;
  const int side = 2 * kClosing_px + 1;
  cv::morphologyEx(still, closed, cv::MORPH_CLOSE,
                   cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}));
  closed |= within(0.5 * kMount_deg);
  cv::connectedComponents(closed, labels, 4, CV_32S);
  cv::Mat component = labels == labels.at<int>(kRadius_px, kRadius_px);
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(component, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  cv::drawContours(component, outlines, -1, cv::Scalar(255), cv::FILLED);
  return component;
}

// 255 in the static region of a line around the nadir; empty if there is none.
cv::Mat still_region(std::vector<StationView> views) {
  const cv::Mat mount = within(kMount_deg) & valid_everywhere(views), view = within(kReach_deg);
  if (cv::countNonZero(mount) == 0) {
    spdlog::info("the frames' masks hide what is below the camera; no dolly is looked for there");
    return {};
  }
  equalise(&views, mount);
  const cv::Mat count = valid_count(views);
  const cv::Mat known = count >= static_cast<double>(kFewestStations);
  cv::Mat deviation = deviation_of(views, count);
  cv::GaussianBlur(deviation, deviation, {3, 3}, 0.0);
  const double noise = std::max(median_of(deviation, mount), kLeastNoise_levels);
  // The room's deviation is measured in the outer half of the view, outside of a dolly.
  const cv::Mat outside = (view - within(kReach_deg * std::sqrt(0.5))) & known;
  if (cv::countNonZero(outside) == 0) return {};
  const double moving = median_of(deviation, outside);
  if (noise > kStillShare * moving) return {};
  const cv::Mat still = (deviation < std::min(kNoiseFactor * noise, moving)) | ~known;
  return connected_with_nadir(still & view) & known;
}

// Largest angle from the nadir.
double reach_deg(const cv::Mat& region) {
  std::vector<cv::Point> points;
  cv::findNonZero(region, points);
  double reach_px = 0.0;
  for (const cv::Point& point : points) {
    reach_px = std::max(reach_px, std::hypot(point.x - kRadius_px, point.y - kRadius_px));
  }
  return kPixel_deg * reach_px;
}

cv::Mat mask_from(const cv::Mat& region, PanoramaSize size) {
  cv::Mat mask(size.height, size.width, CV_8UC1, cv::Scalar(255));
  for (int v = size.height / 2; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      const SphereAngles angles =
          angles_from_pixel({static_cast<double>(u), static_cast<double>(v)}, size);
      const double off_px = degrees_from_radians(angles.phi_rad + kHalfPi) / kPixel_deg;
      const int at_u =
          kRadius_px + static_cast<int>(std::lround(off_px * std::sin(angles.theta_rad)));
      const int at_v =
          kRadius_px - static_cast<int>(std::lround(off_px * std::cos(angles.theta_rad)));
      if (at_u < 0 || at_v < 0 || at_u >= kSide_px || at_v >= kSide_px) continue;
      if (region.at<unsigned char>(at_v, at_u) != 0) mask.at<unsigned char>(v, u) = 0;
    }
  }
  return mask;
}

std::vector<std::vector<int>> stations_by_line(const CaptureSet& set) {
  std::vector<std::vector<int>> stations;
  for (const CaptureLine& line : set.lines) {
    if (line.frames.size() >= kFewestStations) stations.push_back(spread_stations(line));
  }
  if (stations.empty()) {
    throw Error(
        "no line has the 8 stations that are needed to detect what moves with the "
        "camera; give a cone or a picture of the mask instead");
  }
  return stations;
}

}  // namespace

std::optional<DollyDetection> detect_dolly(const CaptureSet& panoramas) {
  const std::vector<std::vector<int>> lines = stations_by_line(panoramas);
  DollyDetection found;
  found.lines = static_cast<int>(lines.size());
  for (const auto& stations : lines) found.stations += static_cast<int>(stations.size());
  Progress progress("looking for the dolly", found.stations, "panoramas");
  cv::Mat region(kSide_px, kSide_px, CV_8UC1, cv::Scalar(0));
  for (const auto& stations : lines) {
    const cv::Mat still = still_region(read_views(panoramas, stations, &progress));
    if (!still.empty()) region |= still;
  }
  if (cv::countNonZero(region) == 0) return std::nullopt;
  found.reach_deg = reach_deg(region) + kMargin_deg;
  if (found.reach_deg >= kReach_deg) {
    throw Error(
        "a dolly cannot be distinguished from a floor without texture; give a cone or a "
        "picture of the mask instead");
  }
  const int margin = static_cast<int>(std::lround(kMargin_deg / kPixel_deg));
  cv::dilate(region, region,
             cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * margin + 1, 2 * margin + 1}));
  found.mask = mask_from(region, panoramas.frame);
  return found;
}

}  // namespace raywalk::calibrate
