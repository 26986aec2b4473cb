// The gains of a room's stations in `gains.h5`, which make their exposures agree in views.
//
// Dataset `gain` float64 [station][theta][phi][rgb]: factors of the 8-bit levels at the middles of
// equal patches of each panorama, through all lines in order; between the middles they are linear.
// Root attributes: `format`, `format_version`; `stations_sha256`, which tells the room's stations
// from others; `sha256` of the gains.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "core/geometry/grid.h"

namespace raywalk {

// The root attribute `format` of gains.h5.
inline constexpr const char* kGainsFormat = "raywalk-gains";

// Factors of 8-bit levels: red, green, blue.
using ColourGain = cv::Vec3f;

// Gains over a station's sphere of directions. A station's lenses differ in exposure, and clouds
// pass over a part of the sky: one factor for the whole picture is not enough.
struct GainField {
  ColourGain whole{1.0F, 1.0F, 1.0F};
  // Further factors, CV_32FC3 [theta][phi], at the middles of equal patches of the panorama and
  // linear in between. Empty: 1 everywhere.
  cv::Mat local{};
};

// Multiplies a transposed panorama (row = theta, column = phi), CV_8UC3, by its gains.
void apply_gains(const GainField& gains, cv::Mat* colours);

// [line][station]; empty: all are 1.
using GainFields = std::vector<std::vector<GainField>>;

// Gains of 1 for every station.
GainFields unit_gain_fields(const Grid& grid);

inline const GainField& gain_field(const GainFields& fields, StationIndex station) {
  return fields[static_cast<size_t>(station.line)][static_cast<size_t>(station.station)];
}

// Whether a station's gains are exactly 1.
bool is_one(const GainField& field);

std::filesystem::path gains_path(const std::filesystem::path& room);

// Writes a file with the fields of all stations of the grid, not all of them 1. Local fields must
// be of one size. Throws Error if it cannot be written.
void write_gain_fields(const std::filesystem::path& file, const Grid& grid,
                       const GainFields& fields);

// Reads one. Throws Error naming the file if it is missing, not HDF5, of another format version, of
// other stations, damaged, or holds a gain outside [1/16, 16].
GainFields read_gain_fields(const std::filesystem::path& file, const Grid& grid);

}  // namespace raywalk
