// Positions and attitudes of a satellite and inertial receiver.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>

#include "calibrate/import/imported_poses.h"

namespace raywalk::calibrate {

// A place on the ellipsoid of WGS 84 (EPSG:4979).
struct GeodeticPlace {
  double latitude_rad = 0.0;   // north
  double longitude_rad = 0.0;  // east
  double altitude_m = 0.0;     // above the ellipsoid
};

// Earth-centred, earth-fixed metres (WGS 84, NIMA TR8350.2, equation 4-14).
Eigen::Vector3d earth_fixed_m(const GeodeticPlace& place);
// The columns are east, north and up at a place, in that frame.
Eigen::Matrix3d earth_from_east_north_up(const GeodeticPlace& place);

// Reads columns file, latitude_deg, longitude_deg, altitude_m, heading_deg, and, if present,
// pitch_deg and roll_deg. Positions become metres in the plane that touches the ellipsoid at the
// first place: x east, y up, z north; no projection is involved, so that distances are exact.
// heading_deg is of the panorama's middle, clockwise from north; pitch_deg raises it, roll_deg
// lowers the right side. Throws Error naming table and line: no rows, a value that is not a number
// or out of range, a place farther than 100 km from the first.
ImportedPoses read_gps_table(const std::filesystem::path& table);
ImportedPoses gps_of_text(const std::string& text, const std::filesystem::path& table);

}  // namespace raywalk::calibrate
