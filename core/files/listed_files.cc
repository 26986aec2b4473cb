#include "core/files/listed_files.h"

#include <utf8proc.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <system_error>
#include <utility>

namespace raywalk {
namespace {

namespace fs = std::filesystem;

// Equal for names that differ in case and Unicode form only. Of a name that is not UTF-8, itself.
std::string folded(const std::string& name) {
  utf8proc_uint8_t* mapped = nullptr;
  const auto length = utf8proc_map(
      reinterpret_cast<const utf8proc_uint8_t*>(name.data()),
      static_cast<utf8proc_ssize_t>(name.size()), &mapped,
      static_cast<utf8proc_option_t>(UTF8PROC_STABLE | UTF8PROC_COMPOSE | UTF8PROC_CASEFOLD));
  if (length < 0) return name;
  const std::unique_ptr<utf8proc_uint8_t, decltype(&std::free)> owner(mapped, std::free);
  return {reinterpret_cast<const char*>(mapped), static_cast<std::size_t>(length)};
}

bool is_there(const fs::path& file) {
  std::error_code error;
  return fs::exists(file, error);
}

}  // namespace

const ListedFiles::Entries& ListedFiles::entries_of(const fs::path& folder) {
  const auto [of, is_new] = seen_.try_emplace(folder);
  if (!is_new) return of->second;
  std::error_code error;
  for (fs::directory_iterator entry(folder.empty() ? "." : folder, error), end;
       !error && entry != end; entry.increment(error)) {
    const fs::path name = entry->path().filename();
    const auto [known, is_first] = of->second.try_emplace(folded(name.string()), name);
    if (!is_first) known->second.clear();
  }
  return of->second;
}

fs::path ListedFiles::find(const std::string& name) {
  fs::path as_written = folder_ / name;
  if (is_there(as_written)) return as_written;
  std::string slashed = name;
  std::ranges::replace(slashed, '\\', '/');
  fs::path found = fs::path(slashed).is_absolute() ? fs::path() : folder_;
  for (const fs::path& part : fs::path(slashed)) {
    if (part.is_absolute() || part == "." || part == ".." || is_there(found / part)) {
      found /= part;
      continue;
    }
    const Entries& entries = entries_of(found);
    const auto entry = entries.find(folded(part.string()));
    if (entry == entries.end() || entry->second.empty()) return as_written;
    found /= entry->second;
  }
  return found;
}

}  // namespace raywalk
