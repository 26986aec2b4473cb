#include "build_lf/refine/source_views.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "core/view/map_choice.h"

namespace raywalk::build_lf {
namespace {

// The station's own map; without one, those around it.
std::vector<MapStation> maps_for(const Room& room, StationIndex station,
                                 const Eigen::Vector3d& position_m) {
  constexpr int kAround = 3;
  std::vector<int> lines(room.grid().lines.size());
  std::iota(lines.begin(), lines.end(), 0);
  std::vector<MapStation> maps =
      nearest_maps(room, lines, position_m, 0.0, std::numeric_limits<int>::max(), kAround);
  for (const MapStation& map : maps) {
    if (StationIndex{map.line, map.station} == station) return {map};
  }
  return maps;
}

}  // namespace

SourceView::SourceView(const Room& room, StationIndex station, DistanceView* distances)
    : station_(station), position_m_(room.grid().station(station).position_m) {
  distances->compute(maps_for(room, station, position_m_), position_m_);
  size_ = distances->size();
  tolerance_ = distances->surface_tolerance();
  const auto rows = static_cast<std::size_t>(size_.height);
  inverse_.reserve(static_cast<std::size_t>(size_.width) * rows);
  for (int theta = 0; theta < size_.width; ++theta) {
    const float* const column = distances->column(theta);
    inverse_.insert(inverse_.end(), column, column + rows);
  }
}

bool SourceView::sees(const SeenThere& point) const {
  // Neither is below -1, so that this rounds down.
  const int left = static_cast<int>(point.u + 1.0f) - 1;
  const int upper = static_cast<int>(point.v + 1.0f) - 1;
  const int x0 = left < 0 ? size_.width - 1 : left, x1 = left + 1 == size_.width ? 0 : left + 1;
  const int y0 = std::max(upper, 0), y1 = std::min(upper + 1, size_.height - 1);
  const float nearest = std::max({at(x0, y0), at(x0, y1), at(x1, y0), at(x1, y1)});
  if (nearest > point.inverse * (1.0f + tolerance_) + point.slack) return false;
  const float held = at(point.u - static_cast<float>(left) < 0.5f ? x0 : x1,
                        point.v - static_cast<float>(upper) < 0.5f ? y0 : y1);
  return held >= point.inverse * (1.0f - tolerance_) - point.slack;
}

std::shared_ptr<const SourceView> SourceViews::of(StationIndex station) {
  const auto known =
      std::ranges::find_if(kept_, [&](const auto& view) { return view->station() == station; });
  if (known != kept_.end()) {
    kept_.splice(kept_.begin(), kept_, known);
  } else {
    kept_.push_front(std::make_shared<const SourceView>(room_, station, &distances_));
  }
  std::size_t bytes = 0;
  const auto last = std::ranges::find_if(kept_, [&](const auto& view) {
    bytes += view->bytes();
    return bytes > kKeptBytes;
  });
  std::shared_ptr<const SourceView> view = kept_.front();
  kept_.erase(last, kept_.end());
  return view;
}

}  // namespace raywalk::build_lf
