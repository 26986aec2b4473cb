// The room the benchmarks measure on: 4096x2048, made once from the white room and kept in the
// build tree.
#pragma once

#include <filesystem>
#include <vector>

#include "build_lf/pack_plan.h"
#include "core/geometry/grid.h"

namespace raywalk::bench {

inline constexpr int kBenchWidth = 4096;

// Frames of every few stations of the white room, enlarged to 4096x2048, with its distance maps as
// given. The full scene is used where it lies beside the checkout (../shared/scenes/white-room),
// the embedded copy elsewhere. The frames are made on the first call; `out` of the result is empty.
build_lf::PackOptions bench_capture();

// The packed room of bench_capture(); packed on the first call.
std::filesystem::path bench_room();

// Viewpoints in the middle of a cell, in its quarters, near a line and near a corner.
std::vector<PlanPoint> viewpoints_in(const Cell& cell);

// Bytes of all files under a directory.
double bytes_under(const std::filesystem::path& directory);

}  // namespace raywalk::bench
