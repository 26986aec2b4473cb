// What reading and writing cost by themselves: a plain copy that ends on the disk.
#pragma once

#include <filesystem>

namespace raywalk::bench {

// Copies a file, or a directory with all in it, and waits until the copy is on the disk. `to` must
// not exist.
void copy_to_disk(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace raywalk::bench
