// The plots of numerical error in docs/numerics.md.
#pragma once

#include <filesystem>

namespace raywalk::bench {

// Writes the plots as SVG files into an existing directory, replacing those of the same names. The
// output is deterministic. Throws Error if a file cannot be written.
void write_error_plots(const std::filesystem::path& directory);

}  // namespace raywalk::bench
