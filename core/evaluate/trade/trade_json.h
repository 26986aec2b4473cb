// A trade as JSON and CSV; docs/file-formats.md lists the keys.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "core/evaluate/trade/trade.h"
#include "core/files/checked_json.h"

namespace raywalk {

nlohmann::ordered_json json_of(const TradeMeasurement& measured);
TradeMeasurement measurement_from(const CheckedJson& json);

// The name of this machine's processor.
std::string cpu_name();

// Position of the view of middle distance, whose errors the report shows.
constexpr std::size_t pictured_view(std::size_t view_count) { return view_count / 2; }

// Of trade.json.
nlohmann::ordered_json trade_document(const TradeInput& input,
                                      std::span<const MeasuredSetting> settings);

// The settings of the document, one row each.
std::string trade_csv(const nlohmann::ordered_json& document);

}  // namespace raywalk
