#include "core/view/visibility.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"

namespace raywalk {
namespace {

// A surface occludes a point only if seen from the eye both would move by at least this much
// against each other, in pixels of the maps: less is noise, and would not be drawn wrongly.
constexpr double kClearlyNearerPx = 2.0;

// A map in which points of a column are looked up.
struct Occluders {
  const float* nearest;
  int width, rows;
  Offset to_eye;
  float column;  // of the map, in the column's direction
  float slack;   // 1/m
};

// Sets `bit` where the map shows points to be occluded.
RAYWALK_VECTOR_CLONES void mark_occluded(const float* sin_phi, const float* cos_phi,
                                         const float* inverse, int rows, Occluders map,
                                         float tolerance, std::uint8_t bit,
                                         std::uint8_t* occluded) {
  const auto width = static_cast<float>(map.width);
  const float per_turn = width / static_cast<float>(kTwoPi);
  const float per_phi = static_cast<float>(map.rows) / static_cast<float>(kPi);
  RAYWALK_INDEPENDENT
  for (int i = 0; i < rows; ++i) {
    const SeenPoint seen = seen_from(sin_phi[i], cos_phi[i], inverse[i], map.to_eye);
    float u = map.column + seen.turn_rad * per_turn;
    u += u < 0.0f ? width : 0.0f;
    u -= u >= width ? width : 0.0f;
    float v = (static_cast<float>(kHalfPi) - seen.phi_rad) * per_phi - 0.5f;
    v = v < 0.0f ? 0.0f : v;
    int x = static_cast<int>(u), y = static_cast<int>(v);
    x = x > map.width - 1 ? map.width - 1 : x;
    y = y > map.rows - 1 ? map.rows - 1 : y;
    const float held = map.nearest[x * map.rows + y];
    const bool nearer = held > inverse[i] / seen.length * (1.0f + tolerance) + map.slack;
    occluded[i] = static_cast<std::uint8_t>(occluded[i] | (nearer ? bit : 0));
  }
}

// The bins of the great circle around A that points are in, and their inverse distance from A.
// `ahead`: 1 of the points down the column, -1 of those up the opposite one.
RAYWALK_VECTOR_CLONES void project_ring(const float* sin_phi, const float* cos_phi,
                                        const float* inverse, int rows, float ahead, float d_p,
                                        float below, std::int32_t* bin, float* from_met) {
  const float per_phi = static_cast<float>(rows) / static_cast<float>(kPi);
  RAYWALK_INDEPENDENT
  for (int i = 0; i < rows; ++i) {
    const float x = ahead * cos_phi[i] - inverse[i] * d_p;
    const float y = sin_phi[i] + inverse[i] * below;
    float at = (static_cast<float>(kHalfPi) - fast_atan2(y, x)) * per_phi;
    at += at < 0.0f ? static_cast<float>(2 * rows) : 0.0f;
    const int row = static_cast<int>(at);
    bin[i] = row > 2 * rows - 1 ? 2 * rows - 1 : row;
    from_met[i] = inverse[i] / (std::sqrt(x * x + y * y) + 1e-30f);
  }
}

// The maps at or before a station and at or after it, as indices; twice the same at the ends.
std::array<int, 2> maps_around(std::span<const int> stations, int station) {
  const auto last = static_cast<int>(stations.size()) - 1;
  const auto after =
      static_cast<int>(std::ranges::lower_bound(stations, station) - stations.begin());
  if (after > last) return {last, last};
  if (stations[static_cast<std::size_t>(after)] == station || after == 0) return {after, after};
  return {after - 1, after};
}

}  // namespace

// The great circle around the point where a column meets a line.
class Visibility::Ring {
 public:
  explicit Ring(int rows)
      : rows_(rows),
        bin_(static_cast<std::size_t>(2 * rows)),
        from_met_(bin_.size()),
        nearest_(bin_.size() + 2) {}

