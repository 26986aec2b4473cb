#include "build_lf/quality/station_links.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/base/recently_made.h"
#include "core/room/station_image.h"

namespace raywalk::build_lf {
namespace {

constexpr int kFlowMaskMarginPx = kFlowWindow / 2 + 1;

}  // namespace

double StationLink::log_exposure_step() const {
  return std::ranges::max(compared.log_ratio, {}, [](double step) { return std::fabs(step); });
}

std::vector<StationPair> pairs_to_compare(const Grid& grid) {
  std::vector<StationPair> pairs;
  for (int line = 0; line < static_cast<int>(grid.lines.size()); ++line) {
    const int stations = static_cast<int>(grid.lines[static_cast<size_t>(line)].stations.size());
    for (int i = 0; i < stations; ++i) {
      for (int j = i + 1; j < std::min(i + 3, stations); ++j) {
        pairs.push_back({{line, i}, {line, j}});
      }
    }
  }
  return pairs;
}

std::vector<StationLink> measure_links(const Room& room, std::span<const StationPair> pairs) {
  const int width = std::min(kComparisonWidth, room.panorama().width);
  const PanoramaSize size{width, width / 2};
  std::vector<StationLink> links(pairs.size());
  Progress progress("comparing neighbours", static_cast<std::int64_t>(pairs.size()), "pairs");
  constexpr int kPairsPerTask = 16;
  parallel_for(0, static_cast<int>(pairs.size()), kPairsPerTask, [&](int begin, int end) {
    // Consecutive pairs share stations.
    RecentlyMade<StationIndex, ComparedPicture> images(4, [&](StationIndex station) {
      return ComparedPicture{station_image(room, station, size),
                             station_validity(room, station, size, kFlowMaskMarginPx)};
    });
    for (auto i = static_cast<size_t>(begin); i < static_cast<size_t>(end); ++i) {
      links[i] = {pairs[i], compare_colours(*images.get(pairs[i].from), *images.get(pairs[i].to))};
      progress.advance();
    }
  });
  return links;
}

}  // namespace raywalk::build_lf
