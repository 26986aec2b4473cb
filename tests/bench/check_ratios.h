// The work of `raywalk-bench --check`: runs benchmarks and compares their ratios with limits.
#pragma once

namespace raywalk::bench {

// Runs the benchmarks that have a limit and prints a line for each. One that exceeds its limit is
// measured up to two more times, and the least of its ratios counts: what else the machine does
// makes ratios rather larger than smaller. Throws Error when a limit is exceeded.
void check_ratios();

}  // namespace raywalk::bench