  // Marks what is occluded from A, `d_p` ahead of the eye and `below` it.
  void mark(const DistanceView& distances, int theta, float d_p, float below,
            std::uint8_t* occluded) {
    // From a line in front, what lies behind the eye is farther than anything on this side of it in
    // the same direction: it occludes nothing. That holds at any height of the line, since all
    // between two points ahead of the eye is ahead of it.
    const auto rows = static_cast<std::size_t>(rows_);
    points_ = d_p > 0.0f ? rows : 2 * rows;
    const Latitudes& latitudes = distances.latitudes();
    project_ring(latitudes.sin_phi.data(), latitudes.cos_phi.data(), distances.column(theta), rows_,
                 1.0f, d_p, below, bin_.data(), from_met_.data());
    if (points_ > rows) {
      project_ring(latitudes.sin_phi.data(), latitudes.cos_phi.data(),
                   distances.opposite_column(theta), rows_, -1.0f, d_p, below, bin_.data() + rows_,
                   from_met_.data() + rows_);
      std::reverse(bin_.begin() + rows_, bin_.end());
      std::reverse(from_met_.begin() + rows_, from_met_.end());
    }
    const float tolerance = distances.surface_tolerance();
    keep_nearest(tolerance);
    for (std::size_t i = 0; i < rows; ++i) {
      const float* const around = nearest_.data() + bin_[i];
      const float nearest = std::max({around[0], around[1], around[2]});
      const bool is_occluded = from_met_[i] < nearest * (1.0f - tolerance);
      occluded[i] = static_cast<std::uint8_t>(occluded[i] | (is_occluded ? kOccludedInView : 0));
    }
  }

 private:
  void keep_nearest(float tolerance) {
    std::ranges::fill(nearest_, 0.0f);
    float* const nearest = nearest_.data() + 1;
    std::size_t before = points_ - 1;
    for (std::size_t i = 0; i < points_; before = i++) {
      nearest[bin_[i]] = std::max(nearest[bin_[i]], from_met_[i]);
      if (i == 0 && points_ == static_cast<std::size_t>(rows_)) continue;
      const int step = std::abs(bin_[i] - bin_[before]);
      const float larger = std::max(from_met_[i], from_met_[before]);
      if (step > 1 && std::fabs(from_met_[i] - from_met_[before]) <= tolerance * larger) {
        fill_gap(i, before);
      }
    }
    // A bin beyond each end, so that every bin has neighbours.
    nearest_.front() = nearest[2 * rows_ - 1];
    nearest_.back() = nearest[0];
  }

  // A surface nearer to A than to the eye covers more bins than it has points.
  void fill_gap(std::size_t i, std::size_t before) {
    const int turn = 2 * rows_;
    const float inverse = std::min(from_met_[i], from_met_[before]);
    int step = bin_[i] - bin_[before];
    if (step > rows_) step -= turn;
    if (step < -rows_) step += turn;
    const int towards = step < 0 ? -1 : 1;
    for (int gap = towards; gap != step && std::abs(gap) < rows_; gap += towards) {
      float& kept = nearest_[static_cast<std::size_t>((bin_[before] + gap + turn) % turn) + 1];
      kept = std::max(kept, inverse);
    }
  }

  int rows_;
  std::size_t points_ = 0;  // down the column, and up the opposite one where it matters
  std::vector<std::int32_t> bin_;
  std::vector<float> from_met_;
  std::vector<float> nearest_;  // of each bin, between two more
};

void Visibility::plan(const DistanceView& distances, Columns columns, const Sources& sources,
                      std::span<const int> lines, double above_lines_m, StationMix mix,
                      const FillStations& fill) {
  distances_ = &distances;
  fill_stations_ = &fill;
  columns_ = columns;
  lines_.assign(lines.begin(), lines.end());
  above_lines_m_ = above_lines_m;
  mix_ = mix;
  rows_ = distances.size().height;
  const int width = distances.size().width;
  sources_.resize(static_cast<std::size_t>(width));
  parallel_for(0, columns.count, 16, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) plan_column((columns.first + i) % width, sources);
  });
}

void Visibility::plan_column(int theta, const Sources& sources) {
  Column& column = sources_[static_cast<std::size_t>(theta)];
  column = {.sources = sources(theta_of_column(theta, distances_->size().width))};
  for (std::size_t i = 0; i < column.sources.count; ++i) {
    const RaySource& at = column.sources.source[i].at;
    const auto stations = room_.distances(at.line).stations();
    // The maps around the stations that are mixed, or the nearest of them.
    const int nearest = at.station + (at.fraction < 0.5 ? 0 : 1);
    const int before = stations.empty() ? 0 : maps_around(stations, nearest)[0];
    column.first_map[i] = std::max(before - (kMapsOfSource - 2) / 2, 0);
  }
}

