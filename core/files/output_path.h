// Output directories: made under another name first, never overwritten unless that is asked for.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace raywalk {

// "room.lf/" becomes "room.lf", so that a suffix such as ".partial" can be appended.
std::filesystem::path without_trailing_slash(const std::filesystem::path& path);

// Throws Error if `path` exists, even as a dangling symbolic link. `option` is the flag that sets
// it ("--out"), for the message.
void require_absent(const std::filesystem::path& path, const std::string& option);

// How an output directory of Raywalk is recognised.
struct OwnOutput {
  std::string what{};       // "a room", for messages
  std::string marker{};     // a file in it: "manifest.json"
  std::string signature{};  // text that only Raywalk's marker begins with, within a few lines
  // Whether a file or directory, relative to the output, is one that Raywalk writes there.
  std::function<bool(const std::filesystem::path& relative, bool is_directory)> belongs{};
};

// Throws Error, with the reason, unless `path` may be replaced by --force: it is absent, an empty
// directory, or a directory with the signed marker and nothing in it that does not belong. A
// symbolic link may not be replaced.
void require_replaceable(const std::filesystem::path& path, const OwnOutput& own);

// Renames the complete `directory` to `target`. A directory that is there already changes places
// with it in one step and is removed then. Throws Error; `target` is then as it was.
void move_into_place(const std::filesystem::path& directory, const std::filesystem::path& target);

}  // namespace raywalk
