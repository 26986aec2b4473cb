#include "core/view/column_renderer.h"

#include <algorithm>

#include "core/room/tile_cache.h"

namespace raywalk {

struct ColumnRenderer::Correction {
  Correction(const ViewInputs& view, StationPositions& positions, SampleReader& reader)
      : distances(view),
        fill(view),
        visibility(view, distances, positions, fill),
        weights(view, visibility, positions, distances.mapping()),
        mixing(view, distances, positions, reader),
        hidden(view, distances.mapping(), positions, fill, reader) {}

  ColumnDistances distances;
  FillStations fill;
  SourceVisibility visibility;
  ColumnWeights weights;
  ColumnMixing mixing;
  HiddenPixels hidden;
};

RowRun rows_between_polar_caps(int height, int step) {
  const int cap = step == 2 ? height / 6 : height * 2 / 25;  // cos 60 deg = 1/2, cos 75.6 deg < 1/4
  return {cap, height - cap};
}

ColumnRenderer::ColumnRenderer(const ViewInputs& view)
    : view_(view),
      reader_(view.room, view.interpolation, view.touched, view.gains),
      positions_(view),
      initial_(view, positions_, reader_) {
  if (view.distances != nullptr) {
    correction_ = std::make_unique<Correction>(view, positions_, reader_);
  }
}

ColumnRenderer::~ColumnRenderer() = default;

PixelCounts ColumnRenderer::counts() const {
  PixelCounts counts = counts_;
  counts.stretched += initial_.stretched();
  if (correction_) {
    counts.filled += correction_->hidden.filled();
    counts.stretched += correction_->hidden.stretched();
    counts.work += correction_->mixing.work();
    counts.work.one_side += correction_->weights.one_side();
  }
  counts.work.found = reader_.found();
  counts.work.samples = counts.work.found + reader_.stored();
  return counts;
}

void ColumnRenderer::render(int u, std::span<const RaySource> sources, std::uint8_t* rgb) {
  const TileReading reading;
  counts_.all += view_.output.height;
  unknown_rows_.clear();
  if (sources.empty()) {
    render_unserved(u, rgb);
  } else if (correction_) {
    render_corrected(u, sources, view_.rows, rgb);
  } else {
    unknown_rows_ = initial_.render(u, sources, rgb);
    const RowRun all{0, view_.output.height};
    if (unknown_rows_.size() == 1 && unknown_rows_.front() == all) fill_empty(u, rgb);
  }
}

bool ColumnRenderer::render_sparsely(int u, std::span<const RaySource> sources, int step,
                                     std::uint8_t* rgb) {
  if (sources.empty() || positions_.rows_per_distance() == 1) {
    render(u, sources, rgb);
    return false;
  }
  const TileReading reading;
  counts_.all += view_.output.height;
  unknown_rows_.clear();
  render_corrected(
      u, sources, common_rows(rows_between_polar_caps(view_.output.height, step), view_.rows), rgb);
  return true;
}

void ColumnRenderer::render_corrected(int u, std::span<const RaySource> sources, RowRun rows,
                                      std::uint8_t* rgb) {
  const ColumnPoints& points = correction_->distances.prepare(u);
  const ColumnShares& shares = correction_->weights.weigh(points, sources);
  correction_->mixing.mix(points, sources, shares, rows, rgb);
  if (!shares.any_hidden) return;
  const auto unresolved = correction_->hidden.fill(points, shares.hidden, rgb);
  const auto render_row = [&](int row) {
    correction_->mixing.mix(points, sources, shares, {row, row + 1}, rgb);
  };
  if (correction_->hidden.stretch(points, rows, render_row, rgb)) {
    unknown_rows_.assign(unresolved.begin(), unresolved.end());
  } else {
    fill_empty(u, rgb);
  }
}

void ColumnRenderer::render_unserved(int u, std::uint8_t* rgb) {
  fill_empty(u, rgb);
  if (!correction_) return;
  const ColumnPoints& points = correction_->distances.prepare(u);
  const ColumnShares& shares = correction_->weights.weigh_none();
  const std::int64_t filled = correction_->hidden.filled();
  const auto unresolved = correction_->hidden.fill(points, shares.hidden, rgb);
  counts_.filled -= correction_->hidden.filled() - filled;  // counted as empty
  unknown_rows_.assign(unresolved.begin(), unresolved.end());
}

void ColumnRenderer::fill_empty(int u, std::uint8_t* rgb) {
  counts_.empty += view_.output.height;
  unknown_rows_.assign(1, {0, view_.output.height});
  const int stripe = std::max(1, view_.output.height / 32);
  for (int row = 0; row < view_.output.height; ++row) {
    const bool dark = ((u + row) / stripe) % 2 == 0;
    std::fill_n(rgb + 3 * row, 3, static_cast<std::uint8_t>(dark ? 72 : 88));
  }
}

}  // namespace raywalk
