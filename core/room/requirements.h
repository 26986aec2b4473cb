// What a room's scene requires, as `raywalk-build-lf require` measures it and keeps it in
// ROOM/require.json: how many depth layers, how dense stations, which k, how much to store.
// raywalk-render reads it for `--layers auto` and `--k auto`.
//
// Every member below is a key of the file under its own name; a list is an array of objects. A
// distance, spacing or width that is infinite (sky, no limit) is null, as is an optional member
// that is none. PSNR is over RGB in dB, capped at 100. Shares are of the solid angle, in [0, 1].
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/layer_count.h"
#include "core/room/connection_errors.h"
#include "core/room/room.h"

namespace raywalk {

inline constexpr const char* kRequirementsFormat = "raywalk-require";
// The newest format this program reads and the one it writes.
inline constexpr int kRequirementsVersion = 1;

// Quantiles of the distances from the stations in a field of directions: 1 %, 50 % and 99 % of the
// solid angle, weighted by confidence, are nearer.
struct DirectionRange {
  double longitude_deg = 0.0;  // the field's middle, in world axes
  double latitude_deg = 0.0;
  double near_m = 0.0;
  double median_m = 0.0;
  double far_m = 0.0;
  double sky_share = 0.0;
};

struct DistanceFacts {
  double near_m = 0.0;  // as in DirectionRange, over all directions
  double median_m = 0.0;
  double far_m = 0.0;
  double sky_share = 0.0;
  double known_share = 0.0;  // confidence, averaged
  // How much the room's maps contradict each other where they see the same surface: 95 % of the
  // pixels differ by less, in 1/m, divided by sqrt(2) as both err. None: no two maps to compare.
  std::optional<double> omega_error_per_m{};
  std::vector<DirectionRange> directions{};
};

struct LayersAtDistance {
  double d_p_m = 0.0;  // from the viewpoint to the line
  int layers = 1;
};

struct LayerFacts {
  double omega_min_per_m = 0.0;  // 1 / far_m
  double omega_max_per_m = 0.0;  // 1 / near_m
  std::vector<LayersAtDistance> by_d_p{};

  OmegaRange range() const { return {omega_min_per_m, omega_max_per_m}; }
};

struct SpacingWithLayers {
  int layers = 1;
  double needed_m = 0.0;
};

// Stations left out and re-created from the nearest ones kept, every `stride`-th.
struct HeldOutFacts {
  int stride = 2;
  double step_m = 0.0;  // between the stations kept, median
  int views = 0;        // how many were re-created
  double psnr_with_distances_db = 0.0;
  double psnr_without_depth_db = 0.0;
  double psnr_of_tolerance_db = 0.0;  // of the captured station against itself, displaced so far
  double hidden_share = 0.0;          // seen by neither neighbour
};

struct SpacingFacts {
  double captured_median_m = 0.0;
  double captured_max_m = 0.0;
  double needed_without_depth_m = 0.0;
  std::vector<SpacingWithLayers> needed_with_layers{};  // 1 layer: Chai's constant depth
  // With distances, for omega_error_per_m; infinite where that is not known.
  double needed_by_error_m = 0.0;
  // The largest step tried at which, with distances, re-created stations are as near to the
  // captured ones as a displacement by the tolerance is: occlusion, reflections and sampling
  // included.
  double measured_up_to_m = 0.0;
  // The smaller of both, but at least captured_median_m; finite.
  double needed_with_distances_m = 0.0;
  int stations = 0;
  int stations_needed_without_depth = 0;
  int stations_needed_with_distances = 0;
  std::vector<HeldOutFacts> held_out{};
};

struct ConnectionFacts {
  std::optional<double> model_k_deg{};         // of the least E_t; none: the room has no cell
  std::vector<MeasuredConnection> measured{};  // empty: raywalk-render connect-error measures it
};

struct StorageFacts {
  double reach_m = 0.0;  // d_p that widths and precision are chosen for: half a cell's side
  int panorama_width_px = 0;
  // Beyond it the parallax that omega_error_per_m leaves exceeds the tolerance; infinite where that
  // error is 0 or not known.
  double worth_width_px = 0.0;
  int distance_width_px = 0;
  int needed_distance_width_px = 0;
  double share_within_tolerance = 0.0;  // of the pixels, at needed_distance_width_px
  int omega_steps = 0;                  // of inverse distance that the tolerance needs
  int omega_bits = 0;                   // to number them, unknown and none included
  std::uint64_t ray_bytes = 0;
  std::uint64_t ray_bytes_thinned = 0;  // with stations_needed_with_distances
  std::uint64_t ray_bytes_worth = 0;    // ... and at worth_width_px, where that is smaller
  std::uint64_t distance_bytes = 0;     // of all maps: 4 per distance and 1 per confidence
  // Of as many maps, needed_distance_width_px wide: omega_bits in whole bytes and 1 per confidence.
  std::uint64_t distance_bytes_needed = 0;
};

// A room written by --thin, compared with the one it was made from.
struct ThinnedFacts {
  std::string room{};
  int stations = 0;
  int distance_maps = 0;
  std::uint64_t bytes = 0;  // of all its files
  int views = 0;            // dropped stations re-created from it
  double psnr_db = 0.0;
  double worst_psnr_db = 0.0;
};

struct RoomRequirements {
  std::string distances_sha256{};  // of the room it was measured on: distances_sha256()
  double tolerance_px = 0.5;       // at the panorama's width
  DistanceFacts distance{};
  LayerFacts layers{};
  SpacingFacts spacing{};
  ConnectionFacts connection{};
  StorageFacts storage{};
  std::optional<ThinnedFacts> thinned{};
};

// Tells a room's distances from others: over the checksums of its maps and where they belong.
std::string distances_sha256(const Room& room);

std::filesystem::path requirements_path(const std::filesystem::path& room);

// Text of require.json and back. `source` names the text in errors. Parsing throws Error for
// anything but what requirements_to_json writes: damage, another format, a newer version, values
// out of range.
std::string requirements_to_json(const RoomRequirements& requirements);
RoomRequirements requirements_from_json(const std::string& text, const std::string& source);

// What the room keeps. None where it keeps nothing, and, with a warning, where that was measured on
// other distances than the room has now. Throws Error where the file is damaged or of a newer
// version, and how to make it anew.
std::optional<RoomRequirements> current_requirements(const Room& room);

}  // namespace raywalk
