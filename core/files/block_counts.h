// Notes into how many blocks a step was divided, where its results are not kept by blocks: merging
// can then name the missing blocks.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/base/block.h"

namespace raywalk {

// Notes a number of blocks in a folder, which is created. Throws Error if it cannot be written.
void note_block_count(const std::filesystem::path& folder, int count);

// The missing blocks of each number of blocks noted: "2 of 16 blocks are missing: 3 and 5"; several
// of them with "; " between. Empty if none is noted.
std::string missing_blocks(const std::filesystem::path& folder,
                           const std::function<bool(Block)>& is_missing);

// "2 of 16 blocks are missing: 3 and 5". `missing` must increase.
std::string missing_blocks_text(const std::vector<int>& missing, int count);

}  // namespace raywalk
