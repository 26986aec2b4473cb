// Whether a disk has space for a room or an export, before hours of work.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace raywalk::build_lf {

struct NeededSpace {
  std::uint64_t needed = 0;  // bytes still to be written
  std::uint64_t there = 0;   // bytes that a stopped run wrote already
};

// Bytes that this user can still write to the disk that holds `directory`; none if the system does
// not say.
std::optional<std::uint64_t> free_bytes(const std::filesystem::path& directory);

// Throws Error naming the directory and both sizes if fewer bytes are free than needed for `what`.
// Never throws if `free` is unknown.
void require_space(const std::filesystem::path& directory, const NeededSpace& space,
                   std::optional<std::uint64_t> free, const char* what = "the room");

}  // namespace raywalk::build_lf
