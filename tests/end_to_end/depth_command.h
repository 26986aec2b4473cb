// For end-to-end tests of raywalk-build-lf depth. RAYWALK_BUILD_LF is the program.
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <span>
#include <string>

#include "build_lf/depth/depth_test_room.h"
#include "core/files/fingerprint.h"
#include "tests/end_to_end/run_command.h"

namespace raywalk::build_lf {

// A textured box with an obstacle close to the front line.
inline SyntheticRoomSpec furnished_room(int width) {
  SyntheticRoomSpec spec = room_of_scale(1.0);
  spec.scene.texture_wavelength_m = 0.5;
  spec.scene.obstacle = SceneBox{{-0.3, -1.2, 0.9}, {0.3, 0.4, 1.3}};
  spec.width = width;
  return spec;
}

inline CommandResult depth(const Room& room, const std::string& arguments = "") {
  return run_command(
      fmt::format("{} depth {} {}", RAYWALK_BUILD_LF, room.directory().string(), arguments));
}

// Checksums of the files in a directory, by name.
inline std::map<std::string, std::string> files_in(const std::filesystem::path& directory) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    const std::string bytes = read_file(entry.path());
    files[entry.path().filename().string()] = sha256_hex(std::as_bytes(std::span(bytes)));
  }
  return files;
}

}  // namespace raywalk::build_lf
