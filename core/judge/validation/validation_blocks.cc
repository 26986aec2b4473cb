#include "core/judge/validation/validation_blocks.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/files/block_results.h"
#include "core/files/fingerprint.h"
#include "core/files/sha256.h"
#include "core/judge/validation/connect_error_blocks.h"
#include "core/judge/validation/connect_error_file.h"
#include "core/judge/validation/measured_views.h"
#include "core/room/room_fingerprint.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;

// Pictures are told by their stamps: each block would have to read all of them otherwise. The views
// themselves are kept under the pictures' contents.
std::string inputs_of(const RoomTask& task, const ConnectErrorOptions& options) {
  std::string text = room_fingerprint(task.room) + " " + text_of(task.unconnected, options) + "\n";
  for (const ViewMode& mode : task.modes) text += text_of(mode.options) + "\n";
  for (const TruthView& truth : task.truths) {
    text += fmt::format("{} {} {} {} {} {}\n", truth.viewpoint.x_m,
                        truth.height_m ? fmt::format("{}", *truth.height_m) : "",
                        truth.viewpoint.z_m, stamp_of(truth.file).text(),
                        truth.mask.empty() ? "" : stamp_of(truth.mask).text(),
                        truth.distances.empty() ? "" : stamp_of(truth.distances).text());
  }
  return text;
}

BlockResults results_of(std::span<const RoomTask> tasks, const ConnectErrorOptions& options) {
  std::string inputs;
  for (const RoomTask& task : tasks) inputs += inputs_of(task, options);
  return {tasks.front().partial->directory() / "blocks", "validate", sha256_hex(inputs)};
}

// Measures the block's views, which are kept, and returns its share of the connection error.
ordered_json measured_share(const RoomTask& task, const ConnectErrorOptions& options, Block block) {
  measured_views(task.room, task.truths, task.modes,
                 block.share_of(task.truths.size() * task.modes.size()), *task.partial);
  return connect_error_share(task.room, task.unconnected, options, block);
}

}  // namespace

std::string validate_block(std::span<const RoomTask> tasks, const ConnectErrorOptions& options,
                           Block block) {
  return results_of(tasks, options).make_and_tell(block, [&] {
    ordered_json shares = ordered_json::array();
    for (const RoomTask& task : tasks) shares.push_back(measured_share(task, options, block));
    return shares.dump();
  });
}

void merge_validation_blocks(std::span<const RoomTask> tasks, const ConnectErrorOptions& options) {
  std::vector<std::vector<CheckedJson>> shares(tasks.size());  // of each room
  for (const std::string& result : results_of(tasks, options).merged()) {
    const CheckedJson block = CheckedJson::parse(result, "a block of validate");
    const std::vector<CheckedJson> parts = block.items(tasks.size());
    for (std::size_t i = 0; i < parts.size(); ++i) shares[i].push_back(parts[i]);
  }
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    const RoomTask& task = tasks[i];
    for (const ConnectError& error :
         connect_errors_of(shares[i], task.room, task.unconnected, options)) {
      store_connect_error(task.partial->connection_errors(), error);
    }
  }
}

}  // namespace raywalk
