// The room used by the benchmarks: 4096x2048, built once from the white room and cached in the
// build tree.
#pragma once

#include <filesystem>
#include <vector>

#include "build_lf/pack/pack_plan.h"
#include "core/geometry/grid.h"
#include "core/room/ray_form.h"

namespace raywalk::bench {

inline constexpr int kBenchWidth = 4096;

// Frames of a subset of the white room's stations, enlarged to 4096x2048, with its distance maps.
// Uses the full scene if it is beside the checkout (../shared/scenes/white-room), else the embedded
// copy. The frames are created on the first call; `out` of the result is empty.
build_lf::PackOptions bench_capture();

// The packed room of bench_capture(); packed on the first call.
std::filesystem::path bench_room();
// The same with its panoramas in another form; repacked on the first call.
std::filesystem::path bench_room(const RayForm& form);

// Viewpoints at the centre of a cell, in its quarters, near a line and near a corner.
std::vector<PlanPoint> viewpoints_in(const Cell& cell);

// Bytes of all files under a directory.
double bytes_under(const std::filesystem::path& directory);

}  // namespace raywalk::bench
