#include "core/geometry/listed_axes.h"

#include <fmt/format.h>

namespace raywalk {

std::string nearest_axis(const Eigen::Vector3d& direction) {
  Eigen::Index axis = 0;
  direction.cwiseAbs().maxCoeff(&axis);
  return fmt::format("{}{}", direction[axis] < 0.0 ? "-" : "", "xyz"[axis]);
}

std::string likely_fault_of_axes(const std::string& along_x, const std::string& along_z) {
  const std::string &x = along_x, &z = along_z;
  if ((x.empty() || x == "x") && (z.empty() || z == "z")) return "";
  if (x == "-x" && z == "z") {
    return "the camera is mirrored left to right or hung upside down, or x grows the other way in "
           "the list; mirror the pictures back, give the attitude (roll 180), or correct the "
           "positions";
  }
  if (x == "-x" && z == "-z") {
    return "the camera looks backwards, or every rail runs the other way; give the attitude (yaw "
           "180), or correct the positions";
  }
  if (x == "x" && z == "-z") {
    return "the camera is mirrored and looks backwards, or z grows the other way in the list; "
           "mirror the pictures back, or correct the positions";
  }
  if ((x == "-x" && z.empty()) || (x.empty() && z == "-z")) {
    return "the stations are listed in reverse order, or the camera looks backwards; correct the "
           "positions, or give the attitude (yaw 180)";
  }
  if (x.ends_with('y') || z.ends_with('y')) {
    return "the list has y for another axis (y is up); correct the positions";
  }
  if ((x == "z" && z == "-x") || (x == "-z" && z == "x") || z.empty() || x.empty()) {
    return "the camera looks to the side, or the list is turned by 90 degrees; give the attitude "
           "(yaw 90 or -90), or correct the positions";
  }
  return "x and z are exchanged in the list; correct the positions";
}

}  // namespace raywalk
