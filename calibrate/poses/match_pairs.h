// Which stations are solved, and which pictures are compared: neighbours on a rail and stations
// around crossings. Everything else would cost hours and add nothing.
#pragma once

#include <array>
#include <span>
#include <tuple>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/poses/panorama_faces.h"

namespace raywalk::calibrate {

// The length that distances in a capture are measured by: the side of a cell, as the median
// distance of neighbouring crossings along the lines. Where no line has two crossings it is two
// thirds of the longest line, as lines reach beyond their cell. Metres, larger than 0 unless all
// stations of all lines coincide.
double cell_side_m(const CaptureSet& set, std::span<const LineCrossing> crossings);

// Indices of frames in ascending order: on every line stations that are at most `keyframes_mm`
// apart as far as there are such, with the first, the last and the two around each crossing; all
// for 0.
std::vector<int> choose_keyframes(const CaptureSet& set, std::span<const LineCrossing> crossings,
                                  double keyframes_mm);

// Indices of two frames, first < second.
struct FramePair {
  int first = 0;
  int second = 0;
  friend bool operator==(const FramePair&, const FramePair&) = default;
  friend bool operator<(const FramePair& a, const FramePair& b) {
    return std::tie(a.first, a.second) < std::tie(b.first, b.second);
  }
};

// Along a line: the next keyframe and the 4th, 16th, … from it as long as they lie within a quarter
// of the cell's side (neighbours make long tracks, far ones keep them true); where the 4th does
// not, the two next. Across: at every crossing five keyframes of each line, spread over a fifth of
// the cell's side to both sides of it, each with each. Sorted, each once.
std::vector<FramePair> choose_pairs(const CaptureSet& set, std::span<const LineCrossing> crossings,
                                    std::span<const int> keyframes);

// Two faces of two panoramas that see much the same.
struct FacePair {
  int first = 0;
  int second = 0;
};

// For every face of the first camera the one of the second that looks closest to the same way; in
// cameras turned against each other by more than 20 degrees every one within 60.
std::vector<FacePair> overlapping_faces(const std::array<PanoramaFace, kFaceCount>& faces,
                                        const Eigen::Matrix3d& world_from_first,
                                        const Eigen::Matrix3d& world_from_second);

}  // namespace raywalk::calibrate
