// A validation measured in blocks: each block measures its share of the views, which are kept one
// by one (validation_partial.h), and of the connection error; merging is the usual run, which finds
// all of them.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/base/block.h"
#include "core/judge/validation/connect_error.h"
#include "core/judge/validation/truth_views.h"
#include "core/judge/validation/validation_partial.h"
#include "core/room/room.h"
#include "core/view/view_mode.h"

namespace raywalk {

// What is to be measured of a room.
struct RoomTask {
  const Room& room;
  std::vector<ViewMode> modes{};
  std::vector<TruthView> truths{};
  // Those whose connection error the room has not yet.
  std::vector<Generation> unconnected{};
  const ValidationPartial* partial = nullptr;  // none until the report is locked
};

// Measures a block of all rooms, unless it is done, and returns a line for the user. Throws as
// measured_views() and measure_connect_error_sums() do.
std::string validate_block(std::span<const RoomTask> tasks, const ConnectErrorOptions& options,
                           Block block);

// Keeps the connection errors that all blocks make together with the views. Throws Error naming
// the blocks that are missing.
void merge_validation_blocks(std::span<const RoomTask> tasks, const ConnectErrorOptions& options);

}  // namespace raywalk
