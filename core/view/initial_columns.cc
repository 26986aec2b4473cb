#include "core/view/initial_columns.h"

#include <algorithm>
#include <cmath>

#include "core/view/source_visibility.h"

namespace raywalk {
namespace {

// One of the stations that a column is mixed from.
struct Share {
  size_t source = 0;  // index of its RaySource
  int next = 0;       // 0: the source's station, 1: the one after it
  double weight = 0.0;
  RowRun rows;  // valid rows of the columns that are read
};

// Removes shares without valid rows and, from the largest weight down, those without valid rows in
// common with the ones before; returns the rows common to the rest.
RowRun drop_disjoint(std::vector<Share>* shares) {
  std::erase_if(*shares, [](const Share& share) { return share.rows.empty(); });
  std::stable_sort(shares->begin(), shares->end(),
                   [](const Share& a, const Share& b) { return a.weight > b.weight; });
  RowRun common;
  std::erase_if(*shares, [&](const Share& share) {
    const RowRun both = common.empty() ? share.rows : common_rows(common, share.rows);
    if (both.empty()) return true;
    common = both;
    return false;
  });
  return common;
}

// The sources of the remaining shares, with weights normalised to a sum of 1.
std::vector<RaySource> sources_of(std::span<const RaySource> sources,
                                  const std::vector<Share>& shares) {
  double total = 0.0;
  for (const Share& share : shares) total += share.weight;
  std::vector<RaySource> left;
  for (size_t i = 0; i < sources.size(); ++i) {
    std::array<double, 2> weight{};
    for (const Share& share : shares) {
      if (share.source == i) weight[static_cast<size_t>(share.next)] = share.weight / total;
    }
    const double both = weight[0] + weight[1];
    if (both <= 0.0) continue;
    left.push_back(sources[i]);
    left.back().weight = both;
    left.back().fraction = weight[1] / both;
  }
  return left;
}

// The output rows whose samples all lie in the given rows of a panorama.
RowRun output_rows(RowRun rows, int captured_height, int height) {
  const auto place = [&](int row) {
    return std::clamp((row + 0.5) * captured_height / height - 0.5, 0.0, captured_height - 1.0);
  };
  RowRun run{0, height};
  while (run.begin < height && std::floor(place(run.begin)) < rows.begin) ++run.begin;
  while (run.end > 0 && std::ceil(place(run.end - 1)) >= rows.end) --run.end;
  return run;
}

}  // namespace

InitialColumns::InitialColumns(const ViewInputs& view, StationPositions& positions,
                               SampleReader& reader)
    : view_(view),
      kernels_(column_kernels()),
      positions_(positions),
      reader_(reader),
      samples_{PositionArrays(view.output.height), PositionArrays(view.output.height)},
      sum_(4 * static_cast<size_t>(view.output.height)),
      row_weight_(static_cast<size_t>(view.output.height)) {}

double InitialColumns::station_share(const RaySource& source, int next) const {
  if (view_.stations_mixed == 1) return reads(usual_reading(view_, source), next) ? 1.0 : 0.0;
  return next == 0 ? 1.0 - source.fraction : source.fraction;
}

void InitialColumns::mix_stored_columns(int u, std::span<const RaySource> sources,
                                        std::uint8_t* rgb) {
  const int rows = view_.rows.end - view_.rows.begin;
  std::uint8_t* const out = rgb + 3 * view_.rows.begin;
  const std::uint8_t* columns[4];
  std::int16_t weights[4];
  std::array<StationShare, 4> shares;
  int count = 0;
  for (const RaySource& source : sources) {
    const LineVolume& volume = view_.room.volume(source.line);
    for (int next = 0; next < 2; ++next) {
      if (!reads(usual_reading(view_, source), next)) continue;
      columns[count] = volume.column(source.station + next, u).data() + 3 * view_.rows.begin;
      reader_.count_stored(source.line, columns[count], rows);
      const double share = source.weight * station_share(source, next);
      shares[static_cast<size_t>(count)] = {source.line, source.station + next,
                                            static_cast<float>(share)};
      weights[count++] = fixed_weight(share);
    }
  }
  if (count == 1) {
    std::copy_n(columns[0], 3 * rows, out);
  } else {
    kernels_.mix_columns(columns, weights, count, 3 * rows, out);
  }
  reader_.gains().apply_stored(std::span(shares).first(static_cast<size_t>(count)), u,
                               view_.rows.begin, rows, out);
}

void InitialColumns::render_cut(int u, std::span<const RaySource> sources, std::uint8_t* rgb) {
  if (view_.output == view_.room.panorama()) {
    mix_stored_columns(u, sources, rgb);
    return;
  }
  const int rows = view_.output.height;
  std::ranges::fill(sum_, std::int16_t{0});
  for (const RaySource& source : sources) {
    RowSamples samples{.line = source.line, .share = fixed_weight(source.fraction), .rows = rows};
    for (int next = 0; next < 2; ++next) {
      if (!reads(usual_reading(view_, source), next)) continue;
      const auto i = static_cast<size_t>(samples.count++);
      samples.station[i] = source.station + next;
      samples.at[i] =
          positions_.find_cut(u, source.line, source.station + next, samples_[i].positions());
    }
    std::ranges::fill(row_weight_, fixed_weight(source.weight));
    reader_.accumulate(samples, row_weight_.data(), sum_.data());
  }
  kernels_.finish(sum_.data(), rows, rgb);
}

RowRun InitialColumns::valid_rows(int u, int line, int station) const {
  const LineVolume& volume = view_.room.volume(line);
  if (view_.output == view_.room.panorama()) return volume.valid_rows(station, u);
  const ColumnTarget target =
      positions_.target_of(angles_from_pixel({double(u), 0.0}, view_.output).theta_rad);
  return common_rows(volume.valid_rows(station, target.u_whole),
                     volume.valid_rows(station, (target.u_whole + 1) % target.width));
}

std::vector<RowRun> InitialColumns::render(int u, std::span<const RaySource> sources,
                                           std::uint8_t* rgb) {
  if (!view_.room.masked()) {
    render_cut(u, sources, rgb);
    return {};
  }
  std::vector<Share> shares;
  for (size_t i = 0; i < sources.size(); ++i) {
    const RaySource& source = sources[i];
    for (int next = 0; next < 2; ++next) {
      const double part = station_share(source, next);
      if (part <= 0.0 || !reads(usual_reading(view_, source), next)) continue;
      shares.push_back(
          {i, next, source.weight * part, valid_rows(u, source.line, source.station + next)});
    }
  }
  const RowRun captured = drop_disjoint(&shares);
  const int rows = view_.output.height;
  const RowRun valid =
      shares.empty() ? RowRun() : output_rows(captured, view_.room.panorama().height, rows);
  if (valid.empty()) return {{0, rows}};
  render_cut(u, sources_of(sources, shares), rgb);
  std::vector<RowRun> masked;
  for (const RowRun& run : {RowRun{0, valid.begin}, RowRun{valid.end, rows}}) {
    if (run.empty()) continue;
    masked.push_back(run);
    stretched_ += run.end - run.begin;
    const int nearest = run.begin == 0 ? valid.begin : valid.end - 1;
    for (int row = run.begin; row < run.end; ++row) {
      std::copy_n(rgb + 3 * nearest, 3, rgb + 3 * row);
    }
  }
  return masked;
}

}  // namespace raywalk
