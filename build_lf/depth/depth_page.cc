#include "build_lf/depth/depth_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "build_lf/depth/station_image.h"
#include "core/report/json_page.h"

namespace raywalk::build_lf {
namespace {

// [theta][phi] values as an upright picture.
template <typename T>
cv::Mat upright(const std::vector<T>& values, PanoramaSize size, int type) {
  const cv::Mat columns(size.width, size.height, type, const_cast<T*>(values.data()));
  return columns.t();
}

cv::Mat distance_picture(const InverseDistanceMap& map) {
  std::vector<float> sorted = map.omega;
  const auto near = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() * 999 / 1000);
  std::nth_element(sorted.begin(), near, sorted.end());
  cv::Mat levels;
  upright(map.omega, map.size, CV_32FC1).convertTo(levels, CV_8U, 255.0 / std::max(1e-9f, *near));
  cv::Mat picture;
  cv::applyColorMap(levels, picture, cv::COLORMAP_TURBO);
  return picture;
}

// Grey for confident pixels, red below kMinConfidence.
cv::Mat confidence_picture(const InverseDistanceMap& map) {
  const cv::Mat confidence = upright(map.confidence, map.size, CV_8UC1);
  cv::Mat picture;
  cv::cvtColor(confidence, picture, cv::COLOR_GRAY2BGR);
  picture.setTo(cv::Scalar(40, 40, 220), confidence < kMinConfidence);
  return picture;
}

cv::Mat photograph(const Room& room, const InverseDistanceMap& map) {
  cv::Mat picture;
  cv::cvtColor(station_image(room, map.station, map.size).t(), picture, cv::COLOR_RGB2BGR);
  return picture;
}

void add_maps(const MapPictures& pictures, JsonPage page) {
  page.section("Distances and confidence")
      .paragraph(
          "Inverse distance from blue (far) to red (near); confidence from black to white, and red "
          "where it is low (the share above is of the solid angle of all maps): there the renderer "
          "prefers other maps. Expect it on plain walls, panes and mirrors, at silhouettes, and "
          "along a rail that no other line crosses.");
  for (const std::vector<HtmlFigure>& of_map : pictures) page.figures(of_map);
  const LinePlot axes{.title = "Confidence along the lines",
                      .x_label = "station",
                      .y_label = "mean confidence",
                      .y_range = AxisRange{0.0, 1.0}};
  LinePlot of_lines = axes;
  of_lines.title = "Confidence of the lines";
  of_lines.x_label = "number of the line";
  page.section("Stations")
      .figures({page.when("shown.curve_per_line")
                    .plot(axes, {{"maps", "{line}", "station", "mean_confidence"}},
                          "Mean over the sphere of each map"),
                page.when("!shown.curve_per_line")
                    .plot(of_lines, {{"lines", "lines along {axis}", "number", "mean_confidence"}},
                          "Mean over the maps of each line")});
}

void add_left_out(JsonPage page) {
  page.section("Left out")
      .paragraph(
          "People, cars and other things that moved: what these stations show and the stations "
          "around them contradict. Views read the place from other stations, and use these pixels "
          "only where no other station sees it. raywalk-build-lf depth --keep-moving keeps them.")
      .table("shown.left_out",
             {{"line", "{line}"},
              {"station", "{station}"},
              {"file", "{file}"},
              {"left out", "{share:.2%}"}},
             "{shown.left_out:size} of {left_out:size}, those with the largest share if not all");
}

void add_truth(JsonPage truth) {
  const LinePlot axes{.title = "Low confidence predicts error",
                      .x_label = "confidence",
                      .y_label = "share of pixels off by more than 1 px",
                      .x_range = AxisRange{0.0, 1.0},
                      .y_range = AxisRange{0.0, 1.0}};
  const std::vector<JsonColumn> columns{{"confidence", "{confidence:.2f}"},
                                        {"pixels", "{pixels}"},
                                        {"off by more than 1 px", "{wrong_share:.1%}"},
                                        {"median error, px", "{median_error_px:.2f}"}};
  truth.section("Comparison with the given distances")
      .paragraph("{maps:counted map}: {summary}.")
      .figures({truth.plot(axes,
                           {{"elsewhere", "elsewhere", "confidence", "wrong_share"},
                            {"edges", "beside silhouettes", "confidence", "wrong_share"}},
                           "Calibration of the confidence")})
      .table("elsewhere", columns)
      .when("edges")
      .paragraph("Beside silhouettes (within 3 pixels):")
      .table("edges", columns);
}

}  // namespace

MapPictures map_pictures(const Room& room, const std::vector<InverseDistanceMap>& maps) {
  MapPictures pictures;
  for (const InverseDistanceMap& map : maps) {
    const std::string where = fmt::format(
        "line {}, station {}", room.grid().lines[static_cast<size_t>(map.station.line)].id,
        map.station.station);
    pictures.push_back(
        {picture_figure(photograph(room, map), EmbeddedFormat::kJpeg, "panorama", where),
         picture_figure(distance_picture(map), EmbeddedFormat::kJpeg, "inverse distance",
                        where + ": inverse distance"),
         picture_figure(confidence_picture(map), EmbeddedFormat::kJpeg, "confidence",
                        where + ": confidence")});
  }
  return pictures;
}

std::string depth_page(const nlohmann::ordered_json& document, const MapPictures& pictures) {
  JsonPage page(document, "Distances of {room}",
                "{maps:size} maps by {method} at {width} x {height}");
  page.facts({{"maps", "{maps:size} of {stations} stations"},
              {"longest baseline", "{reach_m:.3g m}"},
              {"layers", "{layers}"},
              {"confidence below {low_confidence_below:.2f}", "{low_confidence_share:.1%}"},
              {"left out, as it moved", "{left_out_share:.2g%}", "leave_out_moving"},
              {"left out, as it moved", "not looked for", "!leave_out_moving"},
              {"in use by views", "{distances}"},
              {"time", "{seconds:.0f s}"},
              {"memory", "{peak_memory_mb:.0f MB}"},
              {"largest exposure step", "factor {largest_exposure_step:.2f}"}});
  page.within("gains").section("Gains").paragraph(
      "By the surfaces that several stations see, {summary}.");
  page.warnings("shown.warnings");
  add_maps(pictures, page);
  add_left_out(page.when("left_out"));
  add_truth(page.within("truth"));
  return page.html();
}

}  // namespace raywalk::build_lf
