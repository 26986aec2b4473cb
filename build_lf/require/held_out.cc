#include "build_lf/require/held_out.h"

#include <algorithm>

#include "core/base/median.h"
#include "core/base/pick_evenly.h"
#include "core/base/progress.h"
#include "core/evaluate/recreated_station.h"
#include "core/room/kept_stations.h"

namespace raywalk::build_lf {
namespace {

constexpr int kViewsPerStride = 12;

// 2, 3, 4, 6, 8, 12, 16, ...
std::vector<int> strides_up_to(int longest) {
  std::vector<int> strides;
  for (int power = 2; power <= longest; power *= 2) {
    strides.push_back(power);
    if (power + power / 2 <= longest) strides.push_back(power + power / 2);
  }
  return strides;
}

// Two stations of a line, between which the others are left out.
struct Gap {
  int line = 0;
  int left = 0;
  int right = 0;
};

struct StrideGaps {
  int stride = 0;
  double step_m = 0.0;  // their median width
  std::vector<Gap> gaps{};
};

StrideGaps gaps_of_stride(const Grid& grid, int stride) {
  std::vector<Gap> all;
  std::vector<double> steps_m;
  for (int line = 0; line < static_cast<int>(grid.lines.size()); ++line) {
    const std::vector<Station>& stations = grid.lines[static_cast<size_t>(line)].stations;
    for (int left = 0; left + stride < static_cast<int>(stations.size()); left += stride) {
      const int right = left + stride;
      all.push_back({line, left, right});
      steps_m.push_back(stations[static_cast<size_t>(right)].along_m -
                        stations[static_cast<size_t>(left)].along_m);
    }
  }
  StrideGaps some{stride, median(steps_m)};
  for (const int i : pick_evenly(static_cast<int>(all.size()), kViewsPerStride)) {
    some.gaps.push_back(all[static_cast<size_t>(i)]);
  }
  return some;
}

Room without(const Room& room, const Gap& gap) {
  std::vector<std::vector<int>> left_out(room.grid().lines.size());
  for (int station = gap.left + 1; station < gap.right; ++station) {
    left_out[static_cast<size_t>(gap.line)].push_back(station);
  }
  return room.subset(stations_except(room.grid(), left_out));
}

HeldOutFacts facts_of(const StrideGaps& gaps, std::span<const RecreationScore> scores) {
  HeldOutFacts facts{
      .stride = gaps.stride, .step_m = gaps.step_m, .views = static_cast<int>(scores.size())};
  const double part = 1.0 / static_cast<double>(scores.size());
  for (const RecreationScore& score : scores) {
    facts.psnr_with_distances_db += part * score.psnr_with_distances_db;
    facts.psnr_without_depth_db += part * score.psnr_without_depth_db;
    facts.psnr_of_tolerance_db += part * score.psnr_of_tolerance_db;
    facts.hidden_share += part * score.hidden_share;
  }
  return facts;
}

std::vector<StrideGaps> strides_of(const Grid& grid) {
  int longest = 0;
  for (const Line& line : grid.lines) {
    longest = std::max(longest, static_cast<int>(line.stations.size()) - 1);
  }
  std::vector<StrideGaps> strides;
  for (const int stride : strides_up_to(longest)) strides.push_back(gaps_of_stride(grid, stride));
  return strides;
}

}  // namespace

std::vector<HeldOutFacts> measure_strides(const Room& room, double tolerance_px) {
  const std::vector<StrideGaps> strides = strides_of(room.grid());
  std::int64_t stations = 0;
  for (const StrideGaps& of_stride : strides) stations += std::ssize(of_stride.gaps);
  Progress progress("re-creating", stations, "stations");
  StationRecreation recreation(room, room, tolerance_px);
  std::vector<HeldOutFacts> facts;
  for (const StrideGaps& of_stride : strides) {
    std::vector<RecreationScore> scores;
    for (const Gap& gap : of_stride.gaps) {
      const HeldOutStation middle{gap.line, gap.left + of_stride.stride / 2};
      scores.push_back(recreation.score(middle, without(room, gap)));
      progress.advance();
    }
    facts.push_back(facts_of(of_stride, scores));
  }
  return facts;
}

double measured_up_to_m(std::span<const HeldOutFacts> strides) {
  double step_m = 0.0;
  for (const HeldOutFacts& facts : strides) {
    if (facts.psnr_with_distances_db < facts.psnr_of_tolerance_db) break;
    step_m = facts.step_m;
  }
  return step_m;
}

}  // namespace raywalk::build_lf
