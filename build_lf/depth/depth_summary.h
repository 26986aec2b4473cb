// Results and statistics of a depth run, for depth.json and the report.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/partial_maps.h"
#include "build_lf/exposure/make_gains.h"
#include "build_lf/quality/frame_checks.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Errors of the pixels in one band of confidence.
struct ConfidenceBand {
  double confidence = 0.0;  // centre of the band, in [0, 1]
  std::int64_t pixels = 0;
  double wrong_share = 0.0;  // error over one pixel of parallax at the reach
  double median_error_px = 0.0;
};

// What counts as beside a silhouette, pixels.
inline constexpr int kEdgePx = 3;

struct TruthComparison {
  int maps = 0;
  double within_1px_share = 0.0;  // error as parallax over the reach, at the maps' width
  double within_2px_share = 0.0;
  double within_4px_share = 0.0;
  double median_relative_error = 0.0;       // of distances, where both are finite
  std::vector<ConfidenceBand> elsewhere{};  // over kEdgePx from silhouettes
  std::vector<ConfidenceBand> edges{};      // nearer to them
};

struct MapSummary {
  std::string line{};
  int station = 0;
  std::string file{};
  double mean_confidence = 0.0;  // in [0, 1], over the solid angle
  double low_share = 0.0;        // of the solid angle, below kMinConfidence
  double parallax_share = 0.0;   // of the solid angle, moves 1 px or more over the reach
};

// A station part of which views leave out, as the other stations contradict it.
struct LeftOutSummary {
  std::string line{};
  int station = 0;
  std::string file{};
  double share = 0.0;  // of the solid angle
};

struct DepthSummary {
  std::string room{};
  std::string method{};
  PanoramaSize size;
  int stations = 0;
  int every = 0;             // DepthOptions::every
  int hold_out = 0;          // DepthOptions::hold_out
  std::string valid_mask{};  // file; empty: none
  double reach_m = 0.0;
  double nearest_m = 0.0;  // near limit of the sweep; 0: no limit (flow)
  int layers = 0;
  double largest_exposure_step = 1.0;  // factor between neighbours on a line
  double seconds = 0.0;
  double peak_memory_mb = 0.0;
  std::vector<MapSummary> maps{};
  bool leave_out_moving = true;            // DepthOptions::leave_out_moving
  std::vector<LeftOutSummary> left_out{};  // stations of which anything is left out
  std::vector<FrameFinding> frame_findings{};
  std::vector<std::string> warnings{};  // frame and line findings, as sentences
  std::optional<TruthComparison> truth{};
  std::string page{};                   // path of the HTML page
  std::string distances{};              // in use by views after the run: Room::distances_origin()
  std::optional<GainsSummary> gains{};  // of the room, where solved
  std::string kept_given{};  // directory of given distances that are not in use; empty: none

  // Share of the solid angle of all maps with a confidence below kMinConfidence.
  double low_confidence_share() const;
  // Share of the solid angle of all stations that is left out.
  double left_out_share() const;
};

// Of the finished maps, and of what the finished volumes leave out.
std::vector<MapSummary> map_summaries(const Grid& grid, const DepthPlan& plan,
                                      const PartialMaps& partial);
std::vector<LeftOutSummary> left_out_summaries(const Grid& grid,
                                               const std::vector<DistanceVolume>& volumes);

// The document of depth.json.
nlohmann::ordered_json depth_document(const DepthSummary& summary);

// For a terminal: where the result is, how much of it has low confidence, the comparison with the
// truth, the gains, and which distances views now use.
std::string text_of(const DepthSummary& summary);

// Throws Error if most of the solid angle has low confidence, so that views between stations would
// be torn: a clear word instead of bad views.
void require_usable(const DepthSummary& summary);

// One sentence without a full stop: "92.8 % of the pixels within 1 px of parallax ...".
std::string text_of(const TruthComparison& truth);

// One sentence per line whose maps show almost no parallax, as when the camera did not move at all:
// then all frames differ by noise only, which kNotMoved, relative to the line, cannot detect.
// `maps` are ordered by line; surfaces nearer than `far_m` move by a pixel or more over the reach.
std::vector<std::string> parallax_warnings(std::span<const MapSummary> maps, double far_m);

}  // namespace raywalk::build_lf
