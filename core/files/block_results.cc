#include "core/files/block_results.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/block_counts.h"
#include "core/files/output_folder.h"
#include "core/files/words.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

// A result is read whole; of a large room, with few blocks, it has gigabytes.
constexpr std::size_t kMostBytes = std::size_t{1} << 36;
constexpr std::size_t kInputDigits = 16;  // of the fingerprint, in names

}  // namespace

BlockResults::BlockResults(fs::path folder, std::string step, std::string inputs,
                           std::function<bool(Block)> whole)
    : folder_(std::move(folder)),
      step_(std::move(step)),
      inputs_(std::move(inputs)),
      whole_(std::move(whole)) {
  inputs_.resize(std::min(inputs_.size(), kInputDigits));
}

fs::path BlockResults::directory_of(int count) const {
  return folder_ / step_ / fmt::format("{}-{}", inputs_, count);
}

fs::path BlockResults::file_of(Block block) const {
  return directory_of(block.count) / std::to_string(block.index);
}

bool BlockResults::done(Block block) const {
  std::error_code error;
  return fs::exists(file_of(block), error) && (!whole_ || whole_(block));
}

bool BlockResults::make(Block block, const std::function<std::string()>& make) const {
  if (done(block)) return false;
  const std::string result = make();
  make_directories(directory_of(block.count));
  write_file_atomically(file_of(block), result);
  return true;
}

std::string BlockResults::make_and_tell(Block block,
                                        const std::function<std::string()>& make) const {
  const bool now = this->make(block, make);
  return fmt::format("{}: block {} {} done; --merge puts the blocks together", step_, block.text(),
                     now ? "is" : "was already");
}

std::vector<int> BlockResults::started_counts() const {
  std::vector<int> counts;
  std::error_code error;
  for (fs::directory_iterator entry(folder_ / step_, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (!name.starts_with(inputs_ + "-")) continue;
    const std::optional<int> count = parse_whole_number(name.substr(inputs_.size() + 1));
    if (count && *count >= 1 && *count <= kMostBlocks) counts.push_back(*count);
  }
  std::sort(counts.begin(), counts.end());
  return counts;
}

std::vector<int> BlockResults::missing_of(int count) const {
  std::vector<int> missing;
  for (int index = 1; index <= count; ++index) {
    if (!done({index, count})) missing.push_back(index);
  }
  return missing;
}

std::optional<int> BlockResults::complete_count() const {
  for (const int count : started_counts()) {
    if (missing_of(count).empty()) return count;
  }
  return std::nullopt;
}

std::string BlockResults::result_of(Block block) const {
  return read_file(file_of(block), kMostBytes);
}

std::string BlockResults::missing() const {
  std::string text;
  for (const int count : started_counts()) {
    const std::vector<int> missing = missing_of(count);
    if (missing.empty()) return "";
    text += (text.empty() ? "" : "; ") + missing_blocks_text(missing, count);
  }
  return text.empty() ? "no block has been made from these inputs" : text;
}

bool BlockResults::any_done() const { return !started_counts().empty(); }

int BlockResults::count_to_complete(int if_none) const {
  int best = if_none;
  double least = 1.0;
  for (const int count : started_counts()) {
    const double share = static_cast<double>(missing_of(count).size()) / count;
    if (share >= least) continue;
    best = count;
    least = share;
  }
  return best;
}

std::vector<std::string> BlockResults::merged() const {
  const std::optional<int> count = complete_count();
  if (!count) {
    throw Error(fmt::format("{}: {}: {}; make them with --block and merge again", folder_.string(),
                            step_, missing()));
  }
  std::vector<std::string> results;
  for (int index = 1; index <= *count; ++index) results.push_back(result_of({index, *count}));
  return results;
}

void BlockResults::remove() const {
  std::error_code ignored;
  fs::remove_all(folder_ / step_, ignored);
  fs::remove(folder_, ignored);  // only if no other step has results there
}

fs::path blocks_beside(const fs::path& output) {
  return without_trailing_slash(output).string() + ".blocks";
}

}  // namespace raywalk
