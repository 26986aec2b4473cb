// Renders blocks of neighbouring columns of a view; one worker per thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "core/view/column_renderer.h"
#include "core/view/picture_fill.h"
#include "core/view/read_ahead.h"

namespace raywalk {

// 400 kB of pixels at 2048 rows: stays in the second-level cache.
inline constexpr int kColumnsPerTask = 64;

// Column stride in bytes for columns of `height` rgb pixels: an odd number of cache lines. With a
// power of two, the pixels of a row would map to the same few cache sets.
std::size_t spread_column_bytes(int height);

class ColumnWorker {
 public:
  // The lines that output column u is read from.
  using SourcesOf = ReadAhead::SourcesOf;

  // Holds up to kColumnsPerTask columns. `view` must outlive the worker.
  explicit ColumnWorker(const ViewInputs& view);

  // Renders output columns first + [begin, end), wrapping around the seam. In the polar caps some
  // columns are the mean of their neighbours; which ones depends on the arguments only.
  void render(int first, int begin, int end, const SourcesOf& sources_of);

  // The columns of the last render(): rgb, spread_column_bytes() apart.
  const std::uint8_t* columns() const { return columns_.data(); }
  // The rows of each of these columns that no station shows.
  std::span<const UnknownRows> unknown() const { return unknown_; }
  PixelCounts counts() const { return renderer_.counts(); }

 private:
  const ViewInputs& view_;
  std::size_t column_bytes_;
  ReadAhead read_ahead_;
  ColumnRenderer renderer_;
  std::vector<std::uint8_t> columns_;
  std::vector<UnknownRows> unknown_;
};

// A pool of workers: creating their tables and memory costs more than rendering a few columns.
class ColumnWorkers {
 public:
  explicit ColumnWorkers(const ViewInputs& view) : view_(view) {}

  // From any thread.
  std::unique_ptr<ColumnWorker> take();
  void give_back(std::unique_ptr<ColumnWorker> worker);

  // Of all workers given back.
  PixelCounts counts() const;

 private:
  const ViewInputs& view_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<ColumnWorker>> idle_;
};

}  // namespace raywalk
