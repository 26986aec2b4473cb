// The frame list (poses.csv): the position and attitude at which each panorama was captured.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/files/csv.h"
#include "core/geometry/sphere.h"

namespace raywalk {

// Positions farther from the origin indicate a wrong unit or column; manifest.json has the same
// limit.
inline constexpr double kMaxPosition_m = 1e6;

struct Frame {
  std::string file;            // as written in the list, relative to the list
  std::filesystem::path path;  // of the file (core/files/listed_files.h)
  Eigen::Vector3d position_m{0, 0, 0};
  std::optional<Attitude> attitude;           // none: the panorama is already in world axes
  std::optional<std::filesystem::path> mask;  // none: all pixels are valid
  std::string line;                           // the name of its line; empty: not told
  std::string where;                          // "poses.csv:12", for errors
};

// Reads columns file,x,y,z (metres) of a file, or of standard input for "-" with names relative to
// the current directory, and, if present, yaw,pitch,roll (degrees; a missing column is
// 0), mask (relative to the list; may be empty): an 8-bit grey image of the frame's size in the
// frame's own axes, 0 = invalid; and line, the name of the frame's line. Throws Error naming list
// and line: no frames, a field that is not a number or is out of range, a file listed twice.
// `ignored`: other columns that the list may have, such as `distance` of true views.
std::vector<Frame> read_frame_list(const std::filesystem::path& list,
                                   const std::vector<std::string>& ignored = {});

// A row of a frame list to be written.
struct ListedFrame {
  std::string file{};  // relative to the list, or absolute
  Eigen::Vector3d position_m{0, 0, 0};
  std::optional<Attitude> attitude{};  // nullopt: the picture is in world axes
  std::string mask{};                  // as file; empty: none
  std::string line{};                  // the name of its line; empty: not told
};

// The table file,x,y,z (metres), with columns yaw,pitch,roll (degrees) where a frame has an
// attitude, a column mask where one has a mask and a column line where one has a line; numbers to
// 1e-9.
std::string frame_list_text(const std::vector<ListedFrame>& frames);

// Frame names of the listed files, in order, escaped (core/base/escaped.h): their stems, or, where
// these repeat or are taken, their paths without extension, with '_' for '/'. Throws Error naming
// `list` if two names are still the same.
std::vector<std::string> frame_names(std::span<const std::string> files,
                                     const std::filesystem::path& list,
                                     std::span<const std::string> taken = {});

// The columns x,y,z (metres), and yaw,pitch,roll (degrees; 0 where there is no such column), of a
// row. Throw Error naming table, line and value for a value out of range.
Eigen::Vector3d read_position_m(const CsvTable& table, std::size_t row);
Attitude read_attitude(const CsvTable& table, std::size_t row);

}  // namespace raywalk
