#include "core/view/read_ahead.h"

#include <algorithm>
#include <cstdlib>

namespace raywalk {
namespace {

// The unit of requests; the system's own pages may be larger.
constexpr size_t kPageBytes = 4096;
// Two runs of pages become one request where the gap between them takes the disk less time to read
// than a second request.
constexpr size_t kGapPages = 4;
// Only every second column of a block is considered: the others mostly take the polar caps from
// their neighbours and read little that these do not.
constexpr int kColumnStep = 2;

}  // namespace

ReadAhead::ReadAhead(const ViewInputs& view) : view_(view), captured_(view.room.panorama()) {
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
  for (const RayBytes& run : bytes_to_fetch(first, count, sources_of)) {
    view_.room.volume(run.line).fetch(run.station, run.begin, run.end - run.begin);
  }
}

std::vector<RayBytes> ReadAhead::bytes_to_fetch(int first, int count, const SourcesOf& sources_of) {
  marked_.clear();
  for (int i = 0; i < count; i += kColumnStep) {
    const int u = (first + i) % view_.output.width;
    for (const RaySource& source : sources_of(u)) {
      for (int next = 0; next < 2; ++next) mark(u, source, source.station + next);
    }
  }
  std::vector<RayBytes> runs;
  for (const auto& [place, pages] : marked_) append_runs(place.first, place.second, pages, &runs);
  return runs;
}

bool ReadAhead::in_memory(int u, std::span<const RaySource> sources) const {
  return std::ranges::all_of(sources, [&](const RaySource& source) {
    const LineVolume& volume = view_.room.volume(source.line);
    return std::ranges::all_of(checked_columns(u), [&](int theta) {
      return volume.in_memory(source.station, theta) && volume.in_memory(source.station + 1, theta);
    });
  });
}

std::array<int, 2> ReadAhead::checked_columns(int u) const {
  const int column = ahead(u).whole;
  const int turn = view_.distances == nullptr ? 0 : captured_.width / 4;
  return {column, (column + turn) % captured_.width};
}

ColumnPosition ReadAhead::ahead(int u) const {
  return split_column(pixel_from_angles({theta_of(u), 0.0}, captured_).u, captured_.width);
}

void ReadAhead::mark(int u, const RaySource& source, int station) {
  Pages& pages = marked_[{source.line, station}];
  lead_ = lead_of(source.line, station);
  pages.resize((lead_ + station_bytes(source.line) + kPageBytes - 1) / kPageBytes);
  const double theta_rad = theta_of(u);
  const ColumnPosition at = ahead(u);
  const ColumnTarget target{captured_.width, captured_.height, at.whole, at.part};
  // What in_memory() checks, so that it finds what was fetched once.
  for (const int column : checked_columns(u)) {
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
  const Line& line = view_.room.grid().lines[static_cast<size_t>(source.line)];
  column_kernels().find_samples(
      latitudes_->table(), view_.distances->column(depth_theta), size.height,
      column_offset(view_.eye_m(theta_rad) - line.stations[static_cast<size_t>(station)].position_m,
                    theta_rad),
      target, positions_->positions());
  mark_positions(layout_of(view_, source.line), &pages);
}

// Marks what is read for the rows of the distances and for the output rows between them.
void ReadAhead::mark_positions(const RayLayout& layout, Pages* pages) {
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
    // Half a turn is a jump over a pole: nothing between is read.
    const int between = std::abs(columns) > half_turn / 2 ? 1 : per_row;
    for (int step = 0; step < between; ++step) {
      const int left = column + columns * step / between + captured_.width;
      const int upper = row + rows_on * step / between;
      const int doublings = polar_doublings(layout.polar, upper, captured_.height);
      const int before = left >> doublings << doublings;
      for (const int next : {0, 1 << doublings}) {
        const int read = (before + next) % captured_.width;
        const auto begin =
            static_cast<size_t>(ray_offset(layout, doublings, read, upper, captured_.height));
        mark_bytes(begin, begin + 6, pages);
      }
    }
  }
}

void ReadAhead::mark_rows(int column, int first_row, int end_row, Pages* pages) const {
  const auto byte_of = [&](int row) {
    return 3 * (static_cast<size_t>(column) * static_cast<size_t>(captured_.height) +
                static_cast<size_t>(row));
  };
  mark_bytes(byte_of(first_row), byte_of(end_row), pages);
}

void ReadAhead::mark_bytes(size_t begin, size_t end, Pages* pages) const {
  const size_t last = (lead_ + end - 1) / kPageBytes;
  for (size_t page = (lead_ + begin) / kPageBytes; page <= last; ++page) (*pages)[page] = true;
}

void ReadAhead::append_runs(int line, int station, const Pages& pages,
                            std::vector<RayBytes>* runs) const {
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
    const size_t lead = lead_of(line, station);
    runs->push_back({line, station, std::max(begin * kPageBytes, lead) - lead,
                     std::min(end * kPageBytes - lead, station_bytes(line))});
    begin = following;
  }
}

size_t ReadAhead::lead_of(int line, int station) const {
  const void* first = view_.room.volume(line).rays(station);
  return reinterpret_cast<std::uintptr_t>(first) % kPageBytes;
}

size_t ReadAhead::station_bytes(int line) const { return view_.room.volume(line).station_bytes(); }

}  // namespace raywalk
