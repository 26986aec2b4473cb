// What a depth run did and how well: depth.json and the page beside it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "build_lf/depth/frame_checks.h"
#include "build_lf/depth/inverse_distance_map.h"

namespace raywalk::build_lf {

// Pixels of one band of confidence against the truth.
struct ConfidenceBand {
  double confidence = 0.0;  // the band's middle, in [0, 1]
  std::int64_t pixels = 0;
  double wrong_share = 0.0;  // off by more than a pixel of parallax at the reach
  double median_error_px = 0.0;
};

struct TruthComparison {
  int maps = 0;
  double within_1px_share = 0.0;  // of parallax at the reach, at the maps' width
  double within_2px_share = 0.0;
  double within_4px_share = 0.0;
  double median_relative_error = 0.0;  // of the distance, where both are finite
  std::vector<ConfidenceBand> calibration{};
};

struct MapSummary {
  std::string line{};
  int station = 0;
  std::string file{};
  double mean_confidence = 0.0;  // in [0, 1], over the solid angle
  double low_share = 0.0;        // of the solid angle, below kMinConfidence
  double parallax_share = 0.0;   // of the solid angle, moves by a pixel or more over the reach
};

struct DepthSummary {
  std::string room{};
  std::string method{};
  PanoramaSize size;
  int stations = 0;
  int every = 0;             // as asked for: a map at every n-th station; 0: as the grid requires
  int hold_out = 0;          // one of so many stations was left out; 0: none
  std::string valid_mask{};  // file of pixels that were not used; empty: all were
  double reach_m = 0.0;
  double nearest_m = 0.0;  // what the sweep looked for; 0: the method has no such limit
  int layers = 0;
  double gain_spread = 0.0;            // standard deviation of the stations' gains
  double largest_exposure_step = 1.0;  // between neighbours of a line, as a factor
  double seconds = 0.0;
  double peak_memory_mb = 0.0;
  std::vector<MapSummary> maps{};
  std::vector<FrameFinding> frame_findings{};
  std::vector<std::string> warnings{};  // findings about frames and lines, in words
  std::optional<TruthComparison> truth{};
  std::string page{};  // path of the HTML page
};

std::string depth_summary_to_json(const DepthSummary& summary);

}  // namespace raywalk::build_lf
