// Pass 2: which points of a view the stations of each line see.
//
// Two things tell that a point is occluded:
// - The view itself. The eye P, the point A where the column's ray meets a line, and all that the
//   column shows lie in one vertical plane, so that occlusion between them is decided on one great
//   circle: the points that P sees are projected onto the circle around A, and the nearest in each
//   direction stays. A point is occluded if something nearer lies within a pixel of it there: what
//   a camera captures next to a silhouette is in part the foreground.
// - The line's distance maps. A chair just below a line occludes from its stations what the eye
//   sees past the chair. A map shows a point to be occluded from its station if one of the four
//   pixels around it holds a surface that is clearly nearer: by more than the change across a pixel
//   of a steep surface, and so that the two would move by two pixels against each other on the way
//   to the eye. Of a station without a map of its own the two maps around it on the line tell, each
//   the more the nearer it is: where one of them shows the point to be occluded, the station sees
//   it in part, and counts for less.
//
// What no station of these lines sees is read from the first of some others whose map shows that it
// does (fill). Where there is none, the maps contradict each other, and the lines are used after
// all.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/view/column_sources.h"
#include "core/view/distance_view.h"
#include "core/view/fill_stations.h"
#include "core/view/map_cache.h"

namespace raywalk {

// Of a pixel and a source: bit i: occluded from the station of the source's map first_map + i; the
// last bit: occluded by what the view shows.
inline constexpr std::uint8_t kOccludedInView = 0x80;
inline constexpr int kMapsOfSource = 7;

// In Visibility::fill(), where no station shows the point: of a column without sources, and of one
// whose sources are read although their maps show them not to see it.
inline constexpr std::uint8_t kNoStation = 255;
inline constexpr std::uint8_t kReadUnseen = 254;

// What tells that a station does not see a point: the bits of the maps at or before it and at or
// after it on its line, twice the same or none (0) where there are no two.
struct StationOccluders {
  std::uint8_t before = 0, after = 0;
  float after_part = 0.0f;  // how far the station is on the way to the map after it, 0 to 1
};

// How far a station sees a point, 0 to 1.
RAYWALK_INLINE float seen_part(std::uint8_t occluded, StationOccluders by) {
  const float before = (occluded & by.before) != 0 ? 1.0f - by.after_part : 0.0f;
  const float after = (occluded & by.after) != 0 ? by.after_part : 0.0f;
  return (occluded & kOccludedInView) != 0 ? 0.0f : 1.0f - before - after;
}
// Whether it sees it at all well.
inline bool is_seen(std::uint8_t occluded, StationOccluders by) {
  return seen_part(occluded, by) >= 0.5f;
}

class Visibility {
 public:
  // The lines of a column in plan direction theta; a count of 0: none.
  using Sources = std::function<ColumnSources(double theta_rad)>;

  // The room must outlive the object.
  explicit Visibility(const Room& room) : room_(room), cache_(room) {}

  // Of the columns [first, first + count) of the distances, around the seam. `lines`: all that
  // sources are on. `above_lines_m`: of the eye.
  struct Columns {
    int first = 0, count = 0;
    bool fills_empty = true;  // whether stations are searched for columns without sources
  };
  void compute(const DistanceView& distances, Columns columns, const Sources& sources,
               std::span<const int> lines, double above_lines_m, StationMix mix,
               const FillStations& fill) {
    plan(distances, columns, sources, lines, above_lines_m, mix, fill);
    see();
  }
  // The same in two steps: which maps tell, and what they do. A graphics card may do the second one
  // (core/view/gpu).
  void plan(const DistanceView& distances, Columns columns, const Sources& sources,
            std::span<const int> lines, double above_lines_m, StationMix mix,
            const FillStations& fill);
  void see();

  Columns columns() const { return columns_; }
  std::span<const int> lines() const { return lines_; }
  double above_lines_m() const { return above_lines_m_; }
  // How the points of a column are seen from one of its sources.
  struct SourceMaps {
    std::size_t image = 0;    // of what is occluded from it: the first source of its line and side
    int first_map = 0;        // of its line, which bit 0 tells of
    std::uint8_t wanted = 0;  // bits of the maps that tell, of all sources with the image
    StationOccluders by{};    // of its nearest station
  };
  SourceMaps maps_of(int theta, std::size_t source) const;

  const ColumnSources& sources(int theta) const {
    return sources_[static_cast<std::size_t>(theta)].sources;
  }
  // Of the source of a column on a line and side, for each row; null where the column has none.
  const std::uint8_t* occluded(int theta, int line, bool behind) const;
  // The same of a column whose bits are those of column `as`; else null. And its image, or -1.
  const std::uint8_t* occluded_as(int as, int theta, int line, bool behind) const;
  int image_as(int as, int theta, int line, bool behind) const;
  // What tells that a station of a source's line does not see a point.
  StationOccluders occluders(int theta, int line, bool behind, int station) const;
  // Of each row: 0 where the sources are read; else 1 + the index of a station to fill it from.
  const std::uint8_t* fill(int theta) const { return fill_.data() + first(theta); }
  bool any_filled(int theta) const { return sources_[static_cast<std::size_t>(theta)].any_filled; }

 private:
  struct Column {
    ColumnSources sources{};
    std::array<int, kMaxSources> first_map{};
    bool any_filled = false;
  };
  class Ring;

  std::size_t first(int theta) const {
    return static_cast<std::size_t>(theta) * static_cast<std::size_t>(rows_);
  }
  std::size_t index_of(const Column& column, int line, bool behind) const;
  void plan_column(int theta, const Sources& sources);
  void see_column(int theta, Ring* ring);
  void find_occluded(int theta, const Column& column, std::size_t source, Ring* ring);
  void find_fill(int theta, Column* column);

  const Room& room_;
  MapCache<OccluderMap> cache_;
  const DistanceView* distances_ = nullptr;
  const FillStations* fill_stations_ = nullptr;
  Columns columns_;
  std::vector<int> lines_;
  double above_lines_m_ = 0.0;
  StationMix mix_;
  int rows_ = 0;
  std::vector<std::vector<std::shared_ptr<const OccluderMap>>> maps_;  // [line][map]
  std::vector<Column> sources_;                                        // of each column
  std::array<std::vector<std::uint8_t>, kMaxSources> occluded_;        // [theta][phi]
  std::vector<std::uint8_t> fill_;                                     // [theta][phi]
};

}  // namespace raywalk
