#include "core/judge/trade/trade_blocks.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/block_results.h"
#include "core/files/checked_json.h"
#include "core/files/json_text.h"
#include "core/files/sha256.h"
#include "core/judge/trade/measure_trade.h"
#include "core/judge/trade/trade_json.h"
#include "core/judge/validation/connect_error_blocks.h"
#include "core/judge/validation/connect_error_file.h"
#include "core/judge/validation/validate.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

fs::path blocks_of(const fs::path& report) { return report / "trade.blocks"; }

// Generations of a room whose connection error it has not yet, measured with the options.
std::vector<Generation> unconnected(const TradeInput& input, std::size_t room) {
  const WantedConnections wanted = wanted_connections(input, room);
  return unconnected_generations(*input.rooms[room].room, wanted.modes, wanted.options);
}

BlockResults results_of(const TradeInput& input, const fs::path& report) {
  std::string inputs = inputs_text(input);
  for (const TradeSetting& setting : input.settings) {
    inputs += fmt::format("{} {}\n", setting.room, parameters_of(setting).dump());
  }
  for (std::size_t room = 0; room < input.rooms.size(); ++room) {
    inputs += text_of(unconnected(input, room), wanted_connections(input, room).options) + "\n";
  }
  return {blocks_of(report), "trade", sha256_hex(inputs)};
}

ordered_json measured_block(const TradeInput& input, const fs::path& report, Block block) {
  // Of each processor another file, as their times do not mix.
  const std::string partial =
      fmt::format("{}-{}-{}.json", sha256_hex(inputs_text(input) + cpu_name()).substr(0, 16),
                  block.index, block.count);
  make_directories(blocks_of(report) / "partial");
  ordered_json settings = ordered_json::array();
  for (const MeasuredSetting& setting : measure_settings(
           input, block.share_of(input.settings.size()), blocks_of(report) / "partial" / partial)) {
    settings.push_back(json_of(setting.measured));
  }
  ordered_json connections = ordered_json::array();
  for (std::size_t room = 0; room < input.rooms.size(); ++room) {
    connections.push_back(connect_error_share(*input.rooms[room].room, unconnected(input, room),
                                              wanted_connections(input, room).options, block));
  }
  return {{"cpu", cpu_name()}, {"settings", settings}, {"connections", connections}};
}

// The settings of all blocks, which are in order.
std::vector<MeasuredSetting> settings_of(const TradeInput& input,
                                         const std::vector<CheckedJson>& blocks) {
  std::vector<MeasuredSetting> settings;
  for (const TradeSetting& setting : input.settings) settings.push_back({.setting = setting});
  const int count = static_cast<int>(blocks.size());
  for (int i = 0; i < count; ++i) {
    const IndexRange share = Block{i + 1, count}.share_of(settings.size());
    const std::vector<CheckedJson> measured =
        blocks[static_cast<std::size_t>(i)].at("settings").items(share.size());
    for (std::size_t k = 0; k < measured.size(); ++k) {
      settings[share.begin + k].measured = measurement_from(measured[k]);
    }
  }
  return settings;
}

// The names of the processors, each once.
std::string cpus_of(const std::vector<CheckedJson>& blocks) {
  std::vector<std::string> names;
  for (const CheckedJson& block : blocks) {
    std::string name = block.at("cpu").text();
    if (std::ranges::find(names, name) == names.end()) names.push_back(std::move(name));
  }
  return fmt::format("{}", fmt::join(names, "; "));
}

// Keeps the connection errors of each room in `directory`/<its index>.
void keep_connections(const TradeInput& input, const std::vector<CheckedJson>& blocks,
                      const fs::path& directory) {
  for (std::size_t room = 0; room < input.rooms.size(); ++room) {
    std::vector<CheckedJson> shares;
    for (const CheckedJson& block : blocks) {
      const std::vector<CheckedJson> of_rooms = block.at("connections").items(input.rooms.size());
      shares.push_back(of_rooms[room]);
    }
    const fs::path kept = directory / std::to_string(room);
    make_directories(kept);
    for (const ConnectError& error :
         connect_errors_of(shares, *input.rooms[room].room, unconnected(input, room),
                           wanted_connections(input, room).options)) {
      store_connect_error(kept, error);
    }
  }
}

}  // namespace

std::string measure_trade_block(const TradeInput& input, const fs::path& report, Block block) {
  return results_of(input, report).make_and_tell(block, [&] {
    return json_text(measured_block(input, report, block));
  });
}

Trade merged_trade(const TradeInput& input, const fs::path& report) {
  std::vector<CheckedJson> blocks;
  for (const std::string& result : results_of(input, report).merged()) {
    blocks.push_back(CheckedJson::parse(result, "a block of trade"));
  }
  const fs::path connections = blocks_of(report) / "connections";
  keep_connections(input, blocks, connections);
  return completed_trade(input, settings_of(input, blocks), cpus_of(blocks), connections);
}

void remove_trade_blocks(const fs::path& report) {
  std::error_code ignored;
  fs::remove_all(blocks_of(report), ignored);
}

}  // namespace raywalk
