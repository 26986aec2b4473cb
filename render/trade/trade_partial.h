// Settings that are measured already, kept in a file while a trade runs, so that a run that was
// stopped is gone on with.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "render/trade/trade_result.h"

namespace raywalk::render {

class TradePartial {
 public:
  // Reads what an earlier run left, if anything. `input` tells what is measured: measurements of
  // other inputs are not mixed. Throws Error where the file is damaged or belongs to another input,
  // or cannot be written.
  TradePartial(std::filesystem::path file, const std::string& input);

  // The measurement of a setting; none where it is not there yet.
  std::optional<TradeMeasurement> find(const TradeSetting& setting) const;
  // Adds one and writes the file. Throws Error where it cannot be written.
  void add(const TradeSetting& setting, const TradeMeasurement& measured);

 private:
  void read();

  std::filesystem::path file_;
  nlohmann::ordered_json content_;                    // of the file
  std::map<std::string, TradeMeasurement> measured_;  // by the text of their parameters
};

}  // namespace raywalk::render
