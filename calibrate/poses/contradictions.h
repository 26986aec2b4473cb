// Where solved poses contradict the list of positions or the slider's feedback, and what the reason
// most likely is.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "calibrate/base/capture_set.h"
#include "calibrate/base/frame_poses.h"
#include "calibrate/rails/fit_rails.h"

namespace raywalk::calibrate {

struct Contradiction {
  // "exchanged", "shifted", "stretched", "scattered" or "off"
  std::string kind{};
  std::vector<std::size_t> frames{};  // the stations whose positions are wrong
  std::string text{};                 // a sentence
};

// Compares the stations with a solved pose with the rails fitted to them. A line as a whole may be
// listed too long or too short, or with its names shifted by one from a station on (a picture is
// missing, or there twice); whichever explains its stations far better than the list does. Of the
// other stations one is named if it is off by more than a fiftieth of the spacing and five standard
// deviations (the scatter of its line and its own sigma; more where few stations measure it); with
// another one if they lie at each other's places, or it lies where one that was not solved is
// listed. A line whose stations scatter by more than a quarter of the spacing is named as a whole.
// Fewer than three solved stations of a line contradict nothing.
std::vector<Contradiction> contradictions_of(const CaptureSet& set, const FramePoses& poses,
                                             const std::vector<Rail>& rails);

}  // namespace raywalk::calibrate
