#include "core/room/left_out.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/base/error.h"

namespace raywalk {
namespace {

using Run = std::array<std::int32_t, 4>;  // station, theta, first row, one past the last

std::vector<Run> sorted_runs(std::span<const std::int32_t> values, PanoramaSize size, int stations,
                             const std::string& source) {
  if (values.size() % 4 != 0) {
    throw Error(source + ": 'left_out' is not [run][station, theta, first row, one past the last]");
  }
  std::vector<Run> runs(values.size() / 4);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(4 * i), 4, runs[i].begin());
    const auto [station, theta, begin, end] = runs[i];
    const bool inside = station >= 0 && station < stations && theta >= 0 && theta < size.width &&
                        begin >= 0 && begin < end && end <= size.height;
    if (!inside) {
      throw Error(
          fmt::format("{}: 'left_out' names rows {} to {} of column {} of station {}, which "
                      "do not exist",
                      source, begin, end, theta, station));
    }
  }
  std::ranges::sort(runs);
  return runs;
}

}  // namespace

LeftOutPixels::LeftOutPixels(std::span<const std::int32_t> runs, PanoramaSize size, int stations,
                             const std::string& source)
    : size_(size), stations_(static_cast<std::size_t>(stations)) {
  const std::vector<Run> sorted = sorted_runs(runs, size, stations, source);
  for (auto begin = sorted.begin(); begin != sorted.end();) {
    const auto end =
        std::find_if(begin, sorted.end(), [&](const Run& run) { return run[0] != (*begin)[0]; });
    auto columns = std::make_shared<Columns>();
    columns->first.assign(static_cast<std::size_t>(size.width) + 1, 0);
    for (auto run = begin; run != end; ++run) {
      columns->runs.push_back({(*run)[2], (*run)[3]});
      ++columns->first[static_cast<std::size_t>((*run)[1]) + 1];
    }
    for (std::size_t theta = 1; theta < columns->first.size(); ++theta) {
      columns->first[theta] += columns->first[theta - 1];
    }
    stations_[static_cast<std::size_t>((*begin)[0])] = std::move(columns);
    begin = end;
  }
}

LeftOutPixels LeftOutPixels::subset(std::span<const int> stations) const {
  LeftOutPixels part;
  part.size_ = size_;
  for (const int station : stations) {
    part.stations_.push_back(any(station) ? stations_[static_cast<std::size_t>(station)] : nullptr);
  }
  return part;
}

std::vector<std::int32_t> LeftOutPixels::stored_runs(PanoramaSize size) const {
  // The first pixel of `to` that pixel `at` of `from` lies in.
  const auto first_of = [](int at, int from, int to) {
    return static_cast<int>(std::int64_t{at} * to / from);
  };
  std::vector<std::int32_t> stored;
  for (int station = 0; station < static_cast<int>(stations_.size()); ++station) {
    if (!any(station)) continue;
    for (int theta = 0; theta < size_.width; ++theta) {
      const int first = first_of(theta, size_.width, size.width);
      const int last = std::max(first, first_of(theta + 1, size_.width, size.width) - 1);
      for (const RowRun& run : rows(station, theta)) {
        const int begin = first_of(run.begin, size_.height, size.height);
        const int end = first_of(run.end - 1, size_.height, size.height) + 1;
        for (int column = first; column <= last; ++column) {
          stored.insert(stored.end(),
                        {station, column, begin,
                         std::max(end, first_of(run.end, size_.height, size.height))});
        }
      }
    }
  }
  return stored;
}

std::span<const RowRun> LeftOutPixels::rows(int station, int theta) const {
  if (!any(station)) return {};
  const Columns& columns = *stations_[static_cast<std::size_t>(station)];
  const std::size_t begin = columns.first[static_cast<std::size_t>(theta)];
  const std::size_t end = columns.first[static_cast<std::size_t>(theta) + 1];
  return std::span(columns.runs).subspan(begin, end - begin);
}

}  // namespace raywalk
