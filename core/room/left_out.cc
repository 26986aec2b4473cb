#include "core/room/left_out.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "core/base/error.h"

namespace raywalk {

LeftOutPixels::LeftOutPixels(std::span<const std::int32_t> runs, PanoramaSize size, int stations,
                             const std::string& source)
    : size_(size) {
  if (runs.size() % 4 != 0) {
    throw Error(source + ": 'left_out' is not [run][station, theta, first row, one past the last]");
  }
  for (std::size_t i = 0; i < runs.size(); i += 4) {
    const LeftOutRun run{{runs[i + 2], runs[i + 3]}, runs[i], runs[i + 1]};
    const bool inside = run.station >= 0 && run.station < stations && run.theta >= 0 &&
                        run.theta < size.width && run.begin >= 0 && run.begin < run.end &&
                        run.end <= size.height;
    if (!inside) {
      throw Error(
          fmt::format("{}: 'left_out' names rows {} to {} of column {} of station {}, which "
                      "do not exist",
                      source, run.begin, run.end, run.theta, run.station));
    }
    runs_.push_back(run);
  }
  std::ranges::sort(runs_, {}, [](const LeftOutRun& run) {
    return std::tuple(run.station, run.theta, run.begin, run.end);
  });
}

LeftOutPixels LeftOutPixels::subset(std::span<const int> stations) const {
  LeftOutPixels part;
  part.size_ = size_;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    for (LeftOutRun run : runs_of(stations[i])) {
      run.station = static_cast<int>(i);
      part.runs_.push_back(run);
    }
  }
  return part;
}

std::vector<std::int32_t> LeftOutPixels::stored_runs(PanoramaSize size) const {
  // The first pixel of `to` that pixel `at` of `from` lies in.
  const auto first_of = [](int at, int from, int to) {
    return static_cast<int>(std::int64_t{at} * to / from);
  };
  std::vector<std::int32_t> stored;
  for (const LeftOutRun& run : runs_) {
    const int first = first_of(run.theta, size_.width, size.width);
    const int last = std::max(first, first_of(run.theta + 1, size_.width, size.width) - 1);
    const int begin = first_of(run.begin, size_.height, size.height);
    const int end = std::max(first_of(run.end - 1, size_.height, size.height) + 1,
                             first_of(run.end, size_.height, size.height));
    for (int column = first; column <= last; ++column) {
      stored.insert(stored.end(), {run.station, column, begin, end});
    }
  }
  return stored;
}

std::span<const LeftOutRun> LeftOutPixels::runs_of(int station) const {
  return {std::ranges::lower_bound(runs_, station, {}, &LeftOutRun::station),
          std::ranges::upper_bound(runs_, station, {}, &LeftOutRun::station)};
}

std::span<const LeftOutRun> LeftOutPixels::rows(int station, int theta) const {
  const std::span<const LeftOutRun> runs = runs_of(station);
  return {std::ranges::lower_bound(runs, theta, {}, &LeftOutRun::theta),
          std::ranges::upper_bound(runs, theta, {}, &LeftOutRun::theta)};
}

}  // namespace raywalk
