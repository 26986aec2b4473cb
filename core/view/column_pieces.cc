// Selects which rows of a column are read, from which of a line's stations, and at which positions.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/view/column_scratch.h"
#include "core/view/work_skipped.h"

namespace raywalk {
namespace {

Reading nearer_station(const RaySource& source) {
  return source.fraction < 0.5 ? Reading::kFirst : Reading::kSecond;
}

bool is_behind(const RaySource& source) { return source.d_p_m < 0.0; }

bool any_is(std::span<const std::uint8_t> rows, std::uint8_t value) {
  return std::memchr(rows.data(), value, rows.size()) != nullptr;
}

// Erodes every run of 1s by a row on both sides, except at the poles.
void keep_with_neighbours(std::vector<std::uint8_t>* rows) {
  std::uint8_t before = 1;
  for (size_t row = 0; row < rows->size(); ++row) {
    const std::uint8_t here = (*rows)[row];
    const bool after = row + 1 == rows->size() || (*rows)[row + 1] != 0;
    (*rows)[row] = here && before && after;
    before = here;
  }
}

}  // namespace

bool ColumnRenderer::skips_rows() const {
  return view_.skip_px > 0.0 || view_.second_side == SecondSide::kWhereHidden;
}

Reading ColumnRenderer::usual_reading(const RaySource& source) const {
  const double share = std::min(source.fraction, 1.0 - source.fraction);
  const bool without_share = view_.skip_px > 0.0 && fixed_weight(share) == 0;
  if (view_.stations_mixed == 2 && !without_share) return Reading::kBoth;
  return nearer_station(source);
}

double ColumnRenderer::station_share(const RaySource& source, int next) const {
  if (view_.stations_mixed == 1) return reads(usual_reading(source), next) ? 1.0 : 0.0;
  return next == 0 ? 1.0 - source.fraction : source.fraction;
}

std::span<const RowPiece> ColumnRenderer::split_rows(int u, double theta_rad,
                                                     const RaySource& source, RowRun rows) {
  auto& pieces = scratch_->pieces;
  pieces.clear();
  if (!skips_rows()) {
    pieces.push_back({rows, usual_reading(source)});
    return pieces;
  }
  choose_readings(u, theta_rad, source);
  const auto& readings = scratch_->readings;
  const int per_row = scratch_->rows_per_distance;
  for (size_t begin = 0; begin < readings.size();) {
    size_t end = begin + 1;
    while (end < readings.size() && readings[end] == readings[begin]) ++end;
    const RowRun run =
        common_rows({static_cast<int>(begin) * per_row, static_cast<int>(end) * per_row}, rows);
    if (readings[begin] != Reading::kNothing && !run.empty()) {
      pieces.push_back({run, readings[begin]});
    }
    begin = end;
  }
  return pieces;
}

void ColumnRenderer::choose_readings(int u, double theta_rad, const RaySource& source) {
  const bool at_distances = scratch_->rows_per_distance > 1;
  auto& readings = scratch_->readings;
  readings.assign(at_distances ? scratch_->depth_omega.size() : scratch_->omega.size(),
                  usual_reading(source));
  if (view_.skip_px > 0.0) {
    skip_second_station(theta_rad, source);
    skip_correction(u, theta_rad, source);
  }
  const auto& needed = scratch_->needed;
  const auto& first_row = scratch_->mapping->first_row;
  for (auto row = std::ranges::find(needed, 0); row != needed.end();
       row = std::find(row + 1, needed.end(), 0)) {
    const auto depth_row = static_cast<size_t>(row - needed.begin());
    const auto begin = at_distances ? depth_row : static_cast<size_t>(first_row[depth_row]);
    const auto end = at_distances ? depth_row + 1 : static_cast<size_t>(first_row[depth_row + 1]);
    std::fill(readings.begin() + static_cast<std::ptrdiff_t>(begin),
              readings.begin() + static_cast<std::ptrdiff_t>(end), Reading::kNothing);
  }
}

void ColumnRenderer::skip_second_station(double theta_rad, const RaySource& source) {
  if (usual_reading(source) != Reading::kBoth) return;
  const double share = std::min(source.fraction, 1.0 - source.fraction);
  scratch_->near.assign(scratch_->readings.size(), 1);
  keep_near(offset_from(source.line, source.station, theta_rad),
            offset_from(source.line, source.station + 1, theta_rad), scratch_->skip_px / share);
  read_near_rows(nearer_station(source));
}

void ColumnRenderer::skip_correction(int u, double theta_rad, const RaySource& source) {
  // Stored columns can be mixed only where output columns coincide with captured columns.
  if (view_.output != view_.room.panorama()) return;
  scratch_->near.assign(scratch_->readings.size(), 1);
  RowRun valid{0, view_.output.height};
  for (int next = 0; next < 2; ++next) {
    if (!reads(usual_reading(source), next)) continue;
    const int station = source.station + next;
    keep_near({}, offset_from(source.line, station, theta_rad), scratch_->skip_px);
    valid = common_rows(valid, view_.room.volume(source.line).valid_rows(station, u));
  }
  const int per_row = scratch_->rows_per_distance;
  const bool all_valid = valid == RowRun{0, view_.output.height};
  for (size_t row = 0; row < scratch_->near.size() && !all_valid; ++row) {
    const int first = static_cast<int>(row) * per_row;
    if (first < valid.begin || first + per_row > valid.end) scratch_->near[row] = 0;
  }
  read_near_rows(Reading::kStored);
}

void ColumnRenderer::keep_near(ColumnOffset a, ColumnOffset b, double move_px) {
  const MoveLimit limit = move_limit(move_px, view_.room.panorama());
  const auto rows = static_cast<int>(scratch_->near.size());
  if (scratch_->rows_per_distance > 1) {
    kernels_.keep_near(scratch_->depth_latitudes->table(), scratch_->depth_omega.data(), rows, a, b,
                       limit, scratch_->near.data());
  } else {
    kernels_.keep_near(scratch_->latitudes.table(), scratch_->omega.data(), rows, a, b, limit,
                       scratch_->near.data());
  }
}

void ColumnRenderer::read_near_rows(Reading reading) {
  auto& near = scratch_->near;
  if (!any_is(near, 1)) return;
  if (scratch_->rows_per_distance > 1) keep_with_neighbours(&near);
  // Branchless, so that the compiler vectorises it.
  std::ranges::transform(
      scratch_->readings, near, scratch_->readings.begin(),
      [=](Reading read, std::uint8_t is_near) { return is_near != 0 ? reading : read; });
}

StationSamples ColumnRenderer::find_run(double theta_rad, const RaySource& source, int next,
                                        RowRun rows) {
  return find_run(theta_rad, source.line, source.station + next, rows,
                  scratch_->samples[next].positions());
}

StationSamples ColumnRenderer::find_run(double theta_rad, int line, int station, RowRun rows,
                                        SamplePositions positions) {
  const int per_row = scratch_->rows_per_distance;
  if (per_row == 1) {
    return find_samples(theta_rad, line, station, rows.begin, rows.end - rows.begin, positions);
  }
  // A row's position is interpolated between those of the distances' rows around it.
  const int depth_rows = view_.distances->size().height;
  const auto row_above = [&](int row) { return std::max(row - per_row / 2, 0) / per_row; };
  const int first = row_above(rows.begin);
  const int count = std::min(row_above(rows.end - 1) + 2, depth_rows) - first;
  const ColumnTarget target = target_of(theta_rad);
  kernels_.find_shifts(scratch_->depth_latitudes->table(first),
                       scratch_->depth_omega.data() + first, first, count, depth_rows,
                       offset_from(line, station, theta_rad), target, scratch_->shift_u.data(),
                       scratch_->shift_v.data());
  kernels_.add_jumps(scratch_->shift_u.data(), scratch_->shift_v.data(), count - 1, target,
                     scratch_->edges.data() + first, scratch_->no_between.data());
  const ShiftedRows shifted{.u = scratch_->shift_u.data(),
                            .v = scratch_->shift_v.data(),
                            .no_between = scratch_->no_between.data(),
                            .first = first,
                            .rows = depth_rows,
                            .per_row = per_row};
  kernels_.place_shifted(shifted, rows.begin, rows.end, target, positions);
  return samples_at(line, station, positions);
}

RowSamples ColumnRenderer::samples_of(double theta_rad, const RaySource& source,
                                      const RowPiece& piece) {
  RowSamples samples{.line = source.line,
                     .share = fixed_weight(source.fraction),
                     .rows = piece.rows.end - piece.rows.begin};
  for (int next = 0; next < 2; ++next) {
    if (!reads(piece.reading, next)) continue;
    const auto i = static_cast<size_t>(samples.count++);
    samples.station[i] = source.station + next;
    samples.at[i] = find_run(theta_rad, source, next, piece.rows);
  }
  return samples;
}

ColumnRenderer::StoredRows ColumnRenderer::stored_rows(int u, const RaySource& source,
                                                       RowRun rows) {
  const LineVolume& volume = view_.room.volume(source.line);
  StoredRows stored;
  for (int next = 0; next < 2; ++next) {
    if (!reads(usual_reading(source), next)) continue;
    const std::uint8_t* first = volume.column(source.station + next, u).data() + 3 * rows.begin;
    stored.stations[static_cast<size_t>(stored.count)] = source.station + next;
    stored.columns[static_cast<size_t>(stored.count++)] = first;
    scratch_->reader.count_stored(source.line, first, rows.end - rows.begin);
  }
  stored.share = stored.count == 2 ? fixed_weight(source.fraction) : std::int16_t{0};
  if (stored.count == 1) stored.columns[1] = stored.columns[0];
  return stored;
}

void ColumnRenderer::mix_piece(int u, double theta_rad, const RaySource& source,
                               const RowPiece& piece, std::uint8_t* rgb) {
  const RowRun rows = piece.rows;
  count_readings(piece.reading, rows.end - rows.begin);
  if (piece.reading != Reading::kStored) {
    scratch_->reader.mix(samples_of(theta_rad, source, piece), rgb + 3 * rows.begin);
    return;
  }
  mix_stored(u, source, stored_rows(u, source, rows), rows, rgb + 3 * rows.begin);
}

void ColumnRenderer::mix_stored(int u, const RaySource& source, const StoredRows& stored,
                                RowRun rows, std::uint8_t* rgb) {
  const int count = rows.end - rows.begin;
  const std::int16_t weights[] = {static_cast<std::int16_t>(kWeightOne - stored.share),
                                  stored.share};
  kernels_.mix_columns(stored.columns.data(), weights, 2, 3 * count, rgb);
  scratch_->reader.gains().apply_stored(shares_of(source, stored), u, rows.begin, count, rgb);
}

std::array<StationShare, 2> ColumnRenderer::shares_of(const RaySource& source,
                                                      const StoredRows& stored) {
  const float second = static_cast<float>(stored.share) / static_cast<float>(kWeightOne);
  return {{{source.line, stored.stations[0], 1.0F - second},
           {source.line, stored.stations[stored.count == 2 ? 1 : 0], second}}};
}

void ColumnRenderer::add_piece(int u, double theta_rad, const RaySource& source,
                               const RowPiece& piece, std::span<const std::int16_t> weights) {
  const RowRun rows = piece.rows;
  std::int64_t readings = 0;
  for (int row = rows.begin; row < rows.end; ++row) {
    const auto i = static_cast<size_t>(row);
    const std::int16_t weight = weights[static_cast<size_t>(scratch_->mapping->nearest[i])];
    scratch_->row_weight[i] = weight;
    readings += weight != 0;
  }
  count_readings(piece.reading, readings);
  const std::int16_t* weight = scratch_->row_weight.data() + rows.begin;
  std::int16_t* sum = scratch_->sum.data() + 4 * rows.begin;
  if (piece.reading != Reading::kStored) {
    scratch_->reader.accumulate(samples_of(theta_rad, source, piece), weight, sum);
    return;
  }
  StoredRows stored = stored_rows(u, source, rows);
  if (scratch_->reader.gains().change(shares_of(source, stored))) {
    std::uint8_t* const levels = scratch_->levels.data() + 3 * rows.begin;
    mix_stored(u, source, stored, rows, levels);
    stored.columns = {levels, levels};
  }
  kernels_.accumulate_stored(stored.columns[0], stored.columns[1], stored.share, weight,
                             rows.end - rows.begin, sum);
}

void ColumnRenderer::count_readings(Reading reading, std::int64_t readings) {
  WorkCounts& work = counts_.work;
  work.readings += readings;
  if (reading == Reading::kStored) {
    work.uncorrected += readings;
  } else if (view_.stations_mixed == 2 && reading != Reading::kBoth) {
    work.one_station += readings;
  }
}

void ColumnRenderer::find_visible_rows(double theta_rad, int depth_theta,
                                       std::span<const RaySource> sources,
                                       std::span<std::span<const std::uint8_t>> visible) {
  const auto behind = static_cast<size_t>(std::ranges::count_if(sources, is_behind));
  const bool both_sides = behind > 0 && behind < sources.size();
  scratch_->skip_px = both_sides ? 0.5 * view_.skip_px : view_.skip_px;
  const bool where_hidden = both_sides && view_.second_side == SecondSide::kWhereHidden;
  if (where_hidden) {
    read_second_side_where_hidden(theta_rad, depth_theta, sources, visible);
    return;
  }
  for (size_t i = 0; i < sources.size(); ++i) {
    visible[i] = usable_rows(theta_rad, depth_theta, sources[i], i);
  }
  if (both_sides && view_.skip_px > 0.0) skip_second_side(theta_rad, sources, visible);
}

void ColumnRenderer::read_second_side_where_hidden(
    double theta_rad, int depth_theta, std::span<const RaySource> sources,
    std::span<std::span<const std::uint8_t>> visible) {
  const auto nearest = std::ranges::min_element(
      sources, {}, [](const RaySource& source) { return std::fabs(source.d_p_m); });
  const auto is_near = [&](const RaySource& source) {
    return is_behind(source) == is_behind(*nearest);
  };
  const size_t rows = scratch_->hidden.size();
  auto& seen = scratch_->near;
  seen.assign(rows, 0);
  for (size_t i = 0; i < sources.size(); ++i) {
    if (!is_near(sources[i])) continue;
    visible[i] = usable_rows(theta_rad, depth_theta, sources[i], i);
    for (size_t row = 0; row < rows; ++row) seen[row] |= visible[i][row];
  }
  const bool all_seen = !any_is(seen, 0);
  for (size_t i = 0; i < sources.size(); ++i) {
    if (is_near(sources[i])) continue;
    auto& rest = scratch_->unskipped[i];
    rest.assign(rows, 0);
    if (!all_seen) {
      const auto usable = usable_rows(theta_rad, depth_theta, sources[i], i);
      for (size_t row = 0; row < rows; ++row) rest[row] = seen[row] != 0 ? 0 : usable[row];
    }
    visible[i] = rest;
  }
  for (size_t row = 0; row < rows; ++row) {
    if (seen[row] != 0) counts_.work.one_side += output_rows_of(row);
  }
}

void ColumnRenderer::skip_second_side(double theta_rad, std::span<const RaySource> sources,
                                      std::span<std::span<const std::uint8_t>> visible) {
  size_t main = 0;
  for (size_t i = 1; i < sources.size(); ++i) {
    if (blend_share(sources, i) > blend_share(sources, main)) main = i;
  }
  const auto others = std::ranges::count_if(sources, [&](const RaySource& source) {
    return is_behind(source) != is_behind(sources[main]);
  });
  const ColumnOffset from_main = acquisition_offset(sources[main], theta_rad);
  auto& near = scratch_->near;
  auto& dropped = scratch_->dropped;
  dropped.assign(scratch_->hidden.size(), 0);
  for (size_t i = 0; i < sources.size(); ++i) {
    if (is_behind(sources[i]) == is_behind(sources[main])) continue;
    // The largest share it can have where the main source sees the point too.
    const double share =
        blend_share(sources, i) / (blend_share(sources, i) + blend_share(sources, main));
    const double move_px = scratch_->skip_px / (share * static_cast<double>(others));
    near.assign(scratch_->hidden.size(), 1);
    kernels_.keep_near(scratch_->depth_latitudes->table(), scratch_->depth_omega.data(),
                       static_cast<int>(near.size()), from_main,
                       acquisition_offset(sources[i], theta_rad),
                       move_limit(move_px, view_.room.panorama()), near.data());
    if (!any_is(near, 1)) continue;
    keep_with_neighbours(&near);
    auto& left = scratch_->unskipped[i];
    left.assign(visible[i].begin(), visible[i].end());
    for (size_t row = 0; row < near.size(); ++row) {
      if (!near[row] || !visible[main][row] || !left[row]) continue;
      left[row] = 0;
      dropped[row] = 1;
    }
    visible[i] = left;
  }
  if (!any_is(dropped, 1)) return;
  for (size_t row = 0; row < dropped.size(); ++row) {
    if (dropped[row] != 0) counts_.work.one_side += output_rows_of(row);
  }
}

ColumnOffset ColumnRenderer::acquisition_offset(const RaySource& source, double theta_rad) const {
  const ColumnOffset a = offset_from(source.line, source.station, theta_rad);
  const ColumnOffset b = offset_from(source.line, source.station + 1, theta_rad);
  const auto between = [&](float from, float to) {
    return from + (to - from) * static_cast<float>(source.fraction);
  };
  return {between(a.forward, b.forward), between(a.up, b.up), between(a.side, b.side)};
}

int ColumnRenderer::output_rows_of(size_t depth_row) const {
  const auto& first_row = scratch_->mapping->first_row;
  return first_row[depth_row + 1] - first_row[depth_row];
}

}  // namespace raywalk
