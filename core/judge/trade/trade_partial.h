// The settings measured so far, stored in a file while a trade runs so that an interrupted run can
// be resumed.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "core/judge/trade/trade_result.h"

namespace raywalk {

class TradePartial {
 public:
  // Reads the file of an earlier run, if any. `input` identifies what is measured, so that
  // measurements of different inputs are never mixed. Throws Error where the file is damaged,
  // belongs to another input, or cannot be written.
  TradePartial(std::filesystem::path file, const std::string& input);
  ~TradePartial();

  // The measurement of a setting; none where it is not measured yet.
  std::optional<TradeMeasurement> find(const TradeSetting& setting) const;
  // Adds a measurement, or replaces that of the setting, and writes the file. Throws Error where it
  // cannot be written.
  void add(const TradeSetting& setting, const TradeMeasurement& measured);

 private:
  void read();

  std::filesystem::path file_;
  std::unique_ptr<nlohmann::ordered_json> content_;   // of the file
  std::map<std::string, TradeMeasurement> measured_;  // by the text of their parameters
};

}  // namespace raywalk
