#include "core/view/sample_reader.h"

#include <algorithm>
#include <cmath>

#include "core/view/sample_check.h"

namespace raywalk {
namespace {

// The samples of rows from `begin` on.
StationSamples from_row(StationSamples samples, int begin) {
  samples.positions = rows_from(samples.positions, begin);
  return samples;
}

// Marks the pixels of a linear sample: two rows of the two columns around it.
void touch_linear(TouchedRays* touched, int line, const StationSamples& samples, int row) {
  touched->mark(line, samples.rays + samples.positions.offset_left[row], 6);
  touched->mark(line, samples.rays + samples.positions.offset_right[row], 6);
}

// Of a cubic one, which has a pixel more on every side.
void touch_cubic(TouchedRays* touched, int line, const StationSamples& samples, int row,
                 PanoramaSize size) {
  const int column_bytes = 3 * size.height;
  const std::int32_t left = samples.positions.offset_left[row];
  const std::int32_t right = samples.positions.offset_right[row];
  const int upper = left % column_bytes / 3;
  const int first_row = std::max(upper - 1, 0);
  const int last_row = std::min(upper + 2, size.height - 1);
  const auto touch_column = [&](int column) {
    const int around_seam = (column + size.width) % size.width;
    touched->mark(line, samples.rays + around_seam * column_bytes + 3 * first_row,
                  3 * static_cast<std::size_t>(last_row - first_row + 1));
  };
  for (const int step : {0, 1}) {
    touch_column(left / column_bytes - step);
    touch_column(right / column_bytes + step);
  }
}

void touch_nearest(TouchedRays* touched, int line, const StationSamples& samples, int row) {
  const SamplePositions& at = samples.positions;
  constexpr int kHalf = 16384;
  const std::int32_t column =
      weight_of(at.weight_right[row]) >= kHalf ? at.offset_right[row] : at.offset_left[row];
  const int lower = weight_of(at.weight_lower[row]) >= kHalf ? 3 : 0;
  touched->mark(line, samples.rays + column + lower, 3);
}

}  // namespace

const SampleReaders& readers_of(Interpolation interpolation) {
  switch (interpolation) {
    case Interpolation::kNearest:
      return column_kernels().nearest;
    case Interpolation::kCubic:
      return column_kernels().cubic;
    case Interpolation::kLinear:
      break;
  }
  return column_kernels().linear;
}

std::int16_t fixed_weight(double weight) {
  return static_cast<std::int16_t>(std::lround(std::clamp(weight, 0.0, 1.0) * kWeightOne));
}

SampleReader::SampleReader(const Room& room, Interpolation interpolation, TouchedRays* touched,
                           const RoomGains* gains)
    : room_(room),
      interpolation_(interpolation),
      readers_(readers_of(interpolation)),
      linear_(column_kernels().linear),
      tiles_(room, interpolation),
      gains_(gains),
      touched_(touched) {}

template <typename Read>
void SampleReader::in_runs(const RowSamples& samples, Read read) {
  const LineVolume& volume = room_.volume(samples.line);
  if (interpolation_ != Interpolation::kCubic || !volume.masked()) {
    read(readers_, 0, samples.rows);
    return;
  }
  SampleCheck checks[] = {{volume, samples.station[0]},
                          {volume, samples.station[static_cast<size_t>(samples.count - 1)]}};
  const auto all_valid = [&](int row) {
    for (int i = 0; i < samples.count; ++i) {
      const SamplePositions& at = samples.at[static_cast<size_t>(i)].positions;
      if (!checks[i].valid_around(at.offset_left[row], at.offset_right[row])) return false;
    }
    return true;
  };
  for (int begin = 0; begin < samples.rows;) {
    const bool valid = all_valid(begin);
    int end = begin + 1;
    while (end < samples.rows && all_valid(end) == valid) ++end;
    read(valid ? readers_ : linear_, begin, end);
    begin = end;
  }
}

void SampleReader::ask_for_tiles(const RowSamples& samples) {
  for (int i = 0; i < samples.count; ++i) {
    const auto station = static_cast<size_t>(i);
    tiles_.ask(samples.line, samples.station[station], samples.at[station].positions, samples.rows);
  }
}

void SampleReader::mix(const RowSamples& samples, std::uint8_t* rgb) {
  ask_for_tiles(samples);
  count(samples, nullptr);
  mix_levels(samples, rgb);
  gains_.apply(samples, rgb);
}

void SampleReader::mix_levels(const RowSamples& samples, std::uint8_t* rgb) {
  std::uint8_t* const end_of_rows = rgb + 3 * samples.rows;
  const std::uint8_t beyond = *end_of_rows;
  in_runs(samples, [&](const SampleReaders& readers, int begin, int end) {
    const StationSamples first = from_row(samples.at[0], begin);
    if (samples.count == 1) {
      readers.sample_each(first, end - begin, rgb + 3 * begin);
    } else {
      readers.mix_pair(first, from_row(samples.at[1], begin), samples.share, end - begin,
                       rgb + 3 * begin);
    }
  });
  *end_of_rows = beyond;
}

void SampleReader::accumulate(const RowSamples& samples, const std::int16_t* weight,
                              std::int16_t* sum) {
  ask_for_tiles(samples);
  count(samples, weight);
  if (gains_.change(samples)) {
    levels_.resize(3 * static_cast<std::size_t>(samples.rows) + kSampleLookAhead);
    mix_levels(samples, levels_.data());
    gains_.apply(samples, levels_.data());
    column_kernels().accumulate_stored(levels_.data(), levels_.data(), 0, weight, samples.rows,
                                       sum);
    return;
  }
  in_runs(samples, [&](const SampleReaders& readers, int begin, int end) {
    const StationSamples first = from_row(samples.at[0], begin);
    if (samples.count == 1) {
      readers.accumulate_each(first, weight + begin, end - begin, sum + 4 * begin);
    } else {
      readers.accumulate_pair(first, from_row(samples.at[1], begin), samples.share, weight + begin,
                              end - begin, sum + 4 * begin);
    }
  });
}

void SampleReader::count_stored(int line, const std::uint8_t* first_row, int rows) {
  stored_ += rows;
  if (touched_ != nullptr && rows > 0) {
    touched_->mark(line, first_row, 3 * static_cast<std::size_t>(rows));
  }
}

void SampleReader::count(const RowSamples& samples, const std::int16_t* weight) {
  const auto read = weight == nullptr
                        ? samples.rows
                        : samples.rows - std::count(weight, weight + samples.rows, std::int16_t{0});
  found_ += samples.count * static_cast<std::int64_t>(read);
  if (touched_ == nullptr) return;
  in_runs(samples, [&](const SampleReaders& readers, int begin, int end) {
    touch(samples, &readers == &readers_ ? interpolation_ : Interpolation::kLinear, begin, end,
          weight);
  });
}

void SampleReader::touch(const RowSamples& samples, Interpolation interpolation, int begin, int end,
                         const std::int16_t* weight) {
  for (int i = 0; i < samples.count; ++i) {
    const StationSamples& at = samples.at[static_cast<size_t>(i)];
    for (int row = begin; row < end; ++row) {
      if (weight != nullptr && weight[row] == 0) continue;
      if (interpolation == Interpolation::kNearest) {
        touch_nearest(touched_, samples.line, at, row);
      } else if (interpolation == Interpolation::kCubic) {
        touch_cubic(touched_, samples.line, at, row, room_.panorama());
      } else {
        touch_linear(touched_, samples.line, at, row);
      }
    }
  }
}

}  // namespace raywalk
