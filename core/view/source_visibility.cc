#include "core/view/source_visibility.h"

#include <algorithm>
#include <cmath>

#include "core/view/sample_check.h"
#include "core/view/sample_reader.h"

namespace raywalk {
namespace {

// A line that does not seem to see a point is not used for it; the less the distances can be relied
// on (`trust`, null: entirely), the more it is used after all.
void weigh_visibility(const float* trust, std::span<std::uint8_t> rows) {
  for (size_t row = 0; row < rows.size(); ++row) {
    const float doubt = trust == nullptr ? 0.0f : 1.0f - trust[row];
    rows[row] = rows[row] != 0 ? kSeen : static_cast<std::uint8_t>(std::lround(doubt * kSeen));
  }
}

}  // namespace

Reading usual_reading(const ViewInputs& view, const RaySource& source) {
  const double share = std::min(source.fraction, 1.0 - source.fraction);
  const bool without_share = view.skip_px > 0.0 && fixed_weight(share) == 0;
  if (view.stations_mixed == 2 && !without_share) return Reading::kBoth;
  return nearer_station(source);
}

SourceVisibility::SourceVisibility(const ViewInputs& view, ColumnDistances& distances,
                                   StationPositions& positions, FillStations& fill)
    : view_(view),
      distances_(distances),
      positions_(positions),
      fill_(fill),
      ring_(view.distances->size().height),
      stations_(view.room, *view.distances, view.plan.eye()),
      samples_(view.output.height) {}

// Where both stations are read, output columns with other stations share what is visible: it
// changes little. A single station may see what another one does not.
int SourceVisibility::only_station(const RaySource& source) const {
  const Reading reading = usual_reading(view_, source);
  return reading == Reading::kBoth ? kBothStations
                                   : source.station + (reading == Reading::kSecond ? 1 : 0);
}

std::span<const std::uint8_t> SourceVisibility::visible_rows(int depth_theta,
                                                             const RaySource& source) {
  if (theta_ != depth_theta) {
    theta_ = depth_theta;
    visible_.clear();
    visible_.reserve(2 * kMaxSources);
  }
  const bool behind = source.d_p_m < 0.0;
  const int only = only_station(source);
  for (const Visible& known : visible_) {
    if (known.line == source.line && known.behind == behind && known.only_station == only) {
      return known.rows;
    }
  }
  Visible& visible = visible_.emplace_back();  // moving others keeps the rows they have returned
  visible.line = source.line;
  visible.behind = behind;
  visible.only_station = only;
  ring_.compute(*view_.distances, depth_theta, view_.acquisition_point(source), visible.rows);
  remove_hidden_from_stations(depth_theta, source, visible.rows);
  weigh_visibility(view_.distances->trust(depth_theta), visible.rows);
  return visible.rows;
}

void SourceVisibility::remove_hidden_from_stations(int depth_theta, const RaySource& source,
                                                   std::vector<std::uint8_t>& visible) {
  seen_by_line_ = visible;
  const Reading reading = usual_reading(view_, source);
  stations_.remove_hidden({source.line, source.station, {reads(reading, 0), reads(reading, 1)}},
                          depth_theta, visible);
  for (size_t row = 0; row < visible.size(); ++row) {
    if (visible[row] == seen_by_line_[row]) continue;
    // Where every station sees something nearer, so does the viewpoint, and its distance is wrong.
    if (fill_.of(depth_theta, static_cast<int>(row)) == FillStations::kNone) visible[row] = 1;
  }
}

std::span<const std::uint8_t> SourceVisibility::usable_rows(const ColumnPoints& points,
                                                            const RaySource& source,
                                                            std::size_t which) {
  const auto visible = visible_rows(points.depth_theta, source);
  const LeftOutPixels& left_out = view_.room.distances(source.line).left_out();
  if (!view_.room.volume(source.line).masked() && !left_out.any(source.station) &&
      !left_out.any(source.station + 1)) {
    return visible;
  }
  auto& usable = usable_[which];
  usable.assign(visible.begin(), visible.end());
  const ColumnPoints snapped = distances_.in_layers(points, source);
  for (int next = 0; next < 2; ++next) {
    if (!reads(usual_reading(view_, source), next)) continue;
    remove_masked(snapped, source.line, source.station + next, usable);
  }
  return usable;
}

// Visibility changes little within a column of the distances and is shared by its output columns;
// masks must be exact to the pixel, so they are looked up at the actual sample positions.
void SourceVisibility::remove_masked(const ColumnPoints& points, int line, int station,
                                     std::span<std::uint8_t> usable) {
  const LineVolume& volume = view_.room.volume(line);
  const RowRun all{0, view_.output.height};
  const SamplePositions at =
      positions_.find(points, line, station, all, samples_.positions()).positions;
  SampleCheck masks(volume, station);
  LeftOutCheck moved(view_.room.distances(line).left_out(), volume, station);
  for (int row = 0; row < view_.output.height; ++row) {
    const std::int32_t left = at.offset_left[row];
    const std::int32_t right = at.offset_right[row];
    if (masks.valid(left, right) && moved.valid(left, right)) continue;
    usable[static_cast<size_t>(distances_.mapping().nearest[static_cast<size_t>(row)])] = 0;
  }
}

}  // namespace raywalk
