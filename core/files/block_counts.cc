#include "core/files/block_counts.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <system_error>

#include "core/files/atomic_output.h"
#include "core/files/words.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

std::vector<int> noted_counts(const fs::path& folder) {
  std::vector<int> counts;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    const std::optional<int> count = parse_whole_number(name);
    if (count && *count >= 1 && *count <= kMostBlocks) counts.push_back(*count);
  }
  std::sort(counts.begin(), counts.end());
  return counts;
}

}  // namespace

void note_block_count(const fs::path& folder, int count) {
  make_directories(folder);
  const fs::path note = folder / std::to_string(count);
  std::error_code error;
  if (!fs::exists(note, error)) write_file_atomically(note, "");
}

std::string missing_blocks(const fs::path& folder, const std::function<bool(Block)>& is_missing) {
  std::string text;
  for (const int count : noted_counts(folder)) {
    std::vector<int> missing;
    for (int index = 1; index <= count; ++index) {
      if (is_missing({index, count})) missing.push_back(index);
    }
    if (!missing.empty()) text += (text.empty() ? "" : "; ") + missing_blocks_text(missing, count);
  }
  return text;
}

std::string missing_blocks_text(const std::vector<int>& missing, int count) {
  return fmt::format("{} of {} blocks {} missing: {}", missing.size(), count,
                     missing.size() == 1 ? "is" : "are", listed(missing));
}

}  // namespace raywalk
