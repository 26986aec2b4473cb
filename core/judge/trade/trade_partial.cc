#include "core/judge/trade/trade_partial.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/checked_json.h"
#include "core/judge/trade/trade_json.h"

namespace raywalk {
namespace {

using nlohmann::ordered_json;

constexpr const char* kFormat = "raywalk-trade-partial";
constexpr int kPartialFormatVersion = 3;

std::string key_of(const TradeSetting& setting) { return parameters_of(setting).dump(); }

}  // namespace

TradePartial::TradePartial(std::filesystem::path file, const std::string& input)
    : file_(std::move(file)),
      content_(
          std::make_unique<ordered_json>(ordered_json{{"format", kFormat},
                                                      {"format_version", kPartialFormatVersion},
                                                      {"input", input},
                                                      {"settings", ordered_json::array()}})) {
  const AtomicFile probe(file_);
  if (std::filesystem::exists(file_)) read();
}

TradePartial::~TradePartial() = default;

void TradePartial::read() {
  const CheckedJson earlier = CheckedJson::read(file_, "remove it, and everything is measured");
  const auto is_other = [&] {
    return earlier.at("format").text() != kFormat ||
           earlier.at("format_version").integer() != kPartialFormatVersion ||
           earlier.at("input").text() != content_->at("input").get<std::string>();
  };
  if (is_other()) {
    throw Error(file_.string() +
                " belongs to another room, truth or sweep; remove it, or use another --report");
  }
  for (const CheckedJson& setting : earlier.at("settings").items()) {
    measured_[setting.at("setting").text()] = measurement_from(setting.at("measured"));
  }
}

std::optional<TradeMeasurement> TradePartial::find(const TradeSetting& setting) const {
  const auto found = measured_.find(key_of(setting));
  if (found == measured_.end()) return std::nullopt;
  return found->second;
}

void TradePartial::add(const TradeSetting& setting, const TradeMeasurement& measured) {
  measured_[key_of(setting)] = measured;
  ordered_json settings = ordered_json::array();
  for (const auto& [parameters, kept] : measured_) {
    settings.push_back({{"setting", parameters}, {"measured", json_of(kept)}});
  }
  (*content_)["settings"] = std::move(settings);
  write_file_atomically(
      file_,
      content_->dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

}  // namespace raywalk
