#include "core/view/column_mixing.h"

#include <algorithm>

#include "core/view/work_skipped.h"

namespace raywalk {

ColumnMixing::ColumnMixing(const ViewInputs& view, ColumnDistances& distances,
                           StationPositions& positions, SampleReader& reader)
    : view_(view),
      kernels_(column_kernels()),
      distances_(distances),
      positions_(positions),
      reader_(reader),
      readings_(view, positions, distances.mapping()),
      levels_(3 * static_cast<size_t>(view.output.height) + kSampleLookAhead),
      sum_(4 * static_cast<size_t>(view.output.height)),
      row_weight_(static_cast<size_t>(view.output.height)),
      needed_(static_cast<size_t>(view.distances->size().height)) {
  const PositionArrays positions_of_rows(view.output.height);
  samples_.assign(kMaxSources, {positions_of_rows, positions_of_rows});
}

void ColumnMixing::mix(const ColumnPoints& points, std::span<const RaySource> sources,
                       const ColumnShares& shares, RowRun rows, std::uint8_t* rgb) {
  if (sources.size() == 1) {
    mix_source(points, sources[0], shares.needed, shares.skip_px, rows, rgb);
    return;
  }
  if (mixes_in_registers(sources)) {
    mix_in_registers(points, sources, shares, rows, rgb);
    return;
  }
  if (shares.any_shared) std::ranges::fill(sum_, std::int16_t{0});
  for (size_t i = 0; i < sources.size(); ++i) {
    const auto& weights = shares.weights[i];
    std::ranges::transform(weights, needed_.begin(), [](int weight) { return weight > 0 ? 1 : 0; });
    if (shares.any_shared) {
      add_source(points, sources[i], needed_, shares.skip_px, weights, rows);
    } else {
      mix_source(points, sources[i], needed_, shares.skip_px, rows, rgb);
    }
  }
  if (!shares.any_shared) return;
  const std::uint8_t beyond = rgb[3 * rows.end];
  kernels_.finish(sum_.data() + 4 * rows.begin, rows.end - rows.begin, rgb + 3 * rows.begin);
  rgb[3 * rows.end] = beyond;
}

bool ColumnMixing::mixes_in_registers(std::span<const RaySource> sources) const {
  return !skips_rows(view_) && positions_.rows_per_distance() > 1 &&
         view_.interpolation == Interpolation::kLinear && !reader_.counts_bytes() &&
         std::ranges::all_of(sources, [&](const RaySource& source) {
           return usual_reading(view_, source) == Reading::kBoth &&
                  !reader_.gains().change(source.line, source.station) &&
                  !reader_.gains().change(source.line, source.station + 1);
         });
}

void ColumnMixing::mix_in_registers(const ColumnPoints& points, std::span<const RaySource> sources,
                                    const ColumnShares& shares, RowRun rows, std::uint8_t* rgb) {
  std::array<WeightedPair, kMaxSources> pairs;
  for (size_t i = 0; i < sources.size(); ++i) {
    const RaySource& source = sources[i];
    const auto samples = [&](int next) {
      const int station = source.station + next;
      const StationSamples found = positions_.find(
          points, source.line, station, rows, samples_[i][static_cast<size_t>(next)].positions());
      reader_.tiles().ask(source.line, station, found.positions, rows.end - rows.begin,
                          {.weight = shares.weights[i].data(),
                           .first_row = rows.begin,
                           .rows_per_weight = positions_.rows_per_distance()});
      return found;
    };
    pairs[i] = {samples(0), samples(1), fixed_weight(source.fraction), shares.weights[i].data()};
    const std::int64_t read = rows_with_weight(shares.weights[i], rows);
    count_readings(Reading::kBoth, read);
    reader_.count_found(2 * read);
  }
  const std::uint8_t beyond = rgb[3 * rows.end];
  kernels_.mix_weighted(pairs.data(), static_cast<int>(sources.size()), rows.begin, rows.end,
                        positions_.rows_per_distance(), rgb + 3 * rows.begin);
  rgb[3 * rows.end] = beyond;
}

void ColumnMixing::mix_source(const ColumnPoints& points, const RaySource& source,
                              std::span<const std::uint8_t> needed, double skip_px, RowRun rows,
                              std::uint8_t* rgb) {
  const ColumnPoints snapped = distances_.in_layers(points, source);
  for (const RowPiece& piece : readings_.split(snapped, source, rows, needed, skip_px)) {
    mix_piece(snapped, source, piece, rgb);
  }
}

void ColumnMixing::add_source(const ColumnPoints& points, const RaySource& source,
                              std::span<const std::uint8_t> needed, double skip_px,
                              std::span<const std::int16_t> weights, RowRun rows) {
  const ColumnPoints snapped = distances_.in_layers(points, source);
  for (const RowPiece& piece : readings_.split(snapped, source, rows, needed, skip_px)) {
    add_piece(snapped, source, piece, weights);
  }
}

RowSamples ColumnMixing::samples_of(const ColumnPoints& points, const RaySource& source,
                                    const RowPiece& piece) {
  RowSamples samples{.line = source.line,
                     .share = fixed_weight(source.fraction),
                     .rows = piece.rows.end - piece.rows.begin};
  for (int next = 0; next < 2; ++next) {
    if (!reads(piece.reading, next)) continue;
    const auto i = static_cast<size_t>(samples.count++);
    samples.station[i] = source.station + next;
    samples.at[i] = positions_.find(points, source.line, source.station + next, piece.rows,
                                    samples_[0][static_cast<size_t>(next)].positions());
  }
  return samples;
}

ColumnMixing::StoredRows ColumnMixing::stored_rows(int u, const RaySource& source, RowRun rows) {
  const LineVolume& volume = view_.room.volume(source.line);
  StoredRows stored;
  for (int next = 0; next < 2; ++next) {
    if (!reads(usual_reading(view_, source), next)) continue;
    const std::uint8_t* first = volume.column(source.station + next, u).data() + 3 * rows.begin;
    stored.stations[static_cast<size_t>(stored.count)] = source.station + next;
    stored.columns[static_cast<size_t>(stored.count++)] = first;
    reader_.count_stored(source.line, first, rows.end - rows.begin);
  }
  stored.share = stored.count == 2 ? fixed_weight(source.fraction) : std::int16_t{0};
  if (stored.count == 1) stored.columns[1] = stored.columns[0];
  return stored;
}

void ColumnMixing::mix_piece(const ColumnPoints& points, const RaySource& source,
                             const RowPiece& piece, std::uint8_t* rgb) {
  const RowRun rows = piece.rows;
  count_readings(piece.reading, rows.end - rows.begin);
  if (piece.reading != Reading::kStored) {
    reader_.mix(samples_of(points, source, piece), rgb + 3 * rows.begin);
    return;
  }
  mix_stored(points.u, source, stored_rows(points.u, source, rows), rows, rgb + 3 * rows.begin);
}

void ColumnMixing::mix_stored(int u, const RaySource& source, const StoredRows& stored, RowRun rows,
                              std::uint8_t* rgb) {
  const int count = rows.end - rows.begin;
  const std::int16_t weights[] = {static_cast<std::int16_t>(kWeightOne - stored.share),
                                  stored.share};
  kernels_.mix_columns(stored.columns.data(), weights, 2, 3 * count, rgb);
  reader_.gains().apply_stored(shares_of(source, stored), u, rows.begin, count, rgb);
}

std::array<StationShare, 2> ColumnMixing::shares_of(const RaySource& source,
                                                    const StoredRows& stored) {
  const float second = static_cast<float>(stored.share) / static_cast<float>(kWeightOne);
  return {{{source.line, stored.stations[0], 1.0F - second},
           {source.line, stored.stations[stored.count == 2 ? 1 : 0], second}}};
}

void ColumnMixing::add_piece(const ColumnPoints& points, const RaySource& source,
                             const RowPiece& piece, std::span<const std::int16_t> weights) {
  const RowRun rows = piece.rows;
  std::int64_t readings = 0;
  for (int row = rows.begin; row < rows.end; ++row) {
    const auto i = static_cast<size_t>(row);
    const std::int16_t weight = weights[static_cast<size_t>(distances_.mapping().nearest[i])];
    row_weight_[i] = weight;
    readings += weight != 0;
  }
  count_readings(piece.reading, readings);
  const std::int16_t* weight = row_weight_.data() + rows.begin;
  std::int16_t* sum = sum_.data() + 4 * rows.begin;
  if (piece.reading != Reading::kStored) {
    reader_.accumulate(samples_of(points, source, piece), weight, sum);
    return;
  }
  StoredRows stored = stored_rows(points.u, source, rows);
  if (reader_.gains().change(shares_of(source, stored))) {
    std::uint8_t* const levels = levels_.data() + 3 * rows.begin;
    mix_stored(points.u, source, stored, rows, levels);
    stored.columns = {levels, levels};
  }
  kernels_.accumulate_stored(stored.columns[0], stored.columns[1], stored.share, weight,
                             rows.end - rows.begin, sum);
}

void ColumnMixing::count_readings(Reading reading, std::int64_t readings) {
  work_.readings += readings;
  if (reading == Reading::kStored) {
    work_.uncorrected += readings;
  } else if (view_.stations_mixed == 2 && reading != Reading::kBoth) {
    work_.one_station += readings;
  }
}

std::int64_t ColumnMixing::rows_with_weight(std::span<const std::int16_t> weights,
                                            RowRun rows) const {
  const int per_row = positions_.rows_per_distance();
  std::int64_t count = 0;
  for (int row = rows.begin / per_row; row * per_row < rows.end; ++row) {
    const RowRun covered = common_rows({row * per_row, (row + 1) * per_row}, rows);
    if (weights[static_cast<size_t>(row)] != 0) count += covered.end - covered.begin;
  }
  return count;
}

}  // namespace raywalk
