#include "core/view/column_shares.h"

#include <algorithm>
#include <cmath>

#include "core/view/row_pieces.h"
#include "core/view/work_skipped.h"

namespace raywalk {
namespace {

bool is_behind(const RaySource& source) { return source.d_p_m < 0.0; }

// Weight of a source: inversely proportional to the distance of its line, so that a line through
// the viewpoint is used alone.
double blend_share(std::span<const RaySource> sources, size_t which) {
  double span_m = 0.0;
  for (const RaySource& source : sources) span_m += std::fabs(source.d_p_m);
  const double nearness =
      span_m > 0.0 ? 1.0 / (std::fabs(sources[which].d_p_m) / span_m + 1e-4) : 1.0;
  return sources[which].weight * nearness;
}

}  // namespace

ColumnWeights::ColumnWeights(const ViewInputs& view, SourceVisibility& visibility,
                             StationPositions& positions, const RowMapping& mapping)
    : view_(view),
      kernels_(column_kernels()),
      visibility_(visibility),
      positions_(positions),
      mapping_(mapping),
      most_(static_cast<size_t>(view.distances->size().height)),
      seeing_(most_.size()),
      weight_scale_(most_.size()) {
  for (auto& weights : shares_.weights) weights.resize(most_.size());
  shares_.needed.resize(most_.size());
  shares_.hidden.resize(most_.size());
}

const ColumnShares& ColumnWeights::weigh(const ColumnPoints& points,
                                         std::span<const RaySource> sources) {
  Visible visible;
  find_visible_rows(points, sources, visible);
  if (sources.size() == 1) {
    shares_.needed.assign(visible[0].begin(), visible[0].end());
    find_hidden(visible[0]);
    return shares_;
  }
  std::array<float, kMaxSources> shares{};
  std::array<const std::uint8_t*, kMaxSources> seen{};
  std::array<std::int16_t*, kMaxSources> weights{};
  for (size_t i = 0; i < sources.size(); ++i) {
    shares[i] = static_cast<float>(blend_share(sources, i));
    seen[i] = visible[i].data();
    weights[i] = shares_.weights[i].data();
  }
  kernels_.weigh_rows(seen.data(), shares.data(), static_cast<int>(sources.size()),
                      static_cast<int>(most_.size()), weights.data(), most_.data(), seeing_.data(),
                      weight_scale_.data());
  find_hidden(most_);
  shares_.any_shared =
      !skips_rows(view_) || std::ranges::any_of(seeing_, [](int lines) { return lines > 1; });
  return shares_;
}

const ColumnShares& ColumnWeights::weigh_none() {
  std::ranges::fill(shares_.hidden, kSeen);
  shares_.any_hidden = true;
  return shares_;
}

void ColumnWeights::find_hidden(std::span<const std::uint8_t> seen) {
  std::uint8_t least = kSeen;
  for (size_t row = 0; row < seen.size(); ++row) {
    shares_.hidden[row] = static_cast<std::uint8_t>(kSeen - seen[row]);
    least = std::min(least, seen[row]);
  }
  shares_.any_hidden = least < kSeen;
}

void ColumnWeights::find_visible_rows(const ColumnPoints& points,
                                      std::span<const RaySource> sources, Visible& visible) {
  const auto behind = static_cast<size_t>(std::ranges::count_if(sources, is_behind));
  const bool both_sides = behind > 0 && behind < sources.size();
  shares_.skip_px = both_sides ? 0.5 * view_.skip_px : view_.skip_px;
  const bool where_hidden = both_sides && view_.second_side == SecondSide::kWhereHidden;
  if (where_hidden) {
    read_second_side_where_hidden(points, sources, visible);
    return;
  }
  for (size_t i = 0; i < sources.size(); ++i) {
    visible[i] = visibility_.usable_rows(points, sources[i], i);
  }
  if (both_sides && view_.skip_px > 0.0) skip_second_side(points, sources, visible);
}

void ColumnWeights::read_second_side_where_hidden(const ColumnPoints& points,
                                                  std::span<const RaySource> sources,
                                                  Visible& visible) {
  const auto nearest = std::ranges::min_element(
      sources, {}, [](const RaySource& source) { return std::fabs(source.d_p_m); });
  const auto is_near = [&](const RaySource& source) {
    return is_behind(source) == is_behind(*nearest);
  };
  const size_t rows = shares_.hidden.size();
  std::vector<std::uint8_t>& seen = near_;
  seen.assign(rows, 0);
  for (size_t i = 0; i < sources.size(); ++i) {
    if (!is_near(sources[i])) continue;
    visible[i] = visibility_.usable_rows(points, sources[i], i);
    for (size_t row = 0; row < rows; ++row) seen[row] |= visible[i][row];
  }
  const bool all_seen = !any_is(seen, 0);
  for (size_t i = 0; i < sources.size(); ++i) {
    if (is_near(sources[i])) continue;
    auto& rest = unskipped_[i];
    rest.assign(rows, 0);
    if (!all_seen) {
      const auto usable = visibility_.usable_rows(points, sources[i], i);
      for (size_t row = 0; row < rows; ++row) rest[row] = seen[row] != 0 ? 0 : usable[row];
    }
    visible[i] = rest;
  }
  for (size_t row = 0; row < rows; ++row) {
    if (seen[row] != 0) one_side_ += output_rows_of(row);
  }
}

void ColumnWeights::skip_second_side(const ColumnPoints& points, std::span<const RaySource> sources,
                                     Visible& visible) {
  size_t main = 0;
  for (size_t i = 1; i < sources.size(); ++i) {
    if (blend_share(sources, i) > blend_share(sources, main)) main = i;
  }
  const auto others = std::ranges::count_if(sources, [&](const RaySource& source) {
    return is_behind(source) != is_behind(sources[main]);
  });
  const ColumnOffset from_main = positions_.acquisition_offset(sources[main], points.theta_rad);
  dropped_.assign(shares_.hidden.size(), 0);
  for (size_t i = 0; i < sources.size(); ++i) {
    if (is_behind(sources[i]) == is_behind(sources[main])) continue;
    // The largest share it can have where the main source sees the point too.
    const double share =
        blend_share(sources, i) / (blend_share(sources, i) + blend_share(sources, main));
    const double move_px = shares_.skip_px / (share * static_cast<double>(others));
    near_.assign(shares_.hidden.size(), 1);
    kernels_.keep_near(positions_.depth_latitudes(), points.depth_omega.data(),
                       static_cast<int>(near_.size()), from_main,
                       positions_.acquisition_offset(sources[i], points.theta_rad),
                       move_limit(move_px, view_.room.panorama()), near_.data());
    if (!any_is(near_, 1)) continue;
    keep_with_neighbours(&near_);
    auto& left = unskipped_[i];
    left.assign(visible[i].begin(), visible[i].end());
    for (size_t row = 0; row < near_.size(); ++row) {
      if (!near_[row] || !visible[main][row] || !left[row]) continue;
      left[row] = 0;
      dropped_[row] = 1;
    }
    visible[i] = left;
  }
  if (!any_is(dropped_, 1)) return;
  for (size_t row = 0; row < dropped_.size(); ++row) {
    if (dropped_[row] != 0) one_side_ += output_rows_of(row);
  }
}

int ColumnWeights::output_rows_of(size_t depth_row) const {
  const auto& first_row = mapping_.first_row;
  return first_row[depth_row + 1] - first_row[depth_row];
}

}  // namespace raywalk