void Visibility::see() {
  std::vector<MapStation> all;
  for (const int line : lines_) {
    for (int map = 0; map < room_.distances(line).maps(); ++map)
      all.push_back({.line = line, .map = map});
  }
  const auto kept = cache_.get(all);
  maps_.assign(room_.grid().lines.size(), {});
  for (std::size_t i = 0; i < all.size(); ++i) {
    maps_[static_cast<std::size_t>(all[i].line)].push_back(kept[i]);
  }
  const int width = distances_->size().width;
  for (auto& image : occluded_) image.resize(first(width));
  fill_.resize(first(width));
  parallel_for(0, columns_.count, 16, [&](int begin, int end) {
    Ring ring(rows_);
    for (int i = begin; i < end; ++i) see_column((columns_.first + i) % width, &ring);
  });
}

void Visibility::see_column(int theta, Ring* ring) {
  Column& column = sources_[static_cast<std::size_t>(theta)];
  std::fill_n(fill_.data() + first(theta), static_cast<std::size_t>(rows_), std::uint8_t{0});
  for (std::size_t i = 0; i < column.sources.count; ++i) {
    const RaySource& at = column.sources.source[i].at;
    if (index_of(column, at.line, at.d_p_m < 0.0) == i) find_occluded(theta, column, i, ring);
  }
  find_fill(theta, &column);
}

Visibility::SourceMaps Visibility::maps_of(int theta, std::size_t source) const {
  const Column& column = sources_[static_cast<std::size_t>(theta)];
  const RaySource& at = column.sources.source[source].at;
  const bool behind = at.d_p_m < 0.0;
  const int of_line = room_.volume(at.line).stations();
  SourceMaps maps{
      .image = index_of(column, at.line, behind),
      .first_map = column.first_map[source],
      .by = occluders(theta, at.line, behind, at.station + (at.fraction < 0.5 ? 0 : 1))};
  for (std::size_t i = 0; i < column.sources.count; ++i) {
    const RaySource& same = column.sources.source[i].at;
    if (index_of(column, same.line, same.d_p_m < 0.0) != maps.image) continue;
    const StationWindow window = stations_mixed(same, of_line, mix_);
    for (int station = window.first; station <= window.last; ++station) {
      const StationOccluders by = occluders(theta, at.line, behind, station);
      maps.wanted |= by.before | by.after;
    }
  }
  return maps;
}

void Visibility::find_occluded(int theta, const Column& column, std::size_t source, Ring* ring) {
  std::uint8_t* const occluded = occluded_[source].data() + first(theta);
  std::fill_n(occluded, rows_, std::uint8_t{0});
  const RaySource& at = column.sources.source[source].at;
  if (at.d_p_m != 0.0 || above_lines_m_ != 0.0) {  // else the line sees what the eye does
    ring->mark(*distances_, theta, static_cast<float>(at.d_p_m), static_cast<float>(above_lines_m_),
               occluded);
  }
  const auto& line = room_.grid().lines[static_cast<std::size_t>(at.line)];
  const auto stations = room_.distances(at.line).stations();
  const std::uint8_t wanted = maps_of(theta, source).wanted;
  const double theta_rad = theta_of_column(theta, distances_->size().width);
  const Eigen::Vector3d eye_m = distances_->eye().position_m(theta_rad);
  const Latitudes& latitudes = distances_->latitudes();
  for (int bit = 0; bit < kMapsOfSource; ++bit) {
    if ((wanted >> bit & 1) == 0) continue;
    const int of_line = column.first_map[source] + bit;
    const auto index = static_cast<std::size_t>(of_line);
    const OccluderMap& map = *maps_[static_cast<std::size_t>(at.line)][index];
    const Eigen::Vector3d to_eye_m =
        eye_m - line.stations[static_cast<std::size_t>(stations[index])].position_m;
    mark_occluded(latitudes.sin_phi.data(), latitudes.cos_phi.data(), distances_->column(theta),
                  rows_,
                  {.nearest = map.nearest.data(),
                   .width = map.size.width,
                   .rows = map.size.height,
                   .to_eye = offset_in_column(to_eye_m, theta_rad),
                   .column = static_cast<float>((theta_rad + kPi) / kTwoPi * map.size.width - 0.5),
                   .slack = static_cast<float>(kClearlyNearerPx * kTwoPi / map.size.width /
                                               std::max(1e-9, to_eye_m.norm()))},
                  distances_->surface_tolerance(), static_cast<std::uint8_t>(1 << bit), occluded);
  }
}

