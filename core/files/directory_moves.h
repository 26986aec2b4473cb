// Moves of directories.
#pragma once

#include <filesystem>

namespace raywalk {

// Throws Error naming both.
void rename_or_throw(const std::filesystem::path& from, const std::filesystem::path& to);

// Swaps two directories atomically; false if the kernel or file system does not support it. Throws
// Error naming both for any other failure.
bool exchange(const std::filesystem::path& a, const std::filesystem::path& b);

// Duplicates a directory by hard links, or copies on file systems without them; replaces `to`.
// Throws Error naming both.
void copy_by_links(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace raywalk
