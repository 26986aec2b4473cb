// Results of a trade as JSON and CSV.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/files/checked_json.h"
#include "core/judge/trade/trade_result.h"

namespace raywalk {

inline constexpr int kTradeFormatVersion = 4;

// The document of trade.json; docs/file-formats.md lists its keys. A value that was not measured is
// null in the file.
nlohmann::ordered_json trade_document(const Trade& trade);

// trade.csv: one row per setting, with the numbers of trade.json under the same names; the fronts
// are columns pareto_psnr_db, ... of 0 and 1. A value that is null in trade.json is empty here.
std::string trade_csv(const Trade& trade);

// A measurement with the keys of trade.json, and back; throws Error as CheckedJson does.
nlohmann::ordered_json json_of(const TradeMeasurement& measured);
TradeMeasurement measurement_from(const CheckedJson& json);

}  // namespace raywalk
