// Paths of outputs that a program makes anew and never overwrites.
#pragma once

#include <filesystem>
#include <string>

namespace raywalk {

// "room.lf/" and "room.lf" name the same directory, but only the latter has a name to extend.
std::filesystem::path without_trailing_slash(const std::filesystem::path& path);

// Throws Error naming it where `path` is taken, be it by a link that leads nowhere; `option` is
// what chooses it ("--out").
void require_absent(const std::filesystem::path& path, const std::string& option);

}  // namespace raywalk
