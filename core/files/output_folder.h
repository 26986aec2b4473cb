// Output folders: made under another name first, never in place of what Raywalk did not make.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace raywalk {

// How an output folder of Raywalk is recognised.
struct OwnOutput {
  std::string what{};       // "a room", for messages
  std::string marker{};     // a file in it: "manifest.json"
  std::string signature{};  // text that only Raywalk's marker begins with, within a few lines
  // Whether a file or folder, relative to the output, is one that Raywalk writes there.
  std::function<bool(const std::filesystem::path& relative, bool is_folder)> belongs{};
};

// A folder that appears under its name only when it is complete.
class OutputFolder {
 public:
  // Makes a folder under a temporary name beside `out` (temporary_beside()), and the missing
  // folders above it. Throws Error as require_free(), or if it cannot be written.
  OutputFolder(const std::filesystem::path& out, bool replace, OwnOutput own);
  // Removes the folder unless it was completed.
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  const std::filesystem::path& directory() const { return directory_; }
  // Checks `out` again and gives the folder this name. Throws Error.
  void complete();

 private:
  std::filesystem::path out_;
  bool replace_;
  OwnOutput own_;
  std::filesystem::path directory_;
};

// "room.lf/" becomes "room.lf", so that a suffix such as ".partial" can be appended.
std::filesystem::path without_trailing_slash(const std::filesystem::path& path);

// Throws Error if `path` exists, even as a dangling symbolic link. `option` is the flag that sets
// it ("--out"), for the message.
void require_absent(const std::filesystem::path& path, const std::string& option);

// Throws Error, with the reason, unless `path` may be replaced by --force: it is absent, an empty
// folder, or a folder with the signed marker and nothing in it that does not belong. A symbolic
// link may not be replaced.
void require_replaceable(const std::filesystem::path& path, const OwnOutput& own);
// Throws Error unless nothing is at `out`, or `replace` is set and require_replaceable() allows it.
void require_free(const std::filesystem::path& out, bool replace, const OwnOutput& own);
// As require_replaceable() of a file, which may be replaced if it holds the signature within a few
// lines.
void require_replaceable_file(const std::filesystem::path& file, const std::string& what,
                              const std::string& signature);

// Renames the complete `directory` to `target`. A folder that is there already changes places with
// it, in one step where the file system can, and is removed then. Throws Error; `target` is then as
// it was.
void move_into_place(const std::filesystem::path& directory, const std::filesystem::path& target);

// Bytes of all regular files in a folder and its subfolders; 0 where it cannot be read.
std::uint64_t bytes_in(const std::filesystem::path& folder);

}  // namespace raywalk
