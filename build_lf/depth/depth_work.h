// The work of a depth run, step by step and block by block.
//
// What a step leaves is kept in the room's working directory (PartialMaps) until the room has its
// distances: maps, and for each block what else it found. A run of its own goes through the steps
// as blocks do, with one block each, and so has the same result.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "build_lf/depth/contradictions.h"
#include "build_lf/depth/depth_plan.h"
#include "build_lf/depth/depth_steps.h"
#include "build_lf/depth/depth_summary.h"
#include "build_lf/depth/frame_checks.h"
#include "build_lf/depth/partial_maps.h"
#include "build_lf/gains/station_ratios.h"
#include "build_lf/gains/surface_maps.h"
#include "core/base/block.h"
#include "core/files/block_results.h"
#include "core/room/gain_fields.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// What comparing neighbouring frames tells.
struct ExaminedFrames {
  FrameChecks checks;
  std::vector<StationIndex> outliers;  // at a wrong position, or showing something that moved
};

class DepthWork {
 public:
  // Opens the room and its working directory. Throws UsageError for options that contradict each
  // other, Error as Room::open_rays and PartialMaps do, and if estimated distances cannot replace
  // those of the room.
  DepthWork(const DepthOptions& options, MapsUse use);

  const Room& room() const { return room_; }  // without held-out stations
  const DepthOptions& options() const { return options_; }
  const std::filesystem::path& output() const { return output_; }  // for maps and summary
  PartialMaps& partial() { return partial_; }

  // Whether the run has the step; if not, it counts as complete.
  bool has(DepthStep step) const;
  // Does a block unless it is done; whether it was done now. Throws Error if what it needs of the
  // steps before is missing, and as the steps do.
  bool make(DepthStep step, Block block);
  // Does all blocks that are missing, of the number of blocks that was begun.
  void complete(DepthStep step);
  // Which blocks are missing, for people; empty: none.
  std::string missing(DepthStep step);
  // Throws Error naming the step and the blocks that are missing.
  void require(DepthStep step);
  // The number of pieces of a step that are divided.
  std::size_t pieces(DepthStep step);

  // What complete steps tell. Each throws Error as require() does.
  const ExaminedFrames& frames();
  const DepthPlan& plan();
  double nearest_per_m();              // the largest inverse distance that is swept
  const GainFields& matching_gains();  // solved for by the first that asks, and kept
  std::vector<MapSummary> map_summaries();
  std::vector<LeftOutSummary> left_out();
  GainFields room_gains();  // solved for
  InverseDistanceMap final_map(const SweepReference& reference) const;
  // Moves the volumes into the room, or to the held-out ones, and removes the working directory.
  void install();

 private:
  BlockResults results(DepthStep step);
  std::string run(DepthStep step, Block block);
  bool stores_all_maps(DepthStep step, Block block);
  std::vector<std::string> merged(DepthStep step);
  RatioParts ratios(DepthStep step);  // those that the blocks of a step left
  const DepthPlan& plan_before_reach();
  SurfaceMaps coarse_maps();
  // Maps may be of other blocks, which need not all be done.
  void require_maps(DepthStep step, const char* stage, const std::vector<int>& maps);
  std::string make_flow_maps(IndexRange share);
  std::string make_fused_maps(IndexRange share);
  std::string compare_final_colours(Block block);
  std::vector<std::uint64_t> maps_by_line();
  Contradictions contradictions_of(int line);
  MapSummary summary_of(const InverseDistanceMap& map);

  DepthOptions options_;
  Room room_;
  DepthPlan first_plan_;  // of all stations
  cv::Mat valid_;
  std::filesystem::path output_;
  PartialMaps partial_;
  std::optional<ExaminedFrames> frames_{};
  std::optional<DepthPlan> plan_before_reach_{};
  std::optional<DepthPlan> plan_{};
  std::optional<double> nearest_per_m_{};
  std::optional<GainFields> matching_gains_{};
  // The block of contradictions that was read last.
  std::optional<int> read_block_{};
  std::vector<ContradictedStation> read_contradictions_{};
};

}  // namespace raywalk::build_lf
