#include "core/view/initial_view.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/room/tile_cache.h"
#include "core/view/column_geometry.h"
#include "core/view/mask_check.h"
#include "core/view/sampler.h"

namespace raywalk {
namespace {

// One of the stations that a column is mixed from.
struct CutRead {
  int line = 0, station = 0;
  float share = 0.0f;
};

constexpr std::size_t kCutReads = 2 * kMaxSources;

// The samples of a station.
struct CutSamples {
  explicit CutSamples(std::size_t rows)
      : left(rows),
        right(rows),
        across(rows),
        u(rows),
        v(rows),
        weight(rows),
        exposure(4 * (rows / kExposureStep + 2)) {}
  std::vector<std::int32_t> left, right, across;
  std::vector<float> u, v, weight;
  std::vector<float> exposure;
};

class Cut {
 public:
  Cut(const InitialView& view, RowRun rows)
      : view_(view),
        rows_(rows),
        count_(static_cast<std::size_t>(rows.end - rows.begin)),
        total_(count_),
        mixed_(3 * count_ + 1),
        stored_(view.output == view.room.panorama() && !view.room.masked() &&
                view.exposure == nullptr),
        samples_(stored_ ? 0 : kCutReads, CutSamples(count_)) {}

  // Renders a column from the stations that it is mixed from; pixels are `stride` bytes apart.
  void render(int u, std::span<const CutRead> reads, std::uint8_t* bgr, int stride,
              std::vector<UnreadRows>* unread) {
    reads_ = reads;
    if (stored_ && !reads_.empty()) {
      mix_stored(u, bgr, stride);
      return;
    }
    mix_samples(u, bgr, stride);
    find_unread(u, unread);
  }

 private:
  void mix_stored(int u, std::uint8_t* bgr, int stride) {
    std::array<WeightedColumn, kCutReads> columns;
    for (std::size_t k = 0; k < reads_.size(); ++k) {
      columns[k] = {
          view_.room.volume(reads_[k].line).column(reads_[k].station, u).data() + 3 * rows_.begin,
          3 * view_.output.height,
          static_cast<std::int16_t>(std::lround(reads_[k].share * kDownOne))};
    }
    mix_columns(std::span(columns).first(reads_.size()), static_cast<int>(3 * count_),
                mixed_.data());
    store_column(mixed_.data(), static_cast<int>(count_), bgr, stride);
  }

  void mix_samples(int u, std::uint8_t* bgr, int stride) {
    const PanoramaSize captured = view_.room.panorama();
    const bool cubic = view_.options.interpolation == Interpolation::kCubic;
    const auto column =
        static_cast<float>((u + 0.5) * captured.width / view_.output.width - 0.5 + captured.width);
    std::array<StationSamples, kCutReads> samples;
    std::ranges::fill(total_, 0.0f);
    for (std::size_t k = 0; k < reads_.size(); ++k) {
      const CutRead& read = reads_[k];
      CutSamples& of = samples_[k];
      for (std::size_t i = 0; i < count_; ++i) {
        of.u[i] = 0.0f;
        of.v[i] = static_cast<float>((static_cast<double>(i) + rows_.begin + 0.5) *
                                         captured.height / view_.output.height -
                                     0.5);
      }
      const SamplePlaces at{of.left.data(), of.right.data(), of.across.data(), nullptr};
      place_samples(of.u.data(), of.v.data(), static_cast<int>(count_), column, captured,
                    of.u.data(), at);
      MaskCheck check(view_.room, read.line, read.station, cubic ? 1 : 0);
      for (std::size_t i = 0; i < count_; ++i) {
        const bool valid =
            !view_.room.volume(read.line).masked() || check.valid(of.left[i], of.right[i]);
        of.weight[i] = valid ? read.share : 0.0f;
        total_[i] += of.weight[i];
      }
      const LineVolume& volume = view_.room.volume(read.line);
      volume.columns(read.station);  // asks a compressed line for them
      samples[k] = {volume.rays(read.station), at,     of.u.data(), of.v.data(),
                    of.weight.data(),          nullptr};
      if (view_.exposure == nullptr || view_.exposure->is_one(read.line, read.station)) continue;
      for (std::size_t node = 0; node <= count_ / kExposureStep + 1; ++node) {
        const std::size_t row = std::min(node * kExposureStep, count_ - 1);
        const cv::Vec4f factors = view_.exposure->at(read.line, read.station, of.u[row], of.v[row]);
        std::copy_n(factors.val, 4, of.exposure.begin() + static_cast<std::ptrdiff_t>(4 * node));
      }
      samples[k].exposure = of.exposure.data();
      samples[k].exposure_step = kExposureStep;
    }
    mix_exact(std::span(samples).first(reads_.size()), cubic, captured, static_cast<int>(count_),
              bgr, stride);
  }

  void find_unread(int u, std::vector<UnreadRows>* unread) const {
    for (std::size_t i = 0; i < count_; ++i) {
      if (total_[i] > 0.0f) continue;
      const int row = rows_.begin + static_cast<int>(i);
      if (!unread->empty() && unread->back().column == u && unread->back().rows.end == row) {
        ++unread->back().rows.end;
      } else {
        unread->push_back({u, {row, row + 1}});
      }
    }
  }

  const InitialView& view_;
  RowRun rows_;
  std::size_t count_;
  std::vector<float> total_;         // weight of what could be read of each row
  std::vector<std::uint8_t> mixed_;  // captured columns
  std::span<const CutRead> reads_;
  bool stored_;  // whether output columns are captured columns
  std::vector<CutSamples> samples_;
};

// The stations of a column.
std::vector<CutRead> reads_of(const ColumnSources& sources) {
  std::vector<CutRead> reads;
  for (std::size_t i = 0; i < sources.count; ++i) {
    const RaySource& at = sources.source[i].at;
    for (const int next : {0, 1}) {
      const auto part = static_cast<float>(next == 0 ? 1.0 - at.fraction : at.fraction);
      if (part > 0.0f)
        reads.push_back({at.line, at.station + next, sources.source[i].share * part});
    }
  }
  return reads;
}

}  // namespace

void render_initial(const InitialView& view, int first, int count, RowRun rows, cv::Mat image,
                    std::vector<UnreadRows>* unread, PixelCounts* counts) {
  constexpr int kRows = 256;  // at once, so that they stay in the cache
  const TileReading reading;
  std::vector<std::vector<CutRead>> reads;
  for (int i = 0; i < count; ++i) {
    const int u = (first + i) % view.output.width;
    reads.push_back(reads_of(view.sources(theta_of_column(u, view.output.width))));
  }
  // A pixel's fourth byte is overwritten by the next column.
  const std::size_t stride = 3 * static_cast<std::size_t>(count) + 1;
  std::vector<std::uint8_t> block(stride * kRows + 4);
  for (RowRun tile{rows.begin, 0}; tile.begin < rows.end; tile.begin = tile.end) {
    tile.end = std::min(tile.begin + kRows, rows.end);
    Cut cut(view, tile);
    for (int i = 0; i < count; ++i) {
      cut.render((first + i) % view.output.width, reads[static_cast<std::size_t>(i)],
                 block.data() + 3 * i, static_cast<int>(stride), unread);
    }
    store_tile({block.data(), stride, 3 * static_cast<std::size_t>(count), tile.end - tile.begin},
               image.ptr(tile.begin - rows.begin), image.step);
  }
  const std::int64_t height = rows.end - rows.begin;
  counts->all += count * height;
  for (const auto& of_column : reads) counts->empty += of_column.empty() ? height : 0;
}

}  // namespace raywalk
