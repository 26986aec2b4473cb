// Columns of initial views: the vertical cut.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/view/column_scratch.h"

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

void ColumnRenderer::mix_stored_columns(int u, std::span<const RaySource> sources,
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
      if (!reads(usual_reading(source), next)) continue;
      columns[count] = volume.column(source.station + next, u).data() + 3 * view_.rows.begin;
      scratch_->reader.count_stored(source.line, columns[count], rows);
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
  scratch_->reader.gains().apply_stored(std::span(shares).first(static_cast<size_t>(count)), u,
                                        view_.rows.begin, rows, out);
}

void ColumnRenderer::render_cut(int u, std::span<const RaySource> sources, std::uint8_t* rgb) {
  const int rows = view_.output.height;
  if (view_.output == view_.room.panorama()) {
    mix_stored_columns(u, sources, rgb);
    return;
  }
  const double theta_rad = angles_from_pixel({double(u), 0.0}, view_.output).theta_rad;
  std::fill(scratch_->sum.begin(), scratch_->sum.end(), std::int16_t{0});
  std::swap(scratch_->omega, scratch_->zero_omega);
  for (const RaySource& source : sources) {
    std::fill(scratch_->row_weight.begin(), scratch_->row_weight.end(),
              fixed_weight(source.weight));
    scratch_->reader.accumulate(samples_of(theta_rad, source, {{0, rows}, usual_reading(source)}),
                                scratch_->row_weight.data(), scratch_->sum.data());
  }
  std::swap(scratch_->omega, scratch_->zero_omega);
  kernels_.finish(scratch_->sum.data(), rows, rgb);
}

RowRun ColumnRenderer::valid_rows_of_cut(int u, int line, int station) const {
  const LineVolume& volume = view_.room.volume(line);
  if (view_.output == view_.room.panorama()) return volume.valid_rows(station, u);
  const ColumnTarget target =
      target_of(angles_from_pixel({double(u), 0.0}, view_.output).theta_rad);
  return common_rows(volume.valid_rows(station, target.u_whole),
                     volume.valid_rows(station, (target.u_whole + 1) % target.width));
}

void ColumnRenderer::render_initial(int u, std::span<const RaySource> sources, std::uint8_t* rgb) {
  if (!view_.room.masked()) {
    render_cut(u, sources, rgb);
    return;
  }
  std::vector<Share> shares;
  for (size_t i = 0; i < sources.size(); ++i) {
    const RaySource& source = sources[i];
    for (int next = 0; next < 2; ++next) {
      const double part = station_share(source, next);
      if (part <= 0.0 || !reads(usual_reading(source), next)) continue;
      shares.push_back({i, next, source.weight * part,
                        valid_rows_of_cut(u, source.line, source.station + next)});
    }
  }
  const RowRun captured = drop_disjoint(&shares);
  const int rows = view_.output.height;
  const RowRun valid =
      shares.empty() ? RowRun() : output_rows(captured, view_.room.panorama().height, rows);
  if (valid.empty()) {
    fill_empty(u, rgb);
    return;
  }
  render_cut(u, sources_of(sources, shares), rgb);
  for (const RowRun& masked : {RowRun{0, valid.begin}, RowRun{valid.end, rows}}) {
    if (!masked.empty()) add_unresolved(masked);
  }
  for (int row = 0; row < rows; ++row) {
    if (row >= valid.begin && row < valid.end) continue;
    const int nearest = row < valid.begin ? valid.begin : valid.end - 1;
    std::copy_n(rgb + 3 * nearest, 3, rgb + 3 * row);
    ++counts_.stretched;
  }
}

}  // namespace raywalk
