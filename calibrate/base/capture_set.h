// The input of a calibration: the frames of a capture session, or of a folder with poses.csv,
// grouped into lines; and the frames of a gt.csv beside poses.csv, which are held out of the lines.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/geometry/grid.h"
#include "core/geometry/sphere.h"

namespace raywalk::calibrate {

enum class FrameLayout {
  kPanorama,     // equirectangular, width = 2 * height
  kDualFisheye,  // two image circles, in one picture or in two
};

// CaptureFrame::line of a frame of gt.csv.
inline constexpr int kHeldOut = -1;

// One station's picture, or a held-out one. World frame of core/geometry/sphere.h.
struct CaptureFrame {
  std::string name{};                           // of the station, unique in the set: "x0_007"
  int line = 0;                                 // index into CaptureSet::lines, or kHeldOut
  std::filesystem::path file{};                 // the picture, or the front lens's
  std::optional<std::filesystem::path> back{};  // the back lens's, for cameras with two files
  Eigen::Vector3d nominal_m{0, 0, 0};           // position by the slider's feedback and the plan
  std::optional<Attitude> nominal_attitude{};   // nullopt: looks along +z, upright
  std::string sha256{};                         // of file and back, as the session recorded them;
                                                // empty: not recorded
  // Of the size of `file`, in the camera's axes, 8-bit grey, 0 = masked; nullopt: nothing is.
  std::optional<std::filesystem::path> mask{};
  std::string where{};  // its row of a frame list, "poses.csv:12"; empty: of a session

  // Posed and rectified with the others, but no station of a line.
  bool held_out() const { return line == kHeldOut; }
};

// One placement of the rail.
struct CaptureLine {
  std::string id{};              // "x0", "z1", "v0"
  LineAxis axis = LineAxis::kX;  // the slider's positions increase along it
  double across_m = 0.0;         // nominal z of a line along x, x of a line along z
  bool validation = false;       // kept out of the volumes
  std::vector<int> frames{};     // indices into CaptureSet::frames, by rail position
};

struct CaptureSet {
  std::filesystem::path source{};  // as the user named it
  FrameLayout layout = FrameLayout::kPanorama;
  PanoramaSize frame{};  // of every picture (of one half where there are two files)
  std::vector<CaptureLine> lines{};
  // Line by line, by rail position; then those held out, in the order of gt.csv.
  std::vector<CaptureFrame> frames{};

  // Number of frames on lines: frames[0] to frames[stations() - 1].
  std::size_t stations() const;
  const std::string& line_id(int line) const { return lines[static_cast<std::size_t>(line)].id; }
  // The slider's position at a station by its feedback, metres along the line's axis.
  double rail_m(std::size_t frame) const;
  // Distance of two frames' nominal positions; on a slider's line that of their rail positions.
  double nominal_distance_m(std::size_t a, std::size_t b) const;
  // Whether the frame is kept out of the volumes: of a validation line, or held out.
  bool is_validation(const CaptureFrame& frame) const;
};

// The index of every frame by its name.
std::unordered_map<std::string, std::size_t> indices_by_name(const CaptureSet& set);

// Two lines of different axes that cross.
struct LineIntersection {
  int along_x = 0;  // indices into CaptureSet::lines
  int along_z = 0;
  PlanPoint at{};  // nominal
};

struct CaptureInput {
  std::filesystem::path directory{};
  int exposure = 0;           // of a session's bracket
  bool partial = false;       // accept a session with stations not captured yet
  bool dual_fisheye = false;  // layout of a frame list; a session stores its own
  GridTolerance tolerance{};  // how the lines of a frame list are found
};

// Reads a directory: a session (session.db; docs/session.md), else a frame list poses.csv, whose
// lines are found as raywalk-build-lf finds them; frames are then named by the stem of their file,
// or by their whole path where stems repeat ("front/000.jpg": "front_000"). A gt.csv beside
// poses.csv, with the same columns, lists held-out frames. Throws Error naming what is missing or
// damaged: neither of the two, no frames, pictures missing or of different sizes, panoramas that
// are not 2:1, a mask that cannot be used (frame_masks.h), a frame both in poses.csv and in gt.csv,
// a station of a session not captured (unless `partial`); UsageError for an exposure it lacks.
CaptureSet read_capture_set(const CaptureInput& input);

// The set without its held-out frames. The other frames keep their indices.
CaptureSet stations_only(const CaptureSet& set);

// Every pair of lines of different axes whose stations come within one median spacing of where the
// two cross. Validation lines count. In the order of the lines.
std::vector<LineIntersection> intersections_of(const CaptureSet& set);

}  // namespace raywalk::calibrate
