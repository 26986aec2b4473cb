#include "build_lf/depth/preparation.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>

#include "build_lf/depth/sweep_depth.h"
#include "build_lf/exposure/make_gains.h"
#include "build_lf/exposure/room_gains.h"
#include "build_lf/quality/station_links.h"
#include "core/base/error.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

// What is measured; all else follows from it.
struct Measured {
  std::vector<StationLink> links{};
  double near_m = std::numeric_limits<double>::infinity();  // plan_depth()
  double nearest_per_m = 0.0;
};

constexpr const char* kMeasuredFile = "measured";
constexpr const char* kCoarseStage = "coarse";

fs::path gains_file(const PartialMaps& partial) { return partial.directory() / "gains.h5"; }

// As it is kept: the two distances and the links.
std::string bytes_of(const Measured& measured) {
  static_assert(std::is_trivially_copyable_v<StationLink>);
  std::string bytes(reinterpret_cast<const char*>(&measured.near_m), sizeof(double));
  bytes.append(reinterpret_cast<const char*>(&measured.nearest_per_m), sizeof(double));
  bytes.append(reinterpret_cast<const char*>(measured.links.data()),
               measured.links.size() * sizeof(StationLink));
  return bytes;
}

Measured measured_from(const std::string& bytes) {
  constexpr std::size_t kDistances = 2 * sizeof(double);
  Measured measured;
  std::memcpy(&measured.near_m, bytes.data(), sizeof(double));
  std::memcpy(&measured.nearest_per_m, bytes.data() + sizeof(double), sizeof(double));
  measured.links.resize((bytes.size() - kDistances) / sizeof(StationLink));
  std::memcpy(measured.links.data(), bytes.data() + kDistances, bytes.size() - kDistances);
  return measured;
}

// The plan without frames at a wrong position, or that show something that moved.
DepthPlan plan_without_faults(const Room& room, const DepthOptions& options,
                              const FrameChecks& checks, double near_m) {
  std::vector<StationIndex> faulty;
  for (const FrameFinding& finding : checks.frames) {
    if (finding.fault != FrameFault::kExposureStep) faulty.push_back(finding.station);
  }
  DepthPlan plan = plan_depth(room, options, near_m);
  exclude_stations(faulty, &plan);
  return plan;
}

// All but the gains.
Preparation preparation_of(const Room& room, const DepthOptions& options,
                           const Measured& measured) {
  Preparation preparation;
  preparation.checks = check_frames(room, measured.links, plan_depth(room, options).reach_m);
  preparation.plan = plan_without_faults(room, options, preparation.checks, measured.near_m);
  preparation.nearest_per_m = measured.nearest_per_m;
  return preparation;
}

SurfaceMaps coarse_maps(const DepthPlan& plan, const cv::Mat& valid, const PartialMaps& partial) {
  SurfaceMaps maps{coarse_size(plan), {}, {}, valid};
  for (const SweepReference& map : plan.maps) maps.stations.push_back(map.station);
  maps.read = [&partial](StationIndex station) { return partial.stored(kCoarseStage, station); };
  return maps;
}

// Stores the gains, and returns them as they are read again, so that this run and those that read
// them have the same. Gains of 1 are not stored.
GainFields kept_gains(const Room& room, GainFields gains, const PartialMaps& partial) {
  const bool all_are_one = std::ranges::all_of(
      gains, [](const auto& line) { return std::ranges::all_of(line, is_one); });
  fs::remove(gains_file(partial));
  if (all_are_one) return gains;
  write_gain_fields(gains_file(partial), room.grid(), gains);
  return read_gain_fields(gains_file(partial), room.grid());
}

}  // namespace

Preparation prepare_depth(const Room& room, const DepthOptions& options, const cv::Mat& valid,
                          PartialMaps* partial) {
  Measured measured;
  measured.links = measure_links(room, pairs_to_compare(room.grid()));
  Preparation preparation = preparation_of(room, options, measured);
  warn_of(room, preparation.checks);  // before hours of work
  if (options.method == DepthMethod::kSweep && room.grid().cells.empty()) {
    // Without cells, the lines do not tell how far away the scene is.
    measured.near_m = sweep_coarse_maps(room, preparation.plan, valid, "near", partial).near_m;
    preparation.plan = plan_without_faults(room, options, preparation.checks, measured.near_m);
  }
  const DepthPlan& plan = preparation.plan;
  measured.nearest_per_m =
      sweep_coarse_maps(room, plan, valid, kCoarseStage, partial).nearest_per_m;
  preparation.nearest_per_m = measured.nearest_per_m;
  preparation.gains =
      kept_gains(room, solve_room_gains(room, coarse_maps(plan, valid, *partial)), *partial);
  partial->store_bytes(kMeasuredFile, bytes_of(measured));
  return preparation;
}

std::optional<Preparation> kept_preparation(const Room& room, const DepthOptions& options,
                                            const PartialMaps& partial) {
  const std::optional<std::string> kept = partial.load_bytes(kMeasuredFile);
  if (!kept) return std::nullopt;
  const Measured measured = measured_from(*kept);
  GainFields gains = unit_gain_fields(room.grid());
  try {
    if (fs::exists(gains_file(partial))) {
      gains = read_gain_fields(gains_file(partial), room.grid());
    }
  } catch (const Error&) {
    return std::nullopt;
  }
  Preparation preparation = preparation_of(room, options, measured);
  preparation.gains = std::move(gains);
  return preparation;
}

void warn_of(const Room& room, const FrameChecks& checks) {
  for (const std::string& warning : warnings_of(room, checks)) spdlog::warn("{}", warning);
}

}  // namespace raywalk::build_lf
