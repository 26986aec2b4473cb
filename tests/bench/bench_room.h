// What the benchmarks share, above all their room: 4096x2048, built once from the white room and
// cached in the build tree.
#pragma once

#include <filesystem>
#include <string>
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

// Of this process: the number behind "KEY:" in a file of /proc/self.
double number_of_process(const std::string& file, const std::string& key);

// Flushes the files under a directory to the disk.
void flush_to_disk(const std::filesystem::path& directory);
// And drops their pages from the page cache; no process may have them mapped.
void drop_from_cache(const std::filesystem::path& directory);

// The work of `raywalk-bench --check`: runs the benchmarks that have a limit and prints a line for
// each. One that exceeds its limit is measured up to two more times, and the least of its ratios
// counts: what else the machine does makes ratios rather larger than smaller. Throws Error when a
// limit is exceeded.
void check_ratios();

// The work of `raywalk-bench --error-curves`: writes the tables that docs/measured.md shows into an
// existing directory, replacing those of the same names. The output is deterministic. Throws Error
// if a file cannot be written.
void write_model_errors(const std::filesystem::path& directory);

}  // namespace raywalk::bench
