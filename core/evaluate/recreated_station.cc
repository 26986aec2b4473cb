#include "core/evaluate/recreated_station.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <opencv2/core.hpp>

#include "core/base/parallel.h"
#include "core/evaluate/captured_station.h"
#include "core/evaluate/metrics.h"
#include "core/geometry/panorama_pixels.h"
#include "core/room/tiled_rays.h"
#include "core/view/column_sources.h"
#include "core/view/station_mixing.h"

namespace raywalk {
namespace {

constexpr int kMaps = 2;
// Width of the compared pixels: enough to measure the effect of a station.
constexpr int kComparedWidth = 512;
constexpr int kColumnsAtOnce = 32;

const Station& station_of(const Room& room, const HeldOutStation& index) {
  return room.grid()
      .lines[static_cast<size_t>(index.line)]
      .stations[static_cast<size_t>(index.station)];
}

SampledPixels compared_pixels(PanoramaSize panorama) {
  const double ratio = static_cast<double>(panorama.width) / kComparedWidth;
  return {panorama, std::max(1, static_cast<int>(std::lround(ratio)))};
}

// The maps of lines nearest to a position, without those captured at `left_out_m`.
std::vector<MapStation> other_maps(const Room& room, std::span<const int> lines,
                                   const Eigen::Vector3d& position_m,
                                   const Eigen::Vector3d& left_out_m) {
  constexpr int kAny = std::numeric_limits<int>::max();
  const auto at_position = static_cast<int>(lines.size());  // lines may cross there
  std::vector<MapStation> maps =
      nearest_maps(room, lines, position_m, 0.0, kAny, kMaps + at_position);
  std::erase_if(maps, [&](const MapStation& map) { return map.position_m == left_out_m; });
  maps.resize(std::min<size_t>(maps.size(), kMaps));
  return maps;
}

// The distances of a view as the map of a station, behind those in the vectors.
void append_map(const DistanceView& view, std::vector<float>* distance_m,
                std::vector<std::uint8_t>* confidence) {
  const PanoramaSize size = view.size();
  for (int theta = 0; theta < size.width; ++theta) {
    const float* const omega = view.column(theta);
    const float* const trust = view.trust(theta);
    for (int row = 0; row < size.height; ++row) {
      distance_m->push_back(1.0f / omega[row]);  // infinite where omega is 0
      const float part = trust == nullptr ? 1.0f : trust[row];
      confidence->push_back(static_cast<std::uint8_t>(std::lround(255.0f * part)));
    }
  }
}

// A station's view, rendered. All pictures are laid out as captured_columns().
struct Recreation {
  explicit Recreation(const SampledPixels& sampled)
      : pixels(sampled),
        columns(pixels.columns(), pixels.rows(), CV_8UC3),
        unknown(pixels.columns(), pixels.rows(), CV_8UC1, cv::Scalar(0)) {}

  // Keeps the pixels of a rendered column.
  void keep(int i, const cv::Mat& bgr, std::span<const UnreadRows> unread) {
    for (int j = 0; j < pixels.rows(); ++j) {
      const int row = pixels.at(j);
      std::reverse_copy(bgr.ptr(row), bgr.ptr(row) + 3, columns.ptr(i) + 3 * j);
      const bool is_unknown = std::ranges::any_of(
          unread, [&](const UnreadRows& of) { return row >= of.rows.begin && row < of.rows.end; });
      if (is_unknown) unknown.at<std::uint8_t>(i, j) = 255;
    }
  }

