// Finds imported frames by what users call them.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/import/imported_poses.h"

namespace raywalk::calibrate {

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
