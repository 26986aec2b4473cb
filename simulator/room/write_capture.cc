#include "simulator/room/write_capture.h"

#include <fmt/format.h>

#include <set>
#include <string>
#include <vector>

#include "core/base/interrupt.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/jpeg.h"
#include "core/files/output_folder.h"
#include "simulator/room/sensor.h"
#include "simulator/room/stations.h"
#include "simulator/room/truth.h"

namespace raywalk::simulator {
namespace {

namespace fs = std::filesystem;

// Tells the capture of a virtual room from photographs in folders of the same names.
constexpr const char* kMarker = "virtual-room.json";
constexpr const char* kSignature = "raywalk-virtual-room";

bool is_part_of_capture(const fs::path& relative, bool is_folder) {
  static const std::set<fs::path> folders{"capture", "dist", "gt", "ods", "people", "thin"};
  static const std::set<fs::path> files{kMarker, "poses.csv", "true_poses.csv", "gt.csv",
                                        "gt_thin.csv"};
  if (relative.has_parent_path()) {
    return !is_folder && (relative.extension() == ".png" || relative.extension() == ".jpg");
  }
  return (is_folder ? folders : files).contains(relative);
}

PanoramaSize size_of(const VirtualRoomSettings& settings) {
  return {settings.output.width_px, settings.output.width_px / 2};
}

void write_frame(const fs::path& file, const cv::Mat& image, const OutputSettings& output) {
  if (output.format == "jpg") {
    write_file_atomically(file, encode_jpeg(image, output.jpeg_quality,
                                            output.jpeg_colour == "full" ? JpegSampling::kFull
                                                                         : JpegSampling::kQuarter));
  } else {
    write_image(file, image);
  }
}

class CaptureWriter {
 public:
  CaptureWriter(const VirtualRoom& room, const CaptureOptions& options)
      : room_(room),
        options_(options),
        stations_(room_stations(room.settings())),
        truths_(options.views ? read_truth_viewpoints(*options.views)
                              : truth_viewpoints(room, options.truth_views)),
        out_(options.out, options.replace,
             {"a virtual room's capture", kMarker, kSignature, is_part_of_capture}),
        distances_(made("dist")) {}

  std::string write() {
    Progress progress("capturing", static_cast<std::int64_t>(stations_.size() + truths_.size()),
                      "panoramas");
    write_truths(&progress);
    write_stations(&progress);
    throw_if_interrupted();
    write_file_atomically(out_.directory() / kMarker,
                          fmt::format("{{\"format\": \"{}\"}}\n", kSignature));
    out_.complete();
    const PanoramaSize size = size_of(room_.settings());
    return fmt::format("{}: {} panoramas of {} x {} on {} lines, {} true views, {} distance maps",
                       options_.out.string(), stations_.size(), size.width, size.height,
                       plan_lines(room_.settings().grid).size(), truths_.size(), maps_);
  }

 private:
  fs::path made(const char* folder) const {
    make_directories(out_.directory() / folder);
    return out_.directory() / folder;
  }

  // True views first, so that a viewpoint inside furniture is reported early.
  void write_truths(Progress* progress) {
    if (truths_.empty()) return;
    made("gt");
    if (options_.thin) made("thin");
    write_truth_views(room_, truths_, size_of(room_.settings()), out_.directory(), options_.thin,
                      progress);
    maps_ += static_cast<int>(truths_.size());
    if (options_.ods_ipd_mm > 0.0) write_stereo_truths();
  }

  void write_stereo_truths() {
    const fs::path directory = made("ods");
    Progress progress("capturing stereo", static_cast<std::int64_t>(truths_.size()), "views");
    for (const TruthViewpoint& viewpoint : truths_) {
      cv::Mat both;
      for (const double radius_m : {0.5e-3 * options_.ods_ipd_mm, -0.5e-3 * options_.ods_ipd_mm}) {
        both.push_back(room_.render(PanoramaRays(size_of(room_.settings()), radius_m),
                                    {viewpoint.position_m, {}}));
      }
      write_image(directory / (viewpoint.name + ".png"), both);
      progress.advance();
    }
  }

  void write_stations(Progress* progress) {
    const VirtualRoomSettings& settings = room_.settings();
    const fs::path directory = made("capture");
    std::string table = "file,x,y,z,line\n", true_table = "file,x,y,z,yaw,pitch,roll\n";
    const PanoramaRays camera(size_of(settings));
    int number = 0;
    for (const RoomStation& station : stations_) {
      const std::string file = station.name + "." + settings.output.format;
      const cv::Mat seen = room_.render(camera, station.true_pose, {.station = number});
      write_frame(directory / file,
                  apply_sensor(seen, settings.sensor, station.gain, station.noise_key),
                  settings.output);
      if (room_.has_moving_objects()) write_moving_mask(station, number);
      ++number;
      if (has_distances(station)) write_distances(station.name, station.true_pose);
      const std::string name = "capture/" + file + ",";
      table += name + position_fields(station.nominal.position_m) + "," + station.line + "\n";
      true_table += name + pose_fields(station.true_pose) + "\n";
      progress->advance();
    }
    write_file_atomically(out_.directory() / "poses.csv", table);
    const PoseSettings& jitter = settings.pose;
    if (jitter.position_jitter_mm > 0.0 || jitter.attitude_jitter_deg > 0.0) {
      write_file_atomically(out_.directory() / "true_poses.csv", true_table);
    }
  }

  void write_moving_mask(const RoomStation& station, int number) {
    write_image(made("people") / (station.name + ".png"),
                room_.moving_mask(number, station.true_pose, size_of(room_.settings())));
  }

  bool has_distances(const RoomStation& station) const {
    return options_.distance_every > 0 && station.number % options_.distance_every == 0;
  }

  void write_distances(const std::string& name, const CameraPose& pose) {
    write_distance_map(room_, pose, size_of(room_.settings()), distances_ / (name + ".png"));
    ++maps_;
  }

  const VirtualRoom& room_;
  const CaptureOptions& options_;
  std::vector<RoomStation> stations_;
  std::vector<TruthViewpoint> truths_;
  OutputFolder out_;
  fs::path distances_;
  int maps_ = 0;
};

}  // namespace

std::string write_capture(const VirtualRoom& room, const CaptureOptions& options) {
  return CaptureWriter(room, options).write();
}

}  // namespace raywalk::simulator
