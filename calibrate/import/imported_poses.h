// Poses of panoramas that another program or device found.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/reconstruction/colmap_pose.h"

namespace raywalk::calibrate {

struct ImportedFrame {
  std::string file{};   // the panorama, as the source names it; of COLMAP's faces without extension
  CameraPose pose{};    // in Raywalk's kind of axes: left-handed, the camera's y up
  std::string where{};  // "transforms.json: frames[3]", "gps.csv:12", for errors
};

struct ImportedPoses {
  std::string kind{};  // "a COLMAP model", for messages
  std::vector<ImportedFrame> frames{};
  // What is known of the source's world; the rest is fitted.
  bool upright = false;  // its y is up
  bool metric = false;   // its unit is the metre
  // Where the panoramas are unless the user says otherwise; none: unknown.
  std::optional<std::filesystem::path> panoramas{};
};

// Reads, by what it is: a folder with a COLMAP model (or with sparse/0 or sparse in it), whose
// images are faces of panoramas as `faces` describes (a table folder,yaw,pitch,roll in degrees;
// none: those of raywalk-build-lf export); OpenSfM's reconstruction.json; nerfstudio's
// transforms.json; a table with columns latitude_deg,longitude_deg (gps_table.h); a frame list.
// Throws Error as the readers do and if it is none of these.
ImportedPoses read_imported_poses(const std::filesystem::path& source,
                                  const std::optional<std::filesystem::path>& faces);

}  // namespace raywalk::calibrate