  SampledPixels pixels;
  cv::Mat columns;
  cv::Mat unknown;  // CV_8UC1, 255 where neither neighbour shows anything
};

Recreation render_columns(const MixedView& view, const SampledPixels& pixels) {
  Recreation result(pixels);
  parallel_for(0, pixels.columns(), kColumnsAtOnce, [&](int begin, int end) {
    StationMixing mixing(view);
    cv::Mat column(view.output.height, 1, CV_8UC3);
    for (int i = begin; i < end; ++i) {
      mixing.render(pixels.at(i), 1, {0, view.output.height}, column);
      result.keep(i, column, mixing.take_unread());
    }
  });
  return result;
}

// 255 where both neighbours see something nearer: CV_8UC1.
cv::Mat hidden_from_both(const Visibility& visibility, PanoramaSize distances,
                         const SampledPixels& pixels) {
  cv::Mat hidden(pixels.columns(), pixels.rows(), CV_8UC1, cv::Scalar(0));
  for (int i = 0; i < pixels.columns(); ++i) {
    for (int j = 0; j < pixels.rows(); ++j) {
      const PixelPosition pixel{double(pixels.at(i)), double(pixels.at(j))};
      const PixelsAround around = pixels_around(
          pixel_from_angles(angles_from_pixel(pixel, pixels.panorama), distances), distances);
      const std::uint8_t* const fill = visibility.fill(around.nearest_column());
      if (fill[around.nearest_row()] == kReadUnseen) hidden.at<std::uint8_t>(i, j) = 255;
    }
  }
  return hidden;
}

cv::Vec3b color_at(const LineVolume& volume, int station, PixelPosition pixel) {
  const PixelsAround around = pixels_around(pixel, volume.panorama());
  cv::Vec3d sum(0, 0, 0);
  for (size_t i = 0; i < 2; ++i) {
    const auto column = volume.column(station, around.column[i]);
    for (size_t j = 0; j < 2; ++j) {
      const std::uint8_t* rgb = column.data() + 3 * static_cast<size_t>(around.row[j]);
      sum += around.weight(i, j) * cv::Vec3d(rgb[0], rgb[1], rgb[2]);
    }
  }
  return {static_cast<std::uint8_t>(std::lround(sum[0])),
          static_cast<std::uint8_t>(std::lround(sum[1])),
          static_cast<std::uint8_t>(std::lround(sum[2]))};
}

double latitude_cosine(int row, PanoramaSize size) {
  return std::cos(angles_from_pixel({0.0, static_cast<double>(row)}, size).phi_rad);
}

// Mean squared difference between the captured view and itself displaced by the angle of
// `tolerance_px` rows, along rows and along columns; towards a pole that angle spans more columns.
double displacement_error(const LineVolume& volume, int station, const SampledPixels& pixels,
                          double tolerance_px, const cv::Mat& captured, const cv::Mat& compared) {
  cv::Mat along_row(captured.size(), CV_8UC3), along_column(captured.size(), CV_8UC3);
  parallel_for(0, pixels.columns(), kColumnsAtOnce, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const TileReading reading;
      for (int j = 0; j < pixels.rows(); ++j) {
        const double u = pixels.at(i), v = pixels.at(j);
        const double narrowing = std::max(latitude_cosine(pixels.at(j), pixels.panorama),
                                          tolerance_px / pixels.panorama.width);
        along_row.at<cv::Vec3b>(i, j) =
            color_at(volume, station, {u + tolerance_px / narrowing, v});
        along_column.at<cv::Vec3b>(i, j) = color_at(volume, station, {u, v + tolerance_px});
      }
    }
  });
  return 0.5 * (mean_squared_error(captured, along_row, compared) +
                mean_squared_error(captured, along_column, compared));
}

// Of the solid angle of the `valid` pixels.
double share_of(const cv::Mat& marked, const cv::Mat& valid, const SampledPixels& pixels) {
  double sum = 0.0, all = 0.0;
  for (int j = 0; j < pixels.rows(); ++j) {
    const double part = latitude_cosine(pixels.at(j), pixels.panorama);
    for (int i = 0; i < pixels.columns(); ++i) {
      if (valid.at<std::uint8_t>(i, j) == 0) continue;
      all += part;
      if (marked.at<std::uint8_t>(i, j) != 0) sum += part;
    }
  }
  return all > 0.0 ? sum / all : 1.0;
}

double capped(double db) { return std::min(db, kMaxPsnrDb); }

}  // namespace

