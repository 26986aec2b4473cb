// A trade measured in blocks of settings, on any machines: each block times its settings, and the
// remap beside them, on its own. Scores are those of one run; times, as always, are not.
#pragma once

#include <filesystem>
#include <string>

#include "core/base/block.h"
#include "core/judge/trade/trade_input.h"
#include "core/judge/trade/trade_result.h"

namespace raywalk {

// Measures a block, unless it is done, keeps it in `report`/trade.blocks, and returns a line for
// the user. A block that was stopped is resumed on a machine with the same processor. Whether a
// time is disturbed is judged within the block. Throws as measure_trade() does.
std::string measure_trade_block(const TradeInput& input, const std::filesystem::path& report,
                                Block block);

// The trade of all blocks. Throws Error naming those that are missing.
Trade merged_trade(const TradeInput& input, const std::filesystem::path& report);

// Removes all blocks. What cannot be removed stays.
void remove_trade_blocks(const std::filesystem::path& report);

}  // namespace raywalk
