#include "build_lf/export/export_colmap.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "build_lf/export/exported_stations.h"
#include "build_lf/export/observed_points.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kRig = 1;
constexpr double kMostError_px = 0.5;

// Of the six images of each station.
std::uint32_t image_id(std::size_t station, std::size_t face) {
  return static_cast<std::uint32_t>(station * kCubeFaces.size() + face + 1);
}
std::uint32_t camera_id(std::size_t face) { return static_cast<std::uint32_t>(face + 1); }

std::string image_name(const ExportedStation& station, std::size_t face, bool jpeg) {
  return fmt::format("{}/{}", kCubeFaces[face].name, station.file(jpeg));
}

// Every face has its own camera, as the sensors of a rig need.
std::vector<ColmapCamera> cameras_of(int face_px) {
  std::vector<ColmapCamera> cameras;
  for (std::size_t face = 0; face < kCubeFaces.size(); ++face) {
    cameras.push_back({camera_id(face), face_px, face_focal_px(face_px)});
  }
  return cameras;
}

// The first face's frame is the rig's.
ColmapRig rig_of_faces() {
  ColmapRig rig{.id = kRig, .reference_camera = camera_id(0)};
  const std::vector<PanoramaFace> faces = cube_faces();
  for (std::size_t face = 1; face < faces.size(); ++face) {
    // The pose of a face of a panorama at the origin; the first face is the panorama's front.
    rig.others.push_back({camera_id(face), colmap_pose({}, faces[face])});
  }
  return rig;
}

void add_station(const ExportedStation& station, std::size_t index, bool jpeg, ColmapModel* model) {
  const std::vector<PanoramaFace> faces = cube_faces();
  ColmapFrame frame{.id = static_cast<std::uint32_t>(index + 1),
                    .rig = kRig,
                    .from_world = colmap_pose(station.pose(), faces.front())};
  for (std::size_t face = 0; face < faces.size(); ++face) {
    model->images.push_back({.id = image_id(index, face),
                             .camera = camera_id(face),
                             .name = image_name(station, face, jpeg),
                             .pose = colmap_pose(station.pose(), faces[face])});
    frame.images.push_back(image_id(index, face));
  }
  model->frames.push_back(std::move(frame));
}

void add_point(const ObservedPoint& observed, ColmapModel* model) {
  ColmapPoint point{.id = model->points.size() + 1,
                    .position = flipped(observed.position_m),
                    .color = observed.colour};
  for (const PointObservation& seen : observed.observations) {
    const std::uint32_t id =
        image_id(static_cast<std::size_t>(seen.station), static_cast<std::size_t>(seen.face));
    std::vector<ColmapFeature>& features = model->images[id - 1].features;
    point.track.push_back({id, static_cast<std::uint32_t>(features.size())});
    features.push_back({seen.pixel, point.id});
    point.error_px += seen.error_px / static_cast<double>(observed.observations.size());
  }
  model->points.push_back(std::move(point));
}

// For `colmap rig_bundle_adjuster` up to 3.11 and `colmap rig_configurator` from 3.12 on, whose
// keys differ and which pass over those of the other.
std::string rig_config_text(const ColmapRig& rig) {
  using nlohmann::ordered_json;
  ordered_json cameras = ordered_json::array();
  const auto prefix = [](std::uint32_t camera) {
    return std::string(kCubeFaces[camera - 1].name) + "/";
  };
  cameras.push_back({{"camera_id", rig.reference_camera},
                     {"image_prefix", prefix(rig.reference_camera)},
                     {"ref_sensor", true}});
  for (const ColmapSensor& sensor : rig.others) {
    const Eigen::Quaterniond& q = sensor.from_rig.rotation;
    const ordered_json rotation{q.w(), q.x(), q.y(), q.z()};
    const ordered_json translation{0.0, 0.0, 0.0};
    cameras.push_back({{"camera_id", sensor.camera},
                       {"image_prefix", prefix(sensor.camera)},
                       {"cam_from_rig_rotation", rotation},
                       {"cam_from_rig_translation", translation},
                       {"rel_qvec", rotation},
                       {"rel_tvec", translation}});
  }
  const ordered_json rigs{{{"ref_camera_id", rig.reference_camera}, {"cameras", cameras}}};
  return rigs.dump(1) + "\n";
}