void Visibility::find_fill(int theta, Column* column) {
  const bool any_source = column->sources.count > 0;
  if (!any_source && !columns_.fills_empty) {
    std::fill_n(fill_.data() + first(theta), rows_, kNoStation);
    return;
  }
  const float* const trust = distances_->trust(theta);
  std::array<StationOccluders, kMaxSources> by{};
  std::array<const std::uint8_t*, kMaxSources> bits{};
  for (std::size_t i = 0; i < column->sources.count; ++i) {
    const SourceMaps maps = maps_of(theta, i);
    bits[i] = occluded_[maps.image].data() + first(theta);
    by[i] = maps.by;
  }
  for (int row = 0; row < rows_; ++row) {
    const std::size_t pixel = first(theta) + static_cast<std::size_t>(row);
    bool seen = false;
    for (std::size_t i = 0; i < column->sources.count && !seen; ++i) {
      seen = is_seen(bits[i][row], by[i]);
    }
    if (seen || (any_source && trust != nullptr && trust[row] < 0.5f)) continue;
    const int station = fill_stations_->find(*distances_, point_in(*distances_, theta, row));
    if (station == FillStations::kNone) {
      for (auto& image : occluded_) image[pixel] = 0;
      fill_[pixel] = any_source ? kReadUnseen : kNoStation;
    } else {
      fill_[pixel] = static_cast<std::uint8_t>(station + 1);
      column->any_filled = true;
    }
  }
}

std::size_t Visibility::index_of(const Column& column, int line, bool behind) const {
  std::size_t i = 0;
  while (i < column.sources.count && (column.sources.source[i].at.line != line ||
                                      column.sources.source[i].behind() != behind)) {
    ++i;
  }
  return i;
}

const std::uint8_t* Visibility::occluded(int theta, int line, bool behind) const {
  const Column& column = sources_[static_cast<std::size_t>(theta)];
  const std::size_t i = index_of(column, line, behind);
  return i < column.sources.count ? occluded_[i].data() + first(theta) : nullptr;
}

const std::uint8_t* Visibility::occluded_as(int as, int theta, int line, bool behind) const {
  const int image = image_as(as, theta, line, behind);
  return image < 0 ? nullptr : occluded_[static_cast<std::size_t>(image)].data() + first(theta);
}

int Visibility::image_as(int as, int theta, int line, bool behind) const {
  const Column& other = sources_[static_cast<std::size_t>(as)];
  const Column& column = sources_[static_cast<std::size_t>(theta)];
  const std::size_t i = index_of(column, line, behind), j = index_of(other, line, behind);
  if (i == column.sources.count || j == other.sources.count) return -1;
  return column.first_map[i] == other.first_map[j] ? static_cast<int>(i) : -1;
}

StationOccluders Visibility::occluders(int theta, int line, bool behind, int station) const {
  const Column& column = sources_[static_cast<std::size_t>(theta)];
  const std::size_t i = index_of(column, line, behind);
  const auto stations = room_.distances(line).stations();
  if (stations.empty() || i == column.sources.count) return {};
  const auto bit_of = [&](int map) {
    const int bit = std::clamp(map - column.first_map[i], 0, kMapsOfSource - 1);
    return static_cast<std::uint8_t>(
        1 << std::min(bit, static_cast<int>(stations.size()) - 1 - column.first_map[i]));
  };
  const auto [before, after] = maps_around(stations, station);
  const int from = stations[static_cast<std::size_t>(before)];
  const int to = stations[static_cast<std::size_t>(after)];
  return {.before = bit_of(before),
          .after = bit_of(after),
          .after_part = from == to
                            ? 0.0f
                            : static_cast<float>(station - from) / static_cast<float>(to - from)};
}

}  // namespace raywalk
