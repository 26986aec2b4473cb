#include "calibrate/import/gps_table.h"

#include <fmt/format.h>

#include <cmath>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/csv.h"
#include "core/reconstruction/z_up_axes.h"

namespace raywalk::calibrate {
namespace {

// The ellipsoid's semi-major axis and flattening.
constexpr double kMajor_m = 6378137.0;
constexpr double kFlattening = 1.0 / 298.257223563;
constexpr double kFarthest_m = 1e5;

double value_of(const CsvTable& table, std::size_t row, const std::string& column, double most) {
  const double value = table.number(row, column);
  if (std::abs(value) > most) {
    throw Error(
        fmt::format("{}: {} = {:g} is out of range (at most {:g}); correct the unit or the "
                    "column",
                    table.where(row), column, value, most));
  }
  return value;
}

GeodeticPlace place_of(const CsvTable& table, std::size_t row) {
  return {radians_from_degrees(value_of(table, row, "latitude_deg", 90.0)),
          radians_from_degrees(value_of(table, row, "longitude_deg", 360.0)),
          value_of(table, row, "altitude_m", 20000.0)};
}

Attitude attitude_of(const CsvTable& table, std::size_t row) {
  const auto angle = [&](const std::string& column, double most) {
    return table.has_column(column) ? radians_from_degrees(value_of(table, row, column, most))
                                    : 0.0;
  };
  return {angle("heading_deg", 3600.0), angle("pitch_deg", 90.0), angle("roll_deg", 360.0)};
}

}  // namespace

Eigen::Vector3d earth_fixed_m(const GeodeticPlace& place) {
  const double squared = kFlattening * (2.0 - kFlattening);  // of the eccentricity
  const double sine = std::sin(place.latitude_rad);
  const double normal_m = kMajor_m / std::sqrt(1.0 - squared * sine * sine);
  const double in_plane_m = (normal_m + place.altitude_m) * std::cos(place.latitude_rad);
  return {in_plane_m * std::cos(place.longitude_rad), in_plane_m * std::sin(place.longitude_rad),
          (normal_m * (1.0 - squared) + place.altitude_m) * sine};
}

Eigen::Matrix3d earth_from_east_north_up(const GeodeticPlace& place) {
  const double sine = std::sin(place.latitude_rad), cosine = std::cos(place.latitude_rad);
  const double east_sine = std::sin(place.longitude_rad);
  const double east_cosine = std::cos(place.longitude_rad);
  Eigen::Matrix3d axes;
  axes << -east_sine, -sine * east_cosine, cosine * east_cosine,  //
      east_cosine, -sine * east_sine, cosine * east_sine,         //
      0.0, cosine, sine;
  return axes;
}

ImportedPoses gps_of_text(const std::string& text, const std::filesystem::path& file) {
  const CsvTable table =
      CsvTable::parse(text, input_name(file),
                      {"file", "latitude_deg", "longitude_deg", "altitude_m", "heading_deg"},
                      {"pitch_deg", "roll_deg"});
  if (table.rows() == 0) throw Error(input_name(file) + ": lists no frames");
  ImportedPoses poses{.kind = "a table of GPS positions",
                      .upright = true,
                      .metric = true,
                      .panoramas = directory_of(file)};
  const GeodeticPlace origin = place_of(table, 0);
  const Eigen::Vector3d origin_m = earth_fixed_m(origin);
  const Eigen::Matrix3d local_from_earth = earth_from_east_north_up(origin).transpose();
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const GeodeticPlace place = place_of(table, row);
    const Eigen::Vector3d from_origin_m = local_from_earth * (earth_fixed_m(place) - origin_m);
    if (from_origin_m.norm() > kFarthest_m) {
      throw Error(fmt::format("{}: is {:.0f} km from the first place; correct the position",
                              table.where(row), from_origin_m.norm() / 1000.0));
    }
    // Up and north turn a little from place to place.
    const Eigen::Matrix3d turn = local_from_earth * earth_from_east_north_up(place);
    poses.frames.push_back(
        {.file = table.text(row, "file"),
         .pose = {z_up_axes(from_origin_m), z_up_matrix() * turn * z_up_matrix() *
                                                world_from_camera(attitude_of(table, row))},
         .where = table.where(row)});
  }
  return poses;
}

ImportedPoses read_gps_table(const std::filesystem::path& table) {
  return gps_of_text(read_file(table), table);
}

}  // namespace raywalk::calibrate
