// Output paths that a program creates and never overwrites.
#pragma once

#include <filesystem>
#include <string>

namespace raywalk {

// "room.lf/" becomes "room.lf", so that a suffix such as ".partial" can be appended.
std::filesystem::path without_trailing_slash(const std::filesystem::path& path);

// Throws Error if `path` exists, even as a dangling symbolic link. `option` is the flag that sets
// it ("--out"), for the message.
void require_absent(const std::filesystem::path& path, const std::string& option);

}  // namespace raywalk
