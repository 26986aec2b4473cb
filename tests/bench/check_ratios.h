// The work of `raywalk-bench --check`: runs benchmarks and compares their ratios with limits.
#pragma once

#include <filesystem>
#include <string>

namespace raywalk::bench {

// Runs the benchmarks that the file limits (ratio_limits.h) and prints a line for each. One that
// exceeds its limit is measured up to two more times, and the least of its ratios counts: what else
// the machine does makes ratios rather larger than smaller. `program` is argv[0]. Throws UsageError
// as read_ratio_limits does, before any benchmark runs; Error when a limit is exceeded.
void check_ratios(const std::string& program, const std::filesystem::path& limits);

}  // namespace raywalk::bench
