// Plots of numerical error, as docs/numerics.md shows them.
#pragma once

#include <filesystem>

namespace raywalk::bench {

// Writes the plots as SVG files into an existing directory, replacing those of the same names. The
// same program writes the same bytes. Throws Error where a file cannot be written.
void write_error_plots(const std::filesystem::path& directory);

// Its two halves: where a station saw a point, and the error model of the paper.
void write_position_error_plots(const std::filesystem::path& directory);
void write_model_error_plots(const std::filesystem::path& directory);

}  // namespace raywalk::bench
