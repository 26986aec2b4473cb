#include "calibrate/import/imported_poses.h"

#include <fmt/format.h>

#include "calibrate/import/face_poses.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/frame_list.h"
#include "core/reconstruction/nerfstudio_file.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;

bool is_model(const fs::path& directory) {
  return fs::exists(directory / "images.bin") || fs::exists(directory / "images.txt");
}

ImportedPoses of_model(const fs::path& source, const std::optional<fs::path>& faces) {
  fs::path model = source;
  for (const fs::path& inner : {source, source / "sparse" / "0", source / "sparse"}) {
    if (!is_model(inner)) continue;
    model = inner;
    break;
  }
  const std::vector<ColmapImage> images = read_colmap_images(model);
  ImportedPoses poses{.kind = "a COLMAP model"};
  if (images_are_panoramas(model)) {
    for (const ColmapImage& image : images) {
      poses.frames.push_back(
          {.file = image.name,
           .pose = camera_pose_of(image.pose, {}),
           .where = fmt::format("{}: image {}", model.string(), excerpt(image.name))});
    }
    return poses;
  }
  const std::vector<NamedFace> table = faces ? read_face_table(*faces) : exported_faces();
  poses.frames = panoramas_of_faces(images, table, model);
  return poses;
}

ImportedPoses of_nerfstudio(const fs::path& source) {
  ImportedPoses poses{.kind = "nerfstudio's transforms.json", .panoramas = directory_of(source)};
  std::size_t index = 0;
  for (NerfstudioFrame& frame : read_nerfstudio(source)) {
    poses.frames.push_back({.file = std::move(frame.file),
                            .pose = frame.pose,
                            .where = fmt::format("{}: frames[{}]", source.string(), index++)});
  }
  return poses;
}

ImportedPoses of_frame_list(const fs::path& source) {
  ImportedPoses poses{.kind = "a frame list", .in_world = true, .panoramas = directory_of(source)};
  for (const Frame& frame : read_frame_list(source)) {
    poses.frames.push_back(
        {.file = frame.file,
         .pose = {frame.position_m, world_from_camera(frame.attitude.value_or(Attitude{}))},
         .where = frame.where});
  }
  return poses;
}

}  // namespace

ImportedPoses read_imported_poses(const fs::path& source, const std::optional<fs::path>& faces) {
  if (fs::is_directory(source)) return of_model(source, faces);
  if (!fs::exists(source)) {
    throw Error(source.string() +
                ": no such file; give the folder of a COLMAP model, transforms.json "
                "or a frame list");
  }
  if (source.extension() == ".json") return of_nerfstudio(source);
  if (source.extension() == ".csv") return of_frame_list(source);
  throw Error(source.string() +
              ": is neither the folder of a COLMAP model nor a .json nor a .csv file");
}

}  // namespace raywalk::calibrate
