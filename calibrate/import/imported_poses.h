// Poses of panoramas that another program found, and the search among them.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/reconstruction/colmap_pose.h"

namespace raywalk::calibrate {

struct ImportedFrame {
  std::string file{};   // the panorama, as the source names it; of COLMAP's faces without extension
  CameraPose pose{};    // in Raywalk's kind of axes: left-handed, the camera's y up
  std::string where{};  // "transforms.json: frames[3]", "list.csv:12", for errors
};

struct ImportedPoses {
  std::string kind{};  // "a COLMAP model", for messages
  std::vector<ImportedFrame> frames{};
  // What is known of the source's world; the rest is fitted.
  bool in_world = false;  // its y is up and its unit the metre
  // Where the panoramas are unless the user says otherwise; none: unknown.
  std::optional<std::filesystem::path> panoramas{};
};

// Reads, by what it is: a folder with a COLMAP model (or with sparse/0 or sparse in it), whose
// images are panoramas (of EQUIRECTANGULAR cameras) or faces of them as `faces` describes (a table
// folder,yaw,pitch,roll in degrees; none: those of raywalk-build-lf export); nerfstudio's
// transforms.json; a frame list. Throws Error as the readers do and if it is none of these.
ImportedPoses read_imported_poses(const std::filesystem::path& source,
                                  const std::optional<std::filesystem::path>& faces);

// Finds imported frames by what users call them.
class FrameSearch {
 public:
  explicit FrameSearch(const std::vector<ImportedFrame>& frames) {
    for (std::size_t i = 0; i < frames.size(); ++i) {
      files_.emplace(without_extension(frames[i].file), i);
      const std::string stem = std::filesystem::path(frames[i].file).stem().string();
      const auto [first, is_new] = stems_.emplace(stem, i);
      if (!is_new) first->second = std::nullopt;
    }
  }

  // The frame of this file, with or without extension, or else of this stem if only one has it.
  std::optional<std::size_t> find(const std::string& name) const {
    const auto file = files_.find(without_extension(name));
    if (file != files_.end()) return file->second;
    const auto stem = stems_.find(std::filesystem::path(name).stem().string());
    return stem == stems_.end() ? std::nullopt : stem->second;
  }

 private:
  static std::string without_extension(const std::string& file) {
    return std::filesystem::path(file).replace_extension().lexically_normal().generic_string();
  }

  std::map<std::string, std::size_t> files_{};
  std::map<std::string, std::optional<std::size_t>> stems_{};  // none: of several frames
};

}  // namespace raywalk::calibrate