std::string face_table() {
  std::string text = "folder,yaw,pitch,roll\n";
  for (const CubeFace& face : kCubeFaces) {
    text +=
        fmt::format("{},{:g},{:g},{:g}\n", face.name, degrees_from_radians(face.attitude.yaw_rad),
                    degrees_from_radians(face.attitude.pitch_rad),
                    degrees_from_radians(face.attitude.roll_rad));
  }
  return text;
}

void write_faces(const Room& room, const std::vector<ExportedStation>& stations,
                 const ExportOptions& options, int face_px, const fs::path& directory) {
  const bool masked = has_unusable_pixels(room);
  for (const CubeFace& face : kCubeFaces) {
    make_directories(directory / "images" / face.name);
    if (masked) make_directories(directory / "masks" / face.name);
  }
  const FaceCutter cutter(cube_faces(), room.panorama(), face_px);
  Progress progress("Cutting faces", static_cast<std::int64_t>(stations.size()), "panoramas");
  parallel_for(0, static_cast<int>(stations.size()), 1, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const ExportedStation& station = stations[static_cast<std::size_t>(i)];
      const auto faces = cutter.cut(station_picture(room, station.index, options.gains));
      for (std::size_t face = 0; face < faces.size(); ++face) {
        write_image(directory / "images" / image_name(station, face, options.jpeg), faces[face]);
      }
      if (masked) {
        // COLMAP looks for a picture's mask under its whole name and ".png".
        const auto masks = cutter.cut_mask(station_mask(room, station.index), 0.0);
        for (std::size_t face = 0; face < masks.size(); ++face) {
          write_image(directory / "masks" / (image_name(station, face, options.jpeg) + ".png"),
                      masks[face]);
        }
      }
      progress.advance();
    }
  });
}

}  // namespace

ColmapModel colmap_model_of(const Room& room, const std::vector<ExportedStation>& stations,
                            const ExportOptions& options, int face_px) {
  ColmapModel model;
  model.cameras = cameras_of(face_px);
  model.rigs = {rig_of_faces()};
  for (std::size_t i = 0; i < stations.size(); ++i) {
    add_station(stations[i], i, options.jpeg, &model);
  }
  for (const ObservedPoint& point : observed_points(room, stations,
                                                    {.points = options.points,
                                                    .face_px = face_px,
                                                    .most_error_px = kMostError_px,
                                                    .max_distance_m = options.max_distance_m,
                                                    .gains = options.gains})) {
    add_point(point, &model);
  }
  return model;
}

std::string write_colmap(const Room& room, const std::vector<ExportedStation>& stations,
                         const ExportOptions& options, const fs::path& directory) {
  const int face_px = options.face_px > 0 ? options.face_px : native_face_px(room.panorama().width);
  write_faces(room, stations, options, face_px, directory);
  const ColmapModel model = colmap_model_of(room, stations, options, face_px);
  if (model.points.empty()) {
    spdlog::warn("{}: no points, as {}", room.directory().string(),
                 room.has_distances() ? "no two of the exported stations' distances agree"
                                      : "it has no distances; estimate them with depth first");
  }
  make_directories(directory / "sparse" / "0");
  write_colmap_model(directory / "sparse" / "0", model);
  write_file_atomically(directory / "rig_config.json", rig_config_text(model.rigs.front()));
  write_file_atomically(directory / "faces.csv", face_table());
  std::size_t observations = 0;
  double error_px = 0.0;
  for (const ColmapPoint& point : model.points) {
    observations += point.track.size();
    error_px += point.error_px * static_cast<double>(point.track.size());
  }
  return fmt::format(
      "{} images of {} x {} pixels, {} points with {} observations, mean reprojection error {:.3f} "
      "px",
      model.images.size(), face_px, face_px, model.points.size(), observations,
      observations == 0 ? 0.0 : error_px / static_cast<double>(observations));
}

}  // namespace raywalk::build_lf