Room StationRecreation::with_maps_of_neighbours(const Room& kept, const RaySource& between,
                                                const Eigen::Vector3d& left_out_m) {
  std::vector<int> stations;
  std::vector<float> distance_m;
  std::vector<std::uint8_t> confidence;
  for (const int station : {between.station, between.station + 1}) {
    const Eigen::Vector3d& at_m = station_of(kept, {between.line, station}).position_m;
    const auto maps = other_maps(distances_, {{between.line}}, at_m, left_out_m);
    if (maps.empty()) continue;
    distance_view_.compute(maps, at_m);
    append_map(distance_view_, &distance_m, &confidence);
    stations.push_back(station);
  }
  return kept.with_distances(between.line,
                             kept.distances(between.line)
                                 .with_maps(std::move(stations), distance_view_.size(),
                                            std::move(distance_m), std::move(confidence)));
}

RecreationScore StationRecreation::score(const HeldOutStation& station, const Room& kept) {
  const Station& truth = station_of(captured_, station);
  const Line& line = kept.grid().lines[static_cast<size_t>(station.line)];
  const RaySource between = source_at(line, station.line, {.d_p_m = 0.0, .along_m = truth.along_m});
  const ViewPlan plan(kept.grid(), truth.position_m, between);
  const SampledPixels pixels = compared_pixels(kept.panorama());
  const ViewOptions options;
  const auto sources = [&](double theta_rad) {
    return column_sources(plan.column(theta_rad), options);
  };
  const PanoramaSize output = kept.panorama();
  const ViewOptions cut{.generation = Generation::kInitial};
  const FillStations others;  // none
  const Visibility of_nothing(kept);
  const Recreation without_depth = render_columns({.room = kept,
                                                   .options = cut,
                                                   .distances = distance_view_,
                                                   .visibility = of_nothing,
                                                   .edges = Edges(),
                                                   .fill = others,
                                                   .sources = sources,
                                                   .output = output},
                                                  pixels);
  Recreation with_distances = without_depth;
  cv::Mat hidden = without_depth.unknown;
  std::vector<int> lines(distances_.grid().lines.size());
  std::iota(lines.begin(), lines.end(), 0);
  const auto maps = other_maps(distances_, lines, truth.position_m, truth.position_m);
  if (!maps.empty()) {
    const Room mapped = with_maps_of_neighbours(kept, between, truth.position_m);
    distance_view_.compute(maps, truth.position_m);
    const PanoramaSize size = distance_view_.size();
    Visibility visibility(mapped);
    visibility.compute(distance_view_, {0, size.width}, sources, plan.lines(), 0.0,
                       station_mix(options), others);
    Edges edges;
    edges.compute(distance_view_, 0, size.width);
    with_distances = render_columns({.room = mapped,
                                     .options = options,
                                     .distances = distance_view_,
                                     .visibility = visibility,
                                     .edges = edges,
                                     .fill = others,
                                     .sources = sources,
                                     .output = output,
                                     .rows = RowMap(output.height, size.height),
                                     .latitudes = Latitudes(output.height)},
                                    pixels);
    hidden = with_distances.unknown | hidden_from_both(visibility, size, pixels);
  }
  const LineVolume& volume = captured_.volume(station.line);
  const cv::Mat captured = captured_columns(volume, station.station, pixels);
  const cv::Mat valid = valid_columns(volume, station.station, pixels);
  const cv::Mat compared = valid & ~(with_distances.unknown | without_depth.unknown);
  if (cv::countNonZero(compared) == 0) {
    return {kMaxPsnrDb, kMaxPsnrDb, kMaxPsnrDb, 1.0};
  }
  const double displaced =
      displacement_error(volume, station.station, pixels, tolerance_px_, captured, compared);
  return {capped(psnr_db(with_distances.columns, captured, compared)),
          capped(psnr_db(without_depth.columns, captured, compared)), capped(psnr_db(displaced)),
          share_of(hidden, valid, pixels)};
}

}  // namespace raywalk
