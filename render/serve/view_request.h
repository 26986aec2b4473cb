// What /view?... asks for.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "core/geometry/sphere.h"
#include "core/view/view_options.h"
#include "render/view/view_frame.h"

namespace raywalk::render {

inline constexpr int kMostServedSide_px = 4096;
inline constexpr int kMostServedPixels = 8 << 20;

struct ViewRequest {
  PlanPoint viewpoint{};
  double up_m = 0.0;                   // above the height of the lines around
  ViewFrame frame{};                   // flat where fov_deg is not 0
  int panorama_width_px = 0;           // 0: as captured; of a panorama only
  std::optional<ViewMethod> method{};  // none: two-sided where the room has distances
  std::optional<double> k_deg{};       // none: chosen for the room
  bool png = false;                    // else JPEG
};

// Reads the parameters x, z (metres, required), y (metres above the captured height, 0), yaw,
// pitch, roll, fov (degrees), width, height (pixels), method, k (45 to 90 degrees), format
// (jpg, png). With fov a flat picture of width x height (1280x720 unless given), without a panorama
// of that width. Throws HttpFault 400, naming the parameter, for any other parameter, one given
// twice, what is not a number or out of range, and pictures above the limits.
ViewRequest parse_view_request(const std::multimap<std::string, std::string>& query);

}  // namespace raywalk::render
