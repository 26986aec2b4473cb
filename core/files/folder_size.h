// How much a folder holds.
#pragma once

#include <cstdint>
#include <filesystem>

namespace raywalk {

// Bytes of all regular files in a folder and its subfolders; 0 where it cannot be read.
std::uint64_t bytes_in(const std::filesystem::path& folder);

}  // namespace raywalk
