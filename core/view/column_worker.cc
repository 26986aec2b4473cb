#include "core/view/column_worker.h"

#include <algorithm>
#include <functional>
#include <utility>

namespace raywalk {
namespace {

// A column whose polar caps are the mean of the columns `step` / 2 to both sides.
struct SparseColumn {
  int column = 0;
  int step = 0;
};

// Fills the polar caps of an rgb column with the mean of the columns step / 2 to its left and
// right.
void fill_polar_caps(const std::uint8_t* left, const std::uint8_t* right, int height, int step,
                     std::uint8_t* rgb) {
  const auto mean = [&](int begin, int end) {
    for (int i = 3 * begin; i < 3 * end; ++i) {
      rgb[i] = static_cast<std::uint8_t>((left[i] + right[i] + 1) / 2);
    }
  };
  const RowRun between = rows_between_polar_caps(height, step);
  mean(0, between.begin);
  mean(between.end, height);
}

}  // namespace

std::size_t spread_column_bytes(int height) {
  return ((3 * static_cast<std::size_t>(height) / 64 + 1) | 1) * 64;
}

ColumnWorker::ColumnWorker(const ViewInputs& view)
    : view_(view),
      column_bytes_(spread_column_bytes(view.output.height)),
      read_ahead_(view),
      renderer_(view),
      columns_(column_bytes_ * kColumnsPerTask) {}

void ColumnWorker::render(int first, int begin, int end, const SourcesOf& sources_of) {
  read_ahead_.fetch(first + begin, end - begin, sources_of);
  const auto column_of = [&](int i) {
    return columns_.data() + column_bytes_ * static_cast<std::size_t>(i - begin);
  };
  const auto step_of = [&](int i) {
    const int step = i % 2 != 0 ? 2 : (i % 4 != 0 ? 4 : 1);
    return i - step / 2 >= begin && i + step / 2 < end ? step : 1;
  };
  std::vector<SparseColumn> sparse;
  unknown_.resize(static_cast<std::size_t>(end - begin));
  const auto unknown_of = [&](int i) -> UnknownRows& {
    return unknown_[static_cast<std::size_t>(i - begin)];
  };
  for (int i = begin; i < end; ++i) {
    const int u = (first + i) % view_.output.width;
    const auto sources = sources_of(u);
    const int step = step_of(i);
    if (step == 1) {
      renderer_.render(u, sources, column_of(i));
    } else if (renderer_.render_sparsely(u, sources, step, column_of(i))) {
      sparse.push_back({i, step});
    }
    const auto unknown = renderer_.unknown_rows();
    unknown_of(i).assign(unknown.begin(), unknown.end());
  }
  // Larger steps first: the others are means of these columns.
  std::ranges::stable_sort(sparse, std::greater(), &SparseColumn::step);
  for (const auto& [i, step] : sparse) {
    fill_polar_caps(column_of(i - step / 2), column_of(i + step / 2), view_.output.height, step,
                    column_of(i));
    // What is a mean of unknown pixels is not known either.
    for (const int beside : {i - step / 2, i + step / 2}) {
      for (const RowRun& rows : unknown_of(beside)) unknown_of(i).push_back(rows);
    }
  }
}

std::unique_ptr<ColumnWorker> ColumnWorkers::take() {
  {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      auto worker = std::move(idle_.back());
      idle_.pop_back();
      return worker;
    }
  }
  return std::make_unique<ColumnWorker>(view_);
}

void ColumnWorkers::give_back(std::unique_ptr<ColumnWorker> worker) {
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(worker));
}

PixelCounts ColumnWorkers::counts() const {
  PixelCounts total;
  for (const auto& worker : idle_) total += worker->counts();
  return total;
}

}  // namespace raywalk
