#include "build_lf/pack/free_space.h"

#include <fmt/format.h>

#include <string>
#include <system_error>

#include "core/base/error.h"

namespace raywalk::build_lf {
namespace {

struct Unit {
  const char* name;
  std::uint64_t bytes;
};

// The largest unit of which there are at least 10, so that two figures are told apart.
Unit unit_for(std::uint64_t bytes) {
  for (const Unit unit : {Unit{"TB", 1'000'000'000'000}, Unit{"GB", 1'000'000'000},
                          Unit{"MB", 1'000'000}, Unit{"kB", 1'000}}) {
    if (bytes >= 10 * unit.bytes) return unit;
  }
  return {"bytes", 1};
}

}  // namespace

std::optional<std::uint64_t> free_bytes(const std::filesystem::path& directory) {
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(directory, error);
  if (error) return std::nullopt;
  return space.available;
}

void require_space(const std::filesystem::path& directory, const NeededSpace& space,
                   std::optional<std::uint64_t> free, const char* what) {
  if (!free || *free >= space.needed) return;
  const Unit unit = unit_for(space.needed);
  // Rounded apart: what is needed is always shown as more than what is free.
  const std::uint64_t needed = (space.needed + unit.bytes - 1) / unit.bytes;
  const std::string there = space.there == 0 ? ""
                                             : fmt::format(" besides the {} {} that are there",
                                                           space.there / unit.bytes, unit.name);
  throw Error(fmt::format(
      "{}: {} needs {} {}{}, {} {} are free; free some space or choose "
      "another disk",
      directory.string(), what, needed, unit.name, there, *free / unit.bytes, unit.name));
}

}  // namespace raywalk::build_lf
