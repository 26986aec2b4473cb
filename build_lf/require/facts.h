// What `raywalk-build-lf require` measures of a room's scene: depth layers, station spacing and
// storage. Members are keys of require.json with the same names (docs/file-formats.md).
//
// Infinite distances, spacings and widths (sky, no limit) and empty optionals are null in the file.
// PSNR is over RGB in dB, capped at 100. Shares are of the solid angle, in [0, 1].
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/spacing.h"

namespace raywalk::build_lf {

// Quantiles (1 %, 50 %, 99 %) of the distances from the stations, weighted by solid angle and
// confidence.
struct DistanceFacts {
  double near_m = 0.0;
  double median_m = 0.0;
  double far_m = 0.0;
  double sky_share = 0.0;
  double known_share = 0.0;  // mean confidence
  // Error of an inverse distance, 1/m: the 95 % quantile of the differences between maps that see
  // the same surface, divided by sqrt(2) as both have errors. None: no two maps to compare.
  std::optional<double> inverse_error_per_m{};
};

struct LayersAtDistance {
  double d_p_m = 0.0;  // from the viewpoint to the line
  int layers = 1;
};

struct LayerFacts {
  double inverse_min_per_m = 0.0;  // 1 / far_m
  double inverse_max_per_m = 0.0;  // 1 / near_m
  std::vector<LayersAtDistance> by_d_p{};

  InverseRange range() const { return {inverse_min_per_m, inverse_max_per_m}; }
};

struct SpacingWithLayers {
  int layers = 1;
  double needed_m = 0.0;
};

// Stations re-created from those that --thin keeps at `stride` captured steps.
struct HeldOutFacts {
  int stride = 2;
  double step_m = 0.0;  // between the stations kept, at most
  int views = 0;        // number of stations re-created
  double psnr_with_distances_db = 0.0;
  double psnr_without_depth_db = 0.0;
  double psnr_of_tolerance_db = 0.0;  // captured view against itself, displaced by the tolerance
  double hidden_share = 0.0;          // of the pixels: occluded from the lines in use
};

struct SpacingFacts {
  double captured_median_m = 0.0;
  double captured_max_m = 0.0;
  double needed_without_depth_m = 0.0;
  std::vector<SpacingWithLayers> needed_with_layers{};  // 1 layer: Chai's constant depth
  // With distances of error inverse_error_per_m; infinite if that is unknown.
  double needed_by_error_m = 0.0;
  // The largest step tried at which stations re-created with distances match the captured ones at
  // least as well as a displacement by the tolerance does. Includes occlusion, reflections and
  // sampling.
  double measured_up_to_m = 0.0;
  // The smaller of the two above, but at least captured_median_m; finite.
  double needed_with_distances_m = 0.0;
  int stations = 0;
  int stations_needed_without_depth = 0;
  int stations_needed_with_distances = 0;
  std::vector<HeldOutFacts> held_out{};
};

struct StorageFacts {
  double reach_m = 0.0;  // d_p for which widths and precision are chosen
  int panorama_width_px = 0;
  // Panorama width beyond which the parallax error due to inverse_error_per_m exceeds the
  // tolerance; infinite if that error is 0 or unknown.
  double worth_width_px = 0.0;
  int distance_width_px = 0;
  int needed_distance_width_px = 0;
  double share_within_tolerance = 0.0;  // of the pixels, at needed_distance_width_px
  int inverse_steps = 0;                // quantisation steps of inverse distance needed
  int inverse_bits = 0;                 // bits for these steps plus "unknown" and "none"
  std::uint64_t ray_bytes = 0;
  std::uint64_t ray_bytes_thinned = 0;  // with stations_needed_with_distances
  std::uint64_t ray_bytes_worth = 0;    // ... and at worth_width_px, where that is smaller
  std::uint64_t distance_bytes = 0;     // all maps: 4 per distance and 1 per confidence
  // The same number of maps at needed_distance_width_px: inverse_bits rounded up to bytes, and 1
  // byte of confidence.
  std::uint64_t distance_bytes_needed = 0;
};

// A room written by --thin, compared with its source.
struct ThinnedFacts {
  std::string room{};
  int stations = 0;
  int distance_maps = 0;
  std::uint64_t bytes = 0;  // of all its files
  int views = 0;            // dropped stations re-created from it
  double psnr_db = 0.0;
  double worst_psnr_db = 0.0;
};

struct SceneFacts {
  double tolerance_px = 0.5;  // at the panorama's width
  DistanceFacts distance{};
  LayerFacts layers{};
  SpacingFacts spacing{};
  StorageFacts storage{};
  std::optional<ThinnedFacts> thinned{};
};

}  // namespace raywalk::build_lf
