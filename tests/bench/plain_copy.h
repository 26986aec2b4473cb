// A plain copy flushed to the disk, as a baseline for input and output.
#pragma once

#include <filesystem>

namespace raywalk::bench {

// Copies a file or a directory recursively and waits until the copy is on the disk. `to` must not
// exist.
void copy_to_disk(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace raywalk::bench
