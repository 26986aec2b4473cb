#include "render/view/read_ahead.h"

#include <algorithm>
#include <cstdlib>

namespace raywalk::render {
namespace {

// The unit of what is asked for; the system's own pages may be larger.
constexpr size_t kPageBytes = 4096;
// What lies between two runs of pages is read with them if it is less than what a disk reads in the
// time that a request of its own takes.
constexpr size_t kGapPages = 4;
// Of a block's columns every second one is looked at: what the others read besides, which mostly
// take the polar caps from their neighbours, is little.
constexpr int kColumnStep = 2;

}  // namespace

ReadAhead::ReadAhead(const ViewInputs& view)
    : view_(view), captured_(view.room.panorama()), polar_(polar_columns_of(view)) {
  if (view.distances == nullptr) return;
  const int rows = view.distances->size().height;
  latitudes_ = std::make_unique<LatitudeTable>(rows, rows);
  positions_ = std::make_unique<PositionArrays>(rows);
}

double ReadAhead::theta_of(int u) const {
  return angles_from_pixel({double(u), 0.0}, view_.output).theta_rad;
}

void ReadAhead::fetch(int first, int count, const SourcesOf& sources_of) {
  const auto column = [&](int i) { return (first + i) % view_.output.width; };
  const int ends[] = {column(0), column((count - 1) / kColumnStep * kColumnStep)};
  if (std::ranges::all_of(ends, [&](int u) { return in_memory(u, sources_of(u)); })) return;
  marked_.clear();
  for (int i = 0; i < count; i += kColumnStep) {
    const int u = column(i);
    for (const RaySource& source : sources_of(u)) {
      for (int next = 0; next < 2; ++next) mark(u, source, source.station + next);
    }
  }
  fetch_marked();
}

bool ReadAhead::in_memory(int u, std::span<const RaySource> sources) const {
  return std::ranges::all_of(sources, [&](const RaySource& source) {
    const LineVolume& volume = view_.room.volume(source.line);
    return std::ranges::all_of(looked_at(u), [&](int theta) {
      return volume.in_memory(source.station, theta) && volume.in_memory(source.station + 1, theta);
    });
  });
}

std::array<int, 2> ReadAhead::looked_at(int u) const {
  const int column = ahead(u).whole;
  const int turn = view_.distances == nullptr ? 0 : captured_.width / 4;
  return {column, (column + turn) % captured_.width};
}

ColumnPosition ReadAhead::ahead(int u) const {
  return split_column(pixel_from_angles({theta_of(u), 0.0}, captured_).u, captured_.width);
}

void ReadAhead::mark(int u, const RaySource& source, int station) {
  Pages& pages = marked_[{source.line, station}];
  pages.resize((station_bytes() + kPageBytes - 1) / kPageBytes);
  const double theta_rad = theta_of(u);
  const ColumnPosition at = ahead(u);
  const ColumnTarget target{captured_.width, captured_.height, at.whole, at.part};
  // Where in_memory() looks, so that what was fetched once is known to be there.
  for (const int column : looked_at(u)) {
    mark_rows(column, target.height / 2, target.height / 2 + 1, &pages);
  }
  if (view_.distances == nullptr) {
    for (const int next : {0, 1})
      mark_rows((at.whole + next) % target.width, 0, target.height, &pages);
    return;
  }
  const PanoramaSize size = view_.distances->size();
  const int depth_theta =
      split_column(std::round(pixel_from_angles({theta_rad, 0.0}, size).u), size.width).whole;
  const Eigen::Vector3d viewpoint_m(view_.plan.viewpoint().x_m, view_.plan.height_m(),
                                    view_.plan.viewpoint().z_m);
  const Line& line = view_.room.grid().lines[static_cast<size_t>(source.line)];
  column_kernels().find_samples(
      latitudes_->table(), view_.distances->column(depth_theta), size.height,
      column_offset(viewpoint_m - line.stations[static_cast<size_t>(station)].position_m,
                    theta_rad),
      target, positions_->positions());
  mark_seen(&pages);
}

// Marks what is read for the rows of the distances, and for those that the output has in between.
void ReadAhead::mark_seen(Pages* pages) {
  const int rows = view_.distances->size().height;
  const int per_row = std::max(1, view_.output.height / rows);
  const int half_turn = captured_.width / 2;
  for (int i = 0; i + 1 < rows; ++i) {
    const int from = positions_->offset_left[static_cast<size_t>(i)] / 3;
    const int to = positions_->offset_left[static_cast<size_t>(i) + 1] / 3;
    const int column = from / captured_.height;
    const int row = from % captured_.height;
    int columns = to / captured_.height - column;
    if (columns > half_turn) columns -= captured_.width;
    if (columns < -half_turn) columns += captured_.width;
    const int rows_on = to % captured_.height - row;
    // Half a turn is a jump over a pole: nothing is read in between.
    const int between = std::abs(columns) > half_turn / 2 ? 1 : per_row;
    for (int step = 0; step < between; ++step) {
      const int left = column + columns * step / between + captured_.width;
      const int upper = row + rows_on * step / between;
      const int apart = 1 << polar_doublings(polar_, upper, captured_.height);
      const int before = left / apart * apart;
      for (const int next : {0, apart})
        mark_rows((before + next) % captured_.width, upper, upper + 2, pages);
    }
  }
}

void ReadAhead::mark_rows(int column, int first_row, int end_row, Pages* pages) const {
  const auto byte_of = [&](int row) {
    return 3 * (static_cast<size_t>(column) * static_cast<size_t>(captured_.height) +
                static_cast<size_t>(row));
  };
  const size_t last = (byte_of(std::min(end_row, captured_.height)) - 1) / kPageBytes;
  for (size_t page = byte_of(first_row) / kPageBytes; page <= last; ++page) (*pages)[page] = true;
}

void ReadAhead::fetch_marked() const {
  for (const auto& [place, pages] : marked_) {
    fetch_pages(view_.room.volume(place.first), place.second, pages);
  }
}

void ReadAhead::fetch_pages(const LineVolume& volume, int station, const Pages& pages) const {
  const auto next = [&pages](size_t from, bool marked) {
    return static_cast<size_t>(
        std::find(pages.begin() + static_cast<std::ptrdiff_t>(from), pages.end(), marked) -
        pages.begin());
  };
  for (size_t begin = next(0, true); begin < pages.size();) {
    size_t end = next(begin, false);
    size_t following = next(end, true);
    while (following < pages.size() && following - end <= kGapPages) {
      end = next(following, false);
      following = next(end, true);
    }
    volume.fetch(station, begin * kPageBytes,
                 std::min(end * kPageBytes, station_bytes()) - begin * kPageBytes);
    begin = following;
  }
}

size_t ReadAhead::station_bytes() const {
  return 3 * static_cast<size_t>(captured_.width) * static_cast<size_t>(captured_.height);
}

}  // namespace raywalk::render
