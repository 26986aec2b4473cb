// Measures the settings of a trade.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/block.h"
#include "core/judge/trade/trade_input.h"
#include "core/judge/trade/trade_result.h"
#include "core/judge/validation/connect_error.h"

namespace raywalk {

// Measures every setting; those that other programs disturb again (view_time.h), and marks them
// where that does not help. Finished settings are stored in the file `partial`; those already there
// for the same input are not measured again. The file is not removed (write_trade's caller does
// that). Prints progress. Throws Error where `partial` is damaged or belongs to another input or
// processor; Interrupted.
Trade measure_trade(const TradeInput& input, const std::filesystem::path& partial);

// The settings `range` alone, without e_connect. Throws as measure_trade() does.
std::vector<MeasuredSetting> measure_settings(const TradeInput& input, IndexRange range,
                                              const std::filesystem::path& partial);

// The connection errors of a room's settings: one mode of each generation, and every k.
struct WantedConnections {
  std::vector<ViewMode> modes{};
  ConnectErrorOptions options{};
};
WantedConnections wanted_connections(const TradeInput& input, std::size_t room);

// The trade of settings that are measured, with e_connect: as the rooms have it, or what is kept in
// the directory `kept_in`/<index of the room>, or measured now. `cpu` names the processors.
Trade completed_trade(const TradeInput& input, std::vector<MeasuredSetting> settings,
                      std::string cpu,
                      const std::optional<std::filesystem::path>& kept_in = std::nullopt);

// The name of this machine's processor.
std::string cpu_name();

// Everything that measurements depend on, except the settings and the processor, as a text for
// fingerprints.
std::string inputs_text(const TradeInput& input);

}  // namespace raywalk
