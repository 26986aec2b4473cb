// Writes the HDF5 volumes of one line. Stations are read and converted in parallel, one per thread
// at a time, so memory does not grow with their number. Files are written atomically.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "build_lf/pack/station_data.h"
#include "core/base/progress.h"
#include "core/room/ray_form.h"

namespace raywalk::build_lf {

// The rays of a line, read one station at a time.
struct LineRays {
  PanoramaSize panorama;
  // Whether some stations have valid_rows; if false, valid_rows returned by `read` are ignored.
  bool masked = false;
  std::function<StationRays(std::size_t station)> read;  // called once for each, in parallel
  RayForm form{};
  std::string inputs{};  // SHA-256 over what the volume is made from, for inputs_of(); empty: none
};

// lines/<id>.h5 as core/room/line_volume.h describes it, with `position_m` float64 [station][xyz]
// and `sha256` [station] (checksum_of_rays, of what the rays decode to) beside the rays. `progress`
// advances by one per station. Throws Error (unusable image, cannot write) and Interrupted.
void write_line_volume(const std::filesystem::path& file, const Line& line, const LineRays& rays,
                       Progress* progress);

// The distance maps of a line, read one at a time.
struct DistanceMaps {
  std::vector<std::int32_t> stations;  // station of each map, increasing
  PanoramaSize size;
  std::string origin;                                 // kGivenOrigin, or the method of estimation
  std::function<StationDistances(std::size_t)> read;  // the map of stations[i]; called in parallel
  bool compressed = false;                            // losslessly, so that checksums are the same
  // LeftOutPixels of the line as runs: [run][station, theta, first row, one past the last row].
  std::vector<std::int32_t> left_out{};
  std::string inputs{};  // as LineRays::inputs
};

// A distance volume as core/room/distance_volume.h describes it. Throws as write_line_volume does.
void write_distance_volume(const std::filesystem::path& file, const Line& line,
                           const DistanceMaps& maps, Progress* progress);

// The root attribute that says what a volume was made from, and its text; empty where there
// is no such file or it has none.
inline constexpr const char* kInputsAttribute = "inputs_sha256";
std::string inputs_of(const std::filesystem::path& volume);

// Copies either; the copy is there only when it is complete. Throws Error.
void copy_volume(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace raywalk::build_lf
